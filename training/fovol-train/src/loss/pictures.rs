//! Shapes and means of pictures.

use crate::{Error, Result};
use tch::Tensor;

/// Shape of two pictures, \[N, C, H, W\], or an error if they cannot be compared.
pub fn picture_shape(output: &Tensor, reference: &Tensor) -> Result<[i64; 4]> {
    let (found, other) = (output.size(), reference.size());
    match found[..] {
        [n, c, height, width] if found == other && n * c * height * width > 0 => Ok([n, c, height, width]),
        _ => Err(Error::Input(format!(
            "pictures of {found:?} cannot be compared with {other:?}; give two of [batch, channels, rows, columns]"
        ))),
    }
}

/// Mean over all values: a scalar.
pub fn mean(tensor: &Tensor) -> Tensor {
    tensor.mean(None)
}

/// Mean of each element of a batch \[N, C, H, W\] or \[N, C\]: \[N\].
pub fn means(tensor: &Tensor) -> Tensor {
    tensor.flatten(1, -1).mean_dim([1i64].as_slice(), false, None)
}

/// Zero for each element of a batch \[N, C, H, W\], of its kind and on its device: \[N\].
pub fn zeros(pictures: &Tensor) -> Tensor {
    Tensor::zeros([pictures.size()[0]], (pictures.kind(), pictures.device()))
}
