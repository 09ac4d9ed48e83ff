use super::frame::{DeviceInput, keep, load_colour, load_mask, load_motion, show};
use super::kernel::Kernel;
use super::layer::Making;
use super::memory::tensors;
use super::pipelines::{Pipeline, Pipelines};
use super::precision::{Precision, halved};
use super::state::State;
use super::tensor::Place;
use super::timing::Stage;
use crate::input::FrameInput;
use crate::plan::{Layer, Plan, TensorId};
use crate::schedule::{Derived, Schedule};
use crate::weights::Weights;
use crate::{Error, Result};
use fovol_core::{Frame, FrameSize};
use fovol_gpu::Gpu;
use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

/// A network with its weights on a device, ready to run. Any number of sequences can share it. Clones refer to one
/// network.
///
/// Results equal those of [`crate::cpu::Network`] within rounding. [`crate::gpu`] has an example.
#[derive(Clone)]
pub struct Network {
    made: Arc<Made>,
}

/// Contents of a network.
pub struct Made {
    pub gpu: Gpu,
    pub plan: Plan,
    pub precision: Precision,
    /// Whether each tensor is stored as f16.
    pub halved: Vec<bool>,
    /// Kernels in the order of a frame.
    pub steps: Vec<Step>,
    /// States of the plan.
    pub carried: Vec<Carried>,
}

/// A kernel with its pipeline, ready to run.
pub struct Step {
    pub stage: Stage,
    pub kernel: Kernel,
    pub pipeline: Pipeline,
}

/// A state of the plan.
#[derive(Debug, Clone, Copy)]
pub struct Carried {
    /// Tensor from the last frame.
    pub previous: TensorId,
    /// Tensor for the next frame.
    pub next: TensorId,
    /// Whether the buffers of both are swapped after a frame; otherwise one is copied to the other.
    pub is_swapped: bool,
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Network")
            .field("gpu", &self.made.gpu)
            .field("precision", &self.made.precision)
            .field("kernels", &self.made.steps.len())
            .finish_non_exhaustive()
    }
}

impl Network {
    /// Prepares the network of `plan` with `weights` on the device of `gpu`.
    ///
    /// # Errors
    /// Weights that do not fit the plan; layers with more input tensors than shaders can bind (four for
    /// convolutions, four for kernels); a device that is lost or has no memory left.
    pub fn new(gpu: &Gpu, plan: Plan, weights: &Weights, precision: Precision) -> Result<Self> {
        weights.check(&plan)?;
        let precision = precision.on(gpu);
        let halved = halved(&plan, precision);
        let schedule =
            Schedule::new(&plan, &halved, |how| matches!(how, Derived::Folded | Derived::Unfolded));
        let matrices = gpu.matrices().filter(|_| precision == Precision::F16);
        let making = Making { gpu, plan: &plan, weights, halved: &halved, schedule: &schedule, matrices };
        let steps = gpu.guarded("compiling the shaders", || {
            let kernels = kernels(&making)?;
            let mut pipelines = Pipelines::default();
            let step = |(stage, kernel): (Stage, Kernel)| {
                let pipeline = pipelines.of(gpu, &kernel);
                Step { stage, kernel, pipeline }
            };
            Ok::<_, Error>(kernels.into_iter().map(step).collect::<Vec<_>>())
        })??;
        let carried = carried(&making, &steps);
        Ok(Self { made: Arc::new(Made { gpu: gpu.clone(), plan, precision, halved, steps, carried }) })
    }

    /// Plan of the network.
    pub fn plan(&self) -> &Plan {
        &self.made.plan
    }

    /// Device of the network.
    pub fn gpu(&self) -> &Gpu {
        &self.made.gpu
    }

    /// Precision in use on this device; never [`Precision::Auto`].
    pub fn precision(&self) -> Precision {
        self.made.precision
    }

    /// Makes the state for the first frame of a sequence of frames of `size`, and allocates its memory.
    ///
    /// # Errors
    /// A size whose tensors exceed the device's limits or memory.
    pub fn state(&self, size: FrameSize) -> Result<State> {
        State::new(&self.made, size)
    }

