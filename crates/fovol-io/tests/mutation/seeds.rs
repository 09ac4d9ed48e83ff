//! Sound files of every kind, as small as they can be and still use every feature.

#[cfg(feature = "zarr")]
use super::zarr_files;
use super::{Target, readers, tiff_files, transfer_functions};
use fovol_core::{Grid, Volume};
use fovol_io::volume::write;
use std::io::{Cursor, Read, Write};
use std::path::Path;
use std::sync::OnceLock;

/// Files of DICOM in every encoding, by `tests/reference/dicom.py references`.
macro_rules! dicom_files {
    ($($name:literal)*) => { vec![$(include_bytes!(concat!("../dicom_files/", $name)).to_vec()),*] };
}

/// Voxels of every seed along x, y, z.
const DIMS: [usize; 3] = [4, 3, 2];

/// Every parser and its seeds; what they name as data files is written to `folder`.
pub fn targets(folder: &Path) -> Vec<Target> {
    let voxels = voxels();
    for name in ["v.raw", "s0.raw", "s1.raw"] {
        std::fs::write(folder.join(name), &voxels).expect("the folder can be written");
    }
    for name in ["v.img", "p.img"] {
        std::fs::write(folder.join(name), &voxels).expect("the folder can be written");
    }
    let slices = folder.join("slices");
    std::fs::create_dir_all(&slices).expect("the folder can be written");
    for name in ["s1.png", "s3.png", "s10.png"] {
        std::fs::write(slices.join(name), picture(image::ImageFormat::Png))
            .expect("the folder can be written");
    }
    let target = |name, file, seeds| Target { name, file, seeds, read: readers::volume };
    vec![
        target("raw", "v_4x3x2_uint16.raw.gz", vec![gzip(&voxels), voxels.clone()]),
        target("dat", "v.dat", dat()),
        target("ivf", "v.ivf", vec![IVF.into()]),
        target("vvd", "v.vvd", vec![VVD.into()]),
        target("json", "v.json", vec![JSON.into(), JSON_OF_CATALOGUE.into()]),
        target("nrrd", "v.nrrd", [nrrd(), written(".nrrd")].concat()),
        target("nhdr", "v.nhdr", nhdr()),
        target("metaimage", "v.mha", [metaimage(), written(".mha")].concat()),
        target("nifti", "v.nii", [nifti(), written(".nii")].concat()),
        target("nifti_gz", "v.nii.gz", nifti().iter().map(|seed| gzip(seed)).collect()),
        target("nifti_pair", "p.hdr", nifti_pair()),
        target("vti", "v.vti", [vti(), written(".vti")].concat()),
        target("vtr", "v.vtr", vtk_samples(folder, ".vtr")),
        target("pvti", "v.pvti", vtk_samples(folder, ".pvti")),
        target("vtk", "v.vtk", [vtk(), vtk_samples(folder, ".vtk")].concat()),
        target("tiff", "v.tif", tiff_files::all()),
        target("dicom", "v.dcm", dicom()),
        Target {
            read: readers::folder,
            ..target("dicom_slices", "dicom_slices/s2.dcm", dicom_slices(folder))
        },
        target("npy", "v.npy", samples(".npy")),
        target("npz", "v.npz", samples(".npz")),
        #[cfg(feature = "hdf5")]
        target("hdf5", "v.h5", samples(".h5")),
        #[cfg(feature = "hdf5")]
        target("netcdf", "v.nc", samples(".nc")),
        #[cfg(feature = "zarr")]
        Target { read: readers::zarr, ..target("zarr", "v.zarr.zip", zarr_files::all()) },
        #[cfg(feature = "zarr")]
        target("zarr_zip", "v.ozx", zarr_files::all().iter().map(|text| zarr_files::archive(text)).collect()),
        target("vdb", "v.vdb", packed(".vdb.gz")),
        target("nvdb", "v.nvdb", packed(".nvdb.gz")),
        Target { read: readers::patched_grid, ..target("nvdb_tree", "v.nvdb", patches()) },
        Target { read: readers::file_name, ..target("name", "v", names()) },
        Target { read: readers::folder, ..target("slices", "slices/s2.png", pictures()) },
        Target { read: readers::transfer_function, ..target("tf", "v.tf", transfer_functions::all()) },
        target("any", "v.bin", vec![voxels, b"text".to_vec()]),
    ]
}

