use crate::array_bytes::ArrayBytes;
use crate::array_facts::ArrayFacts;
use crate::buffer;
use crate::errors::{raised, wrong};
use crate::interrupts::interruptible;
use crate::settings;
use fovolnet::core::{Dtype, Endian, Grid, Volume as CoreVolume, VoxelBytes, path_of_text};
use fovolnet::io::volume::write;
use fovolnet::{OpenVolume, TransferChoice, open_volume, presets};
use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;
use std::ffi::c_int;
use std::sync::Arc;

/// A volume: voxels, their spacing, and what its file says about them.
///
/// Make one with `read` or `as_volume`. `numpy.asarray(volume)` shows its stored values without a copy, as [z, y, x]; values are
/// slope · stored + intercept, see `rescale`.
#[pyclass(frozen, module = "fovolnet")]
pub struct Volume {
    /// The voxels, and what is shown with them.
    pub opened: OpenVolume,
    /// JSON of the settings that they were read with; `None` if they come from an array.
    read: Option<String>,
}

impl Volume {
    /// The volume `opened`, made in memory.
    fn made(opened: OpenVolume) -> Self {
        Self { opened, read: None }
    }
}

#[pymethods]
impl Volume {
    /// Reads a file, a folder or a procedural volume. `settings` is a JSON object with the names of the command line's flags.
    #[staticmethod]
    #[pyo3(signature = (source, settings = "{}"))]
    fn read(py: Python<'_>, source: &str, settings: &str) -> PyResult<Self> {
        let parsed = settings::of_volumes(settings)?;
        let opened = interruptible(py, || open_volume(source, &parsed))?.map_err(|error| raised(&error))?;
        Ok(Self { opened, read: Some(settings.to_owned()) })
    }

    /// The volume of `array`, in C order, of shape (z, y, x) or (z, y, x, components), without a copy. `facts` is a JSON object.
    #[staticmethod]
    #[pyo3(signature = (array, facts = "{}"))]
    fn from_array(array: &Bound<'_, PyUntypedArray>, facts: &str) -> PyResult<Self> {
        let facts = ArrayFacts::parse(facts)?;
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
        let grid = Grid::new(dims, facts.spacing).map_err(|error| raised(&error))?;
        let bytes: VoxelBytes = Arc::new(ArrayBytes::of(array));
        let endian = if descr.byteorder() == b'>' { Endian::Big } else { Endian::Little };
        let made = || -> fovolnet::core::Result<OpenVolume> {
            let volume = CoreVolume::with_layout(grid, dtype, endian, components, bytes, 0)?;
            let volume = facts.told_to(volume)?;
            if facts.rgb {
                let (colours, opacity) = volume.colours()?;
                let opened = OpenVolume::of(Arc::new(opacity), &*facts.source);
                return Ok(OpenVolume { colours: Some(colours), ..opened });
            }
            Ok(OpenVolume::of(Arc::new(volume), &*facts.source))
        };
        Ok(Self::made(made().map_err(|error| raised(&error))?))
    }