    /// Records the commands of a frame, from `input` to [`State::frame_buffer`], in `encoder`. `state` advances to
    /// the next frame, so encoders must be submitted in the order of recording.
    ///
    /// Sampled colours are clamped to 0…1. Pixels with values that are not finite count as unsampled.
    ///
    /// # Errors
    /// A state of another network; buffers that are too small for its frames; a device that is lost or has no
    /// memory left.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        input: DeviceInput<'_>,
        state: &mut State,
    ) -> Result<()> {
        self.check(state)?;
        state.encode(encoder, input)
    }

    /// Reconstructs the full frame of `input`, with alpha 1 everywhere, and advances `state`. Frames are copied
    /// from the host to the device and back. [`Self::encode`] is for frames that are on the device.
    ///
    /// # Errors
    /// A state of another network or size; motion for another size; a device that is lost or has no memory left.
    pub fn reconstruct(&self, input: &FrameInput<'_>, state: &mut State) -> Result<Frame> {
        self.check(state)?;
        state.reconstruct(input)
    }

    fn check(&self, state: &State) -> Result<()> {
        match state.is_of(&self.made) {
            true => Ok(()),
            false => Err(Error::State("it belongs to another network; start one with this network".into())),
        }
    }
}

/// Makes all kernels of a frame.
fn kernels(making: &Making<'_>) -> Result<Vec<(Stage, Kernel)>> {
    let plan = making.plan;
    let mut middle = Vec::new();
    for (number, layer) in plan.layers().iter().enumerate() {
        let made = making.kernels(layer)?;
        middle.extend(made.into_iter().map(|kernel| (Stage::Layer(number), kernel)));
    }
    let mut used: HashSet<TensorId> = middle.iter().flat_map(|(_, kernel)| tensors(kernel)).collect();
    let shown = making.place(plan.output());
    for place in plan.states().iter().map(|state| making.place(state.next)).chain([shown]) {
        if let Place::Tensor(id) = place {
            used.insert(id);
        }
    }
    let inputs = plan.inputs();
    let given = [
        (Some(inputs.colour), load_colour as fn(TensorId) -> Kernel),
        (inputs.mask, load_mask),
        (inputs.motion, load_motion),
    ];
    let given = given.into_iter().filter_map(|(id, load)| Some((id.filter(|id| used.contains(id))?, load)));
    let mut kernels: Vec<(Stage, Kernel)> = given.map(|(id, load)| (Stage::Input, load(id))).collect();
    kernels.append(&mut middle);
    kernels.push((Stage::Output, show(shown)));
    kernels.extend(kept(making).map(|kernel| (Stage::Output, kernel)));
    Ok(kernels)
}

/// Makes the kernels that remove values that are not finite from states. States that are bounded anyway need none.
fn kept(making: &Making<'_>) -> impl Iterator<Item = Kernel> {
    let written = making.plan.layers().iter().filter(|layer| {
        let is_state = making.plan.states().iter().any(|state| state.next == layer.output());
        let is_bounded = matches!(layer, Layer::Clamp { .. } | Layer::Accumulate { .. } | Layer::Join { .. });
        is_state && !is_bounded
    });
    written.map(|layer| keep(making.place(layer.output()), making.is_halved(layer.output())))
}

/// Finds how each state of the plan is carried to the next frame.
fn carried(making: &Making<'_>, steps: &[Step]) -> Vec<Carried> {
    let states = making.plan.states();
    let place = |id: TensorId| match making.place(id) {
        Place::Tensor(id) => id,
        _ => id,
    };
    let is_written = |id: TensorId| {
        let mut kernels = steps.iter().map(|step| &step.kernel);
        kernels.any(|kernel| super::memory::written(kernel).any(|written| written == id))
    };
    states
        .iter()
        .map(|state| {
            let next = place(state.next);
            let is_shared = states.iter().filter(|other| place(other.next) == next).count() > 1;
            Carried { previous: state.previous, next, is_swapped: is_written(next) && !is_shared }
        })
        .collect()
}