fn dicom() -> Vec<Vec<u8>> {
    dicom_files!(
        "implicit_u8/IM0000.dcm" "big_u12/IM0000.dcm" "deflated_u12/IM0000.dcm" "rle_u12/IM0000.dcm" "j2k_u12/IM0000.dcm"
        "bare_implicit/IM0000.dcm" "signed12/IM0000.dcm" "enhanced_slopes.dcm" "enhanced_rle.dcm" "classic_frames.dcm"
        "double.dcm" "dose.dcm" "rgb_planar.dcm" "palette.dcm" "seg_binary.dcm" "seg_labelmap.dcm" "seg_fractional.dcm"
    )
}

/// Slices of one series; the first and the last are written to `folder`.
fn dicom_slices(folder: &Path) -> Vec<Vec<u8>> {
    let slices = folder.join("dicom_slices");
    std::fs::create_dir_all(&slices).expect("the folder can be written");
    let seeds =
        dicom_files!("gap/IM0000.dcm" "gap/IM0001.dcm" "gap/IM0002.dcm" "gap/IM0003.dcm" "tilt/IM0000.dcm");
    for (name, seed) in [("s1.dcm", &seeds[0]), ("s3.dcm", &seeds[1]), ("s4.dcm", &seeds[2])] {
        std::fs::write(slices.join(name), seed).expect("the folder can be written");
    }
    seeds
}

/// 16-bit voxels.
fn voxels() -> Vec<u8> {
    (0..DIMS.iter().product::<usize>() as u16).flat_map(|value| (value * 259).to_le_bytes()).collect()
}

/// Names of bare voxels that say their size, type, byte order and spacing.
fn names() -> Vec<Vec<u8>> {
    [
        "v_20x20x20_uint8.raw",
        "CT-10X20X20.INT16.raw.gz",
        "v_20x10x10_1.5x1.5x3mm_float32_be.raw",
        "v 10x10x10 f64le (big) [2x].bin",
        "20×20×20_i8_lsb_0.5x0.5x1um_12bit.dat",
    ]
    .map(|name| name.as_bytes().to_vec())
    .to_vec()
}

fn picture(format: image::ImageFormat) -> Vec<u8> {
    let pixels = image::GrayImage::from_fn(5, 4, |x, y| image::Luma([(x * 40 + y) as u8]));
    let mut file = Cursor::new(Vec::new());
    image::DynamicImage::from(pixels).write_to(&mut file, format).expect("memory can be written");
    file.into_inner()
}

/// Pictures of every kind that slices may be.
fn pictures() -> Vec<Vec<u8>> {
    [image::ImageFormat::Png, image::ImageFormat::Bmp, image::ImageFormat::Jpeg].map(picture).to_vec()
}

/// A small volume written by our own writer; empty if it does not write files with this `ending`.
fn written(ending: &str) -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().expect("there is a temporary folder");
    let path = folder.path().join(format!("v{ending}"));
    let grid = Grid::new(DIMS, [1.0, 2.0, 0.5]).expect("the grid is sound");
    let values: Vec<f32> = (0..grid.voxels()).map(|i| i as f32 * 0.5 - 1.0).collect();
    let volume = Volume::from_values(grid, values).expect("the volume is sound");
    match write(&volume, &path) {
        Ok(_) => vec![std::fs::read(path).expect("it was just written")],
        Err(_) => vec![],
    }
}

/// Arrays with this `ending` that other programs wrote.
fn samples(ending: &str) -> Vec<Vec<u8>> {
    files("array_files", ending)
}

/// Files of OpenVDB with this `ending`, unpacked. Longer ones would be cut.
fn packed(ending: &str) -> Vec<Vec<u8>> {
    let mut files: Vec<_> = files("vdb_files", ending).iter().map(|file| gunzip(file)).collect();
    files.retain(|file| file.len() <= super::LONGEST);
    files
}

fn gunzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    flate2::read::GzDecoder::new(bytes).read_to_end(&mut out).expect("the file is sound");
    out
}

