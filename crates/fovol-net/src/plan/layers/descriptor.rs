use crate::plan::tensor::{Parameter, TensorId, TensorSpec};

/// Description of a layer: its inputs, its output, and the arrays that it learns.
pub trait Descriptor {
    /// Name of the parameters, or the kind of a layer without parameters.
    fn name(&self) -> &str;

    /// Input tensors.
    fn inputs(&self) -> Vec<TensorId>;

    /// Output tensor; [`TensorId::UNSET`] before the layer is part of a plan.
    fn output(&self) -> TensorId;

    /// Sets the output tensor.
    fn set_output(&mut self, output: TensorId);

    /// Checks that the inputs, which `tensors` lists, fit together. Returns name and shape of the output.
    ///
    /// # Errors
    /// Inputs that do not fit, in one line.
    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String>;

    /// Learned arrays.
    fn parameters(&self, tensors: &[TensorSpec]) -> Vec<Parameter> {
        let _ = tensors;
        Vec::new()
    }

    /// Multiply-adds for one pixel of the frame. Only those with learned weights and predicted kernels count.
    fn macs_per_pixel(&self, tensors: &[TensorSpec]) -> f64 {
        let _ = tensors;
        0.0
    }

    /// Returns the input picture of a layer that works on each value by itself, if the layer does no more than
    /// that.
    fn changed(&self) -> Option<TensorId> {
        None
    }

    /// Returns the input whose values the layer keeps in part, if its output can be written over that input.
    fn begins_as(&self) -> Option<TensorId> {
        None
    }

    /// Sets properties that depend on the whole plan, once it is complete. The lowest of its tensors has halved
    /// resolution `halvings` times.
    fn complete(&mut self, halvings: u32, tensors: &mut [TensorSpec]) {
        let _ = (halvings, tensors);
    }
}

/// Weights of `shape` and one bias for each of its first axis, as the layer `name` learns them.
pub(super) fn weights_and_bias(name: &str, shape: Vec<usize>) -> Vec<Parameter> {
    let bias = vec![shape[0]];
    vec![
        Parameter { name: format!("{name}.weight"), shape },
        Parameter { name: format!("{name}.bias"), shape: bias },
    ]
}

/// Multiply-adds for one pixel of the frame, if there are `macs` for each pixel of `tensor`.
pub(super) fn per_pixel(tensor: &TensorSpec, macs: usize) -> f64 {
    macs as f64 / f64::from(4u32.pow(tensor.level))
}

/// Methods of a [`Descriptor`] whose output is the field `output`.
macro_rules! one_output {
    () => {
        fn output(&self) -> TensorId {
            self.output
        }

        fn set_output(&mut self, output: TensorId) {
            self.output = output;
        }
    };
}
pub(super) use one_output;

/// Methods of a [`Descriptor`] whose only input is the field `input`, and whose output is the field `output`.
macro_rules! one_input_and_output {
    () => {
        fn inputs(&self) -> Vec<TensorId> {
            vec![self.input]
        }

        $crate::plan::layers::descriptor::one_output!();
    };
}
pub(super) use one_input_and_output;
