//# include pass/raster

@fragment
fn store_raster(corner: Corner) {
    store(fragment_of(corner));
}
