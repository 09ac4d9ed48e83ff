//! MetaImage (`.mha`, `.mhd`): <https://itk.org/Wiki/ITK/MetaIO/Documentation>.

mod write;

use super::affine::Affine;
use super::decompress::Compression;
use super::layout::{Layout, dims_of, placed, spacing_of};
use super::payload::{Blocks, Encoding, Files, Payload, Skip};
use super::{Overrides, Source, series};
use crate::Result;
use fovol_core::{Contents, Dtype, Endian, Placement, Rescale, Space, Volume};
use glam::DVec3;
pub use write::write;

/// A header is shorter than this, a list of many data files included.
const LONGEST_HEADER: usize = 4 << 20;

/// Reads a MetaImage, its voxels in the same file or in others.
///
/// # Errors
/// A damaged header, missing data files, too few bytes.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let header = Header::parse(source)?;
    let sizes = header.sizes(source)?;
    let (dims, volumes) = dims_of(&sizes);
    let volumes = volumes.ok_or_else(|| source.malformed("its DimSize is too large"))?;
    let layout = Layout {
        dims,
        spacing: spacing_of(&header.spacings(source)?),
        dtype: header.dtype(source)?,
        endian: header.endian(),
        components: header.number(source, &["ElementNumberOfChannels"])?.unwrap_or(1),
    };
    let payload = Payload {
        files: header.files(source)?,
        encoding: header.encoding(),
        line_skip: 0,
        byte_skip: header.skip(source)?,
    };
    let time = overrides.time_of(source, volumes)?;
    let contents = Contents {
        arrays: header.get(&["Name"]).map(str::to_owned).into_iter().collect(),
        times: volumes,
        time,
        components: layout.components.max(1),
        ..Contents::default()
    };
    let blocks = Blocks { count: volumes, index: time };
    let volume = payload.volume(source, layout, blocks)?.with_format("MetaImage").with_contents(contents);
    let rescale = Rescale {
        slope: header.number(source, &["ElementToIntensityFunctionSlope"])?.unwrap_or(1.0),
        intercept: header.number(source, &["ElementToIntensityFunctionOffset"])?.unwrap_or(0.0),
    };
    let volume = volume.with_rescale(rescale).map_err(|e| source.malformed(e.to_string()))?;
    let placement = header.placement(source, sizes.len())?;
    Ok(placed(volume, placement, header.get(&["DistanceUnits"])))
}

/// The `Key = Value` lines of a MetaImage, which `ElementDataFile` ends.
struct Header {
    fields: Vec<(String, String)>,
    /// Where the data begins when it is in the same file.
    end: usize,
    /// The lines below `ElementDataFile = LIST`.
    listed: Vec<String>,
}

impl Header {
    fn parse(source: &Source) -> Result<Self> {
        let bytes = &source.bytes()[..source.bytes().len().min(LONGEST_HEADER)];
        let mut header = Self { fields: Vec::new(), end: 0, listed: Vec::new() };
        for (number, line) in bytes.split_inclusive(|&byte| byte == b'\n').enumerate() {
            header.end += line.len();
            let line = String::from_utf8_lossy(line);
            if line.trim().is_empty() || line.starts_with('#') {
                continue;
            }
            let (key, value) = line.split_once(['=', ':']).ok_or_else(|| {
                let shown: String = line.trim().chars().take(40).collect();
                source.malformed(format!(
                    "line {} of its MetaImage header is no `Key = Value`: `{}`",
                    number + 1,
                    shown.escape_debug()
                ))
            })?;
            let (key, value) = (key.trim().to_owned(), value.trim().to_owned());
            let is_last = key == "ElementDataFile";
            let is_list = is_last && value.split_whitespace().next() == Some("LIST");
            header.fields.push((key, value));
            if is_list {
                let text = String::from_utf8_lossy(&bytes[header.end..]);
                let names = text.lines().map(str::trim).filter(|line| !line.is_empty());
                header.listed = names.map(str::to_owned).collect();
            }
            if is_last {
                return Ok(header);
            }
        }
        Err(source.malformed("its MetaImage header has no ElementDataFile, which must end it"))
    }

