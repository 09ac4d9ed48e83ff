use super::*;
use proptest::prelude::*;

fn parsed(text: &str, name: Option<&str>) -> Result<TransferFunction> {
    Ok(parse(Path::new("tf"), text, name)?.as_meant())
}

#[test]
fn our_own_files_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tf.json");
    let tf = TransferFunction::grey_ramp(0.25);
    write(&path, &tf).unwrap();
    assert_eq!(read(&path).unwrap(), tf);
}

#[test]
fn paraview_maps_are_found_by_name() {
    let text = r#"[{"Name":"a","ColorSpace":"RGB","RGBPoints":[-1,0,0,0, 3,1,0.5,0]},
                   {"Name":"b","RGBPoints":[0,0,0,1, 1,1,0,0],"Points":[0,0,0.5,0, 1,0.5,0.5,0]}]"#;
    let a = parsed(text, None).unwrap();
    assert_eq!(a.range(), Some([-1.0, 3.0]));
    assert_eq!(&a.evaluate(0.5)[..3], [0.5, 0.25, 0.0]);
    let b = parsed(text, Some("b")).unwrap();
    assert_eq!(b.evaluate(0.5)[3], 0.25);
    assert!(parsed(text, Some("c")).unwrap_err().to_string().contains("a, b"));
    let table = parsed("0 0 0 0 0\n1 1 1 1 1\n", None).unwrap_err().to_string();
    assert!(table.contains("a table of three numbers a line"), "{table}");
}

#[test]
fn inviwo_points_are_read() {
    let text = r#"<?xml version="1.0" ?><InviwoWorkspace version="2"><Points>
        <Point><pos content="0.25" /><rgba x="0.1" y="0.2" z="0.3" w="0" /></Point>
        <Point><pos content="0.75" /><rgba x="0.5" y="0.6" z="0.7" w="0.8" /></Point></Points></InviwoWorkspace>"#;
    let tf = parsed(text, None).unwrap();
    assert_eq!(tf.points().len(), 2);
    assert!((tf.evaluate(0.5)[3] - 0.4).abs() < 1e-12);
}

#[test]
fn functions_are_those_of_vtk() {
    let cases: serde_json::Value = serde_json::from_str(include_str!("vtk_values.json")).unwrap();
    let cases = cases.as_array().unwrap();
    assert!(cases.len() >= 9);
    for case in cases {
        let imported = parse(Path::new("tf"), &case["map"].to_string(), None).unwrap();
        let every = case["every"].as_u64().unwrap() as f64;
        for (i, rgba) in case["rgba"].as_array().unwrap().iter().enumerate() {
            let found = imported.transfer.evaluate(i as f64 * every / 1000.0);
            for c in 0..4 {
                let wanted = rgba[c].as_f64().unwrap();
                // Without opacities there is a ramp, which VTK has none of; the script writes it.
                assert!(
                    (found[c] - wanted).abs() <= 1.0 / 255.0,
                    "{} at {i}: {found:?}, VTK {rgba}",
                    case["map"]
                );
            }
        }
    }
}

#[test]
fn annotated_values_have_their_colours() {
    let text = r#"[{"Name":"tissue","Annotations":["1","liver","3","bone"],"IndexedColors":[1,0,0,0,0,1],"IndexedOpacities":[0.8,0.8]}]"#;
    let tf = parsed(text, None).unwrap().over([0.0, 4.0]);
    assert_eq!(tf.evaluate(0.25), [1.0, 0.0, 0.0, 0.8]);
    assert_eq!(tf.evaluate(0.75), [0.0, 0.0, 1.0, 0.8]);
    assert!([0.0, 0.5, 1.0].into_iter().all(|v| tf.evaluate(v)[3] == 0.0));
}

