//! Textured quads with a minimal shader. The user interface's general shader does so much per pixel that software
//! rendering takes twenty times as long.

use eframe::egui::{PaintCallbackInfo, Rect, Shape};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState};
use eframe::wgpu;
use std::fmt;
use std::sync::Arc;

const SHADER: &str = "
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var between: sampler;

struct Corner {
    @builtin(position) place: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn corner(@builtin(vertex_index) number: u32) -> Corner {
    let at = vec2<f32>(vec2<u32>(number & 1u, number >> 1u));
    return Corner(vec4<f32>(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0), at);
}

@fragment
fn pixel(corner: Corner) -> @location(0) vec4<f32> {
    return textureSample(picture, between, corner.at);
}
";

/// Renderer of pictures in a window.
#[derive(Clone)]
pub struct Painter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    /// Format of the pictures' texture; values are stored as they are displayed.
    format: wgpu::TextureFormat,
}

impl fmt::Debug for Painter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Painter").field("format", &self.format).finish_non_exhaustive()
    }
}

impl Painter {
    /// Renderer for the window of `state`.
    pub fn of_window(state: &RenderState) -> Self {
        let (device, target) = (&state.device, state.target_format);
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("picture"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("picture"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("corner"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::TriangleStrip,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("pixel"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(target.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let format = match target.is_srgb() {
            true => wgpu::TextureFormat::Rgba8UnormSrgb,
            false => wgpu::TextureFormat::Rgba8Unorm,
        };
        Self { device: device.clone(), queue: state.queue.clone(), pipeline, sampler, format }
    }

    /// Uploads `rgba` as a picture of this width and height. Reuses the texture of `before` if its size matches.
    pub fn show(&self, [width, height]: [u32; 2], rgba: &[u8], before: Option<OnWindow>) -> OnWindow {
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let shown = match before.filter(|shown| shown.0.texture.size() == size) {
            Some(shown) => shown,
            None => OnWindow(Arc::new(self.empty(size))),
        };
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None };
        self.queue.write_texture(shown.0.texture.as_image_copy(), rgba, rows, size);
        shown
    }

    fn empty(&self, size: wgpu::Extent3d) -> Quad {
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let bound = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        });
        Quad { texture, bound, pipeline: self.pipeline.clone() }
    }
}

/// Picture that a window can draw.
#[derive(Debug, Clone)]
pub struct OnWindow(Arc<Quad>);

impl OnWindow {
    /// Shape that draws the picture in `rect`.
    pub fn shape(&self, rect: Rect) -> Shape {
        Callback::new_paint_callback(rect, self.clone()).into()
    }
}

#[derive(Debug)]
struct Quad {
    texture: wgpu::Texture,
    bound: wgpu::BindGroup,
    pipeline: wgpu::RenderPipeline,
}

impl CallbackTrait for OnWindow {
    fn paint(&self, _: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _: &CallbackResources) {
        let Quad { bound, pipeline, .. } = &*self.0;
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, bound, &[]);
        pass.draw(0..4, 0..1);
    }
}