    /// Number of voxels along z, y, x.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [x, y, z] = self.opened.volume.grid().dims();
        (z, y, x)
    }

    /// Distance of voxels along x, y, z.
    #[getter]
    fn spacing(&self) -> [f64; 3] {
        self.opened.volume.grid().spacing()
    }

    /// Unit of the spacing, such as "mm", or None where nothing says.
    #[getter]
    fn units(&self) -> Option<&str> {
        self.opened.volume.units()
    }

    /// Centre of the first voxel, (x, y, z), in patient space (left, posterior, superior) where the volume is a patient's; None where
    /// nothing says.
    #[getter]
    fn origin(&self) -> Option<[f64; 3]> {
        self.opened.volume.placement().map(|placement| placement.origin().to_array())
    }

    /// Unit vectors along the axes x, y, z of the voxels, one after the other, in the space of `origin`; None where nothing says.
    #[getter]
    fn directions(&self) -> Option<[[f64; 3]; 3]> {
        self.opened.volume.placement().map(|placement| placement.directions().to_cols_array_2d())
    }

    /// Type of the stored values: u8, i8, u16, i16, u32, i32, u64, i64, f16, f32 or f64.
    #[getter]
    fn dtype(&self) -> String {
        self.opened.volume.dtype().to_string()
    }

    /// Slope and intercept: values are slope · stored + intercept.
    #[getter]
    fn rescale(&self) -> (f64, f64) {
        let rescale = self.opened.volume.rescale();
        (rescale.slope, rescale.intercept)
    }

    /// Values shown as 0 and 1.
    #[getter]
    fn range(&self) -> [f64; 2] {
        self.opened.volume.range()
    }

    /// Whether `range` was chosen, rather than found in the values.
    #[getter]
    fn range_is_chosen(&self) -> bool {
        self.opened.volume.range_is_chosen()
    }

    /// Settings that the volume was read with, as JSON; None if it comes from an array.
    #[getter]
    fn read_settings(&self) -> Option<&str> {
        self.read.as_deref()
    }

    /// Path or name that the volume was read from.
    #[getter]
    fn source(&self) -> &str {
        &self.opened.source
    }

    /// Whether the volume says which colours it has: those of its file, of labels, or of a procedural volume.
    #[getter]
    fn has_own_colours(&self) -> bool {
        self.opened.has_own_colours()
    }

    /// Number of volumes shown together: 1, and 1 more for each further channel or layer.
    #[getter]
    fn layers(&self) -> usize {
        1 + self.opened.layers.len()
    }

    /// Assumptions while the file was read, one line each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.opened.notes().into_iter().chain(self.opened.remarks()).collect()
    }

    /// Copy that shows other values as 0 and 1, with the same voxels.
    fn with_range(&self, range: [f64; 2]) -> PyResult<Self> {
        let volume = (*self.opened.volume).clone().with_range(range).map_err(|error| raised(&error))?;
        let opened = OpenVolume { volume: Arc::new(volume), ..self.opened.clone() };
        Ok(Self { opened, read: self.read.clone() })
    }

    /// The transfer function of the text `what` over the values shown, as JSON with `points` [value, r, g, b, opacity], all 0 to 1.
    fn transfer_function(&self, py: Python<'_>, what: &str) -> PyResult<String> {
        let found = interruptible(py, || presets::find(what, &self.opened))?;
        found.map(|transfer| presets::text(&transfer)).map_err(|error| raised(&error))
    }

    /// Copy that is shown with `other`, whose transfer function is the text `tf`, on its box.
    fn with_layer(&self, py: Python<'_>, other: &Self, tf: &str) -> PyResult<Self> {
        let (first, other) = (self.opened.clone(), other.opened.clone());
        let layered = interruptible(py, || first.with_layer(other, TransferChoice::from(tf)))?;
        Ok(Self::made(layered.map_err(|error| raised(&error))?))
    }

    /// Writes the volume in the format of the extension of `path`. Returns notes on what the format cannot hold.
    fn write(&self, py: Python<'_>, path: &str) -> PyResult<Vec<String>> {
        let path = path_of_text(path);
        interruptible(py, || write(&self.opened.volume, &path))?.map_err(|error| raised(&error))
    }

    fn __repr__(&self) -> String {
        let (z, y, x) = self.shape();
        format!("<fovolnet.Volume ({z}, {y}, {x}) {} from {}>", self.dtype(), self.source())
    }

    /// # Safety
    /// Python calls this with a buffer to be filled.
    unsafe fn __getbuffer__(slf: Bound<'_, Self>, view: *mut ffi::Py_buffer, flags: c_int) -> PyResult<()> {
        if view.is_null() {
            return Err(PyBufferError::new_err("there is no buffer to be filled"));
        }
        let owner = slf.clone().into_any();
        // SAFETY: the buffer is to be filled, and `owner` keeps its volume, which never changes.
        unsafe { buffer::fill(view, flags, owner, &slf.get().opened.volume) }
    }

    /// # Safety
    /// Python calls this once for each filled buffer.
    unsafe fn __releasebuffer__(&self, view: *mut ffi::Py_buffer) {
        // SAFETY: the buffer was filled by `__getbuffer__`.
        unsafe { buffer::release(view) };
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
