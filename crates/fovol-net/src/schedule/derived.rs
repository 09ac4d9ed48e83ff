//! Tensors that are never written, because their readers compute them from another tensor.

use crate::plan::{Add, DepthToSpace, Layer, Part, Plan, Pool, Read, SpaceToDepth, TensorId};

/// Transformation by which a tensor is computed from another one during reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Derived {
    /// 2×2 pixels are folded into one with four times the channels.
    Folded,
    /// Channels are unfolded into 2×2 pixels.
    Unfolded,
    /// 2×2 pixels are averaged.
    Pooled,
    /// The channel of this number is taken.
    Channel(usize),
    /// 2×2 pixels of the channel of this number are folded into one pixel of four channels.
    FoldedChannel(usize),
}

impl Derived {
    /// Source tensor and transformation of the output of `layer`, if it is such a transformation.
    fn of(plan: &Plan, layer: &Layer) -> Option<(TensorId, Self)> {
        match layer {
            Layer::SpaceToDepth(SpaceToDepth { input, .. }) => Some((*input, Self::Folded)),
            Layer::DepthToSpace(DepthToSpace { input, .. }) => Some((*input, Self::Unfolded)),
            Layer::Pool(Pool { input, .. }) => Some((*input, Self::Pooled)),
            Layer::Part(Part { input, first, output, .. }) if plan.tensor(*output).channels == 1 => {
                Some((*input, Self::Channel(*first)))
            }
            _ => None,
        }
    }

    /// Combines this transformation of `from` with the one `before` by which `from` is computed. `None` if `from`
    /// has to be written.
    fn after(self, before: Option<(TensorId, Self)>, from: TensorId) -> Option<(TensorId, Self)> {
        match (self, before) {
            (_, None) => Some((from, self)),
            (Self::Folded, Some((whole, Self::Channel(number)))) => {
                Some((whole, Self::FoldedChannel(number)))
            }
            _ => None,
        }
    }
}

/// Finds the tensors of `plan` that need not be written, with source and transformation.
///
/// Readers must be able to transform them: convolutions that read them at their own resolution, predicted kernels
/// for pooled tensors, additions for unfolded ones, and folds for single channels. The source must be written, and
/// `is_way` must allow the transformation.
pub(super) fn derived(plan: &Plan, is_way: impl Fn(Derived) -> bool) -> Vec<Option<(TensorId, Derived)>> {
    let mut derived: Vec<Option<(TensorId, Derived)>> = vec![None; plan.tensors().len()];
    for layer in plan.layers() {
        let follows = Derived::of(plan, layer).filter(|(_, how)| is_way(*how));
        derived[layer.output().index()] =
            follows.and_then(|(from, how)| how.after(derived[from.index()], from));
        for id in layer.inputs() {
            let is_read_in_place = match (layer, derived[id.index()]) {
                (Layer::Conv(conv), Some((_, how))) => {
                    !matches!(how, Derived::Unfolded | Derived::Channel(_))
                        && conv.inputs.iter().all(|read| read.tensor != id || *read == Read::same(id))
                }
                (Layer::Filter(filter), Some((_, Derived::Pooled))) => {
                    id != filter.features
                        && filter.images.iter().all(|(read, _)| read.tensor != id || *read == Read::same(id))
                }
                (Layer::Add(Add { input, more, .. }), Some((_, Derived::Unfolded))) => {
                    id == *more && id != *input
                }
                (Layer::SpaceToDepth(SpaceToDepth { output, .. }), Some((_, Derived::Channel(_)))) => {
                    derived[output.index()].is_some()
                }
                _ => false,
            };
            if !is_read_in_place {
                derived[id.index()] = None;
            }
        }
    }
    for id in plan.states().iter().map(|state| state.next).chain([plan.output()]) {
        derived[id.index()] = None;
    }
    // A channel that is not only folded has to be written, and folds of it then read it directly.
    for layer in plan.layers() {
        let Layer::SpaceToDepth(SpaceToDepth { input, output }) = layer else { continue };
        match derived[output.index()] {
            None => derived[input.index()] = None,
            Some((_, Derived::FoldedChannel(_))) if derived[input.index()].is_none() => {
                derived[output.index()] = Some((*input, Derived::Folded));
            }
            _ => {}
        }
    }
    derived
}
