use super::*;
use proptest::prelude::*;

fn points() -> impl Strategy<Value = Vec<ControlPoint>> {
    prop::collection::vec(prop::array::uniform5(0.0f64..=1.0), 1..12).prop_map(|mut all| {
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        all.into_iter().map(ControlPoint::from).collect()
    })
}

#[test]
fn a_step_belongs_to_its_right_side() {
    let tf = TransferFunction::new(vec![
        ControlPoint::new(0.0, [0.0; 3], 0.0),
        ControlPoint::new(0.5, [0.0; 3], 0.0),
        ControlPoint::new(0.5, [1.0; 3], 0.8),
    ])
    .unwrap();
    assert_eq!(tf.evaluate(0.4999)[3], 0.0);
    assert_eq!(tf.evaluate(0.5)[3], 0.8);
    assert_eq!(tf.steepest_slope(), f64::INFINITY);
    assert_eq!(tf.max_opacity(0.0, 0.499), 0.0);
}

#[test]
fn bad_functions_are_refused() {
    assert!(TransferFunction::new(vec![]).is_err());
    let p = |v, a| ControlPoint::new(v, [0.5; 3], a);
    assert!(TransferFunction::new(vec![p(0.5, 0.0), p(0.2, 0.0)]).is_err());
    assert!(TransferFunction::new(vec![p(0.5, 1.5)]).is_err());
    assert!(TransferFunction::new(vec![p(f64::NAN, 0.5)]).is_err());
    let real = TransferFunction::new(vec![p(-1000.0, 0.0)]).unwrap_err().to_string();
    assert!(
        real.contains("v = -1000") && real.contains("the shown range") && real.contains("\"range\":[LO,HI]"),
        "{real}"
    );
}

#[test]
fn json_is_the_documented_shape() {
    let tf: TransferFunction = serde_json::from_str(r#"{"points":[[0,0,0,0,0],[1,1,1,1,0.5]]}"#).unwrap();
    assert_eq!(tf.evaluate(0.5), [0.5, 0.5, 0.5, 0.25]);
    assert_eq!(
        serde_json::to_string(&tf).unwrap(),
        r#"{"points":[[0.0,0.0,0.0,0.0,0.0],[1.0,1.0,1.0,1.0,0.5]]}"#
    );
}

#[test]
fn points_of_another_length_are_named() {
    for (bad, said) in [("[0,0,0,0]", "point 1 has 4 numbers"), ("[1,0,0,0,0,0]", "point 1 has 6 numbers")] {
        let text = format!(r#"{{"points":[[0,0,0,0,0],{bad}]}}"#);
        let error = serde_json::from_str::<TransferFunction>(&text).unwrap_err().to_string();
        assert!(error.contains(said) && error.contains("[v, r, g, b, a]"), "{error}");
    }
}

#[test]
fn functions_of_data_values_stay_there() {
    let text = r#"{"points":[[0,0,0,0,0],[0.5,1,0,0,0.2],[1,1,1,1,1]],"range":[-1000,1000]}"#;
    let tf: TransferFunction = serde_json::from_str(text).unwrap();
    let values = r#"{"points":[[-1000,0,0,0,0],[0,1,0,0,0.2],[1000,1,1,1,1]],"range":[-1000,1000]}"#;
    assert_eq!(serde_json::from_str::<TransferFunction>(values).unwrap(), tf);
    assert_eq!(serde_json::from_str::<TransferFunction>(&serde_json::to_string(&tf).unwrap()).unwrap(), tf);
    for shown in [[-1000.0, 1000.0], [-500.0, 250.0], [-3000.0, 5000.0], [200.0, 201.0]] {
        let over = tf.over(shown);
        assert_eq!(over.range(), None);
        for i in 0..=100 {
            let v = f64::from(i) / 100.0;
            let x = shown[0] + v * (shown[1] - shown[0]);
            let expected = tf.evaluate((x + 1000.0) / 2000.0);
            assert!(distance(over.evaluate(v), expected) < 1e-9, "{shown:?} {v}");
        }
    }
    // All values are equal: the result is the colour of that value.
    assert!((tf.over([500.0, 500.0]).evaluate(0.0)[3] - 0.6).abs() < 1e-12);
    for bad in ["[1,0]", "[0,0]", "[0,1e999]", "[0]", "[-1e308,1e308]"] {
        let text = format!(r#"{{"points":[[0,0,0,0,0]],"range":{bad}}}"#);
        assert!(serde_json::from_str::<TransferFunction>(&text).is_err(), "{bad}");
    }
    let outside = r#"{"points":[[0,0,0,0,0],[2000,0,0,0,0]],"range":[-1000,1000]}"#;
    let error = serde_json::from_str::<TransferFunction>(outside).unwrap_err().to_string();
    assert!(error.contains("2000") && error.contains("-1000 to 1000"), "{error}");
}

#[test]
fn logarithms_of_values() {
    let tf = TransferFunction::grey_ramp(1.0).on_log_scale([0.0, 1000.0], 1.0).unwrap();
    for (x, opacity) in
        [(0.5, 0.0), (1.0, 0.0), (10.0, 1.0 / 3.0), (100.0, 2.0 / 3.0), (300.0, 0.825_707), (1000.0, 1.0)]
    {
        assert!((tf.evaluate(x / 1000.0)[3] - opacity).abs() < TOLERANCE, "{x}");
    }
    assert!(TransferFunction::grey_ramp(1.0).on_log_scale([-2.0, -1.0], 0.0).is_err());
}

#[test]
fn curves_are_followed_and_jumps_kept() {
    let jump = |v: f64| if v <= 0.25 { 0.0 } else { (9.0 * v).sin().abs() };
    let turn = std::f64::consts::PI / 9.0;
    let tf = TransferFunction::of_curve(&[0.0, 1.0, 0.25, turn, 2.0 * turn], |v| [jump(v), v, 1.0, jump(v)])
        .unwrap();
    for i in 0..=1000 {
        let v = f64::from(i) / 1000.0;
        assert!((tf.evaluate(v)[3] - jump(v)).abs() < 1.0 / 255.0, "{v}");
    }
    assert!(tf.points().len() < 150, "{}", tf.points().len());
}

proptest! {
    #[test]
    fn max_opacity_bounds_every_value(points in points(), a in 0.0f64..=1.0, b in 0.0f64..=1.0, f in 0.0f64..=1.0) {
        let tf = TransferFunction::new(points).unwrap();
        let (lo, hi) = (a.min(b), a.max(b));
        prop_assert!(tf.evaluate(lo + f * (hi - lo))[3] <= tf.max_opacity(lo, hi) + 1e-12);
    }

    #[test]
    fn corners_are_met(points in points()) {
        let tf = TransferFunction::new(points.clone()).unwrap();
        for (i, p) in points.iter().enumerate() {
            let last_of_its_value = points.get(i + 1).is_none_or(|next| next.value > p.value);
            if last_of_its_value {
                prop_assert!((tf.evaluate(p.value)[3] - p.opacity).abs() < 1e-12);
            }
        }
    }
}