/// A file of one NanoVDB grid that is not packed.
pub fn plain_grid() -> Vec<u8> {
    static GRID: OnceLock<Vec<u8>> = OnceLock::new();
    let find = || {
        let unpacked = files("vdb_files", ".nvdb.gz").into_iter().map(|file| gunzip(&file));
        unpacked.filter(|file| file[14] == 0).min_by_key(Vec::len).expect("one sample is not packed")
    };
    GRID.get_or_init(find).clone()
}

/// Words of the plain grid with their places: its head, its root and the first node below.
fn patches() -> Vec<Vec<u8>> {
    let grid = plain_grid();
    let places: Vec<usize> = (0..1200).step_by(8).chain((1200..grid.len() - 8).step_by(1 << 9)).collect();
    let patch = |&at: &usize| [&(at as u32).to_le_bytes()[..], &grid[at..at + 8]].concat();
    places.chunks(12).map(|places| places.iter().flat_map(patch).collect()).collect()
}

/// Files of VTK with this `ending`; the pieces of an image are written to `folder`.
fn vtk_samples(folder: &Path, ending: &str) -> Vec<Vec<u8>> {
    for (number, piece) in files("vtk_files", ".vti").iter().enumerate() {
        std::fs::write(folder.join(format!("pieces_{number}.vti")), piece)
            .expect("the folder can be written");
    }
    files("vtk_files", ending)
}

/// Files of `tests/NAME` with this `ending`.
fn files(name: &str, ending: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(name);
    let entries = std::fs::read_dir(folder).expect("the folder is there").flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.retain(|path| path.to_string_lossy().ends_with(ending));
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).expect("the file is there")).collect()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(bytes).and_then(|()| packer.finish()).expect("memory can be written")
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(bytes).and_then(|()| packer.finish()).expect("memory can be written")
}

fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut packer = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    packer.write_all(bytes).and_then(|()| packer.finish()).expect("memory can be written")
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let word =
            group.iter().fold(0u32, |word, &byte| word << 8 | u32::from(byte)) << (8 * (3 - group.len()));
        for digit in 0..4 {
            let shown = DIGITS[(word >> (18 - 6 * digit)) as usize & 63] as char;
            text.push(if digit <= group.len() { shown } else { '=' });
        }
    }
    text
}

fn joined(header: &str, data: &[u8]) -> Vec<u8> {
    [header.as_bytes(), data].concat()
}

const IVF: &str = r#"<?xml version="1.0" ?><InviwoTreeData version="1.0"><RawFile content="v.raw" />
<Format content="UINT16" /><ByteOffset content="0" /><Dimension x="4" y="3" z="2" /><MetaDataMap>
<MetaDataItem type="org.inviwo.BoolMetaData" key="LittleEndian"><MetaData content="1" /></MetaDataItem>
</MetaDataMap></InviwoTreeData>"#;

const VVD: &str = r#"<?xml version="1.0" ?><VoreenData version="1"><Volumes><Volume>
<RawData filename="v.raw" format="uint16" x="4" y="3" z="2"><Paths><paths><item value="v.raw" /></paths></Paths></RawData>
<MetaData><MetaItem name="Spacing" type="Vec3MetaData"><value x="1" y="0.5" z="2" /></MetaItem></MetaData>
</Volume></Volumes></VoreenData>"#;

const JSON: &str = r#"{"file": "v.raw", "dims": [4, 3, 2], "dtype": "u16", "endian": "little", "components": 1, "spacing": [1.0, 2.0, 3.0], "offset": 0}"#;

const JSON_OF_CATALOGUE: &str =
    r#"{"name": "V", "file": "v.raw", "type": "uint16", "size": [4, 3, 2], "spacing": [1, 1, 2]}"#;

fn dat() -> Vec<Vec<u8>> {
    vec![
        b"RawFile: v.raw\nResolution: 4 3 2\nFormat: UINT16\nByteOrder: LittleEndian\nByteOffset: 0\n".to_vec(),
        b"ObjectFileName:\tv.raw\r\nTaggedFileName: ---\r\nResolution:\t4 3 2\r\nSliceThickness:\t1 1 2.5\r\n\
          Format:\tUSHORT_12\r\nObjectModel:\tI\r\n"
            .to_vec(),
        b"RawFile: v.raw\nResolution: 2 3 2\nFormat: Vec2UINT16\n".to_vec(),
    ]
}

