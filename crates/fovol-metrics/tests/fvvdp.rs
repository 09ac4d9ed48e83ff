//! Tests of FovVideoVDP against its published program; `reference/fvvdp.py` computes the values.

mod clips;
mod pattern;

use clips::{Flaw, NONE, picture, size};
use fovol_core::Frame;
use fovol_metrics::{Display, Error, FovVideoVdp};
use proptest::prelude::*;
use serde_json::Value;

/// Tolerance in JOD; the largest difference found is 1e-4. Both programs compute pixels in f32 and sum in different
/// orders, and the values have five digits.
const TOLERANCE: f64 = 2e-4;

fn metric(display: &str, fps: f64) -> FovVideoVdp {
    let display = Display::named(display).unwrap();
    if fps == 0.0 { FovVideoVdp::image(&display) } else { FovVideoVdp::video(&display, fps) }.unwrap()
}

/// JOD and mean of the difference maps of one case.
fn measured(case: &Value) -> (f64, f64) {
    let side = |i: usize| case["size"][i].as_u64().unwrap() as u32;
    let size = size(side(0), side(1));
    let along = |i: usize, side: u32| Some((case["gaze"][i].as_f64()? + 0.5) / f64::from(side));
    let gaze = along(0, size.width).zip(along(1, size.height)).map(|(x, y)| [x, y]);
    let flaw = Flaw(case["flaw"].as_str().unwrap(), case["amount"].as_i64().unwrap());
    let mut metric = metric(case["display"].as_str().unwrap(), case["fps"].as_f64().unwrap());
    let frames = case["frames"].as_i64().unwrap();
    let mut sum = 0.0;
    for frame in 0..frames {
        let (reference, test) = (picture(size, frame, NONE), picture(size, frame, flaw));
        let map = metric.push_mapped(&reference, &test, gaze).unwrap();
        assert_eq!(map.len(), size.pixels());
        sum += map.iter().map(|&v| f64::from(v)).sum::<f64>() / size.pixels() as f64;
    }
    (metric.jod().unwrap(), sum / frames as f64)
}

#[test]
fn jods_and_maps_agree_with_the_published_program() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("reference/fvvdp.json")).unwrap();
    assert!(cases.len() >= 50);
    let mut farthest = 0.0_f64;
    for case in &cases {
        let (jod, map) = measured(case);
        let off = (jod - case["jod"].as_f64().unwrap()).abs();
        farthest = farthest.max(off);
        assert!(off < TOLERANCE, "{jod}: {case}");
        // The program stores its map in f16.
        let expected = case["map_mean"].as_f64().unwrap();
        assert!((map - expected).abs() < 1e-3 * expected + 1e-4, "{map}: {case}");
    }
    println!("farthest from the program: {farthest:.6} JOD");
}

/// Disc over a coloured wave, and its 3×3 average, with 8 bits; 640×360.
fn waves(frame: i32) -> [Frame; 2] {
    let size = size(640, 360);
    let pattern = |x: i32, y: i32| {
        let phase = f64::from(x + 2 * frame) * std::f64::consts::TAU / 16.0;
        let a = 0.5 + 0.25 * phase.sin() * (f64::from(y) * std::f64::consts::TAU / 24.0).cos();
        let inside = (x - 200 - 3 * frame).pow(2) + (y - 180).pow(2) < 80 * 80;
        let rgb = if inside { [0.9, 0.4, 0.1] } else { [a, 0.8 * a, 0.6 * a] };
        rgb.map(|v| (v * 255.0).round_ties_even())
    };
    let at = |x: i32, y: i32| pattern(x.clamp(0, 639), y.clamp(0, 359));
    let mean = |x: i32, y: i32| {
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| at(x + dx, y + dy)));
        let sum = around.fold([0.0; 3], |sum, v| [sum[0] + v[0], sum[1] + v[1], sum[2] + v[2]]);
        sum.map(|v: f64| (v / 9.0).round_ties_even())
    };
    let frame = |rgb: &dyn Fn(i32, i32) -> [f64; 3]| {
        let pixels = (0..360).flat_map(|y| (0..640).map(move |x| (x, y))).map(|(x, y)| {
            let [r, g, b] = rgb(x, y).map(|v| v as f32 / 255.0);
            [r, g, b, 1.0]
        });
        Frame::from_pixels(size, pixels.collect()).unwrap()
    };
    [frame(&at), frame(&mean)]
}

#[test]
fn a_larger_clip_agrees_with_the_published_program() {
    let mut video = metric("standard_4k", 30.0);
    let mut foveated = metric("standard_4k", 30.0);
    let mut image = metric("standard_4k", 0.0);
    for frame in 0..12 {
        let [reference, test] = waves(frame);
        video.push(&reference, &test, None).unwrap();
        foveated.push(&reference, &test, Some([320.5 / 640.0, 180.5 / 360.0])).unwrap();
        if frame == 0 {
            image.push(&reference, &test, None).unwrap();
        }
    }
    for (metric, expected) in [(video, 9.94970), (image, 9.95393), (foveated, 9.97880)] {
        let jod = metric.jod().unwrap();
        assert!((jod - expected).abs() < TOLERANCE, "{jod} {expected}");
    }
}

fn jod(metric: &mut FovVideoVdp, frames: i64, flaw: Flaw<'_>, gaze: Option<[f64; 2]>) -> f64 {
    let size = size(40, 28);
    for frame in 0..frames {
        metric.push(&picture(size, frame, NONE), &picture(size, frame, flaw), gaze).unwrap();
    }
    metric.jod().unwrap()
}

