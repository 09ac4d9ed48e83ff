use crate::errors::{raised, wrong};
use crate::interrupts::interruptible;
use crate::settings;
use fovolnet::core::{Dtype, Endian, Grid, Volume as CoreVolume, VoxelBytes};
use fovolnet::{OpenVolume, open_volume};
use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;

/// A volume: voxels, their spacing and what its file says about them.
#[pyclass(frozen, module = "fovolnet")]
pub struct Volume(pub OpenVolume);

/// The bytes of an array, which lives as long.
struct ArrayBytes {
    /// Owns the memory.
    _array: Py<PyAny>,
    start: *const u8,
    length: usize,
}

// SAFETY: the memory is only read, by any thread, and the owner is dropped with the interpreter's lock (`Py` sees to it).
unsafe impl Send for ArrayBytes {}
// SAFETY: as above.
unsafe impl Sync for ArrayBytes {}

impl AsRef<[u8]> for ArrayBytes {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: the array owns this memory as long as this struct lives; NumPy never moves it.
        unsafe { std::slice::from_raw_parts(self.start, self.length) }
    }
}

#[pymethods]
impl Volume {
    /// Reads a file, a folder or a procedural volume. `settings` is a JSON object with the names of the command line's flags.
    #[staticmethod]
    #[pyo3(signature = (source, settings = "{}"))]
    fn read(py: Python<'_>, source: &str, settings: &str) -> PyResult<Self> {
        let settings = settings::of_volumes(settings)?;
        let opened = interruptible(py, || open_volume(source, &settings))?;
        Ok(Self(opened.map_err(|error| raised(&error))?))
    }

    /// The volume of `array`, in C order, of shape (z, y, x) or (z, y, x, components), without a copy. `spacing` is the distance of
    /// voxels along x, y, z. Voxels with three or four components have colours if `rgb`. `range` are the values shown as 0 and 1.
    #[staticmethod]
    #[pyo3(signature = (array, spacing, rgb = false, range = None))]
    fn from_array(
        array: &Bound<'_, PyUntypedArray>,
        spacing: [f64; 3],
        rgb: bool,
        range: Option<[f64; 2]>,
    ) -> PyResult<Self> {
        let shape = array.shape();
        let (dims, components) = match *shape {
            [z, y, x] => ([x, y, z], 1),
            [z, y, x, components] => ([x, y, z], components),
            _ => {
                return Err(wrong(format!(
                    "a volume has the shape (z, y, x) or (z, y, x, components), not {shape:?}"
                )));
            }
        };
        if !array.is_c_contiguous() {
            return Err(wrong("the array is not in C order; use numpy.ascontiguousarray"));
        }
        let descr = array.dtype();
        let dtype: Dtype =
            name_of(descr.kind(), descr.itemsize()).and_then(|name| name.parse().ok()).ok_or_else(|| {
                wrong(format!(
                    "values of type {descr} cannot be rendered; convert them, for example to float32"
                ))
            })?;
        let grid = Grid::new(dims, spacing).map_err(|error| raised(&error))?;
        // SAFETY: this is an array object, whose data NumPy keeps where it is.
        let start = unsafe { (*array.as_array_ptr()).fields.data.cast::<u8>().cast_const() };
        let bytes: VoxelBytes = Arc::new(ArrayBytes {
            _array: array.clone().into_any().unbind(),
            start,
            length: array.len() * descr.itemsize(),
        });
        let endian = if descr.byteorder() == b'>' { Endian::Big } else { Endian::Little };
        let made = || -> fovolnet::core::Result<OpenVolume> {
            let mut volume = CoreVolume::with_layout(grid, dtype, endian, components, bytes, 0)?;
            if let Some(range) = range {
                volume = volume.with_range(range)?;
            }
            if rgb {
                let (colours, opacity) = volume.colours()?;
                return Ok(OpenVolume { colours: Some(colours), ..OpenVolume::from(opacity) });
            }
            Ok(OpenVolume::from(volume))
        };
        Ok(Self(made().map_err(|error| raised(&error))?))
    }

    /// Number of voxels along z, y, x.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [x, y, z] = self.0.volume.grid().dims();
        (z, y, x)
    }

    /// Distance of voxels along x, y, z.
    #[getter]
    fn spacing(&self) -> [f64; 3] {
        self.0.volume.grid().spacing()
    }

    /// Type of the values, as NumPy writes it.
    #[getter]
    fn dtype(&self) -> String {
        self.0.volume.dtype().to_string()
    }

    /// Values shown as 0 and 1.
    #[getter]
    fn range(&self) -> [f64; 2] {
        self.0.volume.range()
    }

    /// Path or name that the volume was read from.
    #[getter]
    fn source(&self) -> &str {
        &self.0.source
    }

    /// Assumptions while the file was read, one line each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes().into_iter().chain(self.0.remarks()).collect()
    }

    /// Copy that shows other values as 0 and 1, with the same voxels.
    fn with_range(&self, range: [f64; 2]) -> PyResult<Self> {
        let volume = (*self.0.volume).clone().with_range(range).map_err(|error| raised(&error))?;
        Ok(Self(OpenVolume { volume: Arc::new(volume), ..self.0.clone() }))
    }

    fn __repr__(&self) -> String {
        let (z, y, x) = self.shape();
        format!("<fovolnet.Volume ({z}, {y}, {x}) {} from {}>", self.dtype(), self.source())
    }
}

/// The library's name of values of NumPy's `kind` with `size` bytes.
fn name_of(kind: u8, size: usize) -> Option<String> {
    let kind = match kind {
        b'b' => return Some("u8".into()),
        b'u' => 'u',
        b'i' => 'i',
        b'f' => 'f',
        _ => return None,
    };
    Some(format!("{kind}{}", 8 * size))
}