fn nrrd() -> Vec<Vec<u8>> {
    let voxels = voxels();
    let header = |fields: &str| {
        format!("NRRD0005\n# note\ntype: ushort\ndimension: 3\nsizes: 4 3 2\nendian: little\n{fields}\n\n")
    };
    let decimal: Vec<String> = (0..24).map(|i| (i * 259).to_string()).collect();
    let hexadecimal: String = voxels.iter().map(|byte| format!("{byte:02x}")).collect();
    let padded = [b"line\nline\n".as_slice(), &voxels].concat();
    vec![
        joined(&header("encoding: raw\nspacings: 1 2 nan"), &voxels),
        joined(&header("encoding: gzip\nspace directions: (1,0,0) (0,2,0) (0,0,0.5)"), &gzip(&voxels)),
        joined(&header("encoding: bzip2\nkinds: domain domain domain\nkey:=value"), &bzip2(&voxels)),
        joined(&header("encoding: ascii"), decimal.join(" ").as_bytes()),
        joined(&header("encoding: hex"), hexadecimal.as_bytes()),
        joined(&header("encoding: raw\nbyte skip: -1"), &padded),
        joined(&header("encoding: raw\nline skip: 2"), &padded),
        joined(&header("encoding: raw\nline skip: 1\nbyte skip: 5"), &padded),
        joined(&header("encoding: gz\nbyte skip: -1"), &gzip(&padded)),
        joined(
            &header(
                "encoding: raw\naxis mins: 0 0 0\naxis maxs: 4 6 1\ncenters: cell cell node\nunits: \"mm\" \"mm\" \"mm\"",
            ),
            &voxels,
        ),
        joined(
            "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 4 3 2 2\nkinds: space space space time\nspace: RAS\n\
             space directions: (1,0,0) (0,2,0) (0,0,3) none\nspace origin: (1,2,3)\nspace units: \"mm\" \"mm\" \"mm\"\n\
             content: a scan\nencoding: raw\n\n",
            &voxels,
        ),
        joined(
            "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 4 3 2\nkinds: vector space space space\n\
             space directions: none (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n",
            &voxels,
        ),
    ]
}

fn nhdr() -> Vec<Vec<u8>> {
    let header = "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 4 3 2\nendian: big\nencoding: raw\n";
    ["data file: v.raw\n", "data file: s%d.raw 0 1 1\n", "data file: LIST\ns0.raw\ns1.raw\n"]
        .map(|line| joined(header, line.as_bytes()))
        .to_vec()
}

fn metaimage() -> Vec<Vec<u8>> {
    let voxels = voxels();
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 2 0.5\n\
        TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementType = MET_USHORT\n";
    let with = |fields: &str, data: &[u8]| joined(&format!("{header}{fields}"), data);
    let packed = zlib(&voxels);
    let size = packed.len();
    vec![
        with("BinaryData = True\nBinaryDataByteOrderMSB = False\nElementDataFile = LOCAL\n", &voxels),
        with(
            &format!("CompressedData = True\nCompressedDataSize = {size}\nElementDataFile = LOCAL\n"),
            &packed,
        ),
        with("BinaryData = False\nElementDataFile = LOCAL\n", "7 ".repeat(24).as_bytes()),
        with("HeaderSize = -1\nElementDataFile = v.raw\n", b""),
        with("ElementDataFile = s%d.raw 0 1 1\n", b""),
        with("ElementDataFile = LIST\ns0.raw\ns1.raw\n", b""),
        joined(
            "NDims = 2\nDimSize = 4 3\nElementNumberOfChannels = 4\nElementType = MET_UCHAR_ARRAY\n\
             ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1\nElementDataFile = LOCAL\n",
            &voxels,
        ),
    ]
}

/// A NIfTI-1 header (348 bytes) of 4x3x2 voxels and the four bytes of no extensions.
fn nifti1(datatype: i16, bits: i16, magic: &[u8; 4], is_big: bool) -> Vec<u8> {
    let mut header = vec![0u8; 352];
    let mut put = |at: usize, bytes: &[u8]| {
        header[at..at + bytes.len()].copy_from_slice(bytes);
        if is_big {
            header[at..at + bytes.len()].reverse();
        }
    };
    put(0, &348i32.to_le_bytes());
    for (axis, size) in [3i16, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * axis, &size.to_le_bytes());
    }
    put(70, &datatype.to_le_bytes());
    put(72, &bits.to_le_bytes());
    for axis in 0..8 {
        put(76 + 4 * axis, &1.5f32.to_le_bytes());
    }
    let offset = if magic == b"n+1\0" { 352f32 } else { 0.0 };
    put(108, &offset.to_le_bytes());
    put(112, &2f32.to_le_bytes());
    put(116, &(-1f32).to_le_bytes());
    put(252, &1i16.to_le_bytes());
    put(254, &1i16.to_le_bytes());
    header[344..348].copy_from_slice(magic);
    header
}

