// How a lock's holder reaches its pixel's counter and page: relaxed loads and stores, which nothing orders.

// A word that the lock alone guards.
alias Word = atomic<u32>;

// Under the lock.
fn count_of(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

fn set_count(pixel: u32, count: u32) {
    atomicStore(&pixels[pixel].counter, count);
}

fn page_of(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].page);
}

fn set_page(pixel: u32, page: u32) {
    atomicStore(&pixels[pixel].page, page);
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
