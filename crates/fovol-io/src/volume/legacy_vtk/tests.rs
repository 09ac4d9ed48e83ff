use super::*;
use crate::volume::{Overrides, read};
use std::path::Path;

/// Reads `source` without choices.
fn parse(source: &Source) -> Result<Volume> {
    super::parse(source, &Overrides::default())
}

/// A file of 2x1x2 points and these lines.
fn file(kind: &str, rest: &[u8]) -> Source {
    let mut bytes = format!(
        "# vtk DataFile Version 3.0\ntitle\n{kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 2\n\
         ORIGIN 1 2 3\nSPACING 1 0 -2\n"
    )
    .into_bytes();
    bytes.extend_from_slice(rest);
    Source::from_bytes(Path::new("x.vtk"), bytes)
}

#[track_caller]
fn check(source: &Source, dtype: Dtype, components: usize, values: [f64; 4]) -> Volume {
    let volume = parse(source).unwrap();
    let [a, b] = [0, 1].map(|z| [0, 1].map(|x| volume.value([x, 0, z])));
    assert_eq!([a, b].concat(), values);
    assert_eq!((volume.dtype(), volume.components()), (dtype, components));
    assert_eq!(volume.grid().spacing(), [1.0, 1.0, 2.0]);
    volume
}

#[test]
fn text() {
    let scalars = b"POINT_DATA 4\nSCALARS a short\nLOOKUP_TABLE default\n1 -2\n3 4\n";
    let volume = check(&file("ASCII", scalars), Dtype::I16, 1, [1.0, -2.0, 3.0, 4.0]);
    assert_eq!(volume.placement().unwrap().origin().to_array(), [1.0, 2.0, 3.0]);
    let vectors = b"POINT_DATA 4\nVECTORS a float\n1 0 0 2 0 0 3 0 0 4.5 0 0";
    check(&file("ascii", vectors), Dtype::F32, 3, [1.0, 2.0, 3.0, 4.5]);
    let colours = b"POINT_DATA 4\nCOLOR_SCALARS a 1\n0 0.5 1 1";
    check(&file("ASCII", colours), Dtype::U8, 1, [0.0, 128.0, 255.0, 255.0]);
}