fn nifti2() -> Vec<u8> {
    let mut header = vec![0u8; 544];
    header[..4].copy_from_slice(&540i32.to_le_bytes());
    header[4..12].copy_from_slice(b"n+2\0\r\n\x1a\n");
    header[12..14].copy_from_slice(&512i16.to_le_bytes());
    header[14..16].copy_from_slice(&16i16.to_le_bytes());
    for (axis, size) in [3i64, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        header[16 + 8 * axis..24 + 8 * axis].copy_from_slice(&size.to_le_bytes());
        header[104 + 8 * axis..112 + 8 * axis].copy_from_slice(&1f64.to_le_bytes());
    }
    header[168..176].copy_from_slice(&544i64.to_le_bytes());
    header[176..184].copy_from_slice(&1f64.to_le_bytes());
    header
}

fn nifti() -> Vec<Vec<u8>> {
    let voxels = voxels();
    let rgb = [voxels.as_slice(), &voxels].concat();
    vec![
        [nifti1(512, 16, b"n+1\0", false), voxels.clone()].concat(),
        [nifti1(4, 16, b"n+1\0", true), voxels.clone()].concat(),
        [nifti1(128, 24, b"n+1\0", false), rgb].concat(),
        [nifti1(32, 64, b"n+1\0", false), voxels.repeat(4)].concat(),
        [nifti2(), voxels].concat(),
    ]
}

fn nifti_pair() -> Vec<Vec<u8>> {
    vec![nifti1(512, 16, b"ni1\0", false), nifti1(2, 8, b"ni1\0", true), nifti1(4, 16, b"\0\0\0\0", false)]
}

/// One `DataArray` in an image, with what follows it.
fn image_data(attributes: &str, array: &str, content: &str, tail: &str) -> Vec<u8> {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\"{attributes}>\n\
         <ImageData WholeExtent=\"0 3 0 2 0 1\" Origin=\"0 0 0\" Spacing=\"1 2 0.5\">\n<Piece Extent=\"0 3 0 2 0 1\">\n\
         <PointData Scalars=\"v\">\n<DataArray type=\"UInt16\" Name=\"v\" {array}>\n{content}\n</DataArray>\n</PointData>\n\
         <CellData>\n</CellData>\n</Piece>\n</ImageData>\n{tail}</VTKFile>\n"
    )
    .into_bytes()
}

/// The table of compressed blocks: their number, the size of a block, of the last, and of each when packed.
fn blocks(sizes: [usize; 3], packed: usize, is_wide: bool) -> Vec<u8> {
    [sizes.as_slice(), &[packed]]
        .concat()
        .into_iter()
        .flat_map(|size| size.to_le_bytes()[..if is_wide { 8 } else { 4 }].to_vec())
        .collect()
}

