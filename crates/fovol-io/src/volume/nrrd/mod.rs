//! NRRD, "nearly raw raster data": <https://teem.sourceforge.net/nrrd/format.html>.

mod axes;
mod header;
mod space;
mod write;

use super::decompress::Compression;
use super::layout::{Layout, dims_of, placed, spacing_of};
use super::payload::{Blocks, Encoding, Files, Payload, Skip};
use super::{Overrides, Source, series};
use crate::Result;
use axes::Axes;
use fovol_core::{Contents, Dtype, Endian, Volume};
use header::Header;
pub use write::write;

/// Reads an NRRD file, attached (`.nrrd`) or detached (`.nhdr`).
///
/// # Errors
/// A damaged header, missing data files, too few bytes.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let header = Header::parse(source)?;
    let axes = Axes::of(source, &header)?;
    let (dims, _) = dims_of(&axes.sizes);
    let (contents, blocks) = contents(source, &header, &axes, overrides)?;
    let layout = Layout {
        dims,
        spacing: spacing_of(&axes.spacings),
        dtype: dtype(source, &header)?,
        endian: endian(source, &header)?,
        components: axes.components,
    };
    let payload = Payload {
        files: files(source, &header)?,
        encoding: encoding(source, &header)?,
        line_skip: line_skip(source, &header)?,
        byte_skip: byte_skip(source, &header)?,
    };
    let volume = payload.volume(source, layout, blocks)?.with_format("NRRD").with_contents(contents);
    let volume = axes.notes.iter().fold(volume, Volume::with_note);
    let placement = space::placement(source, &header, &axes)?;
    Ok(placed(volume, placement, space::units(&header).as_deref()))
}

/// Lists the contents of the file, and selects the block of x, y and z to read.
///
/// # Errors
/// Sizes that are 0 or overflow; a time point or component out of range.
fn contents(
    source: &Source,
    header: &Header,
    axes: &Axes,
    overrides: &Overrides,
) -> Result<(Contents, Blocks)> {
    let product = |sizes: &[usize]| sizes.iter().try_fold(1usize, |product, &size| product.checked_mul(size));
    let count =
        product(axes.sizes.get(3..).unwrap_or_default()).and_then(|count| count.checked_mul(axes.planes));
    let count = count
        .filter(|&count| count > 0)
        .ok_or_else(|| source.malformed("its NRRD sizes are too large, or 0"))?;
    let times = count / axes.planes;
    let time = overrides.time_of(source, times)?;
    let component = if axes.planes > 1 { overrides.component_of(source, axes.planes)? } else { 0 };
    let name = source.path().file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let contents = Contents {
        arrays: header.get("content").map(str::to_owned).into_iter().collect(),
        times,
        time,
        components: axes.components.max(axes.planes),
        component,
        are_colours: axes.are_colours,
        // Slicer keeps the names of labels in fields of the header.
        are_labels: name.ends_with(".seg.nrrd") || header.key("segment0_id").is_some(),
        ..Contents::default()
    };
    Ok((contents, Blocks { count, index: component * times + time }))
}

fn dtype(source: &Source, header: &Header) -> Result<Dtype> {
    let text = header.get("type").ok_or_else(|| source.malformed("its NRRD header has no type"))?;
    let name = text.to_ascii_lowercase();
    if name == "block" {
        return Err(source.unsupported("its NRRD type is block; convert it to numbers"));
    }
    let unsigned = name.contains("unsigned");
    let words: Vec<&str> = name.split_whitespace().filter(|w| !matches!(*w, "signed" | "unsigned")).collect();
    let signed = match words.as_slice() {
        ["short", "int"] => "int16",
        ["long", "long"] | ["long", "long", "int"] | ["longlong"] => "int64",
        ["ulonglong"] => "uint64",
        [] => "int32",
        [word] => word.trim_end_matches("_t"),
        _ => name.as_str(),
    };
    let full = if unsigned && !signed.starts_with('u') { format!("u{signed}") } else { signed.to_owned() };
    full.parse().map_err(|problem: String| source.malformed(format!("its NRRD type: {problem}")))
}

fn endian(source: &Source, header: &Header) -> Result<Endian> {
    let parsed = header.get("endian").map(str::parse).transpose();
    let parsed = parsed.map_err(|problem: String| source.malformed(format!("its NRRD endian: {problem}")))?;
    Ok(parsed.unwrap_or_default())
}

