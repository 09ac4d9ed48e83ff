use super::element::{Bf16, Element};
use super::numbers::Numbers;
use bytemuck::Pod;
use std::ops::Range;

/// An image of any number of channels: \[row\]\[column\]\[channel\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Map<T: Pod = f32> {
    /// The numbers, channels together.
    pub data: Numbers<T>,
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
    /// Numbers per pixel.
    pub channels: usize,
}

impl<T: Element> Map<T> {
    /// Zeros.
    pub fn zeros(height: usize, width: usize, channels: usize) -> Self {
        let mut map = Self::default();
        map.resize([height, width, channels]);
        map.data.fill(T::default());
        map
    }

    /// Takes another size and keeps the memory; what it holds is not said.
    pub fn resize(&mut self, [height, width, channels]: [usize; 3]) {
        self.data.resize(height * width * channels);
        (self.height, self.width, self.channels) = (height, width, channels);
    }

    /// The numbers of row `y`.
    #[inline]
    pub fn row(&self, y: usize) -> &[T] {
        let length = self.width * self.channels;
        &self.data[y * length..(y + 1) * length]
    }

    /// The numbers of a pixel.
    #[inline]
    pub fn pixel(&self, y: usize, x: usize) -> &[T] {
        let start = (y * self.width + x) * self.channels;
        &self.data[start..start + self.channels]
    }
}

impl Map {
    /// One number, 0 beyond the border.
    #[inline]
    pub fn or_zero(&self, y: isize, x: isize, c: usize) -> f32 {
        let inside = y >= 0 && x >= 0 && (y as usize) < self.height && (x as usize) < self.width;
        if inside { self.pixel(y as usize, x as usize)[c] } else { 0.0 }
    }
}

/// A tensor as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub enum Stored {
    /// Four bytes a number: pictures, and everything at full precision.
    F32(Map<f32>),
    /// Two bytes a number.
    Bf16(Map<Bf16>),
}

/// Calls `$body` with `$map` bound to the map in `$stored`, whatever its numbers are.
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

    /// Numbers per pixel.
    pub fn channels(&self) -> usize {
        self.size()[2]
    }

    /// The same numbers as f32.
    pub fn to_f32(&self) -> Map {
        with_map!(self, map => {
            let Map { height, width, channels, .. } = *map;
            let mut out = Map { data: Numbers::default(), height, width, channels };
            out.data.resize(map.data.len());
            out.data.iter_mut().zip(&map.data).for_each(|(to, v)| *to = v.to_f32());
            out
        })
    }

    /// The numbers `from`…`to` of row `y` as f32; `memory` is used where they are stored otherwise.
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

    /// The picture in it.
    ///
    /// # Panics
    /// When it is no f32 map: pictures always are.
    pub fn picture(&self) -> &Map {
        match self {
            Self::F32(map) => map,
            Self::Bf16(_) => panic!("pictures are stored as f32"),
        }
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// As [`Self::picture`].
    pub fn picture_mut(&mut self) -> &mut Map {
        match self {
            Self::F32(map) => map,
            Self::Bf16(_) => panic!("pictures are stored as f32"),
        }
    }
}