#[test]
fn volume_properties_are_read() {
    let vp = "1\n10\n0.2\n0.1\n0.9\n1\n8 -1000 0 152.19 0 278.93 0.19 952 0.2\n4 0 1 255 1\n8 -1000 0.3 0.3 1 3000 1 1 1\n";
    let xml = r#"<MRML><VolumeProperty name="a" scalarOpacity="4 0 0 9 1" colorTransfer="8 0 0 0 0 9 1 1 1"/>
        <VolumeProperty name="b" gradientOpacity="4 0 0 255 1" scalarOpacity="4 0 0 5 1" colorTransfer="8 0 0 0 0 5 1 1 1"/></MRML>"#;
    assert_eq!(parsed(vp, None).unwrap().range(), Some([-1000.0, 3000.0]));
    assert!((parsed(vp, None).unwrap().evaluate(0.5)[3] - 0.2).abs() < 1e-9);
    assert_eq!(parsed(xml, Some("b")).unwrap().range(), Some([0.0, 5.0]));
    let first = parse(Path::new("tf"), xml, None).unwrap();
    assert!(first.transfer.range() == Some([0.0, 9.0]) && first.notes[0].contains("a, b"));
    let json = r#"{"name":"x","scalarOpacity":"4 0 0 9 1","colorTransfer":"8 0 0 0 0 9 1 1 1"}"#;
    assert_eq!(parsed(json, None).unwrap().range(), Some([0.0, 9.0]));
}

#[test]
fn opacity_by_gradient_of_volume_properties_is_kept() {
    let property = |gradients: &str| {
        let json = format!(
            r#"{{"name":"x","scalarOpacity":"4 -100 0 300 1","colorTransfer":"8 -100 0 0 0 300 1 1 1","gradientOpacity":"{gradients}"}}"#
        );
        parse(Path::new("tf"), &json, None)
    };
    let points = |gradients: &str| {
        let imported = property(gradients).unwrap();
        assert!(imported.notes.is_empty(), "{:?}", imported.notes);
        imported.transfer.gradient().map(|curve| curve.scaled(400.0).points().to_vec())
    };
    assert_eq!(points("6 0 0 20 0.5 100 1"), Some(vec![[0.0, 0.0], [20.0, 0.5], [100.0, 1.0]]));
    assert_eq!(points("4 0 1 255 1"), None);
    assert_eq!(points("4 100 1 0 0"), Some(vec![[0.0, 0.0], [100.0, 1.0]]));
    assert_eq!(points("4 -10 0 30 1"), Some(vec![[0.0, 0.25], [30.0, 1.0]]));
    assert!(property("4 0 1 255").is_err());
    let vp = "1\n10\n0.2\n0.1\n0.9\n1\n4 0 0 100 1\n4 0 0 50 1\n8 0 0 0 0 100 1 1 1\n";
    let curve = parse(Path::new("tf"), vp, None).unwrap().transfer;
    assert_eq!(curve.gradient().unwrap().points(), [[0.0, 0.0], [0.5, 1.0]]);
}

#[test]
fn absolute_points_and_masks_of_inviwo() {
    let file = |kind: u8, least: f64| {
        format!(
            r#"<InviwoTransferFunction><maskMin content="{least}"/><maskMax content="1"/>
        <type content="{kind}"/><Points><Point><pos content="-1000"/><rgba x="0" y="0" z="0" w="0.5"/></Point>
        <Point><pos content="3000"/><rgba x="1" y="1" z="1" w="0.5"/></Point></Points></InviwoTransferFunction>"#
        )
    };
    let absolute = parsed(&file(1, 0.0), None).unwrap();
    assert_eq!(
        (absolute.range(), absolute.evaluate(0.25)),
        (Some([-1000.0, 3000.0]), [0.25, 0.25, 0.25, 0.5])
    );
    let masked = parsed(&file(1, 0.5), None).unwrap();
    assert_eq!((masked.evaluate(0.49)[3], masked.evaluate(0.51)[3]), (0.0, 0.5));
    assert!(parsed(&file(7, 0.0), None).is_err());
}

fn is_near(found: &[f64], wanted: &[f64]) -> bool {
    found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3)
}

#[test]
fn opacities_stand_at_their_own_places() {
    let tent = r#"[{"ColorSpace":"RGB","Name":"tent","NanColor":[1,1,0],"RGBPoints":[0,0,0,0, 255,1,1,1],
        "Points":[0,0,0.5,0, 100,0,0.5,0, 128,1,0.5,0, 156,0,0.5,0, 255,0,0.5,0]}]"#;
    let imported = parse(Path::new("tf"), tent, None).unwrap();
    let opacity = |x| at(&imported.transfer, x)[3];
    assert!(is_near(&[100.0, 114.0, 128.0, 142.0, 156.0].map(opacity), &[0.0, 0.5, 1.0, 0.5, 0.0]));
    assert_eq!((imported.is_stretched, imported.transfer.nan()), (false, [1.0, 1.0, 0.0, 1.0]));
}

