// Which pass of the method's program this is.
override PASS: u32 = 0u;
