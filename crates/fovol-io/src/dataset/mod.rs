//! Published volumes by name: a built-in catalogue and, with the feature `download`, downloads that resume and are
//! checked by hash.
//!
//! ```
//! let entry = fovol_io::dataset::find("aneurism")?;
//! assert_eq!(entry.dims, [256, 256, 256]);
//! # Ok::<(), fovol_io::dataset::Error>(())
//! ```

mod catalogue;
#[cfg(feature = "download")]
mod digest;
#[cfg(feature = "download")]
mod download;
mod error;
#[cfg(feature = "download")]
mod progress;
#[cfg(feature = "download")]
mod transfer;

pub use catalogue::{Entry, catalogue, find};
#[cfg(feature = "download")]
pub use download::{Check, Origin, Outcome, get};
pub use error::{Error, KnownHash, Result};
#[cfg(feature = "download")]
pub use progress::{Progress, Stage};
