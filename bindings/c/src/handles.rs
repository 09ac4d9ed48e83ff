//! Handles: C holds one count of a shared object behind a pointer.

use crate::boundary::call;
use crate::pointers::put;
use crate::status::Failure;
use std::sync::Arc;

/// Object behind `handle`, which `maker` makes.
///
/// # Safety
/// `handle` is null, or was handed out and not released.
pub unsafe fn object<'a, T>(handle: *const T, name: &str, maker: &str) -> Result<&'a T, Failure> {
    // SAFETY: the caller promises it.
    unsafe { handle.as_ref() }
        .ok_or_else(|| Failure::invalid(format!("`{name}` is NULL; give the handle that {maker} made")))
}

/// A further count of the object behind `handle`; `None` for null.
///
/// # Safety
/// `handle` is null, or was handed out and not released.
pub unsafe fn shared<T>(handle: *const T) -> Option<Arc<T>> {
    if handle.is_null() {
        return None;
    }
    // SAFETY: handles come from `Arc::into_raw`, and the caller promises that C still holds its count.
    unsafe {
        Arc::increment_strong_count(handle);
        Some(Arc::from_raw(handle))
    }
}

/// Hands `object` out at `at`, the argument `name`.
///
/// # Safety
/// `at` is null or may be written.
pub unsafe fn hand_out<T>(object: T, at: *mut *mut T, name: &str) -> Result<(), Failure> {
    let handle = Arc::into_raw(Arc::new(object));
    // SAFETY: the caller promises it.
    let written = unsafe { put(at, handle.cast_mut(), name) };
    if written.is_err() {
        // SAFETY: nobody else has the handle.
        drop(unsafe { Arc::from_raw(handle) });
    }
    written
}

/// Gives the caller's count of the object behind `handle` back. Null is fine.
///
/// # Safety
/// `handle` is null, or was handed out and not released.
pub unsafe fn release<T>(handle: *mut T) {
    if handle.is_null() {
        return;
    }
    call(|| {
        // SAFETY: the caller promises it.
        drop(unsafe { Arc::from_raw(handle.cast_const()) });
        Ok(())
    });
}