fn encoding(source: &Source, header: &Header) -> Result<Encoding> {
    Ok(match header.get("encoding").unwrap_or("raw").to_ascii_lowercase().as_str() {
        "raw" => Encoding::Bare,
        "gz" | "gzip" => Encoding::Compressed(Compression::Gzip),
        "bz2" | "bzip2" => Encoding::Compressed(Compression::Bzip2),
        "txt" | "text" | "ascii" => Encoding::Decimal,
        "hex" => Encoding::Hexadecimal,
        other => {
            let shown = other.escape_debug();
            return Err(source.unsupported(format!(
                "its NRRD encoding `{shown}` is not read; save it as raw or gzip, with `unu save` for one"
            )));
        }
    })
}

fn line_skip(source: &Source, header: &Header) -> Result<usize> {
    let text = header.get("lineskip").unwrap_or("0");
    text.parse().map_err(|_| source.malformed("the line skip of its NRRD header is no whole number"))
}

fn byte_skip(source: &Source, header: &Header) -> Result<Skip> {
    match header.get("byteskip").unwrap_or("0") {
        "-1" => Ok(Skip::UpToTheLast),
        text => text
            .parse()
            .map(Skip::Bytes)
            .map_err(|_| source.malformed("the byte skip of its NRRD header is no whole number and not -1")),
    }
}

