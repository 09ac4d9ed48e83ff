//! Limits of what packed bytes may hold.

/// Uncompressed bytes that one byte of a file may stand for, and bytes that every file may have.
pub const BYTES_PER_BYTE: usize = 1032;
pub const FREE_BYTES: usize = 1 << 20;
