use std::ffi::c_char;

/// Version of the functions and structs in this header. It grows when a function or a struct changes in a way that old
/// programs cannot bear. New functions, and new fields at the end of structs, leave it alone.
pub const FOVOLNET_ABI_VERSION: u32 = 1;

/// Version of the library that is linked. A program whose FOVOLNET_ABI_VERSION is another must not go on.
#[unsafe(no_mangle)]
pub extern "C" fn fovolnet_abi_version() -> u32 {
    FOVOLNET_ABI_VERSION
}

/// Release of the library, such as "0.1.0". The text is never freed.
#[unsafe(no_mangle)]
pub extern "C" fn fovolnet_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
