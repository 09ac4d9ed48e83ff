//! Bind groups, their layouts and compute pipelines, in short form.

use crate::{Gpu, Shader};
use wgpu::{BufferBindingType, TextureSampleType, TextureViewDimension};

/// Type of a resource that a shader binds.
#[derive(Debug, Clone, Copy)]
pub enum Slot {
    /// Uniform buffer.
    Uniform,
    /// Storage buffer, read-only.
    Read,
    /// Storage buffer, read and write.
    Write,
    /// 3-D texture of integers.
    Whole,
    /// 3-D texture of floats that a sampler may filter.
    Filtered,
    /// Filtering sampler.
    Sampler,
    /// 3-D storage texture of format rgba8unorm, write-only.
    Stored,
    /// 2-D storage texture of format rgba8unorm, write-only.
    Picture,
}

impl Slot {
    fn binding_type(self) -> wgpu::BindingType {
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: TextureViewDimension::D3,
            multisampled: false,
        };
        let stored = |view_dimension| wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: wgpu::TextureFormat::Rgba8Unorm,
            view_dimension,
        };
        match self {
            Self::Uniform => buffer(BufferBindingType::Uniform),
            Self::Read => buffer(BufferBindingType::Storage { read_only: true }),
            Self::Write => buffer(BufferBindingType::Storage { read_only: false }),
            Self::Whole => texture(TextureSampleType::Uint),
            Self::Filtered => texture(TextureSampleType::Float { filterable: true }),
            Self::Sampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            Self::Stored => stored(TextureViewDimension::D3),
            Self::Picture => stored(TextureViewDimension::D2),
        }
    }
}

/// Makes the layout of a bind group for compute shaders: `slots` at bindings 0, 1, 2…
pub fn bind_group_layout(gpu: &Gpu, label: &str, slots: &[Slot]) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0..)
        .zip(slots)
        .map(|(binding, slot)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: slot.binding_type(),
            count: None,
        })
        .collect();
    gpu.device()
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Makes a bind group: `resources` at bindings 0, 1, 2…
pub fn bind_group(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

/// Compiles an entry point of a shader. `constants` are values of its `override` constants.
pub fn compute_pipeline(
    gpu: &Gpu,
    shader: &Shader,
    entry_point: &str,
    layouts: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let layouts: Vec<_> = layouts.iter().copied().map(Some).collect();
    let layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry_point),
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    let source = wgpu::ShaderSource::Wgsl(shader.source().into());
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(shader.name()), source };
    // SAFETY: shaders are parts of this program, not input. Their loops end, their divisors are not 0, and bounds are checked unless
    // the user says otherwise. Tests compare frames with every check and with none, and all shaders with the processor.
    let module = unsafe { gpu.device().create_shader_module_trusted(descriptor, gpu.checks().of_shaders()) };
    let zero_initialize_workgroup_memory = gpu.checks().memory;
    gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions { constants, zero_initialize_workgroup_memory },
        cache: gpu.compiled(),
    })
}
