//! Evaluation of a network on one frame.

use super::inputs::Inputs;
use super::layers;
use super::layers::points;
use super::model::Network;
use super::quantise;
use fovol_net::plan::{Conv, Filter, Layer, Read, TensorId};
use std::collections::HashMap;
use tch::{Kind, Tensor};

/// Tensors of one frame of a batch, as far as layers have written them.
pub(super) struct Frame<'a> {
    network: &'a Network,
    /// Tensors by their place in the plan, in the kind in which they were written.
    values: Vec<Option<Tensor>>,
    /// Copies in other kinds that layers have asked for; each is made once.
    casts: HashMap<(TensorId, Kind), Tensor>,
    /// Kind of pictures, predicted kernels and states.
    exact: Kind,
    /// Kind of the inputs and outputs of 3×3 convolutions.
    wide: Kind,
}

impl<'a> Frame<'a> {
    /// Starts a frame with the padded inputs and the state.
    pub fn new(network: &'a Network, inputs: &Inputs<'_>, state: Vec<Tensor>) -> Self {
        let exact = network.kind();
        let wide = if network.options.bf16 { Kind::BFloat16 } else { exact };
        let values = network.plan.tensors().iter().map(|_| None).collect();
        let mut frame = Self { network, values, casts: HashMap::new(), exact, wide };
        let plan = &network.plan;
        let colour = frame.padded(inputs.colour);
        if let Some(id) = plan.inputs().mask {
            frame.values[id.index()] = inputs.mask.map(|mask| frame.padded(mask));
        }
        if let Some(id) = plan.inputs().motion {
            let still = || colour.narrow(1, 0, 2).zeros_like();
            let motion = inputs.motion.map_or_else(still, |motion| frame.padded(motion));
            frame.values[id.index()] = Some(motion);
        }
        frame.values[plan.inputs().colour.index()] = Some(colour);
        for (kept, tensor) in plan.states().iter().zip(state) {
            frame.values[kept.previous.index()] = Some(tensor);
        }
        frame
    }

    /// Pads `image` by replication at the right and bottom, so that the network can halve its size.
    fn padded(&self, image: &Tensor) -> Tensor {
        let [_, _, height, width] = layers::shape(image);
        let [rows, columns] = self.network.padded([height, width]);
        let image = layers::cast(&image.to_device(self.network.device), self.exact);
        if [rows, columns] == [height, width] {
            return image;
        }
        image.replication_pad2d([0, columns - width, 0, rows - height])
    }

    /// Tensor `id` as `kind`.
    ///
    /// # Panics
    /// If the tensor has not been written. Plans order layers such that this does not happen.
    fn read(&mut self, id: TensorId, kind: Kind) -> Tensor {
        let Some(value) = &self.values[id.index()] else {
            panic!("`{}` is read before it is written", self.network.plan.tensor(id).name);
        };
        if value.kind() == kind {
            return value.shallow_clone();
        }
        self.casts.entry((id, kind)).or_insert_with(|| value.to_kind(kind)).shallow_clone()
    }

    /// Tensor `id` in the kind of pictures and states.
    pub fn exact(&mut self, id: TensorId) -> Tensor {
        self.read(id, self.exact)
    }

    fn resized(&mut self, read: Read, kind: Kind) -> Tensor {
        layers::resized(&self.read(read.tensor, kind), read.resize)
    }

    /// Weight and bias of layer `name` as `kind`.
    fn pair(&self, name: &str, kind: Kind) -> [Tensor; 2] {
        ["weight", "bias"].map(|part| layers::cast(&self.network.parameters[&format!("{name}.{part}")], kind))
    }

