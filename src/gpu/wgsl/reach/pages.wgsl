// How a lock's holder reaches its pixel's counter and page: plain words.

// A word that the lock alone guards.
alias Word = u32;

// Under the lock.
fn count_of(pixel: u32) -> u32 {
    return pixels[pixel].counter;
}

fn set_count(pixel: u32, count: u32) {
    pixels[pixel].counter = count;
}

fn page_of(pixel: u32) -> u32 {
    return pixels[pixel].page;
}

fn set_page(pixel: u32, page: u32) {
    pixels[pixel].page = page;
}

// Outside of the store pass.
fn empty(pixel: u32) {
    pixels[pixel].counter = 0u;
    pixels[pixel].page = NONE;
}

fn settled_count(pixel: u32) -> u32 {
    return pixels[pixel].counter;
}

fn settled_page(pixel: u32) -> u32 {
    return pixels[pixel].page;
}
