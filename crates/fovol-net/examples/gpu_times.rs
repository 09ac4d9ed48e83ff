//! How long a network takes on a GPU, as a whole and layer by layer:
//! `cargo run --release -p fovol-net --features gpu --example gpu_times -- wnet-fast 1280x720 auto`

use fovol_core::FrameSize;
use fovol_gpu::{AdapterRequest, Gpu};
use fovol_net::gpu::{DeviceInput, Network, Precision, State};
use fovol_net::{Weights, plan::Named};
use std::error::Error;
use std::time::Instant;

/// Frames that are measured, after as many to warm up.
const FRAMES: u32 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |place: usize, default: &'static str| arguments.get(place).map_or(default, String::as_str);
    let named: Named = argument(0, "wnet-fast").parse()?;
    let (width, height) = argument(1, "1280x720").split_once('x').ok_or("a size is WIDTHxHEIGHT")?;
    let size = FrameSize::new(width.parse()?, height.parse()?)?;
    let precision: Precision = argument(2, "auto").parse()?;

    let gpu = Gpu::open(&AdapterRequest::Any.or_environment())?;
    let config = named.config();
    let network = Network::new(&gpu, config.plan()?, &Weights::random(&config, 1)?, precision)?;
    let mut state = network.state(size)?;
    println!("{named} {} at {size} on {}", network.precision(), gpu.info().name);
    println!("{:.1} MB", state.bytes() as f64 / 1e6);
    frames(&network, &mut state, FRAMES)?;
    let started = Instant::now();
    frames(&network, &mut state, FRAMES)?;
    println!("{:.2} ms a frame", started.elapsed().as_secs_f64() * 1e3 / f64::from(FRAMES));

    state.set_timed(true);
    frames(&network, &mut state, 1)?;
    let mut times = state.read_times()?.ok_or("the device has no timestamps")?;
    let total: f64 = times.iter().map(|time| time.ms).sum();
    times.sort_by(|a, b| b.ms.total_cmp(&a.ms));
    println!("{total:.2} ms in layers of their own:");
    times.iter().for_each(|time| println!("{:8.3} ms  {}", time.ms, time.name));
    Ok(())
}

/// Makes `count` frames of nothing and waits for them.
fn frames(network: &Network, state: &mut State, count: u32) -> Result<(), Box<dyn Error>> {
    let gpu = network.gpu();
    let pixels = state.size().pixels() as u64;
    let [sparse, motion] =
        [16, 8].map(|bytes| gpu.buffer("input", bytes * pixels, wgpu::BufferUsages::STORAGE));
    for _ in 0..count {
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let input = DeviceInput { sparse: &sparse, motion: Some(&motion) };
        network.encode(&mut encoder, input, state)?;
        gpu.queue().submit([encoder.finish()]);
    }
    Ok(gpu.wait()?)
}
