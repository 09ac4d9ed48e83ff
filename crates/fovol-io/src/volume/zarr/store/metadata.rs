//! Files of metadata.

/// Names of files that hold metadata.
pub const METADATA: [&str; 5] = ["zarr.json", ".zattrs", ".zgroup", ".zarray", ".zmetadata"];

/// Whether the file `key` holds metadata.
pub fn is_metadata(key: &str) -> bool {
    METADATA.contains(&key.rsplit('/').next().unwrap_or_default())
}