#[test]
fn what_is_wrong_is_said_and_leaves_the_clip_alone() {
    let display = Display::named("standard_fhd").unwrap();
    for fps in [0.0, -30.0, f64::NAN, f64::INFINITY, 1001.0] {
        let error = FovVideoVdp::video(&display, fps).unwrap_err();
        assert!(matches!(&error, Error::FrameRate { .. }) && !error.to_string().contains('\n'));
    }
    let bad = Display { distance_m: -1.0, ..display };
    assert_eq!(FovVideoVdp::image(&bad).unwrap_err(), Error::ImpossibleDisplay);
    let mut metric = FovVideoVdp::video(&display, 30.0).unwrap();
    assert_eq!((metric.jod(), metric.frames()), (None, 0));
    let (small, large) = (Frame::new(size(8, 8)), Frame::new(size(9, 8)));
    assert!(matches!(metric.push(&small, &large, None), Err(Error::SizesDiffer { .. })));
    assert!(matches!(metric.push(&small, &small, Some([f64::NAN, 0.5])), Err(Error::Gaze { .. })));
    for (width, height) in [(1, 1), (3, 3), (1, 500), (500, 2)] {
        let tiny = Frame::new(size(width, height));
        assert!(matches!(metric.push(&tiny, &tiny, None), Err(Error::TooSmall { .. })));
    }
    metric.push(&small, &small, None).unwrap();
    assert!(matches!(metric.push(&large, &large, None), Err(Error::SizeChanged { .. })));
    assert_eq!((metric.jod(), metric.frames()), (Some(10.0), 1));
}

#[test]
fn odd_values_count_as_what_is_written_to_files() {
    let size = size(16, 12);
    let with = |v: f32| {
        let mut frame = picture(size, 0, NONE);
        frame.pixels_mut()[50] = [v; 4];
        frame
    };
    let jod = |a: &Frame, b: &Frame| {
        let mut metric = metric("standard_hmd", 0.0);
        metric.push(a, b, Some([-3.0, 40.0])).unwrap();
        metric.jod().unwrap()
    };
    assert_eq!(jod(&with(f32::NAN), &with(0.0)), 10.0);
    assert_eq!(jod(&with(f32::INFINITY), &with(1.0)), 10.0);
    assert!(jod(&with(f32::NAN), &with(1.0)) < 10.0);
}

#[test]
fn the_worst_difference_is_finite_at_every_small_size() {
    for (width, height) in [(4, 4), (5, 4), (4, 300), (7, 9), (31, 17)] {
        let (black, mut white) = (Frame::new(size(width, height)), Frame::new(size(width, height)));
        white.pixels_mut().iter_mut().step_by(3).for_each(|p| *p = [1.0; 4]);
        for gaze in [None, Some([0.5, 0.5])] {
            let mut metric = metric("standard_fhd", 60.0);
            let map = metric.push_mapped(&black, &white, gaze).unwrap();
            assert!(metric.jod().unwrap() < 10.0 && metric.jod().unwrap().is_finite());
            assert!(map.iter().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn away_from_the_gaze_less_is_seen() {
    let size = size(96, 72);
    let reference = picture(size, 0, NONE);
    let mut test = reference.clone();
    for y in 0..12 {
        for x in 0..12 {
            test.pixels_mut()[y * 96 + x] = [((x + y) % 2) as f32; 4];
        }
    }
    let seen = |gaze| {
        let mut metric = metric("standard_hmd", 0.0);
        let map = metric.push_mapped(&reference, &test, Some(gaze)).unwrap();
        assert!(map[5 * 96 + 5] > 20.0 * map[60 * 96 + 80]);
        metric.jod().unwrap()
    };
    assert!(seen([0.05, 0.05]) + 0.1 < seen([0.9, 0.9]));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn equal_clips_have_ten(width in 4_u32..70, height in 4_u32..70, fps in 0.5_f64..130.0, gaze in any::<bool>()) {
        let mut metric = metric("standard_4k", fps);
        for frame in 0..3 {
            let picture = picture(size(width, height), frame, Flaw("noise", 90));
            let map = metric.push_mapped(&picture, &picture, gaze.then_some([0.3, 0.8])).unwrap();
            prop_assert!(map.iter().all(|&v| v == 0.0));
        }
        prop_assert_eq!(metric.jod(), Some(10.0));
    }

    #[test]
    fn more_noise_is_never_better(less in 4_i64..60, more in 15_i64..60, fps in prop::sample::select(vec![0.0, 24.0, 60.0])) {
        let found = [less, less + more]
            .map(|amount| jod(&mut metric("standard_fhd", fps), 3, Flaw("noise", amount), None));
        prop_assert!(found[1] <= found[0] && found[0] < 10.0, "{found:?}");
    }

    #[test]
    fn the_number_of_threads_changes_nothing(amount in 1_i64..80, gaze in any::<bool>()) {
        let gaze = gaze.then_some([0.2, 0.6]);
        let found = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| jod(&mut metric("standard_4k", 30.0), 3, Flaw("noise", amount), gaze))
        });
        prop_assert_eq!(found[0].to_bits(), found[1].to_bits());
        prop_assert_eq!(found[0].to_bits(), found[2].to_bits());
    }

    #[test]
    fn a_still_clip_is_judged_alike_whenever_one_looks(amount in 1_i64..80, frames in 2_i64..30) {
        // From the start, the temporal window holds copies of this frame.
        let (reference, test) = (picture(size(40, 28), 0, NONE), picture(size(40, 28), 0, Flaw("noise", amount)));
        let mut metric = metric("standard_4k", 30.0);
        metric.push(&reference, &test, None).unwrap();
        let first = metric.jod().unwrap();
        for _ in 1..frames {
            metric.push(&reference, &test, None).unwrap();
        }
        prop_assert!((metric.jod().unwrap() - first).abs() < 1e-9);
    }
}
