//! Tests whole networks on the CPU: precisions compared with each other, damaged input, and states that do not fit.

use fovol_core::{Frame, FrameSize, SparseFrame};
use fovol_net::Weights;
use fovol_net::cpu::{FrameInput, Network, Precision, Simd, calibrate};
use fovol_net::plan::{Named, NetworkConfig};

/// Sparse frame of a moving pattern: one pixel in six, different ones in each frame.
fn sparse(size: FrameSize, t: u32) -> Frame {
    let mut frame = Frame::new(size);
    for y in 0..size.height {
        for x in 0..size.width {
            if (x * 7 + y * 3 + t * 5).is_multiple_of(6) {
                let wave = |f: f32| 0.4 + 0.35 * ((x + 2 * t) as f32 * f + y as f32 * 0.07).sin();
                frame.pixels_mut()[(y * size.width + x) as usize] = [wave(0.09), wave(0.17), wave(0.05), 1.0];
            }
        }
    }
    frame
}

fn clip(network: &Network, size: FrameSize, frames: u32) -> Vec<Frame> {
    let mut state = network.state(size);
    (0..frames)
        .map(|t| {
            let sparse = SparseFrame::from(&sparse(size, t));
            network.reconstruct(&FrameInput { sparse: &sparse, motion: None }, &mut state).unwrap()
        })
        .collect()
}

fn network(config: &NetworkConfig, weights: &Weights, simd: Simd, precision: Precision) -> Network {
    Network::new(config.plan().unwrap(), weights, simd, precision).unwrap()
}

fn psnr(a: &[Frame], b: &[Frame]) -> f64 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a.pixels().iter().zip(b.pixels()));
    let (mut sum, mut count) = (0.0, 0.0);
    for (a, b) in pairs {
        for c in 0..3 {
            sum += f64::from(a[c] - b[c]).powi(2);
            count += 1.0;
        }
    }
    -10.0 * (sum / count + 1e-12).log10()
}

#[test]
fn precisions_stay_close_over_sixteen_steps() {
    let size = FrameSize::new(75, 50).unwrap();
    for named in Named::ALL {
        let config = named.config();
        let mut weights = Weights::random(&config, 3).unwrap();
        let frames: Vec<SparseFrame> = (0..4).map(|t| SparseFrame::from(&sparse(size, t))).collect();
        let inputs = frames.iter().map(|sparse| FrameInput { sparse, motion: None }).collect();
        calibrate(&mut weights, &[inputs]).unwrap();
        let exact = clip(&network(&config, &weights, Simd::best(), Precision::F32), size, 16);
        let spread =
            exact[15].pixels().iter().map(|p| p[0]).fold((1.0f32, 0.0f32), |(l, h), v| (l.min(v), h.max(v)));
        assert!(spread.1 - spread.0 > 0.02, "{named}: a picture without contrast proves nothing: {spread:?}");
        for (precision, least) in [(Precision::Bf16, 45.0), (Precision::Int8, 35.0), (Precision::Mixed, 35.0)]
        {
            let network = network(&config, &weights, Simd::best(), precision);
            let close = psnr(&exact, &clip(&network, size, 16));
            println!("{named} {precision} (as {}): {close:.1} dB, spread {spread:?}", network.precision());
            assert!(close >= least, "{named} {precision}: {close} dB");
        }
    }
}

#[test]
fn instruction_sets_agree_and_threads_change_nothing() {
    let size = FrameSize::new(41, 23).unwrap();
    for named in Named::ALL {
        let config = named.config();
        let weights = Weights::random(&config, 5).unwrap();
        let reference = clip(&network(&config, &weights, Simd::Portable, Precision::F32), size, 3);
        for simd in Simd::available() {
            let network = network(&config, &weights, simd, Precision::F32);
            let on = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| clip(&network, size, 3))
            };
            let one = on(1);
            assert!(psnr(&reference, &one) > 90.0, "{named} {simd}");
            assert_eq!(one, on(3), "{named} {simd}");
        }
    }
}

#[test]
fn numbers_that_are_none_do_not_stay() {
    let size = FrameSize::new(40, 24).unwrap();
    for named in Named::ALL {
        let config = named.config();
        let weights = Weights::random(&config, 2).unwrap();
        let network = network(&config, &weights, Simd::best(), Precision::F32);
        let mut state = network.state(size);
        let mut broken = sparse(size, 0);
        for (i, value) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38].into_iter().enumerate() {
            broken.pixels_mut()[100 * i] = [value, 0.5, value, 1.0];
        }
        for frame in [broken, sparse(size, 1), sparse(size, 2)] {
            let sparse = SparseFrame::from(&frame);
            let out = network.reconstruct(&FrameInput { sparse: &sparse, motion: None }, &mut state).unwrap();
            assert!(
                out.pixels().iter().flatten().all(|v| v.is_finite() && (0.0..=1.0).contains(v)),
                "{named}"
            );
        }
        let is_finite = |map: &fovol_net::cpu::AnyTensor| map.to_f32().data.iter().all(|v| v.is_finite());
        assert!(network.carried(&state).iter().all(is_finite), "{named}");
        state.reset();
        assert!(network.carried(&state).iter().all(|map| map.to_f32().data.iter().all(|&v| v == 0.0)));
    }
}

#[test]
fn every_size_works_and_states_are_independent() {
    let config = Named::WNetFast.config();
    let weights = Weights::random(&config, 1).unwrap();
    let network = network(&config, &weights, Simd::best(), Precision::Auto);
    for (w, h) in [(1, 1), (2, 3), (16, 16), (17, 1), (1, 33), (130, 70)] {
        let size = FrameSize::new(w, h).unwrap();
        let (mut left, mut right) = (network.state(size), network.state(size));
        for t in 0..3 {
            let frame = SparseFrame::from(&sparse(size, t));
            let input = FrameInput { sparse: &frame, motion: None };
            let out = network.reconstruct(&input, &mut left).unwrap();
            assert_eq!(out, network.reconstruct(&input, &mut right).unwrap());
            assert_eq!(out.size(), size);
        }
    }
}

#[test]
fn states_and_motion_that_do_not_fit_are_errors() {
    let config = Named::WNetFast.config();
    let weights = Weights::random(&config, 1).unwrap();
    let ours = network(&config, &weights, Simd::best(), Precision::Auto);
    let other = network(&config, &weights, Simd::best(), Precision::Auto);
    let (small, large) = (FrameSize::new(20, 10).unwrap(), FrameSize::new(21, 10).unwrap());
    let frame = SparseFrame::from(&Frame::new(small));
    let input = FrameInput { sparse: &frame, motion: None };
    let error = ours.reconstruct(&input, &mut other.state(small)).unwrap_err().to_string();
    assert!(error.contains("another network"), "{error}");
    let error = ours.reconstruct(&input, &mut ours.state(large)).unwrap_err().to_string();
    assert!(error.contains("21x10, not 20x10"), "{error}");
    let short = FrameInput { sparse: &frame, motion: Some(&[[0.0; 2]; 3]) };
    assert!(ours.reconstruct(&short, &mut ours.state(small)).is_err());
    let error = Network::new(config.plan().unwrap(), &weights, Simd::best(), Precision::Int8);
    if Simd::best().has_int8() {
        assert!(error.unwrap_err().to_string().contains("calibrate"));
    }
}
