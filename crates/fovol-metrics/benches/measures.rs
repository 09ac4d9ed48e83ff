//! Benchmark of the metrics at 1280×720: median time in milliseconds.

use fovol_core::{Frame, FrameSize};
use fovol_metrics::{ColorVideoVdp, Display, FovVideoVdp, SsimSettings, ms_ssim, psnr, ssim};
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 11;

fn frame(phase: f32) -> Frame {
    let mut frame = Frame::new(FrameSize::default());
    for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let t = i as f32 * 0.01 + phase;
        *pixel = [t.sin().abs(), t.cos().abs(), (t * 0.3).sin().abs(), 1.0];
    }
    frame
}

fn measure<T>(name: &str, mut run: impl FnMut() -> T) {
    black_box(run());
    let mut times = [(); RUNS].map(|()| {
        let started = Instant::now();
        black_box(run());
        started.elapsed().as_secs_f64() * 1e3
    });
    times.sort_by(f64::total_cmp);
    println!("{name:<16}{:8.2} ms", times[RUNS / 2]);
}

fn main() {
    let (a, b) = (frame(0.0), frame(0.1));
    measure("psnr", || psnr(&a, &b));
    let settings = SsimSettings::gaussian();
    measure("ssim", || ssim(&a, &b, &settings));
    measure("ms_ssim", || ms_ssim(&a, &b));
    let display = Display::named("standard_4k").expect("the name of a display");
    let mut clip = FovVideoVdp::video(&display, 30.0).expect("a rate that it knows");
    measure("fvvdp", || clip.push(&a, &b, None));
    measure("fvvdp_foveated", || clip.push(&a, &b, Some([0.5, 0.5])));
    let mut clip = ColorVideoVdp::video(&display, 30.0).expect("a rate that it knows");
    measure("cvvdp", || clip.push(&a, &b));
    let mut picture = ColorVideoVdp::image(&display).expect("a display that can be");
    measure("cvvdp_picture", || picture.push(&a, &b));
}
