//! Several volumes at one point.

use super::RayResult;

/// Opacities above this count as this, so that extinctions stay finite.
const OPAQUEST: f64 = 1.0 - 1e-6;

/// Extinction per reference length, in 1/voxel, of an opacity per reference length: −ln(1 − `opacity`).
pub fn extinction(opacity: f64) -> f64 {
    -(-opacity.min(OPAQUEST)).ln_1p()
}

/// Opacity per reference length of `opacity` whose extinction is scaled by `factor`, 0…1.
pub fn thinned(opacity: f64, factor: f64) -> f64 {
    -(-extinction(opacity) * factor).exp_m1()
}

/// Colour and opacity of volumes of these colours and opacities at one point. Opacities add as extinctions, colours weigh by
/// their extinction.
pub fn blended(volumes: impl IntoIterator<Item = [f64; 4]>) -> [f64; 4] {
    let (mut colour, mut whole, mut clear) = ([0.0; 3], 0.0, 1.0);
    for [r, g, b, opacity] in volumes {
        let weight = extinction(opacity);
        for (sum, channel) in colour.iter_mut().zip([r, g, b]) {
            *sum += weight * channel;
        }
        whole += weight;
        clear *= 1.0 - opacity;
    }
    if whole == 0.0 {
        return [0.0; 4];
    }
    let [r, g, b] = colour.map(|sum| sum / whole);
    [r, g, b, 1.0 - clear]
}

/// The result of a ray over `background` that has these results in several volumes, each of one value. Its depth is that of the
/// most opaque.
pub fn blended_results(volumes: &[RayResult], background: [f32; 3]) -> RayResult {
    let of = |volume: &RayResult| {
        let share = |channel: f32| if volume.opacity > 0.0 { channel / volume.opacity } else { 0.0 };
        let [r, g, b] = volume.unshadowed.map(|channel| f64::from(share(channel)));
        [r, g, b, f64::from(volume.opacity)]
    };
    let [r, g, b, opacity] = blended(volumes.iter().map(of)).map(|channel| channel as f32);
    if opacity == 0.0 {
        return RayResult::nothing(background);
    }
    let unshadowed = [r, g, b].map(|channel| opacity * channel);
    let colour = std::array::from_fn(|c| unshadowed[c] + (1.0 - opacity) * background[c]);
    let most = volumes.iter().max_by(|a, b| a.opacity.total_cmp(&b.opacity));
    RayResult { colour, unshadowed, opacity, depth: most.map_or(f32::INFINITY, |most| most.depth) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacities_add_as_extinctions_and_colours_weigh_by_them() {
        let red = [1.0, 0.0, 0.0, 0.5];
        let blue = [0.0, 0.0, 1.0, 0.75];
        let [r, g, b, a] = blended([red, blue]);
        assert!((r - 1.0 / 3.0).abs() < 1e-12 && g == 0.0 && (b - 2.0 / 3.0).abs() < 1e-12);
        assert!((a - 0.875).abs() < 1e-12);
        assert_eq!(blended([red, [0.2, 0.3, 0.4, 0.0]]), red);
        assert_eq!(blended([[0.2, 0.3, 0.4, 0.0]; 2]), [0.0; 4]);
        assert!(blended([[1.0; 4]; 2]).iter().all(|channel| (channel - 1.0).abs() < 1e-12));
    }

    #[test]
    fn thinned_opacities_have_a_part_of_the_extinction() {
        assert!((thinned(0.75, 0.5) - 0.5).abs() < 1e-12 && thinned(0.75, 0.0) == 0.0);
        assert!((thinned(0.3, 1.0) - 0.3).abs() < 1e-12 && thinned(1.0, 1.0) > 0.999_998);
    }

    #[test]
    fn results_blend_like_samples() {
        let of = |colour: [f32; 3], opacity: f32, depth: f32| RayResult {
            colour,
            unshadowed: colour.map(|channel| opacity * channel),
            opacity,
            depth,
        };
        let results = [of([1.0, 0.0, 0.0], 0.5, 1.0), of([0.0, 0.0, 1.0], 0.75, 2.0)];
        let blended = blended_results(&results, [1.0; 3]);
        assert!((blended.opacity - 0.875).abs() < 1e-6 && blended.depth == 2.0);
        let expected = [0.875 / 3.0 + 0.125, 0.125, 0.875 * 2.0 / 3.0 + 0.125];
        assert!(blended.colour.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
