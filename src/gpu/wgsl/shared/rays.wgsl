// The results of resolve: the records of a pixel, in any order, into its part of the lists.

//# include shared/fragment

struct Ray {
    // Where the pixel's part of the lists begins, and how many records it holds; written by the host.
    start: u32,
    room: u32,
    // How many records were emitted, including those beyond its room; and the pixel's colour, sRGB RGBA8. Written by
    // resolve.
    count: u32,
    color: u32,
}

@group(1) @binding(1) var<storage, read_write> rays: array<Ray>;
@group(1) @binding(2) var<storage, read_write> lists: array<Key>;

var<private> ray: Ray;
