use wgpu::naga;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

/// A compute shader: files of WGSL, joined in this order, of which the last one has the entry points. See [`shader!`].
///
/// [`shader!`]: crate::shader!
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shader {
    name: &'static str,
    parts: &'static [&'static str],
}

/// The [`Shader`] of a file of WGSL, after those that it builds upon: `shader!("folder/", "march": "frame" "scene")` joins
/// `frame.wgsl`, `scene.wgsl` and `march.wgsl` of a folder beside the source file.
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
    /// The shader `name` of `parts`.
    pub const fn new(name: &'static str, parts: &'static [&'static str]) -> Self {
        Self { name, parts }
    }

    /// The name of its last file, without the ending.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Its WGSL.
    pub fn source(&self) -> String {
        self.parts.concat()
    }

    /// Whether it is valid on devices with `capabilities`, found out without one.
    ///
    /// # Errors
    /// What is wrong with it and where.
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
