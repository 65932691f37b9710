// Invocations of a pass, in rows of as many as one dispatch has in x.

const ROW: u32 = 2097152u;

fn linear(id: vec3<u32>) -> u32 {
    return id.y * ROW + id.x;
}