#[test]
fn colours_between_points_are_those_of_their_space() {
    let middle = |space: &str, points: &str| {
        let map = format!(r#"[{{"ColorSpace":"{space}","Name":"x","RGBPoints":[{points}]}}]"#);
        parsed(&map, None).unwrap().evaluate(0.5)
    };
    // By vtkColorTransferFunction.
    assert!(is_near(&middle("Step", "0,1,0,0, 85,1,0,0, 170,0,1,0, 255,0,0,1"), &[0.0, 1.0, 0.0]));
    assert!(is_near(&middle("HSV", "0,0,0,1, 1,1,0,0"), &[0.0, 1.0, 0.0]));
    assert!(is_near(&middle("Lab", "0,0.05,0.2,0.1, 1,0.9,1,0.8"), &[0.4518, 0.5750, 0.4233]));
}

#[test]
fn points_in_data_values_stay_there() {
    let hu = r#"[{"ColorSpace":"RGB","Name":"hu","Points":[-1000,0,0.5,0, 200,0,0.5,0, 300,1,0.5,0, 1000,1,0.5,0],
        "RGBPoints":[-1000,0,0,0, 200,1,0,0, 300,1,1,1, 1000,1,1,1]}]"#;
    // Over data from -1000 to 3000, as over any other.
    let transfer = parsed(hu, None).unwrap().over([-1000.0, 3000.0]);
    assert!(is_near(&transfer.evaluate(1250.0 / 4000.0), &[1.0, 0.5, 0.5, 0.5]));
    let point = |x: f64, [r, g, b, a]: [f64; 4]| {
        format!(r#"<Point><pos content="{x}"/><rgba x="{r}" y="{g}" z="{b}" w="{a}"/></Point>"#)
    };
    let itf = [
        point(-1000.0, [0.0; 4]),
        point(300.0, [1.0, 0.0, 0.0, 0.0]),
        point(400.0, [1.0, 1.0, 1.0, 0.5]),
        point(3000.0, [1.0, 1.0, 1.0, 0.9]),
    ]
    .concat();
    let itf = format!(
        r#"<InviwoTransferFunction version="3"><maskMin content="0"/><maskMax content="1"/><type content="1"/><Points>{itf}</Points></InviwoTransferFunction>"#
    );
    let right = r#"{"points":[[0,0,0,0,0],[0.325,1,0,0,0],[0.35,1,1,1,0.5],[1,1,1,1,0.9]]}"#;
    let (absolute, right) = (parsed(&itf, None).unwrap(), parsed(right, None).unwrap());
    assert_eq!(absolute.range(), Some([-1000.0, 3000.0]));
    assert!(
        (0..=400).map(|i| f64::from(i) / 400.0).all(|v| is_near(&absolute.evaluate(v), &right.evaluate(v)))
    );
}

#[test]
fn notes_are_one_line_of_plain_text() {
    let text = r#"[{"ColorSpace":"\u001b[2J\n","RGBPoints":[0,0,0,0, 1,1,1,1]},{"Name":"\u0000","RGBPoints":[0,0,0,0, 1,1,1,1]}]"#;
    let notes = parse(Path::new("tf"), text, None).unwrap().notes;
    assert!(notes.len() >= 2 && notes.iter().all(|note| !note.contains(char::is_control)), "{notes:?}");
}

/// Rising places with a number of each, from 2 to 6.
fn nodes<const N: usize>() -> impl Strategy<Value = Vec<(f64, [f64; N])>> {
    let node = (0.01f64..50.0, prop::collection::vec(0.0f64..=1.0, N));
    (-2000.0f64..2000.0, prop::collection::vec(node, 2..7)).prop_map(|(first, nodes)| {
        nodes
            .into_iter()
            .scan(first, |x, (gap, numbers)| {
                *x += gap;
                Some((*x, std::array::from_fn(|i| numbers[i])))
            })
            .collect()
    })
}

/// Numbers of all nodes in one list.
fn flat<const N: usize>(nodes: &[(f64, [f64; N])], after: &[f64]) -> Vec<f64> {
    nodes.iter().flat_map(|(x, numbers)| [&[*x], numbers.as_slice(), after].concat()).collect()
}

