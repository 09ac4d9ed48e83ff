use super::frame::Frame;
use super::inputs::Inputs;
use super::model::Network;
use crate::{Error, Result};
use tch::Tensor;

impl Network {
    /// Reconstructs the frame of `inputs`: the picture \[batch, 3, rows, columns\], and the state for the next frame.
    ///
    /// Pictures are cropped to the frame but not clamped to 0…1, so that gradients pass. The caller owns the state
    /// and detaches it where gradients should end.
    ///
    /// # Errors
    /// Inputs or a state of other shapes, or a missing mask.
    pub fn forward(&self, inputs: &Inputs<'_>, state: Vec<Tensor>) -> Result<(Tensor, Vec<Tensor>)> {
        let size = self.check(inputs, &state)?;
        let mut frame = Frame::new(self, inputs, state);
        for layer in self.plan.layers() {
            frame.run(layer);
        }
        let [_, height, width] = size;
        let picture = frame.exact(self.plan.output()).narrow(2, 0, height).narrow(3, 0, width);
        let next = self.plan.states().iter().map(|kept| frame.exact(kept.next));
        Ok((picture, next.collect()))
    }

    /// Checks `inputs` and `state`; returns batch, rows and columns.
    fn check(&self, inputs: &Inputs<'_>, state: &[Tensor]) -> Result<[i64; 3]> {
        let found = inputs.colour.size();
        let &[batch, 3, height, width] = found.as_slice() else {
            return Err(Error::Input(format!("colours are {found:?}; give [batch, 3, rows, columns]")));
        };
        if batch * height * width == 0 {
            return Err(Error::Input(format!("colours are {found:?}, which are no pixels; give some")));
        }
        if self.plan.inputs().mask.is_some() && inputs.mask.is_none() {
            return Err(Error::Input("this network needs the mask of the samples; give it".into()));
        }
        for (what, given, channels) in [("the mask", inputs.mask, 1), ("the motion", inputs.motion, 2)] {
            let expected = [batch, channels, height, width];
            if let Some(given) = given.filter(|given| given.size() != expected) {
                return Err(Error::Input(format!("{what} is {:?}; give {expected:?}", given.size())));
            }
        }
        let sizes: Vec<Vec<i64>> = state.iter().map(Tensor::size).collect();
        let expected = self.state_shapes([batch, height, width]);
        if sizes != expected {
            return Err(Error::Input(format!("the state is {sizes:?}, not {expected:?}; begin a new one")));
        }
        Ok([batch, height, width])
    }
}