    /// The value of the first of `keys` that is there: some have two names.
    fn get(&self, keys: &[&str]) -> Option<&str> {
        let find = |key: &&str| self.fields.iter().find(|(name, _)| name == key);
        keys.iter().find_map(find).map(|(_, value)| value.as_str())
    }

    fn is_true(&self, keys: &[&str]) -> bool {
        self.get(keys).is_some_and(|value| matches!(value.as_bytes().first(), Some(b'T' | b't' | b'1')))
    }

    fn number<T: std::str::FromStr>(&self, source: &Source, keys: &[&str]) -> Result<Option<T>> {
        let parse = |text: &str| {
            text.parse().map_err(|_| {
                let shown: String = text.chars().take(40).collect();
                source.malformed(format!(
                    "the {} of its header is no number: `{}`",
                    keys[0],
                    shown.escape_debug()
                ))
            })
        };
        self.get(keys).map(parse).transpose()
    }

    fn sizes(&self, source: &Source) -> Result<Vec<usize>> {
        let text = self.get(&["DimSize"]).ok_or_else(|| source.malformed("its header has no DimSize"))?;
        let mut sizes = text
            .split_whitespace()
            .map(|word| word.parse().map_err(|_| source.malformed("its DimSize is no list of whole numbers")))
            .collect::<Result<Vec<usize>>>()?;
        let axes = self.number(source, &["NDims"])?.unwrap_or(sizes.len());
        if axes == 0 || axes > 10 || sizes.len() < axes {
            return Err(source.malformed(format!("its DimSize has {} sizes for NDims = {axes}", sizes.len())));
        }
        sizes.truncate(axes);
        Ok(sizes)
    }

    fn spacings(&self, source: &Source) -> Result<Vec<f64>> {
        let text = self.get(&["ElementSpacing", "ElementSize"]).unwrap_or_default();
        text.split_whitespace()
            .map(|word| {
                word.parse().map_err(|_| source.malformed("its ElementSpacing is no list of numbers"))
            })
            .collect()
    }

    fn dtype(&self, source: &Source) -> Result<Dtype> {
        let name =
            self.get(&["ElementType"]).ok_or_else(|| source.malformed("its header has no ElementType"))?;
        Ok(match name.strip_suffix("_ARRAY").unwrap_or(name) {
            "MET_CHAR" | "MET_ASCII_CHAR" => Dtype::I8,
            "MET_UCHAR" => Dtype::U8,
            "MET_SHORT" => Dtype::I16,
            "MET_USHORT" => Dtype::U16,
            // MetaIO's long has four bytes on every machine.
            "MET_INT" | "MET_LONG" => Dtype::I32,
            "MET_UINT" | "MET_ULONG" => Dtype::U32,
            "MET_LONG_LONG" => Dtype::I64,
            "MET_ULONG_LONG" => Dtype::U64,
            "MET_FLOAT" => Dtype::F32,
            "MET_DOUBLE" => Dtype::F64,
            other => {
                let shown = other.escape_debug();
                return Err(source.unsupported(format!(
                    "its ElementType `{shown}` is not read; save it with one of MET_UCHAR … MET_DOUBLE"
                )));
            }
        })
    }

    fn endian(&self) -> Endian {
        match self.is_true(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"]) {
            true => Endian::Big,
            false => Endian::Little,
        }
    }

    fn encoding(&self) -> Encoding {
        if self.is_true(&["CompressedData"]) {
            return Encoding::Compressed(Compression::Zlib);
        }
        match self.get(&["BinaryData"]).is_some() && !self.is_true(&["BinaryData"]) {
            true => Encoding::Decimal,
            false => Encoding::Bare,
        }
    }

    fn skip(&self, source: &Source) -> Result<Skip> {
        match self.number::<i64>(source, &["HeaderSize"])? {
            None => Ok(Skip::Bytes(0)),
            Some(-1) => Ok(Skip::UpToTheLast),
            Some(size) => usize::try_from(size)
                .map(Skip::Bytes)
                .map_err(|_| source.malformed("its HeaderSize is below 0 and not -1")),
        }
    }

