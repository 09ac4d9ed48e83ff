//! Benchmark of the viewer's frame rate along the fly-through, and of how well frames keep their time budget: `cargo
//! bench -p fovolnet-viewer -- [VOLUME …] [--rate F] [--size WxH] [--shadows on|cached] [--side N] [--frames N]`.
//!
//! A low-priority thread makes the frames, as in the viewer. PSNR is that of the last frame, enlarged by bilinear
//! interpolation, against the full frame with exact shadows.

use fovolnet::core::{CameraPath, Frame, FrameSize, Integration, ShadowMode};
use fovolnet::io::procedural::Procedural;
use fovolnet::metrics::psnr;
use fovolnet::{
    Freedom, OpenVolume, Pipeline, Reconstruction, RenderOverrides, RenderSettings, Sampling, SpeedSettings,
    Viewpoint, VolumeSettings, Way, open_volume, presets,
};
use fovolnet_viewer::frames::display_mode::DisplayMode;
use fovolnet_viewer::frames::frame_producer::FrameProducer;
use fovolnet_viewer::frames::presented::{Pixels, Presented};
use fovolnet_viewer::frames::view_request::ViewRequest;
use std::str::FromStr;
use std::time::Instant;

/// Parameters of the benchmark.
struct Run {
    volumes: Vec<String>,
    rate: Option<f64>,
    size: FrameSize,
    shadows: ShadowMode,
    side: usize,
    frames: u32,
}

fn arguments() -> Result<Run, String> {
    let mut run = Run {
        volumes: Vec::new(),
        rate: Some(12.0),
        size: FrameSize::default(),
        shadows: ShadowMode::On,
        side: 256,
        frames: 120,
    };
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        if !word.starts_with("--") {
            run.volumes.push(word);
            continue;
        }
        let value = words.next().ok_or_else(|| format!("{word} takes a value"))?;
        match word.as_str() {
            "--rate" => run.rate = Some(read(&word, &value)?),
            "--size" => run.size = value.parse()?,
            "--shadows" if value == "cached" => run.shadows = ShadowMode::Cached,
            "--shadows" => run.shadows = ShadowMode::On,
            "--side" => run.side = read(&word, &value)?,
            "--frames" => run.frames = read(&word, &value)?,
            _ => return Err(format!("`{word}` is no flag")),
        }
    }
    if run.volumes.is_empty() {
        run.volumes = Procedural::ALL.map(|kind| kind.name().to_owned()).to_vec();
    }
    run.rate = run.rate.filter(|&rate| rate > 0.0);
    Ok(run)
}

fn read<T: FromStr>(flag: &str, value: &str) -> Result<T, String> {
    value.parse().map_err(|_| format!("`{value}` is no value of {flag}"))
}

fn main() {
    let run = arguments().unwrap_or_else(|error| panic!("{error}"));
    let asked = run.rate.map_or("as asked".to_owned(), |rate| format!("{rate} frames a second"));
    println!("{}³, {}, {:?} shadows, {asked}", run.side, run.size, run.shadows);
    println!("volume           frames/s  median ms   95 % ms  within 20 %    cached light  PSNR  last");
    let measured = std::thread::spawn(move || {
        fovolnet::lower_thread_priority();
        run.volumes.iter().for_each(|volume| measure(volume, &run));
    });
    measured.join().expect("what is measured can be rendered");
}

