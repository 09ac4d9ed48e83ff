use super::*;

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
