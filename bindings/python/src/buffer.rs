//! Voxels as a buffer that Python reads in place.

use fovolnet::core::{Dtype, Endian, Volume};
use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;
use std::ffi::{CString, c_int, c_void};
use std::ptr;

/// Memory that a buffer points to besides the voxels.
struct Layout {
    format: CString,
    shape: Vec<ffi::Py_ssize_t>,
    strides: Vec<ffi::Py_ssize_t>,
}

/// Fills `view` with the stored values of `volume`, which `owner` keeps: shape (z, y, x), or (z, y, x, components).
///
/// # Safety
/// `view` is a buffer to be filled, and `owner` keeps `volume` where it is.
pub unsafe fn fill(
    view: *mut ffi::Py_buffer,
    flags: c_int,
    owner: Bound<'_, PyAny>,
    volume: &Volume,
) -> PyResult<()> {
    if flags & ffi::PyBUF_WRITABLE != 0 {
        return Err(PyBufferError::new_err("voxels are read only; copy them with numpy.array(volume)"));
    }
    let [x, y, z] = volume.grid().dims();
    let size = volume.dtype().size();
    let mut shape = vec![z, y, x];
    if volume.components() > 1 {
        shape.push(volume.components());
    }
    let mut strides = vec![size; shape.len()];
    for axis in (0..shape.len() - 1).rev() {
        strides[axis] = strides[axis + 1] * shape[axis + 1];
    }
    let signed = |sizes: Vec<usize>| sizes.into_iter().map(|n| n as ffi::Py_ssize_t).collect();
    let layout =
        Box::new(Layout { format: format_of(volume), shape: signed(shape), strides: signed(strides) });
    let data = volume.data();
    // SAFETY: `view` is to be filled; `layout` lives until `release`, the voxels as long as `owner`.
    unsafe {
        (*view).buf = data.as_ptr().cast_mut().cast::<c_void>();
        (*view).len = data.len() as ffi::Py_ssize_t;
        (*view).readonly = 1;
        (*view).itemsize = size as ffi::Py_ssize_t;
        (*view).ndim = layout.shape.len() as c_int;
        (*view).format = layout.format.as_ptr().cast_mut();
        (*view).shape = layout.shape.as_ptr().cast_mut();
        (*view).strides = layout.strides.as_ptr().cast_mut();
        (*view).suboffsets = ptr::null_mut();
        (*view).internal = Box::into_raw(layout).cast::<c_void>();
        (*view).obj = owner.into_ptr();
    }
    Ok(())
}

/// Frees what [`fill`] allocated.
///
/// # Safety
/// `view` was filled by [`fill`], once.
pub unsafe fn release(view: *mut ffi::Py_buffer) {
    // SAFETY: `internal` is the layout that `fill` left there.
    unsafe { drop(Box::from_raw((*view).internal.cast::<Layout>())) };
}

/// The values of `volume` in the notation of the module `struct`.
fn format_of(volume: &Volume) -> CString {
    let letter = match volume.dtype() {
        Dtype::U8 => "B",
        Dtype::I8 => "b",
        Dtype::U16 => "H",
        Dtype::I16 => "h",
        Dtype::U32 => "I",
        Dtype::I32 => "i",
        Dtype::U64 => "Q",
        Dtype::I64 => "q",
        Dtype::F16 => "e",
        Dtype::F32 => "f",
        Dtype::F64 => "d",
    };
    let order = if volume.endian() == Endian::Big { ">" } else { "<" };
    CString::new(format!("{order}{letter}")).expect("there is no zero in it")
}
