//! Reset of dead channels during training.
//!
//! A rectifier that is zero for every input passes no gradient and stays dead. Sokar et al. ("The dormant neuron
//! phenomenon in deep reinforcement learning", 2023) give such channels new weights. The layers that read them get
//! weights of zero, so that the output stays unchanged until they have learned.

use crate::Result;
use crate::network::{Spread, initial_weights};
use fovol_net::plan::{Activation, Conv, Layer, Plan, Pool, TensorId};
use fovol_net::weights::Array;
use fovol_net::{Error, Weights};

/// Channels whose activations never exceed this are dead. Live channels reach 0.1 to 20.
const DEAD: f32 = 0.01;

/// Resets the dead channels of `weights`, found by the activation ranges stored in them. Returns the new weights and
/// the number of channels.
///
/// # Errors
/// Weights of a configuration that makes no network.
pub(super) fn revived(weights: &Weights, spread: Spread, seed: u64) -> Result<(Weights, usize)> {
    let plan = weights.config.plan().map_err(Error::Config)?;
    let fresh = initial_weights(&weights.config, spread, seed)?;
    let dead: Vec<(&Conv, Vec<usize>)> =
        rectified(&plan).map(|conv| (conv, dead(&plan, conv, weights))).collect();
    let mut arrays = weights.arrays().clone();
    // Zero the readers first: a reader may itself be dead, and its new weights must stay.
    for (conv, channels) in &dead {
        for (name, first) in readers(&plan, conv.output) {
            if let Some(weight) = arrays.get_mut(&format!("{name}.weight")) {
                silence(weight, first, channels);
            }
        }
    }
    for (conv, channels) in &dead {
        for name in ["weight", "bias"].map(|part| format!("{}.{part}", conv.name)) {
            if let (Some(array), Some(drawn)) = (arrays.get_mut(&name), fresh.arrays().get(&name)) {
                redraw(array, drawn, channels);
            }
        }
    }
    let mut revived = Weights::new(weights.config.clone(), arrays);
    revived.facts.clone_from(&weights.facts);
    Ok((revived, dead.iter().map(|(_, channels)| channels.len()).sum()))
}

fn rectified(plan: &Plan) -> impl Iterator<Item = &Conv> {
    plan.layers().iter().filter_map(|layer| match layer {
        Layer::Conv(conv) if conv.activation == Activation::Relu => Some(conv),
        _ => None,
    })
}

fn dead(plan: &Plan, conv: &Conv, weights: &Weights) -> Vec<usize> {
    let reach = weights.ranges.get(&plan.tensor(conv.output).name);
    let of = |reach: &Vec<f32>| (0..reach.len()).filter(|&channel| reach[channel] < DEAD).collect();
    reach.map(of).unwrap_or_default()
}

/// Layers that read the channels of tensor `id`, directly or pooled, in this frame or the next. The number is the
/// index of the first of these channels in the layer's input.
fn readers(plan: &Plan, id: TensorId) -> Vec<(String, usize)> {
    let kept = plan.states().iter().filter(|state| state.next == id);
    let later = kept.flat_map(|state| readers(plan, state.previous));
    plan.layers().iter().flat_map(|layer| places(plan, layer, id)).chain(later).collect()
}

/// [`readers`] in one layer.
fn places(plan: &Plan, layer: &Layer, id: TensorId) -> Vec<(String, usize)> {
    match layer {
        Layer::Conv(conv) => {
            let begins = conv.inputs.iter().scan(0, |next, read| {
                let first = *next;
                *next += plan.tensor(read.tensor).channels;
                Some((read.tensor, first))
            });
            begins.filter(|(tensor, _)| *tensor == id).map(|(_, first)| (conv.name.clone(), first)).collect()
        }
        Layer::Filter(filter) if filter.features == id => vec![(filter.name.clone(), 0)],
        Layer::Pool(Pool { input, output }) if *input == id => readers(plan, *output),
        // Other layers process pictures. Normalisations, which have weights, precede rectifiers.
        _ => Vec::new(),
    }
}

