// `ha64` that keeps all of a pixel's fragments that are wholly alike: a record that finds its like walks on.

//# replaces parts/alike
const ONE_OF_ALIKE: bool = false;

//# include hash_table/ha64
