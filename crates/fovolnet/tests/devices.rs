//! The pipeline renders the same frames on the GPU and on the CPU.
#![cfg(feature = "gpu")]

use fovolnet::core::{
    CameraPath, ClipPlane, ClipPlanes, Frame, Integration, Interpolation, Projection, ShadowMode,
    SurfaceShading,
};
use fovolnet::gpu::{Gpu, read_picture};
use fovolnet::io::procedural;
use fovolnet::net::Fill;
use fovolnet::render::cpu::Simd;
use fovolnet::render::noise::NoiseKind;
use fovolnet::{
    Density, Device, DoneFrame, Guide, Mode, OpenDevice, OpenVolume, Pipeline, Reconstruction,
    RenderSettings, Sampling, ShadowRays, SpeedSettings, Viewpoint, VolumeSettings, open_volume,
};
use std::sync::{Mutex, PoisonError};

fn head() -> OpenVolume {
    open_volume("head", &VolumeSettings { dims: Some([40; 3]), ..Default::default() }).unwrap()
}

fn pipeline(settings: &RenderSettings, device: Device) -> Pipeline {
    let speed = SpeedSettings { device: Some(device), ..Default::default() };
    Pipeline::new(&head(), settings, &speed).unwrap()
}

/// Largest difference of any channel.
fn difference(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn settings(sampling: Sampling, reconstruct: Reconstruction) -> RenderSettings {
    RenderSettings {
        size: "83x47".parse().unwrap(),
        camera: CameraPath::Orbit.into(),
        sampling,
        reconstruction: reconstruct,
        pb: 0.1,
        sigma: 0.1,
        shadows: ShadowMode::On,
        guide: Guide::None.into(),
        density: Density::Fixed.into(),
        ..Default::default()
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_are_those_of_the_processor() {
    for sampling in Sampling::ALL {
        for reconstruct in [
            Reconstruction::None,
            Reconstruction::Fill(Fill::PullPush),
            Reconstruction::Fill(Fill::Linear),
            Reconstruction::WNet,
        ] {
            let settings = settings(sampling, reconstruct);
            let mut both = [Device::Cpu, Device::Gpu(None)].map(|device| pipeline(&settings, device));
            for pipeline in &mut both {
                pipeline.find_motion();
            }
            assert!(both[0].machine().gpu.is_none() && both[1].machine().gpu.is_some());
            for i in 0..3 {
                let name = format!("{sampling:?} {reconstruct:?} {i}");
                let [cpu, gpu] = both.each_mut().map(|pipeline| pipeline.render(i).unwrap());
                assert_eq!(cpu.mask, gpu.mask, "{name}");
                assert_eq!((cpu.samples, cpu.lost), (gpu.samples, gpu.lost), "{name}");
                assert!(difference(&cpu.samples_picture(), &gpu.samples_picture()) <= 2.0 / 255.0, "{name}");
                // Where a depth differs, a network may weigh its history differently.
                assert!(difference(&cpu.frame, &gpu.frame) <= 8.0 / 255.0, "{name}");
                assert_eq!(cpu.motion.is_some(), gpu.motion.is_some(), "{name}");
            }
            let [cpu, gpu] = both.each_mut().map(|pipeline| pipeline.reference(7).unwrap());
            assert!(difference(&cpu, &gpu) <= 2.0 / 255.0, "{sampling:?}");
        }
    }
}

/// Guides and adaptive densities of a GPU's frames. Those with `linear` are filled by the CPU.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn light_ratios_of_a_gpu_are_those_of_the_processor() {
    let linear = Reconstruction::Fill(Fill::Linear);
    let perspective = (Projection::Perspective, Mode::Composite);
    for (sampling, guide, density, reconstruct) in [
        (Sampling::Compact, Guide::Cached, Density::Fixed, Reconstruction::WNet),
        (Sampling::Compact, Guide::Cached, Density::Fixed, linear),
        (Sampling::Compact, Guide::Quarter, Density::Fixed, Reconstruction::WNet),
        (Sampling::Compact, Guide::Quarter, Density::Adaptive, Reconstruction::WNet),
        (Sampling::Compact, Guide::Quarter, Density::Fixed, Reconstruction::Fill(Fill::PullPush)),
        (Sampling::Compact, Guide::Quarter, Density::Fixed, linear),
        (Sampling::Direct, Guide::Full, Density::Fixed, Reconstruction::WNet),
        (Sampling::Compact, Guide::None, Density::Adaptive, Reconstruction::WNet),
    ] {
        agree(perspective, sampling, guide, (density, reconstruct));
    }
    let quarter = (Density::Fixed, Reconstruction::WNet);
    agree((Projection::Orthographic, Mode::Composite), Sampling::Compact, Guide::Quarter, quarter);
    agree((Projection::Orthographic, Mode::Isosurface), Sampling::Compact, Guide::Quarter, quarter);
    agree((Projection::Orthographic, Mode::Mip), Sampling::Compact, Guide::None, quarter);
}

/// Asserts that frames, guides and motion are the same on both devices.
fn agree(
    (projection, mode): (Projection, Mode),
    sampling: Sampling,
    guide: Guide,
    (density, reconstruct): (Density, Reconstruction),
) {
    let settings = RenderSettings {
        projection,
        mode,
        size: "147x101".parse().unwrap(),
        background: [0.3, 0.2, 0.1],
        guide: guide.into(),
        density: density.into(),
        precision: "f32".parse().unwrap(),
        ..settings(sampling, reconstruct)
    };
    let mut both = [Device::Cpu, Device::Gpu(None)].map(|device| pipeline(&settings, device));
    assert_eq!(both.each_ref().map(Pipeline::guide), [guide; 2]);
    for pipeline in &mut both {
        pipeline.keep_guide();
        pipeline.find_motion();
    }
    for i in 0..4 {
        let name = format!("{projection} {mode} {sampling:?} {guide} {density} {reconstruct:?} {i}");
        let [cpu, gpu] = both.each_mut().map(|pipeline| pipeline.render(i).unwrap());
        let near = |a: usize, b: usize| a.abs_diff(b) <= 2 + a / 200;
        assert!(near(cpu.samples, gpu.samples), "{name}: {} {}", cpu.samples, gpu.samples);
        let marched = (cpu.guide_samples, gpu.guide_samples);
        assert!(near(marched.0, marched.1), "{name}: {marched:?}");
        assert_eq!(cpu.guide_samples > 0, guide != Guide::None, "{name}");
        let quality = |a: &Frame, b: &Frame| fovolnet::metrics::psnr(a, b).unwrap();
        let of_frames = quality(&cpu.frame, &gpu.frame);
        assert!(of_frames > 60.0, "{name}: {of_frames}");
        let kept = [&cpu, &gpu].map(|frame| frame.guide.as_ref());
        assert_eq!(kept.map(|kept| kept.is_some()), [guide != Guide::None; 2], "{name}");
        if let [Some(cpu), Some(gpu)] = kept {
            let guides = [cpu, gpu].map(|kept| kept.guide.to_frame(settings.size));
            let of_guides = quality(&guides[0], &guides[1]);
            assert!(of_guides > 60.0, "{name}: {of_guides}");
            println!("{name}: {of_frames:.1} {of_guides:.1} {marched:?}");
        }
        let motion = [&cpu, &gpu].map(|frame| frame.motion.as_deref());
        assert_eq!(motion.map(|motion| motion.is_some()), [i > 0; 2], "{name}");
        if let ([Some(cpu), Some(gpu)], Density::Fixed) = (motion, density) {
            let way = |(a, b): (&[f32; 2], &[f32; 2])| (a[0] - b[0]).hypot(a[1] - b[1]);
            let far = cpu.iter().zip(gpu).filter(|pair| way(*pair) > 0.5).count();
            assert!(far * 50 < cpu.len(), "{name}: {far}");
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn what_a_gpu_cannot_do_is_said() {
    let usual = settings(Sampling::Compact, Reconstruction::WNet);
    let reject = RenderSettings { guide: Guide::Quarter.into(), sampling: Sampling::Reject, ..usual };
    let speed = SpeedSettings { device: Some(Device::Gpu(None)), ..Default::default() };
    let problem = Pipeline::new(&head(), &reject, &speed).unwrap_err().to_string();
    assert!(problem.contains("frames of a GPU cannot have") && problem.contains("--device cpu"));
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn few_shadow_rays_are_as_good_as_the_processors() {
    let settings = RenderSettings {
        shadow_rays: "8".parse().unwrap(),
        size: "147x101".parse().unwrap(),
        precision: "f32".parse().unwrap(),
        ..settings(Sampling::Compact, Reconstruction::WNet)
    };
    let mut both = [Device::Cpu, Device::Gpu(None)].map(|device| pipeline(&settings, device));
    for i in 0..4 {
        let [cpu, gpu] = both.each_mut().map(|pipeline| {
            let rendered = pipeline.render(i).unwrap().frame;
            fovolnet::metrics::psnr(&pipeline.reference(i).unwrap(), &rendered).unwrap()
        });
        assert!((cpu - gpu).abs() < 0.5 && gpu > 25.0, "{i}: {cpu} {gpu}");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn references_have_exact_shadows() {
    let gpu = Device::Gpu(None);
    let with = |shadows, is_transparent: bool| RenderSettings {
        shadows,
        transparent: is_transparent,
        ..settings(Sampling::Full, Reconstruction::None)
    };
    for is_transparent in [false, true] {
        let reference = |shadows| pipeline(&with(shadows, is_transparent), gpu.clone()).reference(3).unwrap();
        let mut cached = pipeline(&with(ShadowMode::Cached, is_transparent), gpu.clone());
        let before = cached.render(3).unwrap().frame;
        let exact = reference(ShadowMode::On);
        assert!(cached.reference(3).unwrap() == exact, "{is_transparent}");
        assert!(before != exact);
        assert!(cached.render(3).unwrap().frame == before, "frames keep their cached shadows");
        assert!(reference(ShadowMode::Off) != exact);
    }
}

/// Checks that `pipeline` displays the frames 0 to 4 that `expected` renders, and reports facts about each.
fn assert_displayed(gpu: &Gpu, pipeline: &mut Pipeline, expected: &mut Pipeline) {
    let (mut done, mut samples) = (Vec::new(), Vec::new());
    for i in 0..5 {
        let viewpoint = Viewpoint { camera: pipeline.camera(i), fovea: pipeline.fovea(i) };
        let displayed = pipeline.display_from(i, &viewpoint).unwrap().unwrap();
        let rendered = expected.render(i).unwrap();
        assert_eq!(displayed.index, i);
        let pixels = read_picture(gpu, &displayed.picture).unwrap();
        let wanted = rendered.frame.to_rgba8();
        let off = pixels.iter().zip(wanted.as_chunks::<4>().0).map(|(found, wanted)| {
            assert_eq!(found[3], 255);
            (0..3).map(|c| found[c].abs_diff(wanted[c])).max().unwrap_or(0)
        });
        assert_eq!(pixels.len(), rendered.frame.pixels().len());
        assert!(off.max().unwrap() <= 1, "frame {i}");
        samples.push((i, rendered.samples));
        done.extend(displayed.done);
        assert_eq!(done.len(), i.saturating_sub(1) as usize, "two frames are under way");
    }
    done.extend(pipeline.finish_display().unwrap());
    assert_eq!(done.iter().map(|done| (done.index, done.samples)).collect::<Vec<_>>(), samples);
    for DoneFrame { timings, .. } in &done {
        let parts = timings.march + timings.mask + timings.guide + timings.reconstruct;
        assert!(timings.march > 0.0 && timings.total >= 0.999 * parts, "{timings:?}");
        assert!(timings.compact <= timings.mask && timings.scatter <= timings.march, "{timings:?}");
        assert!(timings.motion <= timings.reconstruct, "{timings:?}");
    }
    assert!(pipeline.finish_display().unwrap().is_empty());
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_that_stay_on_the_device_are_those_that_come_back() {
    let device = Device::Gpu(None).open().unwrap();
    let OpenDevice::Gpu(gpu) = &device else { panic!("no adapter") };
    let pipeline = |settings: &RenderSettings| {
        Pipeline::on(device.clone(), &head(), settings, &SpeedSettings::default()).unwrap()
    };
    for (sampling, reconstruct, guide, density) in [
        (Sampling::Full, Reconstruction::WNet, Guide::None, Density::Fixed),
        (Sampling::Direct, Reconstruction::Fill(Fill::PullPush), Guide::None, Density::Fixed),
        (Sampling::Compact, Reconstruction::WNet, Guide::None, Density::Fixed),
        (Sampling::Compact, Reconstruction::WNet, Guide::Quarter, Density::Adaptive),
        (Sampling::Direct, Reconstruction::Fill(Fill::PullPush), Guide::Full, Density::Fixed),
    ] {
        let (guide, density) = (guide.into(), density.into());
        let mut settings = RenderSettings { guide, density, ..settings(sampling, reconstruct) };
        let (mut displays, mut renders) = (pipeline(&settings), pipeline(&settings));
        assert_displayed(gpu, &mut displays, &mut renders);
        settings.size = "40x30".parse().unwrap();
        for pipeline in [&mut displays, &mut renders] {
            pipeline.change(&settings).unwrap();
            pipeline.reset();
        }
        assert_displayed(gpu, &mut displays, &mut renders);
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_that_need_the_host_are_not_displayed() {
    let displays = |settings: &RenderSettings, device: Device| {
        let mut pipeline = pipeline(settings, device);
        let viewpoint = Viewpoint { camera: pipeline.camera(0), fovea: pipeline.fovea(0) };
        pipeline.display_from(0, &viewpoint).unwrap().is_some()
    };
    let compact = settings(Sampling::Compact, Reconstruction::None);
    assert!(displays(&compact, Device::Gpu(None)));
    assert!(!displays(&compact, Device::Cpu));
    assert!(!displays(&settings(Sampling::Reject, Reconstruction::None), Device::Gpu(None)));
    let linear = settings(Sampling::Compact, Reconstruction::Fill(Fill::Linear));
    assert!(!displays(&linear, Device::Gpu(None)));
}

/// Mean difference of all channels.
fn mean_difference(a: &Frame, b: &Frame) -> f64 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / (4 * a.pixels().len()) as f64
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn procedural_volumes_look_as_on_the_processor() {
    let device = Device::Gpu(None).open().unwrap();
    for name in procedural::names() {
        let volume = VolumeSettings { dims: Some([32; 3]), ..Default::default() };
        let volume = open_volume(name, &volume).unwrap();
        for (tf, shadows) in
            [("auto", ShadowMode::On), ("head", ShadowMode::Off), ("grey", ShadowMode::Cached)]
        {
            let settings = RenderSettings {
                transfer_function: tf.into(),
                shadows,
                ..settings(Sampling::Full, Reconstruction::None)
            };
            let speed = SpeedSettings { simd: Some(Simd::Scalar), no_skip: true, ..Default::default() };
            let mut specification = Pipeline::on(OpenDevice::Cpu, &volume, &settings, &speed).unwrap();
            let mut twin =
                Pipeline::on(device.clone(), &volume, &settings, &SpeedSettings::default()).unwrap();
            for i in [0, 130] {
                let [expected, found] = [&mut specification, &mut twin].map(|p| p.render(i).unwrap().frame);
                let (most, mean) = (difference(&expected, &found), mean_difference(&expected, &found));
                assert!(most <= 2.0 / 255.0 && mean <= 2e-3, "{name} {tf} {i}: {most} {mean}");
            }
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_device_that_is_lost_is_an_error_of_every_call() {
    let device = Device::Gpu(None).open().unwrap();
    let OpenDevice::Gpu(gpu) = &device else { panic!("no adapter") };
    let settings = settings(Sampling::Compact, Reconstruction::WNet);
    let mut pipeline = Pipeline::on(device.clone(), &head(), &settings, &SpeedSettings::default()).unwrap();
    let viewpoint = Viewpoint { camera: pipeline.camera(1), fovea: pipeline.fovea(1) };
    pipeline.render(0).unwrap();
    assert!(pipeline.display_from(1, &viewpoint).unwrap().is_some());
    gpu.device().destroy();
    let error = pipeline.render(2).unwrap_err();
    assert!(error.is_of_gpu(), "{error}");
    assert!(pipeline.reference(2).is_err());
    let displayed = pipeline.display_from(3, &viewpoint);
    assert!(displayed.is_err() || pipeline.finish_display().is_err());
    let brighter = RenderSettings { ambient: 0.9, ..settings.clone() };
    // Calls on a lost device must not panic.
    let _ = pipeline.change(&brighter);
    let asked = SpeedSettings { device: Some(Device::Gpu(None)), ..Default::default() };
    assert!(Pipeline::on(device.clone(), &head(), &settings, &asked).is_err());
    // With `auto` the CPU takes over.
    let mut instead = Pipeline::on(device, &head(), &settings, &SpeedSettings::default()).unwrap();
    assert!(instead.notes()[0].starts_with("rendering on the processor: "), "{:?}", instead.notes());
    instead.render(0).unwrap();
}

/// Bytes of this process in memory, if the system reports them.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn ten_thousand_frames_leave_memory_as_it_was() {
    let size = "48x32".parse().unwrap();
    check_memory(
        10_000,
        &RenderSettings { size, ..settings(Sampling::Compact, Reconstruction::Fill(Fill::PullPush)) },
    );
}

/// Networks take longer, so fewer of their frames must do.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_thousand_frames_of_networks_leave_memory_as_it_was() {
    let settings = settings(Sampling::Compact, Reconstruction::WNet);
    check_memory(1_000, &RenderSettings { size: "16x16".parse().unwrap(), ..settings.clone() });
    let (guide, density) = (Guide::Quarter.into(), Density::Adaptive.into());
    check_memory(1_000, &RenderSettings { size: "32x32".parse().unwrap(), guide, density, ..settings });
}

/// Frames of other kinds, a hundred of each.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn thousand_frames_of_all_kinds_leave_memory_as_it_was() {
    let fill = Reconstruction::Fill(Fill::PullPush);
    let base = RenderSettings { size: "32x32".parse().unwrap(), ..settings(Sampling::Compact, fill) };
    let few = ShadowRays::Few(2.try_into().unwrap());
    let planes = ClipPlanes::new(&[ClipPlane { normal: [1.0, 0.0, 0.0].into(), distance: 0.0 }]).unwrap();
    for changed in [
        RenderSettings { sampling: Sampling::Full, ..base.clone() },
        RenderSettings { sampling: Sampling::Reject, ..base.clone() },
        RenderSettings { sampling: Sampling::Direct, ..base.clone() },
        RenderSettings { integration: Integration::Fine, ..base.clone() },
        RenderSettings { shadows: ShadowMode::Cached, ..base.clone() },
        RenderSettings { shadows: ShadowMode::Off, ..base.clone() },
        RenderSettings { shadow_rays: few, ..base.clone() },
        RenderSettings { shadow_rays: few, noise: NoiseKind::Uniform, ..base.clone() },
        RenderSettings { shading: SurfaceShading::Gradient, ..base.clone() },
        RenderSettings { mode: Mode::Mip, ..base.clone() },
        RenderSettings { mode: Mode::Isosurface, ..base.clone() },
        RenderSettings { interpolation: Interpolation::Nearest.into(), ..base.clone() },
        RenderSettings { projection: Projection::Orthographic, ..base.clone() },
        RenderSettings { planes, ..base.clone() },
        RenderSettings { guide: Guide::Full.into(), reconstruction: Reconstruction::WNet, ..base.clone() },
        RenderSettings { guide: Guide::Cached.into(), ..base.clone() },
        RenderSettings {
            projection: Projection::Orthographic,
            reconstruction: Reconstruction::WNet,
            ..base.clone()
        },
        RenderSettings { reconstruction: Reconstruction::DeepFovea, ..base.clone() },
    ] {
        check_memory(100, &changed);
    }
}

/// Checks that memory stays as it was after the first half of the frames.
fn check_memory(frames: u32, settings: &RenderSettings) {
    static ALONE: Mutex<()> = Mutex::new(());
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut pipeline = pipeline(settings, Device::Gpu(None));
    let mut at = Vec::new();
    for i in 0..frames {
        let viewpoint = Viewpoint { camera: pipeline.camera(i), fovea: pipeline.fovea(i) };
        // Use both ways of a frame: through the host, and to a screen, if it can be shown at once.
        if i % 50 == 0 || pipeline.display_from(i, &viewpoint).unwrap().is_none() {
            pipeline.render(i).unwrap();
        }
        if (i + 1) % (frames / 10) == 0 {
            at.extend(resident());
        }
    }
    pipeline.finish_display().unwrap();
    println!("{frames} frames, bytes in memory after each tenth of them: {at:?}");
    // Compiled shaders and memory kept by allocators are there after some frames.
    let warm = if frames < 1_000 { 4 } else { 0 };
    if let (Some(first), Some(last)) = (at.get(warm), at.last()) {
        assert!(last.saturating_sub(*first) < 2 << 20, "{settings:?}: {at:?}");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn software_is_announced() {
    let settings = settings(Sampling::Compact, Reconstruction::None);
    let made = pipeline(&settings, Device::Gpu(None));
    let software = made.machine().gpu.unwrap().contains("llvmpipe");
    assert_eq!(made.notes().iter().any(|note| note.contains("program on the processor")), software);
    if software {
        // `auto` never takes such a device.
        assert_eq!(pipeline(&settings, Device::Auto).machine().gpu, None);
    }
}

#[test]
fn a_device_that_is_not_there_is_an_error() {
    let speed =
        SpeedSettings { device: Some(Device::Gpu(Some("no such device".into()))), ..Default::default() };
    let error = Pipeline::new(&head(), &RenderSettings::default(), &speed).unwrap_err();
    assert!(error.to_string().starts_with("no GPU can be used: "), "{error}");
}
