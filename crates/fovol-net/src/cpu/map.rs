use super::element::{Bf16, Element};
use super::numbers::Numbers;
use bytemuck::Pod;
use std::ops::Range;

/// An image with any number of channels: \[row\]\[column\]\[channel\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Map<T: Pod = f32> {
    /// Elements, with the channels of a pixel together.
    pub data: Numbers<T>,
    /// Number of rows.
    pub height: usize,
    /// Number of columns.
    pub width: usize,
    /// Number of channels.
    pub channels: usize,
}

impl<T: Element> Map<T> {
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

impl Map {
    /// Returns one element, or 0 beyond the border.
    #[inline]
    pub fn or_zero(&self, y: isize, x: isize, c: usize) -> f32 {
        let inside = y >= 0 && x >= 0 && (y as usize) < self.height && (x as usize) < self.width;
        if inside { self.pixel(y as usize, x as usize)[c] } else { 0.0 }
    }
}

/// A tensor as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub enum Stored {
    /// f32: pictures, and all tensors at full precision.
    F32(Map<f32>),
    /// bf16.
    Bf16(Map<Bf16>),
}

/// Calls `$body` with `$map` bound to the map in `$stored`, for any element type.
macro_rules! with_map {
    ($stored:expr, $map:ident => $body:expr) => {
        match $stored {
            $crate::cpu::map::Stored::F32($map) => $body,
            $crate::cpu::map::Stored::Bf16($map) => $body,
        }
    };
}
pub(crate) use with_map;

impl Default for Stored {
    fn default() -> Self {
        Self::F32(Map::default())
    }
}

impl Stored {
    /// Rows, columns and channels.
    pub fn size(&self) -> [usize; 3] {
        with_map!(self, map => [map.height, map.width, map.channels])
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.size()[2]
    }

    /// Converts the tensor to f32.
    pub fn to_f32(&self) -> Map {
        with_map!(self, map => {
            let Map { height, width, channels, .. } = *map;
            let mut out = Map { data: Numbers::default(), height, width, channels };
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

    /// Returns the map of a picture; pictures are always f32.
    ///
    /// # Panics
    /// When the map is not f32.
    pub fn picture(&self) -> &Map {
        match self {
            Self::F32(map) => map,
            Self::Bf16(_) => panic!("pictures are stored as f32"),
        }
    }

    /// Returns the map of a picture, mutably.
    ///
    /// # Panics
    /// When the map is not f32.
    pub fn picture_mut(&mut self) -> &mut Map {
        match self {
            Self::F32(map) => map,
            Self::Bf16(_) => panic!("pictures are stored as f32"),
        }
    }
}