#[test]
fn binary_values_are_not_copied() {
    let scalars =
        b"POINT_DATA 4\nSCALARS a unsigned_short 1\nLOOKUP_TABLE default\n\0\x01\0\x02\n\x03\x01\x02";
    let source = file("BINARY", scalars);
    let volume = check(&source, Dtype::U16, 1, [1.0, 2.0, 2563.0, 258.0]);
    assert_eq!(volume.data().as_ptr(), source.bytes()[source.bytes().len() - 8..].as_ptr());
    let bare = b"POINT_DATA 4\nSCALARS a unsigned_char\n\x01\x02\x03\x04";
    check(&file("BINARY", bare), Dtype::U8, 1, [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn points_come_before_cells_and_fields_are_searched() {
    for before in [
        "CELL_DATA 1\nSCALARS c int 1\nLOOKUP_TABLE default\n9\n",
        "FIELD meta 2\ntime 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nname 1 2 int\n1\n2\n",
        "CELL_DATA 1\nFIELD f 1\nc 2 1 float\n8 9\nPOINT_DATA 4\nLOOKUP_TABLE t 1\n0 0 0 1\n",
    ] {
        let rest = format!("{before}\nPOINT_DATA 4\nFIELD f 2\nb 1 1 int\n7\na 1 4 double\n1 2\n3 4\n");
        check(&file("ASCII", rest.as_bytes()), Dtype::F64, 1, [1.0, 2.0, 3.0, 4.0]);
    }
}

#[test]
fn fields_may_come_before_the_size() {
    let field = "FIELD FieldData 2\nTimeValue 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nn 2 1 int\n1 2\nMETADATA\nINFORMATION 0\n\n";
    let text = |field: &str| {
        format!(
            "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET STRUCTURED_POINTS\n{field}DIMENSIONS 2 1 2\nSPACING 1 1 2\n\
             ORIGIN 1 2 3\nPOINT_DATA 4\nSCALARS s int\nLOOKUP_TABLE default\n1 2 3 4\n"
        )
    };
    let source = |field: &str| Source::from_bytes(Path::new("x.vtk"), text(field).into_bytes());
    check(&source(field), Dtype::I32, 1, [1.0, 2.0, 3.0, 4.0]);
    let error = parse(&source("FIELD f 1\na 1 999 int\n")).unwrap_err().to_string();
    assert!(error.contains("its FIELD"), "{error}");
}

#[test]
fn the_active_scalar_comes_before_all_others() {
    let rest = b"POINT_DATA 4\nVECTORS v float\n1 0 0 2 0 0 3 0 0 4 0 0\nFIELD f 2\nvtkGhostType 1 4 unsigned_char\n0 0 0 0\n\
        a%20b 1 4 double\n5 6 7 8\nSCALARS s short\nLOOKUP_TABLE default\n1 -2 3 4\n";
    let source = file("ASCII", rest);
    let volume = check(&source, Dtype::I16, 1, [1.0, -2.0, 3.0, 4.0]);
    assert_eq!(volume.contents().arrays, ["v", "a b", "s"]);
    let chosen = |name: &str| {
        let overrides = Overrides { array: Some(name.into()), ..Overrides::default() };
        super::parse(&source, &overrides)
    };
    assert_eq!(chosen("a b").unwrap().value([1, 0, 1]), 8.0);
    assert_eq!(chosen("v").unwrap().contents().components, 3);
    assert!(chosen("w").unwrap_err().to_string().ends_with("it has v, a b, s"));
}

#[test]
fn damage_behind_an_array_is_noted() {
    let scalars = b"POINT_DATA 4\nSCALARS a short\nLOOKUP_TABLE default\n1 -2\n3 4\nSCALARS b short\nLOOKUP_TABLE default\n1";
    let volume = check(&file("ASCII", scalars), Dtype::I16, 1, [1.0, -2.0, 3.0, 4.0]);
    assert!(volume.notes()[0].contains("it ends before the 4 values"), "{:?}", volume.notes());
}

#[test]
fn cells_where_there_are_no_points() {
    let text = "# vtk DataFile Version 5.1\n\nASCII\nDATASET STRUCTURED_POINTS\nEXTENT 1 3 0 2 4 4\n\
        CELL_DATA 4\nSCALARS c int\nLOOKUP_TABLE default\n1 2 3 4";
    let volume = parse(&Source::from_bytes(Path::new("x.vtk"), text.into())).unwrap();
    assert_eq!((volume.grid().dims(), volume.value([1, 1, 0])), ([2, 2, 1], 4.0));
}

#[test]
fn broken_files_are_one_line_errors() {
    for (what, source) in [
        ("nothing", file("ASCII", b"")),
        ("unknown kind", file("HEX", b"")),
        ("no array", file("ASCII", b"POINT_DATA 4\n")),
        ("array before its section", file("ASCII", b"SCALARS a int\nLOOKUP_TABLE default\n1 2 3 4")),
        ("count", file("ASCII", b"POINT_DATA 5\nSCALARS a int\nLOOKUP_TABLE default\n1 2 3 4 5")),
        ("no count", file("ASCII", b"POINT_DATA\n")),
        ("too few numbers", file("ASCII", b"POINT_DATA 4\nSCALARS a int\nLOOKUP_TABLE default\n1 2 3")),
        ("too few bytes", file("BINARY", b"POINT_DATA 4\nSCALARS a int\nLOOKUP_TABLE default\n123")),
        ("no number", file("ASCII", b"POINT_DATA 4\nSCALARS a int\nLOOKUP_TABLE default\n1 2 3 x")),
        ("bits", file("BINARY", b"POINT_DATA 4\nSCALARS a bit\nLOOKUP_TABLE default\n1")),
        ("unknown line", file("ASCII", b"POINT_DATA 4\nGARBAGE\n")),
        ("no components", file("ASCII", b"POINT_DATA 4\nSCALARS a int 0\n")),
        ("components", file("ASCII", b"POINT_DATA 4\nSCALARS a int 18446744073709551615\n")),
        ("endless field", file("ASCII", b"FIELD f 18446744073709551615\n")),
        ("huge field", file("BINARY", b"FIELD f 1\na 18446744073709551615 2 int\n")),
        ("huge table", file("BINARY", b"POINT_DATA 4\nLOOKUP_TABLE t 18446744073709551615\n")),
        (
            "huge size",
            file("BINARY", b"DIMENSIONS 65536 65536 65536\nPOINT_DATA 281474976710656\nSCALARS a int\n"),
        ),
        ("overflowing size", file("ASCII", b"DIMENSIONS 18446744073709551615 2 2\nPOINT_DATA 0\n")),
        ("overflowing extent", file("ASCII", b"EXTENT -9223372036854775808 9223372036854775807 0 0 0 0\n")),
        ("another kind", file("ASCII", b"DATASET POLYDATA\n")),
        ("another file", Source::from_bytes(Path::new("x.vtk"), b"hello".to_vec())),
    ] {
        let error = parse(&source).err().unwrap_or_else(|| panic!("{what} was read")).to_string();
        assert!(error.starts_with("x.vtk: ") && !error.contains('\n'), "{what}: {error}");
    }
}

#[test]
fn real_files() {
    let Some(data) = crate::test_data() else { return };
    let open = |name: &str| {
        let path = data.join("formats").join(name);
        if !path.is_file() {
            println!("skipped: no {}", path.display());
            return None;
        }
        Some(read(&path, &Overrides::default()))
    };
    if let Some(volume) = open("vtk_data/ironProt.vtk") {
        let volume = volume.unwrap();
        assert_eq!((volume.grid().dims(), volume.dtype()), ([68; 3], Dtype::U8));
    }
    if let Some(volume) = open("vtkio/volume_complex.vtk") {
        let volume = volume.unwrap();
        assert_eq!((volume.grid().dims(), volume.value([1, 2, 2])), ([3, 4, 6], 40.0));
    }
    if let Some(volume) = open("vtkio/rectilinear_grid.vtk") {
        let volume = volume.unwrap();
        assert_eq!((volume.grid().dims(), volume.grid().spacing()), ([2, 3, 1], [2.0, 1.0, 1.0]));
    }
    for name in ["vtkio/structured_grid.vtk", "vtk_data/brainImageSmooth.vtk"] {
        if let Some(refused) = open(name) {
            assert!(refused.unwrap_err().to_string().contains("Resample To Image"), "{name}");
        }
    }
}
