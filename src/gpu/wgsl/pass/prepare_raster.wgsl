//# include pass/raster

@fragment
fn prepare_raster(corner: Corner) {
    prepare(fragment_of(corner));
}
