//! Sound hierarchies of Zarr, as texts of several files: each begins with a line `=== NAME`.

use std::fmt::Write;

/// The line before a file.
const MARK: &[u8] = b"=== ";

/// A hierarchy of every version, with every kind of codec.
pub fn all() -> Vec<Vec<u8>> {
    vec![filtered_v2(), fortran_v2(), coordinates_v2(), sharded_v3(), image_v3(), image_v2()]
}

/// The zip archive, not packed, of the files of `text`.
pub fn archive(text: &[u8]) -> Vec<u8> {
    let (mut out, mut directory, mut count) = (Vec::new(), Vec::new(), 0u16);
    for (name, content) in files(text) {
        // Sizes that do not fit belong to no input.
        let numbers = [0, content.len() as u32, content.len() as u32].map(u32::to_le_bytes).concat();
        let lengths = [(name.len() as u16).to_le_bytes(), [0; 2]].concat();
        let offset = (out.len() as u32).to_le_bytes();
        out.extend(
            [b"PK\x03\x04\x14\0\0\0\0\0\0\0\0\0".as_slice(), &numbers, &lengths, name, content].concat(),
        );
        directory.extend(
            [
                b"PK\x01\x02\x14\0\x14\0\0\0\0\0\0\0\0\0".as_slice(),
                &numbers,
                &lengths,
                &[0; 10],
                &offset,
                name,
            ]
            .concat(),
        );
        count += 1;
    }
    let numbers = [directory.len() as u32, out.len() as u32].map(u32::to_le_bytes).concat();
    let counts = [[0; 2], [0; 2], count.to_le_bytes(), count.to_le_bytes()].concat();
    [out, directory, b"PK\x05\x06".to_vec(), counts, numbers, vec![0; 2]].concat()
}

/// Names and contents of the files in `text`.
fn files(text: &[u8]) -> Vec<(&[u8], &[u8])> {
    let is_mark = |at: &usize| text[*at..].starts_with(MARK) && (*at == 0 || text[*at - 1] == b'\n');
    let mut starts: Vec<usize> = (0..text.len()).filter(is_mark).collect();
    starts.push(text.len());
    let file = |pair: &[usize]| {
        let (mut part, is_last) = (&text[pair[0] + MARK.len()..pair[1]], pair[1] == text.len());
        if !is_last {
            part = part.strip_suffix(b"\n").unwrap_or(part);
        }
        let end = part.iter().position(|&byte| byte == b'\n')?;
        Some((&part[..end], &part[end + 1..]))
    };
    starts.windows(2).filter_map(file).collect()
}

/// The text of files.
fn joined(files: &[(&str, &[u8])]) -> Vec<u8> {
    let file = |(name, content): &(&str, &[u8])| [MARK, name.as_bytes(), b"\n", content, b"\n"].concat();
    let mut text = files.iter().flat_map(file).collect::<Vec<u8>>();
    text.pop();
    text
}

fn voxels(count: u16) -> Vec<u8> {
    (0..count).flat_map(|i| (i * 5).to_le_bytes()).collect()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    out.write_all(bytes).expect("memory can be written");
    out.finish().expect("memory can be written")
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![0; zstd_safe::compress_bound(bytes.len())];
    let length = zstd_safe::compress(&mut out[..], bytes, 3).expect("there is room");
    out.truncate(length);
    out
}

/// A chunk of Blosc: `flags` name the compressor, `block` is what it made of `length` bytes.
fn blosc(flags: u8, size: u8, length: usize, block: &[u8]) -> Vec<u8> {
    let numbers = [length, length, 16 + 4 + 4 + block.len(), 20, block.len()];
    let numbers = numbers.map(|number| (number as u32).to_le_bytes()).concat();
    [&[2, 1, flags, size], &numbers[..], block].concat()
}

fn filtered_v2() -> Vec<u8> {
    let metadata = br#"{"zarr_format": 2, "shape": [2, 3, 4], "chunks": [1, 3, 4], "dtype": "<u2", "order": "C", "fill_value": 7,
"compressor": {"id": "zlib", "level": 1}, "filters": [{"id": "delta", "dtype": "<u2", "astype": "<u2"}, {"id": "shuffle", "elementsize": 2}]}"#;
    let chunk = zlib(&[[1; 12], [0; 12]].concat());
    joined(&[(".zarray", metadata), ("0.0.0", &chunk), ("1.0.0", &chunk)])
}

fn fortran_v2() -> Vec<u8> {
    let metadata = br#"{"zarr_format": 2, "shape": [5, 3, 4], "chunks": [2, 3, 4], "dtype": ">f4", "order": "F", "fill_value": "NaN",
"compressor": null, "filters": null, "dimension_separator": "/"}"#;
    joined(&[(".zarray", metadata), (".zattrs", b"{\"resolution\": [3, 2, NaN]}"), ("0/0/0", &voxels(48))])
}