/// Sets the weights of inputs `first + channels` of `weight` \[out, in, rows, columns\] to zero.
fn silence(weight: &mut Array, first: usize, channels: &[usize]) {
    let (inputs, window) = (weight.shape[1], weight.shape[2..].iter().product::<usize>());
    for of_output in weight.values.chunks_exact_mut(inputs * window) {
        for channel in channels {
            of_output[(first + channel) * window..][..window].fill(0.0);
        }
    }
}

/// Copies the values of outputs `channels` from `drawn` to `array` \[out, …\].
fn redraw(array: &mut Array, drawn: &Array, channels: &[usize]) {
    let each: usize = array.shape[1..].iter().product();
    for channel in channels {
        let own = channel * each..(channel + 1) * each;
        array.values[own.clone()].copy_from_slice(&drawn.values[own]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_net::plan::Named;
    use std::collections::BTreeMap;

    /// Weights of the default network with these channels dead; all others reach 1.
    fn with_dead(dead: &[(&str, &[usize])]) -> Weights {
        let config = Named::WNetFast.config();
        let plan = config.plan().unwrap();
        let mut weights = initial_weights(&config, Spread::He, 1).unwrap();
        let mut ranges: BTreeMap<String, Vec<f32>> = rectified(&plan)
            .map(|conv| (conv.name.clone(), vec![1.0; plan.tensor(conv.output).channels]))
            .collect();
        for (name, channels) in dead {
            channels.iter().for_each(|&channel| ranges.get_mut(*name).unwrap()[channel] = 0.0);
        }
        weights.ranges = ranges;
        weights
    }

    fn changed(before: &Weights, after: &Weights, name: &str) -> Vec<usize> {
        let (before, after) = (before.values(name).unwrap(), after.values(name).unwrap());
        (0..before.len()).filter(|&at| before[at] != after[at]).collect()
    }

    #[test]
    fn nothing_changes_where_all_is_alive() {
        let weights = with_dead(&[]);
        let (after, count) = revived(&weights, Spread::He, 2).unwrap();
        assert_eq!(count, 0);
        assert_eq!(after.arrays(), weights.arrays());
    }

    #[test]
    fn a_dead_channel_gets_new_weights_and_is_not_heard_at_first() {
        let weights = with_dead(&[("encoder.1.conv2", &[5]), ("decoder.2.conv2", &[3])]);
        let (after, count) = revived(&weights, Spread::He, 2).unwrap();
        assert_eq!(count, 2);
        let each = 16 * 9;
        let redrawn = changed(&weights, &after, "encoder.1.conv2.weight");
        assert_eq!(redrawn, (5 * each..6 * each).collect::<Vec<_>>());
        // The next encoder reads the pooled output. The decoder reads both: the encoder as a skip connection and,
        // after it, the second tensor.
        for (reader, silent) in [("encoder.2.conv1", vec![5]), ("decoder.1.conv1", vec![5, 16 + 3])] {
            let weight = &after.arrays()[&format!("{reader}.weight")];
            let zeros = (0..weight.values.len()).filter(|&at| weight.values[at] == 0.0);
            let expected = (0..weight.values.len()).filter(|at| silent.contains(&(at / 9 % weight.shape[1])));
            assert_eq!(zeros.collect::<Vec<_>>(), expected.collect::<Vec<_>>(), "{reader}");
        }
        let touched = after.arrays().keys().filter(|name| !changed(&weights, &after, name).is_empty());
        assert_eq!(touched.count(), 4);
    }

    #[test]
    fn a_dead_layer_hears_a_dead_layer_before_it() {
        let all: Vec<usize> = (0..32).collect();
        let weights = with_dead(&[("decoder.2.conv1", &all), ("decoder.2.conv2", &all)]);
        let (after, count) = revived(&weights, Spread::He, 2).unwrap();
        assert_eq!(count, 64);
        assert!(after.values("decoder.2.conv2.weight").unwrap().iter().all(|&w| w != 0.0));
    }
}
