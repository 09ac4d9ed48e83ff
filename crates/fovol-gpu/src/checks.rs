//! Checks that wgpu adds to shaders and dispatches.

use crate::{GpuError, Result};
use std::str::FromStr;

/// Environment variable for the checks to keep: `all`, `none`, or some of `bounds`, `loops`, `memory` and `dispatches`,
/// separated by commas.
pub const CHECKS_VARIABLE: &str = "FOVOLNET_GPU_CHECKS";

/// Checks of a device while its shaders run. The shaders of this program need none of them; each costs time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Checks {
    /// Indices are kept within arrays and textures where the driver does not do so.
    pub bounds: bool,
    /// Loops end after 2⁶⁴ rounds, and integers are not divided by 0.
    pub loops: bool,
    /// Workgroup memory is 0 when a shader starts.
    pub memory: bool,
    /// A shader of wgpu's looks at the size of each indirect dispatch before it.
    pub dispatches: bool,
}

impl Checks {
    /// Every check: what wgpu does for shaders that it does not know.
    pub const ALL: Self = Self { bounds: true, loops: true, memory: true, dispatches: true };
    /// No check.
    pub const NONE: Self = Self { bounds: false, loops: false, memory: false, dispatches: false };

    /// Names of the checks, as in [`CHECKS_VARIABLE`].
    const NAMES: [&str; 4] = ["bounds", "loops", "memory", "dispatches"];

    /// The checks that [`CHECKS_VARIABLE`] names, or else the default.
    ///
    /// # Errors
    /// [`GpuError::Checks`] for a value that names something else.
    pub fn of_environment() -> Result<Self> {
        match std::env::var(CHECKS_VARIABLE) {
            Ok(text) if !text.trim().is_empty() => text.parse().map_err(GpuError::Checks),
            _ => Ok(Self::default()),
        }
    }

    /// How wgpu compiles shaders.
    pub(crate) fn of_shaders(self) -> wgpu::ShaderRuntimeChecks {
        let mut checks = wgpu::ShaderRuntimeChecks::checked();
        checks.bounds_checks = self.bounds;
        checks.force_loop_bounding = self.loops;
        checks.int_div_checks = self.loops;
        checks
    }

    /// Flags of an instance whose devices have these checks.
    pub fn of_instance(self) -> wgpu::InstanceFlags {
        let flags = wgpu::InstanceFlags::from_env_or_default();
        match self.dispatches {
            true => flags,
            false => flags - wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL,
        }
    }
}

impl Default for Checks {
    /// Bounds: an index that is wrong despite all tests then does no harm. And the sizes of dispatches on Windows, where wgpu needs
    /// them for DirectX.
    fn default() -> Self {
        Self { bounds: true, dispatches: cfg!(windows), ..Self::NONE }
    }
}

impl FromStr for Checks {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.trim() {
            "all" => return Ok(Self::ALL),
            "none" => return Ok(Self::NONE),
            _ => {}
        }
        let names: Vec<&str> = text.split(',').map(str::trim).collect();
        match names.iter().find(|name| !Self::NAMES.contains(name)) {
            Some(name) => {
                Err(format!("`{name}` is no check; use all, none, or some of {}", Self::NAMES.join(",")))
            }
            None => {
                let [bounds, loops, memory, dispatches] = Self::NAMES.map(|name| names.contains(&name));
                Ok(Self { bounds, loops, memory, dispatches })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_read_as_written() {
        assert_eq!("all".parse(), Ok(Checks::ALL));
        assert_eq!(" none ".parse(), Ok(Checks::NONE));
        assert_eq!("loops, memory".parse(), Ok(Checks { loops: true, memory: true, ..Checks::NONE }));
        assert_eq!("bounds,loops,memory,dispatches".parse(), Ok(Checks::ALL));
        let error = "bounds,loop".parse::<Checks>().unwrap_err();
        assert_eq!(error, "`loop` is no check; use all, none, or some of bounds,loops,memory,dispatches");
    }

    #[test]
    fn an_instance_checks_dispatches_only_where_asked() {
        let flag = wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL;
        assert!(!Checks::NONE.of_instance().contains(flag));
        assert_eq!(Checks::ALL.of_instance(), wgpu::InstanceFlags::from_env_or_default());
    }
}
