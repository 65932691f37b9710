// The raster path: one instance per triangle, whose corners are already on the device's sub-pixel grid, under a
// viewport that contains them all. Its width and height are a power of two, so that the mapping there and back is exact
// in 32-bit floats. Depth comes from integers, never from the device's interpolation.

//# include shared/fragment
//# include shared/grid
//# include shared/depth

struct Triangle {
    // Corners in 1/256 pixel of the picture, y down.
    @location(0) a: vec2<i32>,
    @location(1) b: vec2<i32>,
    @location(2) c: vec2<i32>,
    // The depth plane: right and down; origin, nearest and farthest.
    @location(3) slopes: vec4<u32>,
    @location(4) rest: vec4<u32>,
    @location(5) data: u32,
}

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) slopes: vec4<u32>,
    @location(1) @interpolate(flat) rest: vec4<u32>,
    @location(2) @interpolate(flat) data: u32,
}

@vertex
fn raster_corner(@builtin(vertex_index) index: u32, triangle: Triangle) -> Corner {
    var corner = triangle.a;
    if index == 1u {
        corner = triangle.b;
    } else if index == 2u {
        corner = triangle.c;
    }
    let from_center = vec2<f32>(corner - vec2<i32>(CENTER_X, CENTER_Y)) * PER_HALF_VIEWPORT;
    let position = vec4<f32>(from_center.x, -from_center.y, 0.5, 1.0);
    return Corner(position, triangle.slopes, triangle.rest, triangle.data);
}

fn fragment_of(corner: Corner) -> Fragment {
    // A place in the drawn band; planes refer to the whole picture.
    let place = vec2<u32>(corner.position.xy);
    let plane = Plane(corner.slopes.xy, corner.slopes.zw, corner.rest.xy, corner.rest.z, corner.rest.w);
    let depth = depth_code(plane, place + vec2<u32>(0u, BAND_TOP)) >> DEPTH_SHIFT;
    return Fragment(pixel_at(place), depth, corner.data * DATA_IS_TRIANGLE, 0u, KEPT);
}
