use super::element::Element;
use super::tensor_buf::TensorBuf;
use super::{AnyTensor, Tensor, with_tensor};
use std::ops::Range;

impl AnyTensor {
    /// Converts the tensor to f32.
    pub fn to_f32(&self) -> Tensor {
        with_tensor!(self, map => {
            let Tensor { height, width, channels, .. } = *map;
            let mut out = Tensor { data: TensorBuf::default(), height, width, channels };
            out.data.resize(map.data.len());
            out.data.iter_mut().zip(&map.data).for_each(|(to, v)| *to = v.to_f32());
            out
        })
    }

    /// Returns the elements `range` of row `y` as f32. `memory` is used if a conversion is needed.
    #[inline(always)]
    pub fn numbers<'a>(&'a self, y: usize, range: Range<usize>, memory: &'a mut Vec<f32>) -> &'a [f32] {
        match self {
            Self::F32(map) => &map.row(y)[range],
            Self::Bf16(map) => {
                memory.clear();
                memory.extend(map.row(y)[range].iter().map(|v| v.to_f32()));
                memory
            }
        }
    }
}
