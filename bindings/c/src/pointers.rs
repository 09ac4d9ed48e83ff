//! Arguments of C: texts, numbers, structs that may grow, and places for results.

use crate::status::Failure;
use std::ffi::{CStr, c_char};
use std::mem::size_of;

/// Text at `at`, the argument `name`.
///
/// # Safety
/// `at` is null or a string that ends in NUL.
pub unsafe fn text<'a>(at: *const c_char, name: &str) -> Result<&'a str, Failure> {
    if at.is_null() {
        return Err(Failure::invalid(format!("`{name}` is NULL; give a text")));
    }
    // SAFETY: the caller promises it.
    let text = unsafe { CStr::from_ptr(at) };
    text.to_str().map_err(|_| Failure::invalid(format!("`{name}` is no UTF-8; convert it")))
}

/// Text of the path or address at `at`, which may hold all bytes that the system allows.
///
/// # Safety
/// `at` is null or a string that ends in NUL.
pub unsafe fn path_text(at: *const c_char, name: &str) -> Result<String, Failure> {
    #[cfg(unix)]
    if !at.is_null() {
        use std::os::unix::ffi::OsStrExt;
        // SAFETY: the caller promises it.
        let bytes = unsafe { CStr::from_ptr(at) }.to_bytes();
        let path = std::path::Path::new(std::ffi::OsStr::from_bytes(bytes));
        return Ok(fovolnet::core::text_of_path(path));
    }
    // SAFETY: the caller promises it.
    unsafe { text(at, name) }.map(str::to_owned)
}

/// Writes `value` at `at`, the argument `name`.
///
/// # Safety
/// `at` is null or may be written.
pub unsafe fn put<T>(at: *mut T, value: T, name: &str) -> Result<(), Failure> {
    if at.is_null() {
        return Err(Failure::invalid(format!(
            "`{name}` is NULL; give the address of a variable for the result"
        )));
    }
    // SAFETY: it is not null, and the caller promises the rest.
    unsafe { at.write(value) };
    Ok(())
}

/// `N` numbers at `at`, the argument `name`.
///
/// # Safety
/// `at` is null or holds so many numbers.
pub unsafe fn numbers<const N: usize>(at: *const f64, name: &str) -> Result<[f64; N], Failure> {
    // SAFETY: the caller promises it; arrays of numbers have the alignment of one.
    let numbers = unsafe { at.cast::<[f64; N]>().as_ref() };
    numbers.copied().ok_or_else(|| Failure::invalid(format!("`{name}` is NULL; give {N} numbers")))
}

/// `count` values at `at`, the argument `name`. No values may lie anywhere.
///
/// # Safety
/// `at` is null or holds so many values, which nobody writes as long as they are used.
pub unsafe fn slice<'a, T>(at: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    if at.is_null() || !at.is_aligned() || count > isize::MAX as usize / size_of::<T>() {
        return Err(Failure::invalid(format!(
            "`{name}` is NULL, not aligned or too large; give the address of {count} values"
        )));
    }
    // SAFETY: it is neither null nor too large, and the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts(at, count) })
}

/// Structs of the header whose first field is their size in bytes, as the caller knows them. Zeros are valid.
///
/// # Safety
/// The struct is `repr(C)`, its first field is a `usize`, and all its bytes may be zero.
pub unsafe trait Growing: Copy {
    /// Name in the header.
    const NAME: &'static str;
    /// Size of the first version.
    const FIRST: usize;
}

/// Reads the struct at `at`, which may be of an older or a newer version. Fields that the caller does not know are zero.
///
/// # Safety
/// `at` is null or begins with a size, and so many bytes follow from there.
pub unsafe fn read<T: Growing>(at: *const T, name: &str) -> Result<T, Failure> {
    // SAFETY: the caller promises it.
    let size = unsafe { known_size(at, name)? };
    let mut value = std::mem::MaybeUninit::<T>::zeroed();
    // SAFETY: both have as many bytes, and zeros are valid for what is not copied.
    unsafe {
        at.cast::<u8>().copy_to_nonoverlapping(value.as_mut_ptr().cast(), size);
        Ok(value.assume_init())
    }
}

/// Writes `value` to the struct at `at`, as far as the caller knows it. The size stays.
///
/// # Safety
/// `at` is null or begins with a size, and so many bytes from there may be written.
pub unsafe fn write<T: Growing>(at: *mut T, value: &T, name: &str) -> Result<(), Failure> {
    // SAFETY: the caller promises it.
    let size = unsafe { known_size(at, name)? };
    let skipped = size_of::<usize>();
    // SAFETY: both have as many bytes; the first field is skipped.
    unsafe {
        let from = std::ptr::from_ref(value).cast::<u8>();
        from.add(skipped).copy_to_nonoverlapping(at.cast::<u8>().add(skipped), size - skipped);
    }
    Ok(())
}

/// Number of bytes of the struct at `at` that both the caller and this library know.
///
/// # Safety
/// `at` is null or begins with a size.
unsafe fn known_size<T: Growing>(at: *const T, name: &str) -> Result<usize, Failure> {
    let kind = T::NAME;
    if at.is_null() {
        return Err(Failure::invalid(format!("`{name}` is NULL; give the address of a {kind}")));
    }
    // SAFETY: it is not null, and the caller promises that it begins with a size.
    let size = unsafe { at.cast::<usize>().read_unaligned() };
    if size < T::FIRST {
        return Err(Failure::invalid(format!(
            "`{name}->size` is {size}; fill the struct with zeros and set it to sizeof({kind})"
        )));
    }
    Ok(size.min(size_of::<T>()))
}

/// Writes `text` to the buffer `at` of `capacity` bytes, shortened if it does not fit, and its length to `length`.
///
/// # Safety
/// `at` is null or so many bytes there may be written; `length` is null or may be written.
pub unsafe fn put_text(
    text: &str,
    at: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> Result<(), Failure> {
    if !length.is_null() {
        // SAFETY: it is not null, and the caller promises the rest.
        unsafe { length.write(text.len()) };
    }
    if at.is_null() || capacity == 0 {
        return match length.is_null() {
            true => Err(Failure::invalid("both `text` and `length` are NULL; give one of them")),
            false => Ok(()),
        };
    }
    let kept = text.floor_char_boundary(capacity - 1);
    // SAFETY: with the NUL these are at most `capacity` bytes.
    unsafe {
        text.as_ptr().copy_to_nonoverlapping(at.cast(), kept);
        at.add(kept).write(0);
    }
    Ok(())
}