    fn files(&self, source: &Source) -> Result<Files> {
        let text = self.get(&["ElementDataFile"]).unwrap_or_default();
        let words: Vec<&str> = text.split_whitespace().collect();
        if matches!(text, "LOCAL" | "Local" | "local") {
            return Ok(Files::Attached(self.end));
        }
        if words.first() == Some(&"LIST") {
            return Ok(Files::Detached(self.listed.clone()));
        }
        if series::is_pattern(&words) {
            let number = |i: usize| words.get(i).and_then(|word| word.parse::<i64>().ok());
            let (first, last, step) = (number(1), number(2), number(3).unwrap_or(1));
            let (Some(first), Some(last)) = (first, last) else {
                return Err(source.malformed("its pattern of data files has no first and last number"));
            };
            return Ok(Files::Detached(series::expand(source, words[0], first, last, step)?));
        }
        Ok(Files::Detached(vec![text.to_owned()]))
    }

    /// The numbers of the first of `keys` that is there.
    fn numbers(&self, source: &Source, keys: &[&str]) -> Result<Option<Vec<f64>>> {
        let Some(text) = self.get(keys) else { return Ok(None) };
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let wrong = || source.malformed(format!("the {} of its header is no list of numbers", keys[0]));
        numbers.map(Some).ok_or_else(wrong)
    }

