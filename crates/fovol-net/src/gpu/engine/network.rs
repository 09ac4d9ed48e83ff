use super::frame::{DeviceInput, keep, load_colour, load_mask, load_motion, show};
use super::memory::{tensors, written};
use super::prepared::{Carried, Prepared, Step};
use super::state::State;
use super::timing::Stage;
use crate::gpu::kernel::{Context, Kernel, Pipelines};
use crate::gpu::layers;
use crate::gpu::tensor::{Place, Precision, halved};
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
    prepared: Arc<Prepared>,
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Network")
            .field("gpu", &self.prepared.gpu)
            .field("precision", &self.prepared.precision)
            .field("kernels", &self.prepared.steps.len())
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
        let context = Context { gpu, plan: &plan, weights, halved: &halved, schedule: &schedule, matrices };
        let steps = gpu.guarded("compiling the shaders", || {
            let kernels = kernels(&context)?;
            let mut pipelines = Pipelines::default();
            let step = |(stage, kernel): (Stage, Kernel)| {
                let pipeline = pipelines.of(gpu, &kernel);
                Step { stage, kernel, pipeline }
            };
            Ok::<_, Error>(kernels.into_iter().map(step).collect::<Vec<_>>())
        })??;
        let carried = carried(&context, &steps);
        Ok(Self {
            prepared: Arc::new(Prepared { gpu: gpu.clone(), plan, precision, halved, steps, carried }),
        })
    }

    /// Plan of the network.
    pub fn plan(&self) -> &Plan {
        &self.prepared.plan
    }

    /// Device of the network.
    pub fn gpu(&self) -> &Gpu {
        &self.prepared.gpu
    }

    /// Precision in use on this device; never [`Precision::Auto`].
    pub fn precision(&self) -> Precision {
        self.prepared.precision
    }

    /// Makes the state for the first frame of a sequence of frames of `size`, and allocates its memory.
    ///
    /// # Errors
    /// A size whose tensors exceed the device's limits or memory.
    pub fn state(&self, size: FrameSize) -> Result<State> {
        State::new(&self.prepared, size)
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
        match state.is_of(&self.prepared) {
            true => Ok(()),
            false => Err(Error::State("it belongs to another network; start one with this network".into())),
        }
    }
}

/// Makes all kernels of a frame.
fn kernels(context: &Context<'_>) -> Result<Vec<(Stage, Kernel)>> {
    let plan = context.plan;
    let mut middle = Vec::new();
    let mut number = 0;
    while number < plan.layers().len() {
        let (made, count) = layers::kernels(context, number)?;
        middle.extend(made.into_iter().map(|kernel| (Stage::Layer(number), kernel)));
        number += count;
    }
    let mut used: HashSet<TensorId> = middle.iter().flat_map(|(_, kernel)| tensors(kernel)).collect();
    let shown = context.place(context.schedule.shown);
    for place in plan.states().iter().map(|state| context.place(state.next)).chain([shown]) {
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
    let shows = |kernel: &Kernel| kernel.operands.iter().any(|operand| operand.place() == Some(Place::Frame));
    if !kernels.iter().any(|(_, kernel)| shows(kernel)) {
        kernels.push((Stage::Output, show(shown)));
    }
    kernels.extend(kept(context).map(|kernel| (Stage::Output, kernel)));
    Ok(kernels)
}

/// Makes the kernels that remove values that are not finite from states. States that are bounded anyway need none.
fn kept(context: &Context<'_>) -> impl Iterator<Item = Kernel> {
    let written = context.plan.layers().iter().filter(|layer| {
        let is_state = context.plan.states().iter().any(|state| state.next == layer.output());
        let is_bounded = matches!(layer, Layer::Clamp(_) | Layer::Accumulate(_) | Layer::Join(_));
        is_state && !is_bounded
    });
    written.map(|layer| keep(context.place(layer.output()), context.is_halved(layer.output())))
}

/// Finds how each state of the plan is carried to the next frame.
fn carried(context: &Context<'_>, steps: &[Step]) -> Vec<Carried> {
    let states = context.plan.states();
    let place = |id: TensorId| match context.place(id) {
        Place::Tensor(id) => id,
        _ => id,
    };
    let is_written = |id: TensorId| {
        let mut kernels = steps.iter().map(|step| &step.kernel);
        kernels.any(|kernel| written(kernel).any(|written| written == id))
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