    /// Runs one layer.
    pub fn run(&mut self, layer: &Layer) {
        let written = match layer {
            Layer::Conv(layer) => self.conv(layer),
            Layer::Norm(layer) => {
                let [weight, bias] = self.pair(&layer.name, self.exact);
                layers::norm(&self.exact(layer.input), &weight, &bias, layer.activation)
            }
            Layer::Filter(layer) => self.filter(layer),
            Layer::Pool(layer) => layers::pool(&self.as_written(layer.input), 2),
            Layer::SpaceToDepth(layer) => self.as_written(layer.input).pixel_unshuffle(2),
            Layer::DepthToSpace(layer) => self.as_written(layer.input).pixel_shuffle(2),
            Layer::Scale(layer) => {
                self.exact(layer.input) * f64::from(layer.factor) + f64::from(layer.offset)
            }
            Layer::Clamp(layer) => self.exact(layer.input).clamp(0.0, 1.0),
            Layer::Join(layer) => Tensor::cat(&[layer.colour, layer.weight].map(|id| self.exact(id)), 1),
            Layer::Spread(layer) => {
                let base = layer.base.map(|base| self.exact(base));
                layers::spread(&self.exact(layer.known), base.as_ref(), layer.levels)
            }
            Layer::Smooth(layer) => layers::smooth(&self.exact(layer.input)),
            Layer::Blend(layer) => layers::blend(&self.exact(layer.known), &self.exact(layer.base)),
            Layer::HistoryConfidence(layer) => {
                let [known, prior, fresh] = [layer.known, layer.prior, layer.fresh].map(|id| self.exact(id));
                // Detached like points: the prior is judged here, and no gradient should make it easier to trust.
                let prior = prior.detach();
                let lowest = self.network.plan.tensor(layer.output).level;
                layers::history_confidence(&known, [&prior, &fresh], [layer.levels, lowest])
            }
            Layer::Accumulate(layer) => {
                let share = layer.share.map(|share| self.exact(share));
                let [known, before] = [layer.known, layer.before].map(|id| self.exact(id));
                layers::accumulate(&known, &before, share.as_ref(), layer.fade)
            }
            Layer::Part(layer) => {
                self.exact(layer.input).narrow(1, layer.first as i64, layer.channels as i64)
            }
            Layer::Add(layer) => self.exact(layer.input) + self.exact(layer.more),
            Layer::Bypass(layer) => {
                let [colour, mask, input] = [layer.colour, layer.mask, layer.input].map(|id| self.exact(id));
                layers::bypass(&colour, &mask, &input)
            }
            Layer::Reproject(layer) => points::reproject(&self.exact(layer.input), &self.exact(layer.motion)),
            Layer::Splat(layer) => points::splat(&self.exact(layer.input)),
            Layer::Warp(layer) => layers::warp(&self.exact(layer.input), &self.exact(layer.motion)),
        };
        self.values[layer.output().index()] = Some(written);
    }

    /// Tensor `id` in the kind in which it was written.
    fn as_written(&mut self, id: TensorId) -> Tensor {
        let kind = self.values[id.index()].as_ref().map_or(self.exact, Tensor::kind);
        self.read(id, kind)
    }

    fn conv(&mut self, conv: &Conv) -> Tensor {
        // 1×1 convolutions make pictures, for which the eight bits of bf16 are too few.
        let kind = if conv.size == 3 { self.wide } else { self.exact };
        let mut inputs: Vec<Tensor> = conv.inputs.iter().map(|&read| self.resized(read, kind)).collect();
        let [mut weight, bias] = self.pair(&conv.name, kind);
        if self.network.options.fake_quantised && conv.size == 3 {
            (inputs, weight) = quantise::as_bytes(&inputs, &weight);
        }
        let input = if inputs.len() == 1 { inputs[0].shallow_clone() } else { Tensor::cat(&inputs, 1) };
        let input = if self.network.options.channels_last { layers::channels_last(&input) } else { input };
        layers::conv(conv, &input, &weight, &bias)
    }

    fn filter(&mut self, filter: &Filter) -> Tensor {
        let [weight, bias] = self.pair(&filter.name, self.exact);
        let kernels = self.exact(filter.features).conv2d(&weight, Some(bias), [1; 2], [0; 2], [1; 2], 1);
        let images = filter.images.iter();
        let images: Vec<_> = images.map(|&(read, taps)| (self.resized(read, self.exact), taps)).collect();
        layers::filter(&kernels, filter.expand, &images, filter.normalisation)
    }
}
