//! Pictures between the library and NumPy.

use crate::errors::{raised, wrong};
use fovolnet::core::{Frame, FrameSize, Pixel, SampleList, SampleMask, SparseFrame};
use numpy::{Element, IntoPyArray, PyArray, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// An array of shape (height, width, `channels`) that owns `numbers`.
pub fn picture<'py, T: Element>(
    py: Python<'py>,
    size: FrameSize,
    channels: usize,
    numbers: Vec<T>,
) -> PyResult<Bound<'py, PyArray<T, numpy::Ix3>>> {
    numbers.into_pyarray(py).reshape([size.height as usize, size.width as usize, channels])
}

/// An array of shape (height, width) that owns `numbers`.
pub fn plane<'py, T: Element>(
    py: Python<'py>,
    size: FrameSize,
    numbers: Vec<T>,
) -> PyResult<Bound<'py, PyArray<T, numpy::Ix2>>> {
    numbers.into_pyarray(py).reshape([size.height as usize, size.width as usize])
}

/// The frame of `array`, of shape (height, width, 3) or (height, width, 4).
pub fn frame_of(array: &PyReadonlyArrayDyn<'_, f32>) -> PyResult<Frame> {
    let shape = array.shape();
    let &[height, width, channels @ (3 | 4)] = shape else {
        return Err(wrong(format!("a picture has the shape (height, width, 3 or 4), not {shape:?}")));
    };
    let size = frame_size(height, width)?;
    let numbers =
        array.as_slice().map_err(|_| wrong("a picture lies in C order; use numpy.ascontiguousarray"))?;
    let pixel = |c: &[f32]| [c[0], c[1], c[2], if channels == 4 { c[3] } else { 1.0 }];
    Frame::from_pixels(size, numbers.chunks_exact(channels).map(pixel).collect())
        .map_err(|error| raised(&error))
}

/// The samples of `picture` where `mask`, of shape (height, width), is true.
pub fn samples_of(
    picture: &PyReadonlyArrayDyn<'_, f32>,
    mask: &PyReadonlyArrayDyn<'_, bool>,
) -> PyResult<SparseFrame> {
    let frame = frame_of(picture)?;
    let size = frame.size();
    let expected = [size.height as usize, size.width as usize];
    if mask.shape() != expected {
        return Err(wrong(format!(
            "the mask has the shape {:?}, the picture {expected:?}; make both equal",
            mask.shape()
        )));
    }
    let mask = mask.as_slice().map_err(|_| wrong("a mask lies in C order; use numpy.ascontiguousarray"))?;
    let pixels: Vec<Pixel> = (0..size.height)
        .flat_map(|y| (0..size.width).map(move |x| [x, y]))
        .zip(mask)
        .filter(|(_, sampled)| **sampled)
        .map(|([x, y], _)| Pixel { x: x as u16, y: y as u16 })
        .collect();
    let colours = pixels
        .iter()
        .map(|pixel| {
            let [r, g, b, _] = frame.pixel(pixel.x.into(), pixel.y.into());
            [r, g, b]
        })
        .collect();
    let depths = vec![f32::INFINITY; pixels.len()];
    Ok(SparseFrame::new(SampleList::new(size, pixels), colours, depths))
}

/// Which pixels are sampled, row by row.
pub fn sampled(mask: &SampleMask) -> Vec<bool> {
    let size = mask.size();
    (0..size.height).flat_map(|y| (0..size.width).map(move |x| mask.contains(x, y))).collect()
}

fn frame_size(height: usize, width: usize) -> PyResult<FrameSize> {
    let [width, height] = [width, height].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    FrameSize::new(width, height).map_err(|error| raised(&error))
}
