//! Tests of ColorVideoVDP against its published program; `reference/cvvdp.py` computes the values.

mod clips;
mod pattern;

use clips::{Flaw, NONE, picture, size};
use fovol_core::{Frame, FrameSize};
use fovol_metrics::{ColorVideoVdp, Display, Error};
use proptest::prelude::*;
use serde_json::Value;

/// Tolerance in JOD; the largest difference found is 7e-6. Both programs compute pixels in f32 and sum in different
/// orders, and the values have five digits.
const TOLERANCE: f64 = 5e-5;

fn metric(display: &str, fps: f64) -> ColorVideoVdp {
    let display = Display::named(display).unwrap();
    if fps == 0.0 { ColorVideoVdp::image(&display) } else { ColorVideoVdp::video(&display, fps) }.unwrap()
}

/// JOD of `frames` frames with `flaw`.
fn jod(metric: &mut ColorVideoVdp, size: FrameSize, frames: i64, flaw: Flaw<'_>) -> f64 {
    for frame in 0..frames {
        metric.push(&picture(size, frame, NONE), &picture(size, frame, flaw)).unwrap();
    }
    metric.jod().unwrap()
}

#[test]
fn jods_agree_with_the_published_program() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("reference/cvvdp.json")).unwrap();
    assert!(cases.len() >= 80);
    let mut farthest = 0.0_f64;
    for case in &cases {
        let side = |i: usize| case["size"][i].as_u64().unwrap() as u32;
        let flaw = Flaw(case["flaw"].as_str().unwrap(), case["amount"].as_i64().unwrap());
        let mut metric = metric(case["display"].as_str().unwrap(), case["fps"].as_f64().unwrap());
        let found = jod(&mut metric, size(side(0), side(1)), case["frames"].as_i64().unwrap(), flaw);
        let off = (found - case["jod"].as_f64().unwrap()).abs();
        farthest = farthest.max(off);
        assert!(off < TOLERANCE, "{found}: {case}");
    }
    println!("farthest from the program: {farthest:.6} JOD");
}

#[test]
fn what_is_wrong_is_said_and_leaves_the_clip_alone() {
    let display = Display::named("standard_fhd").unwrap();
    for fps in [0.0, -30.0, f64::NAN, f64::INFINITY, 1001.0] {
        let error = ColorVideoVdp::video(&display, fps).unwrap_err();
        assert!(matches!(&error, Error::FrameRate { .. }) && !error.to_string().contains('\n'));
    }
    let bad = Display { distance_m: -1.0, ..display };
    assert_eq!(ColorVideoVdp::image(&bad).unwrap_err(), Error::ImpossibleDisplay);
    let mut metric = ColorVideoVdp::video(&display, 30.0).unwrap();
    assert_eq!((metric.jod(), metric.frames()), (None, 0));
    let (small, large) = (Frame::new(size(8, 8)), Frame::new(size(9, 8)));
    assert!(matches!(metric.push(&small, &large), Err(Error::SizesDiffer { .. })));
    for (width, height) in [(1, 1), (3, 3), (1, 500), (500, 2)] {
        let tiny = Frame::new(size(width, height));
        assert!(matches!(metric.push(&tiny, &tiny), Err(Error::TooSmall { .. })));
    }
    metric.push(&small, &small).unwrap();
    assert!(matches!(metric.push(&large, &large), Err(Error::SizeChanged { .. })));
    assert_eq!((metric.jod(), metric.frames()), (Some(10.0), 1));
}

#[test]
fn odd_values_count_as_what_is_written_to_files() {
    let with = |v: f32| {
        let mut frame = picture(size(16, 12), 0, NONE);
        frame.pixels_mut()[50] = [v; 4];
        frame
    };
    let jod = |a: &Frame, b: &Frame| {
        let mut metric = metric("standard_hmd", 0.0);
        metric.push(a, b).unwrap();
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
        // Without black, contrasts reach their bounds.
        let dark = Display { contrast: 1e9, ambient: 0.0, ..Display::named("standard_fhd").unwrap() };
        for fps in [0.5, 60.0, 1000.0] {
            let mut metric = ColorVideoVdp::video(&dark, fps).unwrap();
            metric.push(&black, &white).unwrap();
            metric.push(&white, &black).unwrap();
            let found = metric.jod().unwrap();
            assert!(found < 9.0 && found.is_finite(), "{width}x{height}, {fps}: {found}");
        }
    }
}

