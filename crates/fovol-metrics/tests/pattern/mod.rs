//! Picture generators that the scripts of reference values use too.

/// Triangle wave between 0 and 255.
pub fn triangle(t: i64, period: i64) -> i64 {
    let t = t.rem_euclid(2 * period);
    t.min(2 * period - t) * 255 / period
}

/// Pseudorandom byte.
pub fn noise(x: i64, y: i64, c: i64, frame: i64) -> i64 {
    let mix = |v: i64, factor: u32| (v as u32).wrapping_mul(factor);
    let h = mix(x, 374_761_393)
        .wrapping_add(mix(y, 668_265_263))
        .wrapping_add(mix(c, 2_246_822_519))
        .wrapping_add(mix(frame, 3_266_489_917));
    let h = (h ^ (h >> 13)).wrapping_mul(1_274_126_177);
    i64::from((h ^ (h >> 16)) & 255)
}
