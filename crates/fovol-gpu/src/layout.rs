//! Tests, without a device, that Rust structs have the memory layout that shaders expect.

use crate::Shader;
use wgpu::naga;

/// Asserts that a struct of a shader has the fields of a Rust struct, with equal names, order, offsets and size.
#[macro_export]
macro_rules! assert_twins {
    ($shader:expr, $name:literal, $twin:ty { $($field:ident),* $(,)? }) => {
        $crate::layout::assert_members(
            &$shader,
            $name,
            &[$((stringify!($field), std::mem::offset_of!($twin, $field))),*],
            size_of::<$twin>(),
        )
    };
}
/// Asserts that struct `name` of `shader` has members of these names at these offsets and takes `size` bytes.
///
/// # Panics
/// Where the layout differs, or the shader has no such struct.
pub fn assert_members(shader: &Shader, name: &str, fields: &[(&str, usize)], size: usize) {
    let module = naga::front::wgsl::parse_str(&shader.source()).expect("shaders are valid: see their test");
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
        panic!("{} has no struct {name}", shader.name());
    };
    let members: Vec<(&str, usize)> =
        members.iter().map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize)).collect();
    assert_eq!(members, fields, "{name} of {}", shader.name());
    assert_eq!(*span as usize, size, "size of {name} of {}", shader.name());
}
