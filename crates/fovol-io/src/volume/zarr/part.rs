//! The chosen part of an array as a volume.

use super::axes::Axes;
use super::chunks::Chunked;
use super::window::Window;
use crate::Result;
use crate::volume::Overrides;
use crate::volume::layout::Layout;
use crate::volume::levels::fits;
use fovol_core::{Contents, Volume};
use std::sync::Arc;

/// An array and the meaning of its axes.
pub struct Part<'a> {
    /// The array.
    pub chunked: Chunked<'a>,
    /// Its axes.
    pub axes: Axes,
}

impl Part<'_> {
    /// Number of time points, channels and components.
    pub fn counts(&self) -> [usize; 3] {
        self.axes.counts(&self.chunked.array.shape)
    }

    /// The layout of its values in memory.
    pub fn layout(&self) -> Layout {
        let array = self.chunked.array;
        Layout {
            endian: array.element.endian,
            components: self.counts()[2],
            ..Layout::new(self.axes.dims(&array.shape), array.element.dtype)
        }
    }

    /// Whether a volume of it fits in half of the available memory: what renders it needs the rest.
    pub fn fits(&self) -> bool {
        let Layout { dims, components, dtype, .. } = self.layout();
        let length = dims
            .iter()
            .chain([&components, &dtype.size()])
            .try_fold(1u64, |product, &factor| product.checked_mul(factor as u64));
        length.is_some_and(fits) && dims.iter().all(|&dim| dim <= fovol_core::MAX_DIM)
    }

    /// Reads the time point and channel that `overrides` choose, at this `spacing`. `contents` describes the rest of
    /// the file.
    ///
    /// # Errors
    /// Choices out of range, damaged chunks, too little memory.
    pub fn volume(&self, overrides: &Overrides, spacing: [f64; 3], contents: Contents) -> Result<Volume> {
        let source = self.chunked.hierarchy.source;
        let [times, channels, components] = self.counts();
        let time = overrides.time_of(source, times)?;
        let channel = overrides.channel_of(source, channels)?;
        let layout = Layout { spacing, ..self.layout() };
        let length = layout.length(source)?;
        let values = self.chunked.read(&self.window(time, channel), length)?;
        let names = match contents.channels.is_empty() && channels > 1 {
            true => vec![String::new(); channels],
            false => contents.channels.clone(),
        };
        let contents = Contents { times, time, channels: names, channel, components, ..contents };
        let volume = layout.volume(source, Arc::new(values), 0)?.with_contents(contents);
        Ok(self.axes.notes.iter().fold(volume, |volume, note| volume.with_note(note.as_str())))
    }

    /// The values of a time point and channel, x fastest behind the components.
    fn window(&self, time: usize, channel: usize) -> Window {
        let array = self.chunked.array;
        let [x, y, _] = self.axes.dims(&array.shape);
        let value = array.element.size();
        let voxel = value * self.counts()[2];
        let mut window =
            Window { ranges: vec![0..1; array.shape.len()], strides: vec![0; array.shape.len()], base: 0 };
        let steps = [voxel, voxel * x, voxel * x * y];
        let of_space = self.axes.space.into_iter().zip(steps);
        for (axis, step) in of_space.chain([(self.axes.component, value)]) {
            if let Some(axis) = axis {
                window.ranges[axis] = 0..array.shape[axis];
                window.strides[axis] = step;
            }
        }
        for (axis, index) in [(self.axes.time, time), (self.axes.channel, channel)] {
            if let Some(axis) = axis {
                window.ranges[axis] = index..index + 1;
            }
        }
        window
    }
}
