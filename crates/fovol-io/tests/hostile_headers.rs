//! Headers made of plausible fields and absurd values, and sound files with bytes changed: always a volume or
//! a one-line error, never a panic, never much memory.

use fovol_io::volume::{Overrides, Source, parse};
use proptest::prelude::*;
use std::path::Path;

/// Values that parsers stumble over.
const VALUES: &[&str] = &[
    "",
    "0",
    "1",
    "-1",
    "3",
    "2 2 2",
    "4 4 4 4",
    "65536 65536 65536",
    "65537 1 1",
    "18446744073709551615",
    "18446744073709551616 1",
    "4294967296 4294967296 4294967296 4294967296",
    "1e308",
    "nan",
    "inf -inf 0",
    "1.5 0 -2",
    "(1,0,0) (0,1,0) (0,0,1)",
    "(1,0,0)",
    "none (1,0,0) (0,1,0) (0,0,1)",
    "(((",
    "vector domain domain domain",
    "list",
    "domain domain list domain",
    "LIST",
    "LIST 2",
    "LOCAL",
    "s%d.raw 0 9223372036854775807 1",
    "%s%s%n 1 2",
    "s%d 5 1 1",
    "/dev/zero",
    ".",
    "..",
    "x",
    "raw",
    "gzip",
    "bzip2",
    "ascii",
    "hex",
    "big",
    "little",
    "uchar",
    "unsigned long long int",
    "double",
    "block",
    "True",
    "False",
    "MET_UCHAR",
    "MET_DOUBLE",
    "MET_SHORT_ARRAY",
    "\u{FFFD}",
    "é × ∞",
];

const NRRD_FIELDS: &[&str] = &[
    "type",
    "dimension",
    "sizes",
    "spacings",
    "space directions",
    "kinds",
    "endian",
    "encoding",
    "data file",
    "line skip",
    "byte skip",
    "space",
    "space origin",
    "# note",
    "key:",
];

const META_FIELDS: &[&str] = &[
    "ObjectType",
    "NDims",
    "DimSize",
    "ElementType",
    "ElementSpacing",
    "ElementSize",
    "ElementNumberOfChannels",
    "HeaderSize",
    "CompressedData",
    "CompressedDataSize",
    "BinaryData",
    "BinaryDataByteOrderMSB",
    "Offset",
    "ElementToIntensityFunctionSlope",
    "ElementToIntensityFunctionOffset",
    "ElementDataFile",
];

const DAT_FIELDS: &[&str] = &[
    "RawFile",
    "ObjectFileName",
    "Resolution",
    "Format",
    "ByteOrder",
    "SliceThickness",
    "ByteOffset",
    "ObjectModel",
];

/// A sound file of each kind.
fn sound() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("a.nrrd", b"NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 1\nspacings: 1 2 3\nencoding: raw\nendian: big\n\n12345678".to_vec()),
        ("b.nrrd", b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 1\nencoding: ascii\n\n1 2 3 4".to_vec()),
        ("c.mha", b"NDims = 3\nDimSize = 2 2 1\nElementType = MET_USHORT\nElementSpacing = 1 1 2\nElementDataFile = LOCAL\n12345678".to_vec()),
        ("d.dat", b"RawFile: gone.raw\nResolution: 2 2 1\nFormat: UINT16\nByteOrder: BigEndian\n".to_vec()),
        ("e.json", br#"{"dims": [2, 2, 1], "dtype": "u8", "spacing": [1, 1, 2], "file": "gone.raw"}"#.to_vec()),
        ("f.ivf", br#"<?xml version="1.0" ?><D><RawFile content="gone.raw" /><Format content="UINT8" /><Dimension x="1" y="2" z="3" /></D>"#.to_vec()),
        ("g.vvd", br#"<V><Volume><RawData filename="gone.raw" format="uint8" x="1" y="2" z="3" /></Volume></V>"#.to_vec()),
        ("h_2x1x1_uint8.raw", b"12".to_vec()),
    ]
}

fn survives(name: &str, bytes: Vec<u8>) {
    let source = Source::from_bytes(Path::new(name), bytes);
    match parse(&source, &Overrides::default()) {
        Ok(volume) => assert!(volume.data().len() <= 1 << 20),
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

fn header(fields: &'static [&'static str], separator: &'static str) -> impl Strategy<Value = String> {
    let line = (prop::sample::select(fields), prop::sample::select(VALUES));
    prop::collection::vec(line, 0..16).prop_map(move |lines| {
        lines.iter().map(|(field, value)| format!("{field}{separator}{value}\n")).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn absurd_nrrd(text in header(NRRD_FIELDS, ": "), data in prop::collection::vec(any::<u8>(), 0..64)) {
        let sound = "type: uchar\nsizes: 2 2 2\nencoding: raw\n";
        survives("x.nrrd", [b"NRRD0004\n", text.as_bytes(), b"\n", &data].concat());
        survives("x.nrrd", [b"NRRD0004\n", text.as_bytes(), sound.as_bytes(), b"\n", &data].concat());
        survives("x.nrrd", [b"NRRD0004\n", sound.as_bytes(), text.as_bytes(), b"\n", &data].concat());
    }

    #[test]
    fn absurd_metaimage(text in header(META_FIELDS, " = "), data in prop::collection::vec(any::<u8>(), 0..64)) {
        let sound = "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n";
        let end = "ElementDataFile = LOCAL\n";
        survives("x.mha", [text.as_bytes(), end.as_bytes(), &data].concat());
        survives("x.mha", [text.as_bytes(), sound.as_bytes(), end.as_bytes(), &data].concat());
        survives("x.mha", [sound.as_bytes(), text.as_bytes(), end.as_bytes(), &data].concat());
    }

    #[test]
    fn absurd_sidecars(text in header(DAT_FIELDS, ": ")) {
        survives("x.dat", text.into_bytes());
    }

    #[test]
    fn changed_bytes(
        which in 0usize..8,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let (name, mut bytes) = sound().swap_remove(which);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        survives(name, bytes);
    }
}

#[test]
fn sound_files_are_sound() {
    for (name, bytes) in sound() {
        let result = parse(&Source::from_bytes(Path::new(name), bytes), &Overrides::default());
        match result {
            Ok(_) => {}
            Err(error) => assert!(error.to_string().contains("gone.raw"), "{error}"),
        }
    }
}

#[test]
fn a_small_bomb_costs_little() {
    use std::io::Write;
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(&vec![0; 64 << 20]).unwrap();
    let packed = packed.finish().unwrap();
    let head = "NDims = 3\nDimSize = 65536 65536 65536\nElementType = MET_DOUBLE\nCompressedData = True\nElementDataFile = LOCAL\n";
    let source = Source::from_bytes(Path::new("x.mha"), [head.as_bytes(), &packed].concat());
    let error = parse(&source, &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("ends before"), "{error}");
}
