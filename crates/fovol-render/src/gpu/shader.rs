/// A compute shader: files of `src/shaders`, joined in this order, of which the last one has the entry points.
#[derive(Debug, Clone, Copy)]
pub struct Shader {
    name: &'static str,
    parts: &'static [&'static str],
}

/// The shader whose parts are the files of these names.
macro_rules! shader {
    ($name:literal: $($part:literal)*) => {
        Shader { name: $name, parts: &[$(include_str!(concat!("../shaders/", $part, ".wgsl")),)* include_str!(concat!("../shaders/", $name, ".wgsl"))] }
    };
}

/// Which pixels are sampled.
pub const MASK: Shader = shader!("mask": "frame" "random");
/// The sampled pixels as a list.
pub const COMPACT: Shader = shader!("compact": "frame");
/// Image formation.
pub const MARCH: Shader = shader!("march": "frame" "scene" "field" "skip" "segment" "shadow_rays");
/// From packed samples to a sparse frame.
pub const SCATTER: Shader = shader!("scatter": "frame");
/// Transmittance towards the light at half resolution.
pub const SHADOW_GRID: Shader = shader!("shadow_grid": "scene" "field" "skip" "shadow_rays");

impl Shader {
    /// The name of its last file, without the ending.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Its WGSL.
    pub fn source(&self) -> String {
        self.parts.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga;
    use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

    #[test]
    fn every_shader_is_valid_without_any_optional_feature() {
        for shader in [MASK, COMPACT, MARCH, SCATTER, SHADOW_GRID] {
            let (name, source) = (shader.name(), shader.source());
            let module = naga::front::wgsl::parse_str(&source)
                .unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&source)));
            Validator::new(ValidationFlags::all(), Capabilities::empty())
                .validate(&module)
                .unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&source)));
            assert!(!module.entry_points.is_empty(), "{name} has no entry point");
        }
    }

    #[test]
    fn no_shader_is_left_out() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/shaders");
        let all: String = [MASK, COMPACT, MARCH, SCATTER, SHADOW_GRID].map(|shader| shader.source()).concat();
        for file in std::fs::read_dir(folder).unwrap() {
            let path = file.unwrap().path();
            assert!(all.contains(&std::fs::read_to_string(&path).unwrap()), "{} is not used", path.display());
        }
    }
}
