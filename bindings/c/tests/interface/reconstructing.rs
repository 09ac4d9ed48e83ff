//! Sparse frames of any renderer become pictures.

use crate::calls::*;
use fovolnet::core::{Frame, FrameSize, SparseFrame};
use fovolnet::{Reconstructor, RenderOverrides};
use fovolnet_c::*;
use std::ptr::{null, null_mut};

const SIZE: FrameSize = FrameSize { width: 40, height: 24 };

/// Every third pixel of a gradient.
fn samples() -> (Vec<f32>, Vec<u8>) {
    let pixels = SIZE.pixels();
    let colour = |i: usize| [(i % 40) as f32 / 40.0, (i / 40) as f32 / 24.0, 0.5];
    let mask = (0..pixels).map(|i| u8::from(i % 3 == 0) * 255).collect();
    ((0..pixels).flat_map(colour).collect(), mask)
}

fn sparse(colours: &[f32], mask: &[u8]) -> FovolnetSparseFrame {
    FovolnetSparseFrame {
        size: size_of::<FovolnetSparseFrame>(),
        width: 40,
        height: 24,
        colours: colours.as_ptr(),
        components: 3,
        reserved: 0,
        mask: mask.as_ptr(),
        motion: null(),
    }
}

#[test]
fn pictures_are_those_of_the_library() {
    let (colours, mask) = samples();
    for (json, reconstruct) in [("{}", None), (r#"{"reconstruct": "linear"}"#, Some("linear"))] {
        let mut handle = null_mut();
        unsafe { ok(fovolnet_reconstructor_new(40, 24, c(json).as_ptr(), &raw mut handle)) };
        let given = RenderOverrides {
            reconstruct: reconstruct.map(|how| how.parse().unwrap()),
            ..Default::default()
        };
        let mut own = Reconstructor::new(&given.resolve().unwrap(), SIZE).unwrap();
        let mut uses = 2;
        unsafe { ok(fovolnet_reconstructor_uses_motion(handle, &raw mut uses)) };
        assert_eq!(uses == 1, own.uses_motion());
        let pixels = colours.chunks_exact(3).zip(&mask);
        let pixels = pixels.map(|(c, m)| if *m > 0 { [c[0], c[1], c[2], 1.0] } else { [0.0; 4] });
        let frame = SparseFrame::from(&Frame::from_pixels(SIZE, pixels.collect()).unwrap());
        let motion = vec![[0.5f32, -0.25]; SIZE.pixels()];
        for i in 0..3 {
            let moves = i == 2;
            let given = sparse(&colours, &mask);
            let given =
                FovolnetSparseFrame { motion: if moves { motion.as_ptr().cast() } else { null() }, ..given };
            let mut picture = vec![0f32; 4 * SIZE.pixels()];
            let bytes = size_of_val(&*picture);
            let status = unsafe {
                fovolnet_reconstructor_reconstruct(handle, &raw const given, picture.as_mut_ptr(), bytes)
            };
            ok(status);
            let expected = own.reconstruct(&frame, moves.then_some(&*motion)).unwrap();
            assert_eq!(picture, expected.pixels().as_flattened(), "{json} {i}");
        }
        unsafe {
            ok(fovolnet_reconstructor_reset(handle));
            fovolnet_reconstructor_release(handle);
        }
    }
}

#[test]
fn wrong_sizes_are_refused() {
    let (colours, mask) = samples();
    let right = sparse(&colours, &mask);
    let mut handle = null_mut();
    let mut picture = vec![0f32; 4 * SIZE.pixels()];
    let bytes = size_of_val(&*picture);
    let invalid = |status| fails(status, FOVOLNET_ERROR_INVALID);
    unsafe {
        invalid(fovolnet_reconstructor_new(0, 24, null(), &raw mut handle));
        let text = invalid(fovolnet_reconstructor_new(40, 24, c"{\"weight\": 1}".as_ptr(), &raw mut handle));
        assert!(text.contains("did you mean weights?"), "{text}");
        let json = c"{\"reconstruct\": \"pull-push\"}";
        ok(fovolnet_reconstructor_new(40, 24, json.as_ptr(), &raw mut handle));
        let mut refused = |given: FovolnetSparseFrame, bytes: usize| {
            let at = picture.as_mut_ptr();
            invalid(fovolnet_reconstructor_reconstruct(handle, &raw const given, at, bytes))
        };
        assert!(refused(right, bytes - 1).contains(&format!("needs {bytes}")));
        assert!(refused(FovolnetSparseFrame { width: 41, ..right }, bytes).contains("41x24"));
        assert!(refused(FovolnetSparseFrame { components: 2, ..right }, bytes).contains("3 or 4"));
        assert!(refused(FovolnetSparseFrame { mask: null(), ..right }, bytes).contains("mask"));
        assert!(refused(FovolnetSparseFrame { colours: null(), ..right }, bytes).contains("colours"));
        assert!(refused(FovolnetSparseFrame { size: 0, ..right }, bytes).contains("sizeof"));
        fovolnet_reconstructor_release(handle);
    }
}
