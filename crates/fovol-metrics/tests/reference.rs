//! Tests of the metrics against scikit-image and pytorch-msssim; `reference/metrics.py` computes the values.

mod pattern;

use fovol_core::{Frame, FrameSize};
use fovol_metrics::{SsimSettings, ms_ssim, mse, psnr, ssim, temporal_mse};
use pattern::{noise, triangle};
use serde_json::Value;

/// Picture equal to the script's.
fn picture(size: FrameSize, frame: i64, flaw: i64) -> Frame {
    let channel = |x: i64, y: i64, c: i64| {
        let waves =
            (triangle(3 * x + 2 * y + 5 * frame, 40 + 9 * c) + triangle(x * (c + 1) + 7 * frame, 23)) / 2;
        let base = if 2 * x > i64::from(size.width) + y { 250 - 3 * c } else { waves };
        let value = base + ((noise(x, y, c, frame) - 128) * flaw).div_euclid(128);
        value.clamp(0, 255) as f32 / 255.0
    };
    let pixels = (0..i64::from(size.height))
        .flat_map(|y| (0..i64::from(size.width)).map(move |x| (x, y)))
        .map(|(x, y)| [channel(x, y, 0), channel(x, y, 1), channel(x, y, 2), 1.0])
        .collect();
    Frame::from_pixels(size, pixels).unwrap()
}

fn close(what: &str, size: FrameSize, found: f64, expected: &Value, tolerance: f64) {
    let Some(expected) = expected.as_f64() else {
        panic!("metrics.json has no {what} of {size}; remake it with metrics.py")
    };
    assert!((found - expected).abs() < tolerance, "{what} of {size}: {found}, expected {expected}");
}

#[test]
fn every_measure_agrees_with_the_reference() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("reference/metrics.json")).unwrap();
    assert!(cases.len() >= 7);
    for case in &cases {
        let side = |i: usize| case["size"][i].as_u64().unwrap() as u32;
        let size = FrameSize::new(side(0), side(1)).unwrap();
        let flaw = case["flaw"].as_i64().unwrap();
        let [r0, r1] = [0, 1].map(|f| picture(size, f, 0));
        let [t0, t1] = [0, 1].map(|f| picture(size, f, flaw));
        close("MSE", size, mse(&r0, &t0).unwrap(), &case["mse"], 1e-9);
        close("PSNR", size, psnr(&r0, &t0).unwrap(), &case["psnr"], 1e-6);
        let gaussian = ssim(&r0, &t0, &SsimSettings::gaussian()).unwrap();
        close("SSIM", size, gaussian, &case["ssim_gaussian"], 1e-9);
        let uniform = ssim(&r0, &t0, &SsimSettings::uniform7()).unwrap();
        close("SSIM 7x7", size, uniform, &case["ssim_uniform7"], 1e-9);
        let change = temporal_mse([&r0, &r1], [&t0, &t1]).unwrap();
        close("temporal MSE", size, change, &case["temporal_mse"], 1e-9);
        match ms_ssim(&r0, &t0) {
            Ok(found) => close("MS-SSIM", size, found, &case["ms_ssim"], 1e-6),
            Err(_) => assert!(case["ms_ssim"].is_null(), "MS-SSIM of {size}"),
        }
    }
}
