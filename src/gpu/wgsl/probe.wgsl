// How fine a device's sub-pixel grid is. Row r has a triangle whose left edge stands 3/4 of 2^-(r+1) pixel to the right
// of the centres of column 0: a grid with such a step leaves them out, a coarser one moves the edge onto them.

@group(0) @binding(0) var<storage, read_write> hits: array<u32>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) row: u32,
}

@vertex
fn probe_corner(@builtin(vertex_index) index: u32, @builtin(instance_index) row: u32) -> Corner {
    // In pixels of a viewport of 16 x 16: a vertical left edge through the whole row.
    let left = 0.5 + 0.75 * exp2(-f32(row + 1u));
    let top = f32(row) - 0.5;
    var corner = vec2<f32>(left, top);
    if index == 1u {
        corner = vec2<f32>(left, top + 2.0);
    } else if index == 2u {
        corner = vec2<f32>(left + 8.0, top);
    }
    let position = corner / 8.0 - 1.0;
    return Corner(vec4<f32>(position.x, -position.y, 0.5, 1.0), row);
}

@fragment
fn probe_pixel(corner: Corner) {
    let place = vec2<u32>(corner.position.xy);
    if place.x == 0u && place.y == corner.row {
        hits[corner.row] = 1u;
    }
}
