use super::buffers::{Buffers, blocks};
use super::shader::COMPACT;
use fovol_core::FrameSize;
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Pass};

/// The pipelines that pack the pixels of a mask.
#[derive(Debug)]
pub struct CompactPass {
    layout: wgpu::BindGroupLayout,
    count: wgpu::ComputePipeline,
    scan: wgpu::ComputePipeline,
    pack: wgpu::ComputePipeline,
}

impl CompactPass {
    /// The pipelines on the device of `gpu`.
    pub fn new(gpu: &Gpu) -> Self {
        let slots =
            [Slot::Uniform, Slot::Read, Slot::Write, Slot::Write, Slot::Write, Slot::Write, Slot::Write];
        let layout = bind_group_layout(gpu, "compact", &slots);
        let pipeline = |entry_point| compute_pipeline(gpu, &COMPACT, entry_point, &[&layout], &[]);
        Self { count: pipeline("count"), scan: pipeline("scan"), pack: pipeline("pack"), layout }
    }

    /// Binds the mask as input, the list as output, and the sparse frame, which is cleared.
    pub fn bind(&self, gpu: &Gpu, buffers: &Buffers) -> wgpu::BindGroup {
        let buffers = [
            &buffers.extent,
            &buffers.mask,
            &buffers.blocks,
            &buffers.listed.length,
            &buffers.listed.pixels,
            &buffers.frame.colours,
            &buffers.frame.inverse_depths,
        ];
        bind_group(gpu, "compact", &self.layout, &buffers.map(wgpu::Buffer::as_entire_binding))
    }

    /// Packs the mask of a frame of `size`, and clears the frame.
    pub fn dispatch(&self, pass: &mut Pass<'_>, group: &wgpu::BindGroup, size: FrameSize) {
        pass.set_bind_group(0, group, &[]);
        for (pipeline, groups) in [(&self.count, blocks(size)), (&self.scan, 1), (&self.pack, blocks(size))] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(groups, 1, 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu;
    use crate::gpu::buffers::BLOCK;
    use crate::gpu::frame_buffers::FrameBuffers;
    use crate::gpu::layers::Layering;
    use crate::gpu::stages::Stages;
    use crate::gpu::volume_texture::TexelKind;
    use crate::noise::hash;
    use fovol_core::SampleMask;
    use fovol_gpu::AdapterRequest;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    static DEVICE: LazyLock<(Gpu, Stages)> = LazyLock::new(|| {
        let gpu = Gpu::open(&AdapterRequest::Any.or_environment()).unwrap();
        let stages = Stages::new(&gpu, TexelKind::Filtered, Layering::default());
        (gpu, stages)
    });

    fn compacted(mask: &SampleMask) -> fovol_core::SampleList {
        let (gpu, stages) = &*DEVICE;
        let mut buffers = FrameBuffers::new(gpu, stages, mask.size()).unwrap();
        buffers.set_decided_mask(mask);
        gpu.guarded("compaction", || {
            let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = gpu.pass(&mut encoder);
            stages.compact.dispatch(&mut pass, &buffers.groups.compact, mask.size());
            drop(pass);
            gpu.enqueue([encoder.finish()]);
        })
        .unwrap();
        buffers.is_tiled = true;
        buffers.read_list().unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
        fn the_list_is_that_of_the_cpu(w in 1u32..700, h in 1u32..300, seed in 0u64..100, density in 0u64..=100) {
            let size = FrameSize::new(w, h).unwrap();
            let mask = SampleMask::from_fn(size, |x, y| hash(seed, u64::from(y * 1000 + x)) % 100 < density);
            prop_assert_eq!(compacted(&mask), cpu::compact(&mask));
        }
    }

    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn more_blocks_than_one_workgroup_scans_at_once_are_packed_too() {
        // 4096 pixels a row are 128 words: 600 rows are 300 blocks.
        let size = FrameSize::new(4096, 600).unwrap();
        let mask = SampleMask::from_fn(size, |x, y| (x * 7 + y * 13) % 5 < 2);
        assert!(blocks(size) > BLOCK);
        assert_eq!(compacted(&mask), cpu::compact(&mask));
    }
}
