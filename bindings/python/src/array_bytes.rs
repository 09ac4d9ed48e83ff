//! Memory of NumPy that the library reads in place.

use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// The bytes of an array, which lives as long.
pub struct ArrayBytes {
    /// Owns the memory.
    _array: Py<PyAny>,
    start: *const u8,
    length: usize,
}

// SAFETY: the memory is only read, by any thread, and the owner is dropped with the interpreter's lock (`Py` sees to it).
unsafe impl Send for ArrayBytes {}
// SAFETY: as above.
unsafe impl Sync for ArrayBytes {}

impl ArrayBytes {
    /// The bytes of `array`, which lies in C order.
    pub fn of(array: &Bound<'_, PyUntypedArray>) -> Self {
        debug_assert!(array.is_c_contiguous());
        // SAFETY: this is an array object, whose data NumPy keeps where it is.
        let start = unsafe { (*array.as_array_ptr()).fields.data.cast::<u8>().cast_const() };
        let length = array.len() * array.dtype().itemsize();
        Self { _array: array.clone().into_any().unbind(), start, length }
    }
}

impl AsRef<[u8]> for ArrayBytes {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: the array owns this memory as long as this struct lives; NumPy never moves it.
        unsafe { std::slice::from_raw_parts(self.start, self.length) }
    }
}
