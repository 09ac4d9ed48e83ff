use super::variation::Variation;
use crate::mask_noise::MaskNoise;
use fovol_core::FrameSize;
use fovolnet::render::Importance;

impl Variation {
    /// Sampling mask of frame `t`: docs/guide/src/internals/algorithm.md, section 1. With `importance` the density follows
    /// it, with as many samples as without.
    pub(super) fn sampled(
        &self,
        size: FrameSize,
        t: usize,
        noise: &MaskNoise,
        importance: Option<&Importance>,
    ) -> Vec<bool> {
        let along = if self.length > 1 { t as f64 / (self.length - 1) as f64 } else { 0.0 };
        let gaze: [f64; 2] =
            std::array::from_fn(|a| self.gaze[0][a] + (self.gaze[1][a] - self.gaze[0][a]) * along);
        let [left, top, slice] = self.offset;
        let noise = noise.frame(slice + t as u32);
        let falloff = |at: u32, gaze: f64| {
            if self.sigma > 0.0 {
                (-0.5 * ((f64::from(at) + 0.5 - gaze) / self.sigma).powi(2)).exp()
            } else {
                0.0
            }
        };
        // The least base density with which each pixel is sampled.
        let mut keys = Vec::with_capacity(size.pixels());
        for y in 0..size.height {
            let row = falloff(y, gaze[1]);
            keys.extend((0..size.width).map(|x| {
                let seen = row * falloff(x, gaze[0]);
                (noise.threshold(x + left, y + top) - seen).max(0.0) / (1.0 - seen).max(f64::MIN_POSITIVE)
            }));
        }
        let fixed: Vec<bool> = keys.iter().map(|key| *key < self.base).collect();
        let Some(importance) = importance else { return fixed };
        let budget = fixed.iter().filter(|is_sampled| **is_sampled).count();
        for (at, key) in keys.iter_mut().enumerate() {
            *key /= f64::from(importance.at(at as u32 % size.width, at as u32 / size.width));
        }
        let mut ordered = keys.clone();
        let Some(last) = budget.checked_sub(1) else { return fixed };
        let (_, limit, _) = ordered.select_nth_unstable_by(last, f64::total_cmp);
        keys.iter().map(|key| *key <= *limit).collect()
    }
}
