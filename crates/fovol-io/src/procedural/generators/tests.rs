use super::*;
use crate::procedural::names;
use fovol_core::Dtype;

fn bytes(kind: Procedural, dims: [usize; 3], seed: u64) -> Vec<u8> {
    make(kind, dims, seed).unwrap().data().to_vec()
}

fn on_threads(threads: usize, kind: Procedural) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| bytes(kind, [32, 24, 28], 9))
}

#[test]
fn every_name_reads_back_and_others_list_them() {
    for kind in Procedural::ALL {
        assert_eq!(kind.name().parse(), Ok(kind));
        assert!(kind.description().len() > 20);
    }
    assert_eq!("Marschner_Lobb".parse(), Ok(Procedural::MarschnerLobb));
    let error = "skull".parse::<Procedural>().unwrap_err().to_string();
    assert!(names().iter().all(|name| error.contains(name)), "{error}");
}

#[test]
fn sizes_out_of_bounds_are_refused() {
    for dims in [[3, 8, 8], [0, 8, 8], [1 << 40, 1 << 40, 8], [65_537, 4, 4]] {
        assert!(make(Procedural::Plume, dims, 0).is_err(), "{dims:?}");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    for kind in Procedural::ALL {
        assert!(on_threads(1, kind) == on_threads(3, kind), "{kind}");
    }
}

#[test]
fn seeds_matter_wherever_something_is_random() {
    for kind in Procedural::ALL {
        let same = bytes(kind, [16; 3], 1) == bytes(kind, [16; 3], 2);
        assert_eq!(same, kind == Procedural::MarschnerLobb, "{kind}");
    }
}

#[test]
fn tiny_and_lopsided_grids_work() {
    for kind in Procedural::ALL {
        for dims in [[4, 4, 4], [4, 40, 9]] {
            let volume = make(kind, dims, 0).unwrap();
            assert_eq!(volume.grid().dims(), dims);
            assert!(volume.grid().world_extent().abs_diff_eq(glam::DVec3::ONE, 1e-9), "{kind}");
        }
    }
}

#[test]
fn values_look_like_the_data_they_stand_for() {
    for kind in Procedural::ALL {
        let volume = make(kind, [48; 3], 3).unwrap();
        let s = volume.statistics();
        assert_eq!(s.non_finite, 0, "{kind}");
        let (dtype, min, max) = match kind {
            Procedural::Vortices => (Dtype::F32, 0.0..1.5, 5.0..80.0),
            Procedural::Supernova | Procedural::Plume => (Dtype::F32, 0.0..0.001, 0.6..1.001),
            Procedural::Head => (Dtype::I16, -1024.0..-1000.0, 1800.0..3072.0),
            Procedural::Engine => (Dtype::U8, 0.0..3.0, 200.0..256.0),
            Procedural::Angiogram => (Dtype::U8, 0.0..1.0, 220.0..256.0),
            Procedural::Reptile => (Dtype::U16, 0.0..1.0, 40_000.0..65_536.0),
            Procedural::MarschnerLobb => (Dtype::F32, 0.0..0.05, 0.95..1.001),
        };
        assert_eq!(volume.dtype(), dtype, "{kind}");
        assert!(min.contains(&s.min) && max.contains(&s.max), "{kind}: {} to {}", s.min, s.max);
    }
}

#[test]
fn vessels_and_smoke_leave_most_of_the_cube_empty() {
    for (kind, threshold, least) in [(Procedural::Angiogram, 40.0, 0.9), (Procedural::Plume, 0.02, 0.6)] {
        let volume = make(kind, [48; 3], 3).unwrap();
        let mut empty = 0;
        for i in 0..48 * 48 * 48 {
            let value = volume.value([i % 48, i / 48 % 48, i / 48 / 48]);
            empty += usize::from(value < threshold);
        }
        let share = empty as f64 / 48f64.powi(3);
        assert!(share > least && share < 0.999, "{kind}: {share} empty");
    }
}

#[test]
fn marschner_lobb_is_its_formula() {
    let volume = make(Procedural::MarschnerLobb, [40; 3], 0).unwrap();
    let at = |i: usize| (i as f64 + 0.5) / 20.0 - 1.0;
    for [x, y, z] in [[0, 0, 0], [19, 20, 7], [39, 3, 31]] {
        let r = at(x).hypot(at(y));
        let ripples = (12.0 * std::f64::consts::PI * (0.5 * std::f64::consts::PI * r).cos()).cos();
        let expected = (1.0 - (0.5 * std::f64::consts::PI * at(z)).sin() + 0.25 * (1.0 + ripples)) / 2.5;
        assert!((volume.value([x, y, z]) - expected).abs() < 1e-5);
    }
}
