//! Calibration of activation ranges, which int8 networks need.

use super::TrainConfig;
use super::lessons::prepare;
use super::validation::sparse_frame;
use crate::Result;
use crate::clips::ClipSet;
use crate::lesson::{LessonFrame, TrainingBatch};
use fovol_core::SparseFrame;
use fovol_net::Weights;
use fovol_net::cpu::{FrameInput, calibrate};
use tch::{Device, Kind, Tensor};

/// Number of batches that ranges are taken from.
const LESSONS: u64 = 24;

/// Records in `weights` the ranges of activations on batches of `config` from `clips`.
///
/// # Errors
/// Clips that cannot be read, or no clips.
pub fn note_ranges(weights: &mut Weights, clips: &ClipSet, config: &TrainConfig) -> Result<()> {
    let single = TrainConfig { batch: 1, ..config.clone() };
    let lesson = TrainingBatch::new(&config.lesson)?;
    let lessons: Vec<Vec<Given>> = (0..LESSONS)
        .map(|number| prepare(clips, &single, &lesson, number)?.iter().map(Given::of).collect())
        .collect::<Result<_>>()?;
    let inputs: Vec<_> =
        lessons.iter().map(|frames| frames.iter().map(Given::input).collect::<Vec<_>>()).collect();
    Ok(calibrate(weights, &inputs)?)
}

/// Input of a network for one frame.
struct Given {
    sparse: SparseFrame,
    motion: Vec<[f32; 2]>,
}

impl Given {
    fn of(frame: &LessonFrame) -> Result<Self> {
        let planes = |channel| -> Vec<f32> {
            let plane: Tensor = frame.motion.get(0).get(channel);
            let flat = plane.to_device(Device::Cpu).to_kind(Kind::Float).contiguous().view([-1]);
            let mut values = vec![0.0; flat.numel()];
            flat.copy_data(&mut values, flat.numel());
            values
        };
        let motion = planes(0).into_iter().zip(planes(1)).map(|(x, y)| [x, y]).collect();
        Ok(Self { sparse: sparse_frame(frame)?, motion })
    }

    fn input(&self) -> FrameInput<'_> {
        FrameInput { sparse: &self.sparse, motion: Some(&self.motion) }
    }
}
