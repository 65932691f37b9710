// How a lock's holder reaches its pixel's counter and page: by updates alone (see reach/updates). Links and records
// can stay plain: they are written once, and read after a barrier.

//# include reach/updates

// A word that the lock alone guards.
alias Word = atomic<u32>;

// Under the lock.
fn count_of(pixel: u32) -> u32 {
    return got(atomicOr(&pixels[pixel].counter, 0u));
}

fn set_count(pixel: u32, count: u32) {
    got(atomicExchange(&pixels[pixel].counter, count));
}

fn page_of(pixel: u32) -> u32 {
    return got(atomicOr(&pixels[pixel].page, 0u));
}

fn set_page(pixel: u32, page: u32) {
    got(atomicExchange(&pixels[pixel].page, page));
}

// Outside of the store pass.
fn empty(pixel: u32) {
    atomicStore(&pixels[pixel].counter, 0u);
    atomicStore(&pixels[pixel].page, NONE);
}

fn settled_count(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

fn settled_page(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].page);
}
