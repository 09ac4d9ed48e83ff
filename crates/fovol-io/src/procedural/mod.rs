//! Volumes made by formula, so that everything works with no file at hand.
//!
//! Each stands in for a class of real data: simulated flow, medical and industrial scans, thin
//! structures in empty space. All fill the cube [−1, 1]³ with +y up and +z towards the viewer of
//! frame 0; a grid that is not cubic samples the same cube with a spacing to match. The same kind,
//! size and seed give the same bytes, whatever the number of threads. (Another processor or another
//! mathematical library may round last digits otherwise.)
//!
//! ```
//! use fovol_io::procedural::{Procedural, make};
//!
//! let kind: Procedural = "marschner-lobb".parse()?;
//! let volume = make(kind, [41, 41, 41], 0)?;
//! assert_eq!(volume.grid().voxels(), 68_921);
//! # Ok::<(), fovol_io::procedural::Error>(())
//! ```

#[cfg(feature = "procedural")]
mod generators;

#[cfg(feature = "procedural")]
pub use generators::make;

use fovol_core::memory::Shortage;
use fovol_core::{Dtype, did_you_mean};
use std::fmt;
use std::str::FromStr;

/// The fewest voxels along an axis.
pub const MIN_SIDE: usize = 4;

/// The most voxels of one volume: 16 GiB of the largest type made here.
pub const MAX_VOXELS: usize = 1 << 32;

/// Why a procedural volume was not made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A name that no procedural volume has.
    #[error("`{name}` is no procedural volume; use one of {}{}", names().join(", "), did_you_mean(name, &names()))]
    UnknownName {
        /// The name asked for.
        name: String,
    },
    /// A size that is too small or too large.
    #[error(
        "a procedural volume of {}x{}x{} voxels cannot be made; use {MIN_SIDE} or more along each axis and at most {MAX_VOXELS} in all",
        dims[0], dims[1], dims[2]
    )]
    Size {
        /// The size asked for.
        dims: [usize; 3],
    },
    /// A grid that the volume type refuses.
    #[error(transparent)]
    Core(#[from] fovol_core::Error),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] Shortage),
}

/// The result of making a procedural volume.
pub type Result<T> = std::result::Result<T, Error>;

/// A kind of procedural volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Procedural {
    /// Turbulence: vorticity magnitude of an incompressible flow (f32).
    Vortices,
    /// An exploding star: a shell with Rayleigh–Taylor fingers (f32).
    Supernova,
    /// A head in computed tomography, in Hounsfield units (i16).
    Head,
    /// A two-cylinder engine in industrial tomography (u8).
    Engine,
    /// Thin blood vessels in empty space (u8).
    Angiogram,
    /// A lizard with a curled tail: skin shell, scales and bones (u16).
    Reptile,
    /// A rising plume of smoke (f32).
    Plume,
    /// The test signal of Marschner and Lobb (f32).
    MarschnerLobb,
}

impl Procedural {
    /// Every kind.
    pub const ALL: [Self; 8] = [
        Self::Vortices,
        Self::Supernova,
        Self::Head,
        Self::Engine,
        Self::Angiogram,
        Self::Reptile,
        Self::Plume,
        Self::MarschnerLobb,
    ];

    /// The name on the command line and of the preset transfer function.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vortices => "vortices",
            Self::Supernova => "supernova",
            Self::Head => "head",
            Self::Engine => "engine",
            Self::Angiogram => "angiogram",
            Self::Reptile => "reptile",
            Self::Plume => "plume",
            Self::MarschnerLobb => "marschner-lobb",
        }
    }

    /// The type of its values.
    pub const fn dtype(self) -> Dtype {
        match self {
            Self::Engine | Self::Angiogram => Dtype::U8,
            Self::Head => Dtype::I16,
            Self::Reptile => Dtype::U16,
            Self::Vortices | Self::Supernova | Self::Plume | Self::MarschnerLobb => Dtype::F32,
        }
    }

    /// One line for lists.
    pub const fn description(self) -> &'static str {
        match self {
            Self::Vortices => "turbulent vortices: vorticity magnitude of a Navier-Stokes simulation, f32",
            Self::Supernova => "exploding star: a shell with Rayleigh-Taylor fingers, f32",
            Self::Head => "head CT: skin, skull, teeth, brain, sinuses, in Hounsfield units, i16",
            Self::Engine => "two-cylinder engine in industrial CT: aluminium and steel, u8",
            Self::Angiogram => "blood vessels with an aneurysm in nearly empty space, u8",
            Self::Reptile => "lizard with a curled tail: scaly skin shell and bones, u16",
            Self::Plume => "rising smoke, wispy and mostly transparent, f32",
            Self::MarschnerLobb => "the Marschner-Lobb test signal, hard on every reconstruction filter, f32",
        }
    }
}

impl fmt::Display for Procedural {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Procedural {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let name = text.trim().to_ascii_lowercase().replace('_', "-");
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| Error::UnknownName { name: text.into() })
    }
}

/// The names of all kinds.
pub fn names() -> [&'static str; Procedural::ALL.len()] {
    Procedural::ALL.map(Procedural::name)
}