    /// Where the grid lies: each row of the matrix is the direction of an axis. ITK writes no other space than the
    /// patient's, LPS.
    fn placement(&self, source: &Source, axes: usize) -> Result<Option<Placement>> {
        let matrix = self.numbers(source, &["TransformMatrix", "Rotation", "Orientation"])?;
        let offset = self.numbers(source, &["Offset", "Position", "Origin"])?;
        if matrix.is_none() && offset.is_none() {
            return Ok(None);
        }
        let offset = offset.unwrap_or_default();
        let origin = DVec3::from_array(std::array::from_fn(|i| offset.get(i).copied().unwrap_or(0.0)));
        let Some(matrix) = matrix else {
            let steps = [DVec3::X, DVec3::Y, DVec3::Z];
            return Affine { steps, origin }.placement(source, Space::Other).map(Some);
        };
        if matrix.len() != axes * axes {
            return Err(source.malformed(format!(
                "its TransformMatrix has {} numbers for {axes} axes; it needs {}",
                matrix.len(),
                axes * axes
            )));
        }
        let entry = |axis: usize, i: usize| match axis < axes && i < axes {
            true => matrix[axis * axes + i],
            false => f64::from(u8::from(axis == i)),
        };
        let steps = [0, 1, 2].map(|axis| DVec3::new(entry(axis, 0), entry(axis, 1), entry(axis, 2)));
        Affine { steps, origin }.placement(source, Space::Patient).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::path::Path;

    fn parse(source: &Source) -> Result<Volume> {
        super::parse(source, &Overrides::default())
    }

    fn read(text: &[u8]) -> Result<Volume> {
        parse(&Source::from_bytes(Path::new("x.mha"), text.to_vec()))
    }

    #[test]
    fn bare_voxels_are_not_copied() {
        let text = b"NDims = 3\nDimSize = 2 1 1\nElementType = MET_USHORT\nElementSpacing = 1 2 -3\n\
            ElementByteOrderMSB = True\nElementDataFile = LOCAL\n\0\x01\0\x02";
        let source = Source::from_bytes(Path::new("x.mha"), text.to_vec());
        let volume = parse(&source).unwrap();
        assert_eq!(volume.data().as_ptr(), source.bytes()[text.len() - 4..].as_ptr());
        assert_eq!([volume.value([0, 0, 0]), volume.value([1, 0, 0])], [1.0, 2.0]);
        assert_eq!(volume.grid().spacing(), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn compressed_channels_text_and_scaling() {
        let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(&[1, 2, 3, 4, 5, 6]).unwrap();
        let mut text =
            b"NDims = 2\nDimSize = 2 1\nElementType = MET_UCHAR_ARRAY\nElementNumberOfChannels = 3\n\
            CompressedData = True\nElementDataFile = LOCAL\n"
                .to_vec();
        text.extend(packed.finish().unwrap());
        let volume = read(&text).unwrap();
        assert_eq!((volume.components(), volume.value([1, 0, 0])), (3, 4.0));
        let volume = read(
            b"DimSize = 2 1 1\nElementType = MET_FLOAT\nBinaryData = False\nOffset = 1 2 3\n\
              ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = 1\nElementDataFile = LOCAL\n1.5 2\n",
        )
        .unwrap();
        assert_eq!(volume.value([0, 0, 0]), 4.0);
        let placement = volume.placement().unwrap();
        assert_eq!((placement.origin(), placement.space()), (DVec3::new(1.0, 2.0, 3.0), Space::Other));
    }

    #[test]
    fn rows_of_the_matrix_are_directions_of_axes() {
        let header = |lines: &str| {
            read(
                format!("DimSize = 2 1 1\nElementType = MET_UCHAR\n{lines}\nElementDataFile = LOCAL\n12")
                    .as_bytes(),
            )
        };
        let volume = header("NDims = 3\nTransformMatrix = 0 1 0 0 0 1 1 0 0\nOffset = 1 2 3").unwrap();
        let placement = volume.placement().unwrap();
        assert_eq!((placement.letters(), placement.space()), ("PSL".into(), Space::Patient));
        assert_eq!(placement.directions().x_axis, DVec3::Y);
        for wrong in ["TransformMatrix = 1 0 0", "TransformMatrix = 1 0 0 1 0 0 0 0 1", "Offset = a b c"] {
            let error = header(wrong).unwrap_err().to_string();
            assert!(error.starts_with("x.mha: ") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn voxels_in_other_files() {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in [("s1.raw", b"h\x01"), ("s2.raw", b"h\x02")] {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        for files in ["s%d.raw 1 2 1", "s%d.raw 1 2", "LIST\ns1.raw\ns2.raw\n"] {
            for skip in [1, -1] {
                let text = format!(
                    "NDims = 3\nDimSize = 1 1 2\nHeaderSize = {skip}\nElementType = MET_CHAR\nElementDataFile = {files}"
                );
                let source = Source::from_bytes(&folder.path().join("x.mhd"), text.into_bytes());
                assert_eq!(parse(&source).unwrap().statistics().max, 2.0);
            }
        }
    }

    #[test]
    fn malformed_files_are_one_line_errors() {
        let tail = "ElementDataFile = LOCAL\n12345678";
        for text in [
            "NDims = 3",
            "NDims = 3\n\x01\x02\n",
            "DimSize = 2 2 2\nElementDataFile = LOCAL\n12345678",
            &format!("ElementType = MET_UCHAR\n{tail}"),
            &format!("NDims = 3\nDimSize = 2 2\nElementType = MET_UCHAR\n{tail}"),
            &format!("NDims = 0\nDimSize = 2 2\nElementType = MET_UCHAR\n{tail}"),
            &format!("DimSize = 2 2 3\nElementType = MET_UCHAR\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_STRING\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_UCHAR\nElementSpacing = 1 a\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_UCHAR\nElementSpacing = 1 0 1\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_UCHAR\nElementNumberOfChannels = 0\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_UCHAR\nElementNumberOfChannels = -1\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_UCHAR\nElementToIntensityFunctionSlope = 0\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_UCHAR\nHeaderSize = -2\n{tail}"),
            &format!("DimSize = 2 2 2\nElementType = MET_UCHAR\nCompressedData = True\n{tail}"),
            &format!("DimSize = 65536 65536 65536 65536 65536 65536\nElementType = MET_UCHAR\n{tail}"),
            "DimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = gone.raw\n",
            "DimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LIST\n",
        ] {
            let error = read(text.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with("x.mha: ") && !error.contains('\n'), "{error}");
        }
    }
}
