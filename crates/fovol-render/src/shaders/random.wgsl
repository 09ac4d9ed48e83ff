// Well-mixed bits. Twin of `hash` in noise/random.rs. WGSL has no 64-bit arithmetic, so pairs hold the low and the high word.

/// a + b.
fn add_64(a: vec2u, b: vec2u) -> vec2u {
    let low = a.x + b.x;
    return vec2u(low, a.y + b.y + u32(low < a.x));
}

/// All 64 bits of a·b, from products of half words.
fn full_product(a: u32, b: u32) -> vec2u {
    let a_low = a & 0xFFFFu;
    let a_high = a >> 16u;
    let b_low = b & 0xFFFFu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    // Neither sum overflows: (2¹⁶ − 1)² + 2¹⁶ − 1 < 2³².
    let middle = a_high * b_low + (low >> 16u);
    let other = a_low * b_high + (middle & 0xFFFFu);
    return vec2u(a * b, a_high * b_high + (middle >> 16u) + (other >> 16u));
}

/// a·b modulo 2⁶⁴.
fn multiply_64(a: vec2u, b: vec2u) -> vec2u {
    let low = full_product(a.x, b.x);
    return vec2u(low.x, low.y + a.x * b.y + a.y * b.x);
}

/// a ^ (a >> by), 0 < by < 32.
fn fold_64(a: vec2u, by: u32) -> vec2u {
    return a ^ vec2u(a.x >> by | a.y << (32u - by), a.y >> by);
}

/// 64 well-mixed bits of (`seed`, `index`): SplitMix64 (Steele, Lea, Flood 2014).
fn hash(seed: vec2u, index: vec2u) -> vec2u {
    let golden = vec2u(0x7F4A7C15u, 0x9E3779B9u);
    var z = add_64(seed, multiply_64(add_64(index, vec2u(1u, 0u)), golden));
    z = multiply_64(fold_64(z, 30u), vec2u(0x1CE4E5B9u, 0xBF58476Du));
    z = multiply_64(fold_64(z, 27u), vec2u(0x133111EBu, 0x94D049BBu));
    return fold_64(z, 31u);
}
