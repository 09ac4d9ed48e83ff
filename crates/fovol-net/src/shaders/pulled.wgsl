// How a pull-push pyramid pulls: weighted means of pixels. Twin of the constants of cpu/fill/pyramid.rs.

/// Lower limit of divisors.
const SMALLEST = 1e-8;
/// Gain of weights: a mean weight of 1/8 suffices for a full weight at half the resolution.
const GAIN = 8.0;
/// Binomial weights of four neighbours.
const BINOMIAL = vec4f(0.125, 0.375, 0.375, 0.125);

/// Binomial mean of four pixels.
fn binomial(a: vec4f, b: vec4f, c: vec4f, d: vec4f) -> vec4f {
    return (BINOMIAL[0] * a + BINOMIAL[1] * b) + (BINOMIAL[2] * c + BINOMIAL[3] * d);
}

/// Mean pixel with its weight raised.
fn gained(mean: vec4f) -> vec4f {
    let weight = min(GAIN * mean.a, 1.0);
    return vec4f(mean.rgb * (weight / max(mean.a, SMALLEST)), weight);
}
