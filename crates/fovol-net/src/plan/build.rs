use super::definition::{Inputs, Plan, StateTensor};
use super::layers::Layer;
use super::tensor::{TensorId, TensorSpec};

/// Builds a [`Plan`] layer by layer and checks that shapes fit.
///
/// # Panics
/// Methods panic if shapes do not fit: configurations are checked beforehand.
#[derive(Debug)]
pub struct PlanBuilder {
    plan: Plan,
}

impl Default for PlanBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl PlanBuilder {
    /// Begins a plan with a colour input and no layers.
    pub fn new() -> Self {
        let colour = TensorId(0);
        let plan = Plan {
            tensors: vec![TensorSpec { name: "input".into(), channels: 3, level: 0 }],
            layers: Vec::new(),
            states: Vec::new(),
            inputs: Inputs { colour, mask: None, motion: None },
            output: colour,
        };
        Self { plan }
    }

    /// Returns the colour input.
    pub fn colour(&self) -> TensorId {
        self.plan.inputs.colour
    }

    /// Returns the mask input, and adds it to the plan if needed.
    pub fn mask(&mut self) -> TensorId {
        if self.plan.inputs.mask.is_none() {
            self.plan.inputs.mask = Some(self.tensor("mask", 1, 0));
        }
        self.plan.inputs.mask.unwrap_or(TensorId(0))
    }

    /// Returns the motion input, and adds it to the plan if needed.
    pub fn motion(&mut self) -> TensorId {
        if self.plan.inputs.motion.is_none() {
            self.plan.inputs.motion = Some(self.tensor("motion", 2, 0));
        }
        self.plan.inputs.motion.unwrap_or(TensorId(0))
    }

    fn tensor(&mut self, name: &str, channels: usize, level: u32) -> TensorId {
        self.plan.tensors.push(TensorSpec { name: name.to_owned(), channels, level });
        TensorId(self.plan.tensors.len() - 1)
    }

    /// Adds a state, as the last frame left it. [`Self::keep`] sets its next value.
    pub fn state(&mut self, name: &str, channels: usize, level: u32) -> TensorId {
        let previous = self.tensor(&format!("state.{name}"), channels, level);
        self.plan.states.push(StateTensor { name: name.to_owned(), previous, next: previous });
        previous
    }

    /// Adds a state with the shape of `tensor`.
    pub fn state_like(&mut self, name: &str, tensor: TensorId) -> TensorId {
        let TensorSpec { channels, level, .. } = *self.plan.tensor(tensor);
        self.state(name, channels, level)
    }

    /// Makes `next` the value of the state `previous` in the next frame.
    pub fn keep(&mut self, previous: TensorId, next: TensorId) {
        let shape = |id: TensorId| (self.plan.tensor(id).channels, self.plan.tensor(id).level);
        assert_eq!(shape(previous), shape(next), "a state keeps its shape");
        for state in self.plan.states.iter_mut().filter(|state| state.previous == previous) {
            state.next = next;
        }
    }

    /// Adds `layer`, and returns its output. The output of `layer` itself is ignored.
    pub fn add(&mut self, layer: impl Into<Layer>) -> TensorId {
        let mut layer = layer.into();
        match layer.descriptor().check(&self.plan.tensors) {
            Ok(TensorSpec { name, channels, level }) => {
                let output = self.tensor(&name, channels, level);
                layer.descriptor_mut().set_output(output);
                self.plan.layers.push(layer);
                output
            }
            Err(problem) => panic!("the layer `{}` does not fit: {problem}", layer.name()),
        }
    }

    /// Completes the plan, with `output` as the reconstructed picture.
    pub fn finish(mut self, output: TensorId) -> Plan {
        let shape = self.plan.tensor(output);
        assert_eq!((shape.channels, shape.level), (3, 0), "the output is a picture");
        self.plan.output = output;
        let halvings = self.plan.multiple().ilog2();
        for layer in &mut self.plan.layers {
            layer.descriptor_mut().complete(halvings, &mut self.plan.tensors);
        }
        self.plan
    }
}