#[test]
fn colour_alone_is_seen() {
    let pixel = |rgb: [f32; 3]| {
        let mut frame = Frame::new(size(48, 48));
        frame.fill([0.5, 0.5, 0.5, 1.0]);
        for (i, out) in frame.pixels_mut().iter_mut().enumerate() {
            if (i / 8 + i / (8 * 48)) % 2 == 0 {
                *out = [rgb[0], rgb[1], rgb[2], 1.0];
            }
        }
        frame
    };
    // Both patches have the luminance of the grey around them.
    let (grey, reddish) = (pixel([0.5; 3]), pixel([0.7, 0.431_5, 0.5]));
    let mut coloured = metric("standard_fhd", 0.0);
    coloured.push(&grey, &reddish).unwrap();
    assert!(coloured.jod().unwrap() < 8.5, "{:?}", coloured.jod());
}

#[test]
fn several_pictures_are_as_good_as_their_difference_on_average() {
    let size = size(40, 28);
    let single = |amount| jod(&mut metric("standard_4k", 0.0), size, 1, Flaw("noise", amount));
    let [good, bad] = [single(5), single(100)];
    let mut both = metric("standard_4k", 0.0);
    jod(&mut both, size, 1, Flaw("noise", 5));
    let found = jod(&mut both, size, 1, Flaw("noise", 100));
    assert!(bad < found && found < good, "{bad} {found} {good}");
    let mut twice = metric("standard_4k", 0.0);
    jod(&mut twice, size, 1, Flaw("noise", 100));
    assert!((jod(&mut twice, size, 1, Flaw("noise", 100)) - bad).abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn equal_clips_have_ten(width in 4_u32..70, height in 4_u32..70, fps in 0.5_f64..130.0) {
        let mut metric = metric("standard_4k", fps);
        for frame in 0..3 {
            let picture = picture(size(width, height), frame, Flaw("noise", 90));
            metric.push(&picture, &picture).unwrap();
        }
        prop_assert_eq!(metric.jod(), Some(10.0));
    }

    #[test]
    fn more_noise_is_never_better(less in 4_i64..60, more in 15_i64..60, fps in prop::sample::select(vec![0.0, 24.0, 60.0])) {
        let found = [less, less + more]
            .map(|amount| jod(&mut metric("standard_fhd", fps), size(40, 28), 3, Flaw("noise", amount)));
        prop_assert!(found[1] <= found[0] && found[0] < 10.0, "{found:?}");
    }

    #[test]
    fn the_number_of_threads_changes_nothing(amount in 1_i64..80, fps in prop::sample::select(vec![0.0, 30.0])) {
        let found = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| jod(&mut metric("standard_4k", fps), size(40, 28), 3, Flaw("noise", amount)))
        });
        prop_assert_eq!(found[0].to_bits(), found[1].to_bits());
        prop_assert_eq!(found[0].to_bits(), found[2].to_bits());
    }

    #[test]
    fn a_still_clip_is_judged_alike_whenever_one_looks(amount in 1_i64..80, frames in 2_i64..30) {
        // From the start, the temporal window holds copies of this frame.
        let size = size(40, 28);
        let (reference, test) = (picture(size, 0, NONE), picture(size, 0, Flaw("noise", amount)));
        let mut metric = metric("standard_4k", 30.0);
        metric.push(&reference, &test).unwrap();
        let first = metric.jod().unwrap();
        for _ in 1..frames {
            metric.push(&reference, &test).unwrap();
        }
        prop_assert!((metric.jod().unwrap() - first).abs() < 1e-9);
    }
}