/// RGBA of `transfer` at the data value `x`.
fn at(transfer: &TransferFunction, x: f64) -> [f64; 4] {
    let [lo, hi] = transfer.range().unwrap();
    transfer.evaluate((x - lo) / (hi - lo))
}

fn is_sound(transfer: &TransferFunction) -> bool {
    (0..=200).all(|i| transfer.evaluate(f64::from(i) / 200.0).iter().all(|c| (0.0..=1.0).contains(c)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn maps_meet_their_points(
        colours in nodes::<3>(),
        opacities in nodes::<1>(),
        space in prop::sample::select(vec!["RGB", "HSV", "Lab", "Prolab"]),
    ) {
        let map = serde_json::json!({
            "ColorSpace": space, "RGBPoints": flat(&colours, &[]), "Points": flat(&opacities, &[0.5, 0.0]),
        });
        let transfer = parse(Path::new("tf"), &map.to_string(), None).unwrap().transfer;
        prop_assert!(is_sound(&transfer));
        for (x, colour) in &colours {
            let found = at(&transfer, *x);
            prop_assert!((0..3).all(|c| (found[c] - colour[c]).abs() < 3e-3), "{x}: {found:?}, not {colour:?}");
        }
        for (x, [opacity]) in &opacities {
            prop_assert!((at(&transfer, *x)[3] - opacity).abs() < 1e-6, "{x}: {:?}, not {opacity}", at(&transfer, *x));
        }
    }

    #[test]
    fn volume_properties_meet_their_points(colours in nodes::<3>(), opacities in nodes::<1>()) {
        let list = |numbers: Vec<f64>| format!("{} {}", numbers.len(), numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "));
        let (colour_list, opacity_list) = (list(flat(&colours, &[])), list(flat(&opacities, &[])));
        let vp = format!("1\n10\n0.2\n0.1\n0.9\n1\n{opacity_list}\n4 0 1 255 1\n{colour_list}\n");
        let xml = format!(r#"<M><VolumeProperty scalarOpacity="{opacity_list}" colorTransfer="{colour_list}"/></M>"#);
        for text in [vp, xml] {
            let transfer = parse(Path::new("tf"), &text, None).unwrap().transfer;
            prop_assert!(is_sound(&transfer));
            for (x, colour) in &colours {
                prop_assert!((0..3).all(|c| (at(&transfer, *x)[c] - colour[c]).abs() < 1e-6), "{x}");
            }
            for (x, [opacity]) in &opacities {
                prop_assert!((at(&transfer, *x)[3] - opacity).abs() < 1e-6, "{x}");
            }
        }
    }
}

#[test]
fn bad_files_are_errors() {
    for text in [
        "",
        "{",
        "[]",
        "{}",
        "[1,2]",
        r#"{"points":[]}"#,
        r#"{"points":[[0,0,0]]}"#,
        "<a>",
        "<InviwoWorkspace/>",
        r#"[{"Name":"x","RGBPoints":[0,0,0]}]"#,
        r#"[{"Name":"x","RGBPoints":["a",0,0,0]}]"#,
    ] {
        assert!(parsed(text, None).is_err(), "{text}");
    }
}

#[test]
fn real_files_of_other_programs_are_read() {
    let Some(data) = crate::test_data() else { return };
    let maps = data.join("colormaps");
    let viridis = read(&maps.join("inviwo/matplotlib/viridis.itf")).unwrap();
    assert!((viridis.evaluate(1.0)[0] - 0.993).abs() < 0.01);
    let cool = read(&maps.join("vtkjs_ColorMaps.json#Cool to Warm")).unwrap();
    let middle = cool.evaluate(0.5);
    assert!(middle[..3].iter().all(|c| (0.8..0.9).contains(c)), "{middle:?}");
    // It ends in a comma that JSON does not have.
    let several = import(&maps.join("paraview_ColorMaps.json")).unwrap();
    assert!(several.is_stretched && several.notes[0].contains("FILE#NAME"), "{:?}", several.notes);
    let bone = read(&maps.join("slicer/presets.xml#CT-Bone")).unwrap();
    assert_eq!(bone.range(), Some([-3024.0, 3071.0]));
    let ice = read(&maps.join("cmocean/ice-rgb.txt")).unwrap();
    assert_eq!((ice.points().len(), ice.range()), (256, None));
}
