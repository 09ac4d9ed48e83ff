//! What shaders bind, in few words.

use crate::{Gpu, Shader};
use wgpu::{BufferBindingType, TextureSampleType, TextureViewDimension};

/// One thing that a shader binds.
#[derive(Debug, Clone, Copy)]
pub enum Slot {
    /// A small buffer, the same for all threads.
    Uniform,
    /// A buffer to read.
    Read,
    /// A buffer to read and write.
    Write,
    /// A 3-D texture of whole numbers.
    Whole,
    /// A 3-D texture that a sampler may filter.
    Filtered,
    /// A filtering sampler.
    Sampler,
    /// A 3-D texture of rgba8unorm to write.
    Stored,
    /// A picture of rgba8unorm to write.
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

/// The layout of a bind group: `slots` at bindings 0, 1, 2…
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

/// A bind group: `resources` at bindings 0, 1, 2…
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

/// The entry point of a shader, with values for its `override` constants, as a pipeline.
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
    let module = gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(shader.name()),
        source: wgpu::ShaderSource::Wgsl(shader.source().into()),
    });
    gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: gpu.compiled(),
    })
}