fn vti() -> Vec<Vec<u8>> {
    let voxels = voxels();
    let size = voxels.len();
    let narrow = [&(size as u32).to_le_bytes(), voxels.as_slice()].concat();
    let wide = [&(size as u64).to_le_bytes(), voxels.as_slice()].concat();
    let (packed, lz4) = (zlib(&voxels), lz4_flex::block::compress(&voxels));
    let zlib_table = blocks([1, size, 0], packed.len(), false);
    let lz4_table = blocks([1, size, 0], lz4.len(), true);
    let inline = |table: &[u8], data: &[u8]| base64(table) + &base64(data);
    let appended = |encoding: &str, data: &[u8]| {
        let start = format!("<AppendedData encoding=\"{encoding}\">\n_");
        let at_end = image_data(" header_type=\"UInt32\"", "format=\"appended\" offset=\"0\"", "", "@");
        let text = String::from_utf8(at_end).expect("it is text");
        let (before, after) = text.split_once('@').expect("the mark is there");
        [before.as_bytes(), start.as_bytes(), data, b"\n</AppendedData>\n", after.as_bytes()].concat()
    };
    let decimal: Vec<String> = (0..24).map(|i| i.to_string()).collect();
    let compressor = |name: &str, header: &str| format!(" compressor=\"{name}\" header_type=\"{header}\"");
    vec![
        image_data("", "format=\"ascii\" RangeMin=\"0\" RangeMax=\"23\"", &decimal.join(" "), ""),
        image_data(" header_type=\"UInt64\"", "format=\"binary\"", &base64(&wide), ""),
        image_data("", "format=\"binary\"", &base64(&narrow), ""),
        image_data(
            &compressor("vtkZLibDataCompressor", "UInt32"),
            "format=\"binary\"",
            &inline(&zlib_table, &packed),
            "",
        ),
        image_data(
            &compressor("vtkLZ4DataCompressor", "UInt64"),
            "format=\"binary\" NumberOfComponents=\"1\"",
            &inline(&lz4_table, &lz4),
            "",
        ),
        image_data(&compressor("vtkLZMADataCompressor", "UInt32"), "format=\"binary\"", "AAAA", ""),
        appended("base64", base64(&narrow).as_bytes()),
        appended("raw", &narrow),
        arrays_and_marks(),
    ]
}

/// Several arrays of points and of cells, marks of ghosts among them, in a turned image.
fn arrays_and_marks() -> Vec<u8> {
    let decimal = |count: usize| (0..count).map(|i| (i % 8).to_string()).collect::<Vec<_>>().join(" ");
    let array = |kind: &str, name: &str, components: usize, count: usize| {
        let text = decimal(components * count);
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">{text}</DataArray>"
        )
    };
    let points = [
        array("UInt8", "vtkGhostType", 1, 24),
        array("Float32", "velocity", 3, 24),
        array("Int16", "t&amp;p", 1, 24),
        array("Float64", "density", 1, 24),
    ]
    .concat();
    let cells = [array("Int32", "density", 1, 6), array("UInt8", "vtkGhostType", 1, 6)].concat();
    format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"-1 2 0 2 4 5\" Origin=\"1 2 3\" Spacing=\"1 2 0.5\" \
         Direction=\"0 1 0 1 0 0 0 0 -1\"><Piece Extent=\"-1 2 0 2 4 5\"><PointData Scalars=\"density\" Vectors=\"velocity\">\
         {points}</PointData><CellData Scalars=\"density\">{cells}</CellData></Piece></ImageData></VTKFile>"
    )
    .into_bytes()
}

fn vtk() -> Vec<Vec<u8>> {
    let header = |kind: &str| {
        format!(
            "# vtk DataFile Version 3.0\ntitle\n{kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nORIGIN 0 0 0\n\
             SPACING 1 2 0.5\nPOINT_DATA 24\n"
        )
    };
    let decimal: Vec<String> = (0..72).map(|i| i.to_string()).collect();
    let scalars = "SCALARS v unsigned_short 1\nLOOKUP_TABLE default\n";
    vec![
        joined(&(header("ASCII") + scalars), decimal[..24].join(" ").as_bytes()),
        joined(&(header("BINARY") + scalars), &voxels()),
        joined(&(header("ASCII") + "VECTORS v float\n"), decimal.join(" ").as_bytes()),
        joined(&(header("ASCII") + "FIELD f 1\nv 1 24 double\n"), decimal[..24].join(" ").as_bytes()),
        joined(&(header("BINARY") + "COLOR_SCALARS v 2\n"), &voxels()),
        joined(
            "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nFIELD FieldData 1\nTimeValue 1 1 double\n0.5\n\
             METADATA\nINFORMATION 0\n\nDIMENSIONS 4 3 1\nPOINT_DATA 12\nSCALARS v int\n",
            b"1 2 3 4 5 6 7 8 9 10 11 12\n",
        ),
        joined(
            &(header("ASCII")
                + "METADATA\nINFORMATION 0\n\nFIELD f 2\na%20b 1 24 int\n"
                + &decimal[..24].join(" ")),
            format!("\nc 1 2 double\n1 2\nCELL_DATA 6\n{scalars}1 2 3 4 5 6\n").as_bytes(),
        ),
    ]
}
