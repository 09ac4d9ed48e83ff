//! How long the measures take at 1280×720.

use criterion::{Criterion, criterion_group, criterion_main};
use fovol_core::{Frame, FrameSize};
use fovol_metrics::{Display, FovVideoVdp, SsimSettings, ms_ssim, psnr, ssim};

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
    let display = Display::named("standard_4k").unwrap();
    let mut clip = FovVideoVdp::video(&display, 30.0).unwrap();
    criterion.bench_function("fvvdp", |bench| bench.iter(|| clip.push(&a, &b, None)));
    criterion.bench_function("fvvdp_foveated", |bench| bench.iter(|| clip.push(&a, &b, Some([0.5, 0.5]))));
}

criterion_group!(benches, measures);
criterion_main!(benches);
