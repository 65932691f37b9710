// Up to this k, an array is faster than a heap.
const ARRAY_UP_TO: u32 = 16u;
