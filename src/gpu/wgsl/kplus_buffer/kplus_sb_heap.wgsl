// `kplus_sb` with a heap in every full pixel, whatever k.

//# replaces parts/array_up_to
const ARRAY_UP_TO: u32 = 0u;

//# include kplus_buffer/kplus_sb
