// The k nearest of an A-buffer in fixed arrays (Yu, Yang, Hensley, Harada, Yu 2012; KB-AB-Array): resolve selects.

//# replaces shared/emit
//# include shared/nearest
//# include a_buffer/ab_array