fn measure(volume: &str, run: &Run) {
    let read = VolumeSettings { dims: Some([run.side; 3]), ..VolumeSettings::default() };
    let volume = open_volume(volume, &read).expect("a procedural volume");
    let transfer = presets::find("auto", &volume).expect("every volume has one");
    let settings = RenderOverrides {
        size: Some(run.size),
        tf: Some(transfer.into()),
        shadows: Some(run.shadows),
        integration: Some(Integration::Plain),
        reconstruct: Some(Reconstruction::WNet),
        ..RenderOverrides::default()
    };
    let mut producer = FrameProducer::new(SpeedSettings::default(), None);
    let (mut times, mut cached) = (Vec::new(), 0.0);
    let mut last = None;
    // The first frames teach the budget what the machine can do.
    let learning = 20;
    for i in 0..run.frames + learning {
        let wanted = ViewRequest {
            volume: volume.clone(),
            settings: settings.clone(),
            freedom: Freedom::ALL,
            camera: CameraPath::Flythrough.camera(i),
            gaze: [0.5; 2],
            probe: None,
            rate: run.rate,
            converges: false,
            look: DisplayMode::Picture,
        };
        let started = Instant::now();
        let shown =
            producer.step(&wanted).expect("settings that can be rendered").expect("a view that moves");
        if i >= learning {
            times.push(started.elapsed().as_secs_f64() * 1e3);
            let plan = shown.plan.as_ref();
            cached += f64::from(plan.is_some_and(|plan| plan.way == Way::CachedLight));
        }
        last = Some(shown);
    }
    let last = last.expect("there are frames");
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let budget = run.rate.map_or(f64::INFINITY, |rate| 1e3 / rate);
    let within = times.iter().filter(|&&ms| ms <= 1.2 * budget).count() as f64 / times.len() as f64;
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    println!(
        "{:<16} {:8.1}  {:9.1}  {:8.1}  {:10.0} %  {:12.0} %  {:4.1}  {} {} step {:.2}",
        volume.source,
        1e3 / mean,
        at(0.5),
        at(0.95),
        within * 100.0,
        cached / times.len() as f64 * 100.0,
        quality(&volume, &settings, &last),
        last.size,
        last.settings.sampling,
        last.settings.step,
    );
}

/// PSNR of the picture `shown`, enlarged, against the full frame of `settings` with exact shadows, in dB.
fn quality(volume: &OpenVolume, settings: &RenderOverrides, shown: &Presented) -> f64 {
    let settings = settings.resolve().expect("settings that were rendered");
    let mut pipeline =
        Pipeline::new(volume, &settings, &SpeedSettings::default()).expect("a volume that was rendered");
    let sampling = RenderSettings { sampling: Sampling::Full, ..settings.clone() };
    pipeline.change(&sampling).expect("settings of full frames");
    let fovea = pipeline.fovea(0);
    let exact =
        pipeline.render_from(0, &Viewpoint { camera: shown.camera, fovea }).expect("a full frame").frame;
    let Pixels::Host(bytes) = &shown.pixels else { return f64::NAN };
    let pixels = bytes.as_chunks::<4>().0.iter().map(|pixel| pixel.map(|byte| f32::from(byte) / 255.0));
    let picture = Frame::from_pixels(shown.size, pixels.collect()).expect("a pixel for every place");
    psnr(&exact, &enlarged(&picture, exact.size())).expect("frames of one size")
}

/// `picture` at `size`, by bilinear interpolation.
fn enlarged(picture: &Frame, size: FrameSize) -> Frame {
    let small = picture.size();
    let place = |at: u32, side: u32, small: u32| {
        let place = (f64::from(at) + 0.5) * f64::from(small) / f64::from(side) - 0.5;
        let place = place.clamp(0.0, f64::from(small - 1));
        (place as u32, (place as u32 + 1).min(small - 1), place.fract() as f32)
    };
    let pixel = |i: u32| {
        let (x0, x1, fx) = place(i % size.width, size.width, small.width);
        let (y0, y1, fy) = place(i / size.width, size.height, small.height);
        let mix = |a: [f32; 4], b: [f32; 4], part: f32| std::array::from_fn(|c| a[c] + part * (b[c] - a[c]));
        let row = |y: u32| mix(picture.pixel(x0, y), picture.pixel(x1, y), fx);
        mix(row(y0), row(y1), fy)
    };
    Frame::from_pixels(size, (0..size.pixels() as u32).map(pixel).collect()).expect("a pixel for every place")
}
