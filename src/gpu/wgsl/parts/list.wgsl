// No node, or no page: the end of a list.
const NONE: u32 = 0xFFFFFFFFu;