fn coordinates_v2() -> Vec<u8> {
    let array = |shape: &str, dtype: &str, codec: &str| {
        format!(
            r#"{{"zarr_format": 2, "shape": {shape}, "chunks": {shape}, "dtype": "{dtype}", "order": "C", "fill_value": -1, "compressor": {codec}, "filters": null}}"#
        )
    };
    let lz4 = [&48u32.to_le_bytes()[..], &lz4_flex::block::compress(&voxels(24))].concat();
    let positions: Vec<u8> = [0f64, 2.0, 4.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    joined(&[
        (".zgroup", br#"{"zarr_format": 2}"#),
        ("v/.zarray", array("[2, 1, 3, 4]", "<i2", r#"{"id": "lz4"}"#).as_bytes()),
        (
            "v/.zattrs",
            br#"{"_ARRAY_DIMENSIONS": ["time", "z", "y", "x"], "scale_factor": 0.5, "add_offset": 3, "units": "K"}"#,
        ),
        ("v/0.0.0.0", &lz4),
        ("y/.zarray", array("[3]", "<f8", "null").as_bytes()),
        ("y/.zattrs", br#"{"_ARRAY_DIMENSIONS": ["y"], "units": "mm"}"#),
        ("y/0", &positions),
    ])
}

fn sharded_v3() -> Vec<u8> {
    let metadata = br#"{"zarr_format": 3, "node_type": "array", "shape": [2, 3, 4], "data_type": "uint16", "fill_value": 9,
"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [4, 3, 4]}}, "dimension_names": ["z", null, "x"],
"chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}, "attributes": {},
"codecs": [{"name": "sharding_indexed", "configuration": {"chunk_shape": [1, 3, 4], "index_location": "end",
"codecs": [{"name": "transpose", "configuration": {"order": [2, 0, 1]}}, {"name": "bytes", "configuration": {"endian": "big"}}, {"name": "zstd", "configuration": {"level": 0, "checksum": false}}],
"index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}]}}]}"#;
    let chunk = zstd(&voxels(12));
    let entry = |place: u64, length: u64| [place.to_le_bytes(), length.to_le_bytes()].concat();
    let length = chunk.len() as u64;
    let none = entry(u64::MAX, u64::MAX);
    let shard = [&chunk[..], &entry(0, length), &none, &entry(0, length), &none].concat();
    joined(&[("zarr.json", metadata), ("c/0/0/0", &shard)])
}

/// An array of version 3 of `shape`, in one chunk of Blosc.
fn array_v3(shape: &str) -> String {
    format!(
        r#"{{"zarr_format": 3, "node_type": "array", "shape": {shape}, "data_type": "uint16", "fill_value": 0,
"chunk_grid": {{"name": "regular", "configuration": {{"chunk_shape": {shape}}}}},
"chunk_key_encoding": {{"name": "v2"}}, "codecs": [{{"name": "bytes", "configuration": {{"endian": "little"}}}}, "blosc"]}}"#
    )
}

fn image_v3() -> Vec<u8> {
    let group = br##"{"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"version": "0.5", "multiscales": [{"axes": [
{"name": "c", "type": "channel"}, {"name": "z", "type": "space", "unit": "micrometer"}, {"name": "y", "type": "space", "unit": "nanometer"}, {"name": "x", "type": "space"}],
"datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 2, 500, 0.25]}, {"type": "translation", "translation": [0, 1, 2, 3]}]}, {"path": "1"}],
"coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1, 2]}]}],
"omero": {"channels": [{"label": "DAPI", "color": "0000FF", "active": true, "window": {"min": 0, "max": 99, "start": 5, "end": 60}}, {"label": "GFP"}]}}}}"##;
    let labels = br#"{"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"labels": ["a"]}}}"#;
    let label = br#"{"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"multiscales": [{"axes": ["z", "y", "x"], "datasets": [{"path": "0"}]}],
"image-label": {"colors": [{"label-value": 1, "rgba": [255, 0, 9, 255]}], "properties": [{"label-value": 1, "class": "cell"}]}}}}"#;
    let values = voxels(48);
    let lz4 = blosc(1 << 5 | 16 | 1, 2, values.len(), &lz4_flex::block::compress(&values));
    // One literal, repeated.
    let blosclz = blosc(16, 2, 24, &[0, 7, 7 << 5, 14, 0]);
    joined(&[
        ("zarr.json", group),
        ("0/zarr.json", array_v3("[2, 2, 3, 4]").as_bytes()),
        ("0/0.0.0.0", &lz4),
        ("1/zarr.json", array_v3("[2, 1, 2, 3]").as_bytes()),
        ("1/0.0.0.0", &blosclz),
        ("labels/zarr.json", labels),
        ("labels/a/zarr.json", label),
        ("labels/a/0/zarr.json", array_v3("[1, 3, 4]").as_bytes()),
        ("labels/a/0/0.0.0", &blosclz),
    ])
}

fn image_v2() -> Vec<u8> {
    let metadata = br#"{"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 4], "dtype": "<u2", "order": "C", "fill_value": 0,
"compressor": {"id": "blosc", "cname": "zstd", "clevel": 5, "shuffle": 2, "blocksize": 0}, "filters": null}"#;
    let chunk = blosc(4 << 5 | 16 | 4, 2, 48, &zstd(&voxels(24)));
    let mut attributes = String::from(r#"{"multiscales": [{"version": "0.4", "axes": ["#);
    for name in ["z", "y", "x"] {
        let separator = if name == "z" { "" } else { ", " };
        write!(attributes, r#"{separator}{{"name": "{name}", "type": "space", "unit": "angstrom"}}"#)
            .expect("memory can be written");
    }
    attributes += r#"], "datasets": [{"path": "s0", "coordinateTransformations": [{"type": "scale", "scale": [4, 2, 1]}]}]}]}"#;
    joined(&[
        (".zgroup", br#"{"zarr_format": 2}"#),
        ("0/.zgroup", br#"{"zarr_format": 2}"#),
        ("0/.zattrs", attributes.as_bytes()),
        ("0/s0/.zarray", metadata),
        ("0/s0/0.0.0", &chunk),
        (".zattrs", br#"{"bioformats2raw.layout": 3}"#),
        ("OME/.zgroup", br#"{"zarr_format": 2}"#),
        ("OME/.zattrs", br#"{"series": ["0"]}"#),
    ])
}
