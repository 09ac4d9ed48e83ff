// Clean-up of states: values that are not finite would stay forever and become 0. Twin of `carry` in
// cpu/engine/network.rs.

/// Whether elements are f16.
override HALVED: bool;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read_write> words: array<vec2u>;

/// Replaces the elements whose `exponent` bits are all set by zeros.
fn kept(found: vec2u, number: u32, exponent: u32) -> vec2u {
    let lost = (found & vec2u(exponent)) == vec2u(exponent);
    return select(found, found & ~vec2u(number), lost);
}

@compute @workgroup_size(8, 8)
fn keep(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let i = place(shape, at.x, at.y, at.z);
    if HALVED {
        let found = words[i];
        let finite = kept(kept(found, 0xffffu, 0x7c00u), 0xffff0000u, 0x7c000000u);
        if any(finite != found) {
            words[i] = finite;
        }
        return;
    }
    for (var j = 2u * i; j < 2u * i + 2u; j += 1u) {
        let found = words[j];
        let finite = kept(found, 0xffffffffu, 0x7f800000u);
        if any(finite != found) {
            words[j] = finite;
        }
    }
}
