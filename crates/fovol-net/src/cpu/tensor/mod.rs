//! Images with any number of channels, as networks store them.

mod convert;
pub mod element;
pub mod page_buf;
pub mod ring;
pub mod rows;
pub mod samples;
pub mod tensor_buf;
pub mod upsampling;
pub mod vec4;

use bytemuck::Pod;
use fovol_simd::Bf16;
use tensor_buf::TensorBuf;

/// An image with any number of channels: \[row\]\[column\]\[channel\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tensor<T: Pod = f32> {
    /// Elements, with the channels of a pixel together.
    pub data: TensorBuf<T>,
    /// Number of rows.
    pub height: usize,
    /// Number of columns.
    pub width: usize,
    /// Number of channels.
    pub channels: usize,
}

impl<T: Pod + Default + Send + Sync> Tensor<T> {
    /// Makes an image of zeros.
    pub fn zeros(height: usize, width: usize, channels: usize) -> Self {
        let mut map = Self::default();
        map.resize([height, width, channels]);
        map.data.fill(T::default());
        map
    }

    /// Resizes the image and keeps its memory; contents become undefined.
    pub fn resize(&mut self, [height, width, channels]: [usize; 3]) {
        self.data.resize(height * width * channels);
        (self.height, self.width, self.channels) = (height, width, channels);
    }

    /// Elements of row `y`.
    #[inline]
    pub fn row(&self, y: usize) -> &[T] {
        let length = self.width * self.channels;
        &self.data[y * length..(y + 1) * length]
    }

    /// Elements of a pixel.
    #[inline]
    pub fn pixel(&self, y: usize, x: usize) -> &[T] {
        let start = (y * self.width + x) * self.channels;
        &self.data[start..start + self.channels]
    }
}

impl Tensor {
    /// Returns one element, or 0 beyond the border.
    #[inline]
    pub fn or_zero(&self, y: isize, x: isize, c: usize) -> f32 {
        let inside = y >= 0 && x >= 0 && (y as usize) < self.height && (x as usize) < self.width;
        if inside { self.pixel(y as usize, x as usize)[c] } else { 0.0 }
    }
}

/// A tensor as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyTensor {
    /// f32: pictures, and all tensors at full precision.
    F32(Tensor<f32>),
    /// bf16.
    Bf16(Tensor<Bf16>),
}

/// Calls `$body` with `$map` bound to the map in `$stored`, for any element type.
macro_rules! with_tensor {
    ($stored:expr, $map:ident => $body:expr) => {
        match $stored {
            $crate::cpu::tensor::AnyTensor::F32($map) => $body,
            $crate::cpu::tensor::AnyTensor::Bf16($map) => $body,
        }
    };
}
pub(crate) use with_tensor;

impl Default for AnyTensor {
    fn default() -> Self {
        Self::F32(Tensor::default())
    }
}

impl AnyTensor {
    /// Rows, columns and channels.
    pub fn size(&self) -> [usize; 3] {
        with_tensor!(self, map => [map.height, map.width, map.channels])
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.size()[2]
    }

    /// Returns the map of a picture; pictures are always f32.
    ///
    /// # Panics
    /// When the map is not f32.
    pub fn picture(&self) -> &Tensor {
        match self {
            Self::F32(map) => map,
            Self::Bf16(_) => panic!("pictures are stored as f32"),
        }
    }

    /// Returns the map of a picture, mutably.
    ///
    /// # Panics
    /// When the map is not f32.
    pub fn picture_mut(&mut self) -> &mut Tensor {
        match self {
            Self::F32(map) => map,
            Self::Bf16(_) => panic!("pictures are stored as f32"),
        }
    }
}
