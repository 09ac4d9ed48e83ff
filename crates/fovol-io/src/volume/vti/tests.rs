use super::*;
use crate::volume::{Overrides, read};
use fovol_core::Dtype;
use std::io::Write;
use std::path::Path;

/// Reads `source` without choices.
fn parse(source: &Source) -> Result<Volume> {
    super::parse(source, &Overrides::default())
}

/// A file of 2×1×2 unsigned shorts 1, 2, 3, 258 with these attributes, array and tail.
fn file(attributes: &str, array: &str, tail: &[u8]) -> Source {
    let mut bytes = format!(
        r#"<?xml version="1.0"?><VTKFile type="ImageData" {attributes}>
        <ImageData WholeExtent="3 4 -1 -1 0 1" Spacing="1 0 -2" Origin="0 0 0" Direction="1 0 0 0 1 0 0 0 1">
        <FieldData><DataArray type="Float32" Name="t" format="ascii">7</DataArray></FieldData>
        <Piece Extent="3 4 -1 -1 0 1"><PointData Scalars="b">
        <DataArray type="String" Name="a" format="ascii">x</DataArray>
        <DataArray type="UInt16" Name="b" {array}</DataArray>
        </PointData><CellData/></Piece></ImageData>"#
    )
    .into_bytes();
    bytes.extend_from_slice(tail);
    Source::from_bytes(Path::new("x.vti"), bytes)
}

const LITTLE: &[u8] = &[1, 0, 2, 0, 3, 0, 2, 1];
const BIG: &[u8] = &[0, 1, 0, 2, 0, 3, 1, 2];

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let quad = |bytes: &[u8]| {
        let bits = (0..3).fold(0u32, |bits, i| bits << 8 | u32::from(*bytes.get(i).unwrap_or(&0)));
        let digit = |i: usize| char::from(DIGITS[(bits >> (18 - 6 * i)) as usize & 63]);
        (0..4).map(|i| if i <= bytes.len() { digit(i) } else { '=' }).collect::<String>()
    };
    bytes.chunks(3).map(quad).collect()
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

#[track_caller]
fn check(source: &Source) -> Volume {
    let volume = parse(source).unwrap();
    let values = [0, 1].map(|z| [0, 1].map(|x| volume.value([x, 0, z])));
    assert_eq!(values, [[1.0, 2.0], [3.0, 258.0]]);
    assert_eq!((volume.grid().dims(), volume.dtype()), ([2, 1, 2], Dtype::U16));
    volume
}

#[test]
fn text() {
    let volume = check(&file("", "format=\"ascii\">\n<InformationKey>9</InformationKey>\n1 2\n3 258 ", b""));
    assert_eq!(volume.placement().unwrap().letters(), "LPS");
}

#[test]
fn inline_base64_in_both_byte_orders() {
    let little = [&words(&[8]), LITTLE].concat();
    check(&file("", &format!("format=\"binary\">\n {}\n", base64(&little)), b""));
    // Some writers pad the length by itself.
    let parts = format!("{}{}", base64(&words(&[8])), base64(LITTLE));
    check(&file("", &format!("format=\"binary\">{parts}"), b""));
    let big = [&8u64.to_be_bytes()[..], BIG].concat();
    let attributes = r#"byte_order="BigEndian" header_type="UInt64""#;
    check(&file(attributes, &format!("format=\"binary\">{}", base64(&big)), b""));
}

