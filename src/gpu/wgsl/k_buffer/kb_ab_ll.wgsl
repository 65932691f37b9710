// The k nearest of an A-buffer in linked lists (Yu, Yang, Hensley, Harada, Yu 2012; KB-AB-LL): resolve selects.

//# replaces shared/emit
//# include shared/nearest
//# include a_buffer/ab_ll
