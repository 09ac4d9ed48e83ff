//! Published volumes by name: a catalogue that is built in, downloads that resume, and hashes.
//!
//! ```no_run
//! use fovol_io::dataset::{find, get};
//! use std::path::Path;
//! use std::sync::atomic::AtomicBool;
//!
//! let never = AtomicBool::new(false);
//! let got = get(find("aneurism")?, Path::new("volumes"), &mut |p| println!("{} of {}", p.done, p.total), &never)?;
//! println!("{got}");
//! # Ok::<(), fovol_io::dataset::Error>(())
//! ```

mod catalogue;
mod digest;
mod download;
mod error;
mod progress;
mod transfer;

pub use catalogue::{Entry, catalogue, find};
pub use download::{Check, Origin, Outcome, get};
pub use error::{Error, KnownHash, Result};
pub use progress::{Progress, Stage};