#[test]
fn compressed_blocks() {
    let packed = [zlib(&LITTLE[..6]), zlib(&LITTLE[6..])];
    let sizes = words(&[2, 6, 2, packed[0].len() as u32, packed[1].len() as u32]);
    let text = base64(&sizes) + &base64(&packed.concat());
    check(&file(r#"compressor="vtkZLibDataCompressor""#, &format!("format=\"binary\">{text}"), b""));

    let packed = lz4_flex::block::compress(LITTLE);
    let sizes = words(&[1, 8, 0, packed.len() as u32]);
    let text = base64(&sizes) + &base64(&packed);
    check(&file(r#"compressor="vtkLZ4DataCompressor""#, &format!("format=\"binary\">{text}"), b""));
}

#[test]
fn appended_data() {
    let bare =
        [b"<AppendedData encoding=\"raw\">\n  _junk".as_slice(), &words(&[8]), LITTLE, b"\n</AppendedData>"];
    let source = file("", r#"format="appended" offset="4">"#, &bare.concat());
    let volume = check(&source);
    assert!(source.bytes().as_ptr_range().contains(&volume.data().as_ptr()), "copied");

    let text = base64(&[&words(&[8]), LITTLE].concat());
    let tail = format!("<AppendedData encoding=\"base64\">_AAAA{text}</AppendedData></VTKFile>");
    check(&file("", r#"format="appended" offset="4">"#, tail.as_bytes()));

    let packed = zlib(LITTLE);
    let sizes = words(&[1, 8, 0, packed.len() as u32]);
    let tail = [b"<AppendedData encoding='raw'>_".as_slice(), &sizes, &packed].concat();
    check(&file(r#"compressor="vtkZLibDataCompressor""#, r#"format="appended" offset="0">"#, &tail));
}

#[test]
fn cells_where_there_are_no_points() {
    let text = r#"<VTKFile type="ImageData"><ImageData WholeExtent="0 2 0 1 0 0"><Piece><PointData/><CellData>
        <DataArray type="Int8" format="ascii" NumberOfComponents="2">1 -1 2 -2</DataArray></CellData></Piece>
        </ImageData></VTKFile>"#;
    let volume = parse(&Source::from_bytes(Path::new("x.vti"), text.into())).unwrap();
    assert_eq!((volume.grid().dims(), volume.components()), ([2, 1, 1], 2));
    assert_eq!(volume.value([1, 0, 0]), 2.0);
}

/// A file of 2x1x1 points and cells with these attributes and arrays.
fn arrays(points: &str, cells: &str) -> Source {
    let text = format!(
        r#"<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 0 0 0"><Piece><PointData {points}</PointData>
        <CellData {cells}</CellData></Piece></ImageData></VTKFile>"#
    );
    Source::from_bytes(Path::new("x.vti"), text.into_bytes())
}

fn array(name: &str, components: usize, values: &str) -> String {
    format!(
        r#"<DataArray type="Int8" Name="{name}" NumberOfComponents="{components}" format="ascii">{values}</DataArray>"#
    )
}

#[test]
fn ghosts_are_no_data_and_scalars_come_before_vectors() {
    let ghost = array("vtkGhostType", 1, "0 0");
    let (vector, scalar) = (array("v", 3, "1 2 3 4 5 6"), array("t", 1, "7 8"));
    let shown = |points: String| {
        let volume = parse(&arrays(&points, ">")).unwrap();
        (volume.contents().array_name().map(str::to_owned), volume.value([1, 0, 0]))
    };
    assert_eq!(shown(format!(">{ghost}{vector}{scalar}")), (Some("t".into()), 8.0));
    assert_eq!(shown(format!("Scalars=\"v\">{ghost}{scalar}{vector}")), (Some("v".into()), 4.0));
    assert_eq!(shown(format!("Scalars=\"vtkGhostType\">{ghost}{vector}")), (Some("v".into()), 4.0));
    let cells = arrays(&format!(">{ghost}"), &format!(">{}", array("c", 1, "9")));
    assert_eq!(parse(&cells).unwrap().value([0; 3]), 9.0);
}

#[test]
fn arrays_and_components_are_chosen() {
    let source = arrays(&format!(">{}{}", array("v", 3, "1 2 3 4 5 6"), array("t", 1, "7 8")), ">");
    let read = |array: &str, component: usize| {
        let overrides =
            Overrides { array: Some(array.into()), component: Some(component), ..Overrides::default() };
        crate::volume::parse(&source, &overrides)
    };
    let volume = read("v", 2).unwrap();
    assert_eq!([volume.value([0, 0, 0]), volume.value([1, 0, 0])], [3.0, 6.0]);
    assert_eq!((volume.contents().components, volume.contents().component), (3, 2));
    assert!(read("v", 3).unwrap_err().to_string().ends_with("it has 3 components, 0 to 2"));
    assert!(read("x", 0).unwrap_err().to_string().ends_with("--array x is not there; it has v, t"));
}

#[test]
fn broken_files_are_one_line_errors() {
    let base = |bytes: &[u8]| format!("format=\"binary\">{}", base64(bytes));
    let zlib = r#"compressor="vtkZLibDataCompressor""#;
    let lz4 = r#"compressor="vtkLZ4DataCompressor""#;
    let cases = [
        ("no array text", file("", "format=\"binary\">", b"")),
        ("too few numbers", file("", "format=\"ascii\">1 2 3", b"")),
        ("no numbers", file("", "format=\"ascii\">1 2 3 x", b"")),
        ("no base64", file("", "format=\"binary\">****", b"")),
        ("short array", file("", &base(&[&words(&[6]), LITTLE].concat()), b"")),
        ("cut array", file("", &base(&[&words(&[8]), &LITTLE[..5]].concat()), b"")),
        ("no appended data", file("", r#"format="appended" offset="0">"#, b"")),
        ("no mark", file("", r#"format="appended" offset="0">"#, b"<AppendedData encoding=\"raw\">")),
        ("offset", file("", r#"format="appended" offset="99">"#, b"<AppendedData encoding=\"raw\">_")),
        ("overflow", file("", &format!(r#"format="appended" offset="{}">"#, usize::MAX), b"<AppendedData>_")),
        ("components", file("", &format!(r#"NumberOfComponents="{}" format="ascii">1"#, usize::MAX), b"")),
        ("no components", file("", r#"NumberOfComponents="0" format="ascii">1"#, b"")),
        ("many blocks", file(zlib, &base(&words(&[u32::MAX, 1, 1, 1])), b"")),
        ("long block", file(zlib, &base(&words(&[1, u32::MAX, 0, u32::MAX])), b"")),
        ("bad block", file(zlib, &base(&words(&[1, 8, 0, 4, 1])), b"")),
        ("endless LZ4", file(lz4, &base(&words(&[1, u32::MAX, 0, 4, 1])), b"")),
        ("no blocks", file(zlib, &base(&words(&[0, 0, 0])), b"")),
        ("LZMA", file(r#"compressor="vtkLZMADataCompressor""#, "format=\"ascii\">1", b"")),
        ("tags", file("", "format=\"ascii\"></b>", b"")),
        ("empty", Source::from_bytes(Path::new("x.vti"), vec![])),
        ("other data", Source::from_bytes(Path::new("x.vti"), b"<VTKFile type='PolyData'>".to_vec())),
        ("binary", Source::from_bytes(Path::new("x.vti"), vec![0xFF; 9])),
    ];
    for (what, source) in cases {
        let error = parse(&source).err().unwrap_or_else(|| panic!("{what} was read")).to_string();
        assert!(error.starts_with("x.vti: ") && !error.contains('\n'), "{what}: {error}");
    }
}

#[test]
fn extents_cannot_overflow() {
    for extent in
        ["0 9223372036854775807 0 0 0 0", "-9223372036854775808 9223372036854775807 0 0 0 0", "1 0 0 0 0 0"]
    {
        let text = format!(
            r#"<VTKFile type="ImageData"><ImageData WholeExtent="{extent}"><Piece><PointData>
            <DataArray type="Int8" format="ascii">1</DataArray></PointData></Piece></ImageData></VTKFile>"#
        );
        assert!(parse(&Source::from_bytes(Path::new("x.vti"), text.into_bytes())).is_err(), "{extent}");
    }
}

#[test]
fn real_files() {
    let Some(data) = crate::test_data() else { return };
    for (name, dims, dtype, components) in [
        ("vtk_data/vase.vti", [115, 101, 75], Dtype::U8, 1),
        ("vtk_data/hydrogen/hydrogen.vti", [64, 64, 64], Dtype::F32, 1),
        ("vtkio/volume_complex.vti", [3, 4, 6], Dtype::I8, 1),
        ("voreen/results_iT0000000iC00000.vti", [33, 44, 28], Dtype::F32, 3),
        ("voreen/results_iT0001000iC00000.vti", [33, 44, 28], Dtype::F32, 3),
    ] {
        let path = data.join("formats").join(name);
        if !path.is_file() {
            println!("skipped: no {}", path.display());
            continue;
        }
        let volume = read(&path, &Overrides::default()).unwrap();
        assert_eq!(
            (volume.grid().dims(), volume.dtype(), volume.components()),
            (dims, dtype, components),
            "{name}"
        );
    }
}
