//! Measures the time of one training step. `benchmarks/peers/training_step.py` runs it beside PyTorch.

use anyhow::Result;
use clap::Args;
use fovol_net::plan::Named;
use fovol_train::network::{Inputs, Network, Options, Spread, initial_weights};
use fovol_train::optimise::{Ranger, RangerConfig};
use fovol_train::terminal::say;
use std::time::Instant;
use tch::{Device, Kind, Tensor};

/// Network, clip size and options of the measurement.
#[derive(Args)]
pub struct BenchStep {
    /// Which network
    #[arg(long, default_value_t = Named::WNetFast)]
    network: Named,
    /// Frames of a clip
    #[arg(long, default_value_t = 16)]
    clip: usize,
    /// Rows and columns of a frame
    #[arg(long, default_value_t = 256)]
    size: i64,
    /// Clips of a step
    #[arg(long, default_value_t = 1)]
    batch: i64,
    /// Threads of the processor
    #[arg(long, default_value_t = 2)]
    threads: i32,
    /// Measured steps, after one unmeasured warm-up step
    #[arg(long, default_value_t = 1)]
    repeats: usize,
    /// Compute 3×3 convolutions in bf16
    #[arg(long)]
    bf16: bool,
    /// Keep tensors in channels-last layout
    #[arg(long)]
    channels_last: bool,
}

/// Inputs and target of one frame: \[batch, channels, rows, columns\].
struct Sample {
    colour: Tensor,
    mask: Tensor,
    motion: Tensor,
    target: Tensor,
}

impl BenchStep {
    /// Runs the measurement and prints one line of JSON.
    ///
    /// # Errors
    /// Sizes that make no frame.
    pub fn run(&self) -> Result<()> {
        tch::set_num_threads(self.threads);
        tch::manual_seed(1);
        let device = Device::cuda_if_available();
        let options = Options { bf16: self.bf16, channels_last: self.channels_last, ..Options::default() };
        let network =
            Network::new(&initial_weights(&self.network.config(), Spread::Pytorch, 1)?, options, device)?;
        let mut ranger = Ranger::new(&network.parameters(), RangerConfig::default());
        let clip: Vec<Sample> = (0..self.clip).map(|_| self.sample(device)).collect();
        self.step(&network, &mut ranger, &clip)?;
        let mut seconds = Vec::new();
        for _ in 0..self.repeats {
            let started = Instant::now();
            self.step(&network, &mut ranger, &clip)?;
            seconds.push(started.elapsed().as_secs_f64());
        }
        let network = self.network.name();
        say(serde_json::json!({ "network": network, "seconds": seconds }));
        Ok(())
    }

    /// Random colours at 5 % of the pixels, and random motion of up to two pixels.
    fn sample(&self, device: Device) -> Sample {
        let random =
            |channels: i64| Tensor::rand([self.batch, channels, self.size, self.size], (Kind::Float, device));
        let (target, mask) = (random(3), random(1).lt(0.05).to_kind(Kind::Float));
        Sample { colour: &target * &mask, motion: (random(2) - 0.5) * 4.0, mask, target }
    }

    /// Forward and backward pass over the whole clip, and one optimiser step.
    fn step(&self, network: &Network, ranger: &mut Ranger, clip: &[Sample]) -> Result<()> {
        let mut state = network.initial_state([self.batch, self.size, self.size]);
        let mut losses = Vec::new();
        for Sample { colour, mask, motion, target } in clip {
            let inputs = Inputs { colour, mask: Some(mask), motion: Some(motion) };
            let (picture, next) = network.forward(&inputs, state)?;
            state = next;
            losses.push((picture - target).abs().mean(Kind::Float));
        }
        ranger.zero_gradients();
        let loss = Tensor::stack(&losses, 0).mean(Kind::Float);
        loss.backward();
        ranger.step(1e-3);
        // Reading the loss waits for all work that the device still has to do.
        anyhow::ensure!(loss.double_value(&[]).is_finite(), "the loss is no number");
        Ok(())
    }
}
