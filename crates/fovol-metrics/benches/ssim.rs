//! How long the measures take at 1280×720.

use criterion::{Criterion, criterion_group, criterion_main};
use fovol_core::{Frame, FrameSize};
use fovol_metrics::{SsimSettings, ms_ssim, psnr, ssim};

fn frame(phase: f32) -> Frame {
    let mut frame = Frame::new(FrameSize::default());
    for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let t = i as f32 * 0.01 + phase;
        *pixel = [t.sin().abs(), t.cos().abs(), (t * 0.3).sin().abs(), 1.0];
    }
    frame
}

fn measures(criterion: &mut Criterion) {
    let (a, b) = (frame(0.0), frame(0.1));
    criterion.bench_function("psnr", |bench| bench.iter(|| psnr(&a, &b)));
    let settings = SsimSettings::gaussian();
    criterion.bench_function("ssim", |bench| bench.iter(|| ssim(&a, &b, &settings)));
    criterion.bench_function("ms_ssim", |bench| bench.iter(|| ms_ssim(&a, &b)));
}

criterion_group!(benches, measures);
criterion_main!(benches);
