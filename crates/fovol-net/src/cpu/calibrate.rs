use super::network::{FrameInput, Network};
use super::precision::Precision;
use super::simd::Simd;
use crate::weights::Weights;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Finds what values the tensors of a network reach on `clips`, each of frames of one size, and notes it in `weights`:
/// bytes are steps of these ranges.
///
/// # Errors
/// Weights that fit no network, clips without frames or with frames of different sizes.
pub fn calibrate(weights: &mut Weights, clips: &[Vec<FrameInput<'_>>]) -> Result<()> {
    if clips.is_empty() || clips.iter().any(Vec::is_empty) {
        return Err(Error::Config("calibration needs at least one clip, and each a frame".into()));
    }
    let plan = weights.config.plan().map_err(Error::Config)?;
    let network = Network::layer_by_layer(plan, weights, Simd::best(), Precision::F32)?;
    let mut most = vec![0.0f32; network.plan().tensors().len()];
    let inputs = network.plan().inputs();
    for id in [Some(inputs.colour), inputs.mask].into_iter().flatten() {
        most[id.index()] = 1.0;
    }
    for clip in clips {
        let mut state = network.state(clip[0].sparse.size());
        for frame in clip {
            network.observed(&mut frame.sparse.clone(), frame.motion, &mut state, |layers, out, _| {
                let place = network.plan().layers()[layers.start].output().index();
                most[place] = out.to_f32().data.iter().fold(most[place], |most, v| most.max(v.abs()));
            })?;
        }
    }
    let plan = network.plan();
    for state in plan.states() {
        most[state.previous.index()] = most[state.next.index()];
    }
    let named = plan.tensors().iter().zip(most).map(|(tensor, most)| (tensor.name.clone(), most));
    weights.ranges = named.collect::<BTreeMap<_, _>>();
    Ok(())
}
