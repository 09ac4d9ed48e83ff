use super::build::PlanBuilder;
use super::definition::Plan;
use super::layers::{Activation, Bypass, Conv, Norm, Read, Scale};
use serde::{Deserialize, Serialize};

/// Configuration of DeepFovea's generator as published (Kaplanyan et al. 2019):
/// docs/guide/src/internals/algorithm.md, section 6.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DeepFoveaConfig {
    /// Channels of the encoders, finest first. The decoders have them in reverse order.
    pub encoder: Vec<usize>,
    /// Channels of the bottleneck.
    pub bottleneck: usize,
}

impl Default for DeepFoveaConfig {
    fn default() -> Self {
        Self { encoder: vec![32, 64, 128, 128, 128], bottleneck: 128 }
    }
}

impl DeepFoveaConfig {
    /// Builds the plan of the network.
    ///
    /// # Errors
    /// Widths that make no network.
    pub fn plan(&self) -> Result<Plan, String> {
        let widths = self.encoder.iter().chain([&self.bottleneck]);
        if self.encoder.is_empty() || self.encoder.len() > 8 || widths.clone().any(|&w| w == 0 || w > 4096) {
            return Err("DeepFovea needs 1 to 8 encoders of 1 to 4096 channels each".into());
        }
        let mut builder = PlanBuilder::new();
        let (colour, mask) = (builder.colour(), builder.mask());
        let signed = builder.add(Scale::new(colour, 2.0, -1.0));
        let mut inputs = vec![Read::same(signed), Read::same(builder.add(Scale::new(mask, 2.0, -1.0)))];
        let mut skips = Vec::new();
        for (depth, &width) in self.encoder.iter().enumerate() {
            let name = |part: &str| format!("encoder.{depth}.{part}");
            let skip = builder.add(Conv::replicating(name("conv1"), &inputs, width, 1, Activation::Elu));
            let down =
                builder.add(Conv::replicating(name("conv2"), &[Read::same(skip)], width, 2, Activation::Elu));
            skips.push(skip);
            inputs = vec![Read::same(down)];
        }
        let mut deepest = inputs[0];
        for part in ["conv1", "conv2"] {
            let name = format!("bottleneck.{part}");
            deepest = Read::same(builder.add(Conv::replicating(
                name,
                &[deepest],
                self.bottleneck,
                1,
                Activation::Elu,
            )));
        }
        let mut below = deepest.tensor;
        let mut carried = Vec::new();
        for depth in (0..self.encoder.len()).rev() {
            let width = self.encoder[depth];
            let name = |part: &str| format!("decoder.{depth}.{part}");
            let up = [Read::nearest(below), Read::same(skips[depth])];
            let up = builder.add(Conv::replicating(name("conv1"), &up, width, 1, Activation::Elu));
            let state = builder.state(&format!("decoder.{depth}"), width, depth as u32);
            let both = [Read::same(up), Read::same(state)];
            let both = builder.add(Conv::replicating(name("conv2"), &both, width, 1, Activation::None));
            below = builder.add(Norm::new(name("norm"), both, Activation::Elu));
            carried.push((state, below));
        }
        let picture = builder.add(Conv::new("output", &[Read::same(below)], 3, 1, Activation::None));
        let picture = builder.add(Bypass::new(signed, mask, picture));
        let picture = builder.add(Scale::new(picture, 0.5, 0.5));
        for (previous, next) in carried {
            builder.keep(previous, next);
        }
        Ok(builder.finish(picture))
    }
}
