use wgpu::naga;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

/// A compute shader: WGSL files, joined in order. The last one has the entry points. See [`shader!`].
///
/// [`shader!`]: crate::shader!
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shader {
    name: &'static str,
    parts: &'static [&'static str],
}

/// Makes the [`Shader`] of a WGSL file and the files that it builds upon.
///
/// `shader!("folder/", "march": "frame" "scene")` joins `frame.wgsl`, `scene.wgsl` and `march.wgsl` of a folder
/// beside the source file.
#[macro_export]
macro_rules! shader {
    ($folder:literal, $name:literal: $($part:literal)*) => {
        $crate::Shader::new($name, &[
            $(include_str!(concat!($folder, $part, ".wgsl")),)*
            include_str!(concat!($folder, $name, ".wgsl")),
        ])
    };
}

impl Shader {
    /// Makes the shader `name` from the texts `parts`.
    pub const fn new(name: &'static str, parts: &'static [&'static str]) -> Self {
        Self { name, parts }
    }

    /// Name of the last file, without its extension.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// WGSL source of all parts.
    pub fn source(&self) -> String {
        self.parts.concat()
    }

    /// Validates the shader for devices with `capabilities`. Needs no device.
    ///
    /// # Errors
    /// The problem and its place in the source.
    pub fn check(&self, capabilities: Capabilities) -> Result<naga::Module, String> {
        let (name, source) = (self.name, self.source());
        let module = naga::front::wgsl::parse_str(&source)
            .map_err(|e| format!("{name}: {}", e.emit_to_string(&source)))?;
        Validator::new(ValidationFlags::all(), capabilities)
            .validate(&module)
            .map_err(|e| format!("{name}: {}", e.emit_to_string(&source)))?;
        match module.entry_points.is_empty() {
            true => Err(format!("{name} has no entry point")),
            false => Ok(module),
        }
    }
}
