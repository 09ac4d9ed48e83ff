//! Benchmark of the viewer's frame rate along the fly-through, and of how well frames keep their time budget: `cargo
//! bench -p fovolnet-viewer -- [VOLUME …] [--rate F] [--size WxH] [--shadows on|cached] [--side N] [--frames N]`.
//!
//! A low-priority thread makes the frames, as in the viewer.

use fovolnet::core::{CameraPath, FrameSize, Integration, ShadowMode};
use fovolnet::io::procedural::Procedural;
use fovolnet::{Reconstruction, RenderOverrides, SpeedSettings, VolumeSettings, open_volume, presets};
use fovolnet_viewer::frames::display_mode::DisplayMode;
use fovolnet_viewer::frames::frame_producer::FrameProducer;
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
    println!("volume           frames/s  median ms   95 % ms  within 20 %  by the network  last");
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
    let (mut times, mut by_network) = (Vec::new(), 0.0);
    let mut last = None;
    // The first frames teach the budget what the machine can do.
    let learning = 20;
    for i in 0..run.frames + learning {
        let wanted = ViewRequest {
            volume: volume.clone(),
            settings: settings.clone(),
            camera: CameraPath::Flythrough.camera(i),
            gaze: [0.5; 2],
            rate: run.rate,
            converges: false,
            look: DisplayMode::Picture,
        };
        let started = Instant::now();
        let shown =
            producer.step(&wanted).expect("settings that can be rendered").expect("a view that moves");
        if i >= learning {
            times.push(started.elapsed().as_secs_f64() * 1e3);
            by_network += f64::from(shown.settings.reconstruction == Reconstruction::WNet);
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
        "{:<16} {:8.1}  {:9.1}  {:8.1}  {:10.0} %  {:12.0} %  {} {} step {:.2}",
        volume.source,
        1e3 / mean,
        at(0.5),
        at(0.95),
        within * 100.0,
        by_network / times.len() as f64 * 100.0,
        last.size,
        last.settings.reconstruction,
        last.settings.step,
    );
}
