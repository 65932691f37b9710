// Of a pixel's fragments that are wholly alike, the table keeps one.
const ONE_OF_ALIKE: bool = true;