fn files(source: &Source, header: &Header) -> Result<Files> {
    let Some(text) = header.get("datafile") else {
        let end = header.end.ok_or_else(|| {
            source.malformed("its NRRD header does not end; an empty line must part it from the data")
        })?;
        return Ok(Files::Attached(end));
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.first() == Some(&"LIST") {
        return Ok(Files::Detached(header.listed.clone()));
    }
    if series::is_pattern(&words) {
        let number = |i: usize| words.get(i).and_then(|word| word.parse::<i64>().ok());
        if let (Some(first), Some(last), Some(step)) = (number(1), number(2), number(3)) {
            return Ok(Files::Detached(series::expand(source, words[0], first, last, step)?));
        }
        return Err(source.malformed("its NRRD data file pattern wants three numbers: first, last, step"));
    }
    Ok(Files::Detached(vec![text.to_owned()]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parse(source: &Source) -> Result<Volume> {
        super::parse(source, &Overrides::default())
    }

    fn read(text: &[u8]) -> Result<Volume> {
        parse(&Source::from_bytes(Path::new("x.nrrd"), text.to_vec()))
    }

    fn types(name: &str) -> Result<Dtype> {
        let text = format!("NRRD0004\ntype: {name}\n\n");
        let source = Source::from_bytes(Path::new("x.nrrd"), text.into_bytes());
        dtype(&source, &Header::parse(&source)?)
    }

    #[test]
    fn types_have_many_names() {
        for (dtype, names) in [
            (Dtype::I8, &["signed char", "int8", "int8_t"][..]),
            (Dtype::U8, &["uchar", "unsigned char", "uint8", "uint8_t"]),
            (Dtype::I16, &["short", "short int", "signed short", "signed short int", "int16", "int16_t"]),
            (Dtype::U16, &["ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"]),
            (Dtype::I32, &["int", "signed int", "int32", "int32_t"]),
            (Dtype::U32, &["uint", "unsigned int", "uint32", "uint32_t"]),
            (Dtype::I64, &["longlong", "long long", "long long int", "signed long long int", "int64_t"]),
            (Dtype::U64, &["ulonglong", "unsigned long long", "unsigned long long int", "uint64"]),
            (Dtype::F32, &["float"]),
            (Dtype::F64, &["double"]),
        ] {
            for name in names {
                assert_eq!(types(name).unwrap(), dtype, "{name}");
            }
        }
        assert!(types("block").is_err() && types("complex").is_err());
    }

    #[test]
    fn bare_voxels_are_not_copied() {
        let text = b"NRRD0001\ntype: ushort\nsizes: 2 1 1\nspacings: 2 nan 1\nendian: big\nencoding: raw\n\n\0\x01\0\x02";
        let source = Source::from_bytes(Path::new("x.nrrd"), text.to_vec());
        let volume = parse(&source).unwrap();
        assert_eq!(volume.data().as_ptr(), source.bytes()[text.len() - 4..].as_ptr());
        assert_eq!(volume.value([1, 0, 0]), 2.0);
        assert_eq!(volume.grid().spacing(), [2.0, 1.0, 1.0]);
    }

    #[test]
    fn text_and_hexadecimal_voxels() {
        let volume = read(b"NRRD0001\ntype: short\nsizes: 3\nencoding: txt\n\n-1 0\n7").unwrap();
        assert_eq!(volume.grid().dims(), [3, 1, 1]);
        assert_eq!(volume.statistics().min, -1.0);
        let volume =
            read(b"NRRD0001\ntype: short\nsizes: 2\nencoding: hex\nendian: big\n\n00 01 FFFF").unwrap();
        assert_eq!([volume.value([0, 0, 0]), volume.value([1, 0, 0])], [1.0, -1.0]);
    }

    #[test]
    fn patterns_and_lists_name_many_files() {
        let folder = tempfile::tempdir().unwrap();
        for (name, byte) in [("s01", 1u8), ("s02", 2)] {
            std::fs::write(folder.path().join(name), [byte]).unwrap();
        }
        for files in ["data file: s%02d 1 2 1", "data file: s%02d 1 2 1 2", "data file: LIST 2\ns01\ns02"] {
            let text = format!("NRRD0004\ntype: uchar\nsizes: 1 1 2\nencoding: raw\n{files}\n");
            let volume =
                parse(&Source::from_bytes(&folder.path().join("x.nhdr"), text.into_bytes())).unwrap();
            assert_eq!(volume.data(), [1, 2]);
        }
    }

    #[test]
    fn times_and_components_are_chosen() {
        let read = |kinds: &str, time, component| {
            let text =
                format!("NRRD0004\ntype: uchar\nsizes: 3 1 1 2\nkinds: {kinds}\nencoding: raw\n\n123456");
            let source = Source::from_bytes(Path::new("x.nrrd"), text.into_bytes());
            crate::volume::parse(&source, &Overrides { time, component, ..Overrides::default() })
        };
        let times = "domain domain domain time";
        assert_eq!(read(times, Some(1), None).unwrap().data(), b"456");
        assert!(
            read(times, Some(2), None).unwrap_err().to_string().ends_with("it has 2 time points, 0 to 1")
        );
        let planes = "domain domain domain vector";
        assert_eq!(read(planes, None, Some(1)).unwrap().data(), b"456");
        assert_eq!(read(planes, None, None).unwrap().contents().components, 2);
        let colours = read("RGB-color domain domain domain", None, Some(2)).unwrap();
        assert_eq!(colours.data(), b"36");
        assert!(colours.contents().are_colours && colours.contents().components == 3);
    }

    #[test]
    fn malformed_files_are_one_line_errors() {
        for text in [
            "NRRD0001\n",
            "NRRD0001\ntype: uchar\nsizes: 2 2 2\nencoding: raw\n",
            "NRRD0001\ntype: uchar\nsizes: 2 2 2\nencoding: raw\n\n1234567",
            "NRRD0001\ntype: uchar\nsizes: 65536 65536 65536\nencoding: gzip\n\nnot gzip",
            "NRRD0001\ntype: uchar\nsizes: 99999999999 1 1\nencoding: raw\n\n1",
            "NRRD0001\ntype: uchar\nsizes: 0 1 1\nencoding: raw\n\n1",
            "NRRD0001\ntype: uchar\nsizes: 1 1 1\nencoding: zrl\n\n1",
            "NRRD0001\ntype: uchar\nsizes: 1 1 1\nbyte skip: -2\n\n1",
            "NRRD0001\ntype: uchar\nsizes: 1 1 1\nline skip: x\n\n1",
            "NRRD0001\ntype: short\nsizes: 1 1 1\nendian: middle\n\n12",
            "NRRD0001\ntype: uchar\nsizes: 1 1 1\nspacings: 0 1 1\n\n1",
            "NRRD0001\ntype: uchar\nsizes: 1 1 1\ndata file: gone.raw\n",
            "NRRD0001\ntype: uchar\nsizes: 1 1 1\ndata file: s%d 1 2\n",
            "NRRD0001\ntype: uchar\nsizes: 1 1 1\ndata file: LIST\n",
        ] {
            let error = read(text.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with("x.nrrd: ") && !error.contains('\n'), "{error}");
        }
    }
}
