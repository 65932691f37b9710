// The k nearest of an S-buffer (Yu, Yang, Hensley, Harada, Yu 2012; KB-AB-SB): resolve selects.

//# replaces shared/emit
//# include shared/nearest
//# include a_buffer/s_buffer
