use crate::boundary::call;
use crate::committed::Committed;
use crate::handles::{hand_out, object, release};
use crate::pointers::{path_text, slice};
use crate::status::{Failure, FovolnetStatus};
use fovolnet::TransferChoice;
use fovolnet::core::{ControlPoint, GradientOpacity, TransferFunction};
use std::ffi::c_char;

/// Colours and opacities of values.
pub struct FovolnetTransferFunction(Committed<Parameters, TransferChoice>);

/// Pending parameters.
#[derive(Clone, Default)]
struct Parameters {
    base: Base,
    range: Option<[f64; 2]>,
    gradient: Vec<[f64; 2]>,
}

#[derive(Clone)]
enum Base {
    Text(String),
    Points(Vec<[f64; 5]>),
}

impl Default for Base {
    fn default() -> Self {
        Self::Text("auto".into())
    }
}

impl Parameters {
    fn choice(self) -> Result<TransferChoice, Failure> {
        let points = match self.base {
            Base::Text(text) if self.range.is_none() && self.gradient.is_empty() => return Ok(text.into()),
            Base::Text(_) => {
                return Err(Failure::invalid(
                    "a range and opacity by gradient go with control points; write them into the JSON or the file instead",
                ));
            }
            Base::Points(points) => points,
        };
        let mut function = TransferFunction::new(points.into_iter().map(ControlPoint::from).collect())?;
        if !self.gradient.is_empty() {
            function = function.with_gradient(Some(GradientOpacity::new(self.gradient)?));
        }
        Ok(function.with_range(self.range)?.into())
    }
}

impl FovolnetTransferFunction {
    /// Transfer function of the last commit.
    pub(crate) fn choice(&self) -> Result<TransferChoice, Failure> {
        self.0.committed("transfer_function")
    }
}

/// The function that makes transfer functions.
const MAKER: &str = "fovolnet_transfer_function_new";

/// Makes a transfer function, which follows the histogram until it is set. Give the handle to fovolnet_transfer_function_release in
/// the end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_transfer_function_new(
    transfer_function: *mut *mut FovolnetTransferFunction,
) -> FovolnetStatus {
    call(|| {
        let made = FovolnetTransferFunction(Committed::default());
        // SAFETY: see the rules at the top of the header.
        unsafe { hand_out(made, transfer_function, "transfer_function") }
    })
}

/// Gives the handle back. NULL is fine; a handle that was released must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_transfer_function_release(
    transfer_function: *mut FovolnetTransferFunction,
) {
    // SAFETY: see the rules at the top of the header.
    unsafe { release(transfer_function) }
}

/// Sets the value of the flag "tf": "auto", the name of a preset or a colour map such as "viridis", a file, or JSON such as
/// {"points": [[0, 0, 0, 0, 0], [1, 1, 1, 1, 0.5]]}. Control points of earlier calls are forgotten.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_transfer_function_set(
    transfer_function: *mut FovolnetTransferFunction,
    value: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let value = unsafe { path_text(value, "value")? };
        // SAFETY: likewise.
        unsafe { object(transfer_function, "transfer_function", MAKER)? }.0.set(|pending| {
            pending.base = Base::Text(value);
            Ok(())
        })
    })
}

/// Sets `count` control points of five numbers each, between which colours are linear: value, red, green, blue, opacity of one
/// voxel. All are 0 to 1, and values rise. Value 0 and 1 are the ends of the range that the volume shows, or of
/// fovolnet_transfer_function_set_range. Colours are display colours (sRGB). The numbers are copied.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_transfer_function_set_points(
    transfer_function: *mut FovolnetTransferFunction,
    points: *const f64,
    count: usize,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let points = unsafe { slice(points.cast::<[f64; 5]>(), count, "points")? }.to_vec();
        // SAFETY: likewise.
        unsafe { object(transfer_function, "transfer_function", MAKER)? }.0.set(|pending| {
            pending.base = Base::Points(points);
            Ok(())
        })
    })
}

/// Sets the values of the data at which control points 0 and 1 lie. Two equal numbers take the range back: control points then span
/// the range that the volume shows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_transfer_function_set_range(
    transfer_function: *mut FovolnetTransferFunction,
    low: f64,
    high: f64,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        unsafe { object(transfer_function, "transfer_function", MAKER)? }.0.set(|pending| {
            pending.range = (low != high).then_some([low, high]);
            Ok(())
        })
    })
}

/// Sets factors of opacity by the length of the gradient: `count` points of two numbers each, the length in values of the transfer
/// function a voxel, and the factor 0 to 1. No points take it back. The numbers are copied.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_transfer_function_set_gradient(
    transfer_function: *mut FovolnetTransferFunction,
    points: *const f64,
    count: usize,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let points = unsafe { slice(points.cast::<[f64; 2]>(), count, "points")? }.to_vec();
        // SAFETY: likewise.
        unsafe { object(transfer_function, "transfer_function", MAKER)? }.0.set(|pending| {
            pending.gradient = points;
            Ok(())
        })
    })
}

/// Checks the pending parameters. Renderers use them from their next frame on. Files are read then, not now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_transfer_function_commit(
    transfer_function: *mut FovolnetTransferFunction,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let function = unsafe { object(transfer_function, "transfer_function", MAKER)? };
        function.0.commit(function.0.pending().choice()?);
        Ok(())
    })
}
