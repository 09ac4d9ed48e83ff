use super::*;
use crate::volume::{Overrides, read};
use fovol_core::Dtype;
use std::fs;
use std::io::Cursor;
use tiff::encoder::colortype::{self, ColorType};
use tiff::encoder::{Compression, TiffEncoder, TiffValue};

/// Reads `source` without choices.
fn parse(source: &Source) -> Result<Volume> {
    super::parse(source, &Overrides::default())
}

/// A file with these pages of 2x1 pixels.
fn file<C: ColorType>(compression: Compression, pages: &[&[C::Inner]]) -> Source
where
    [C::Inner]: TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression);
    for pixels in pages {
        encoder.write_image::<C>(2, 1, pixels).unwrap();
    }
    Source::from_bytes(Path::new("x.tif"), bytes.into_inner())
}

fn check(source: &Source, dtype: Dtype, components: usize, values: [[f64; 2]; 2]) {
    let volume = parse(source).unwrap();
    assert_eq!((volume.grid().dims(), volume.dtype(), volume.components()), ([2, 1, 2], dtype, components));
    assert_eq!([0, 1].map(|z| [0, 1].map(|x| volume.value([x, 0, z]))), values);
}

#[test]
fn every_type() {
    use Compression::{Lzw, Packbits, Uncompressed};
    let low = [[1.0, 2.0], [3.0, 4.0]];
    let signed = [[-1.0, 2.0], [3.0, 4.0]];
    check(&file::<colortype::Gray8>(Packbits, &[&[1, 2], &[3, 4]]), Dtype::U8, 1, low);
    check(&file::<colortype::Gray16>(Lzw, &[&[1, 2], &[3, 4]]), Dtype::U16, 1, low);
    check(&file::<colortype::Gray32>(Uncompressed, &[&[1, 2], &[3, 4]]), Dtype::U32, 1, low);
    check(&file::<colortype::GrayI8>(Uncompressed, &[&[-1, 2], &[3, 4]]), Dtype::I8, 1, signed);
    check(&file::<colortype::GrayI16>(Lzw, &[&[-1, 2], &[3, 4]]), Dtype::I16, 1, signed);
    check(&file::<colortype::GrayI32>(Uncompressed, &[&[-1, 2], &[3, 4]]), Dtype::I32, 1, signed);
    check(&file::<colortype::Gray32Float>(Lzw, &[&[-1.0, 2.0], &[3.0, 4.0]]), Dtype::F32, 1, signed);
    check(&file::<colortype::Gray64Float>(Uncompressed, &[&[-1.0, 2.0], &[3.0, 4.0]]), Dtype::F64, 1, signed);
    let colours: [&[u8]; 2] = [&[1, 9, 9, 2, 9, 9], &[3, 9, 9, 4, 9, 9]];
    check(&file::<colortype::RGB8>(Uncompressed, &colours), Dtype::U8, 3, low);
}

#[test]
fn folders_are_stacked_in_natural_order() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(read(folder.path(), &Overrides::default()).is_err());
    for (name, value) in [("img10.tif", 10u8), ("img2.TIF", 2), ("img1.tiff", 1)] {
        fs::write(at(name), file::<colortype::Gray8>(Compression::Uncompressed, &[&[value, 0]]).bytes())
            .unwrap();
    }
    fs::write(at("notes.txt"), "no slice").unwrap();
    fs::write(at("._img1.tif"), "no slice either").unwrap();
    let volume = read(folder.path(), &Overrides::default()).unwrap();
    assert_eq!([0, 1, 2].map(|z| volume.value([0, 0, z])), [1.0, 2.0, 10.0]);

    let odd = file::<colortype::Gray16>(Compression::Uncompressed, &[&[1, 2]]);
    fs::write(at("img3.tif"), odd.bytes()).unwrap();
    let error = read(folder.path(), &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("img3.tif") && error.contains("1 x u16"), "{error}");

    let many = file::<colortype::Gray8>(Compression::Uncompressed, &[&[1, 2], &[3, 4]]);
    fs::write(at("img3.tif"), many.bytes()).unwrap();
    let error = read(folder.path(), &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("img3.tif") && error.contains("several pages"), "{error}");
}

#[test]
fn a_folder_of_one_file_is_that_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = file::<colortype::Gray8>(Compression::Uncompressed, &[&[1, 2], &[3, 4]]);
    fs::write(folder.path().join("all.tif"), file.bytes()).unwrap();
    assert_eq!(read(folder.path(), &Overrides::default()).unwrap().grid().dims(), [2, 1, 2]);
}

/// A little-endian file of one page with these tags and no pixels.
fn page(tags: &[(u16, u32)]) -> Source {
    let mut bytes = b"II\x2A\0\x08\0\0\0".to_vec();
    bytes.extend((tags.len() as u16).to_le_bytes());
    for (tag, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(4u16.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    Source::from_bytes(Path::new("x.tif"), bytes)
}

#[test]
fn hostile_pages_are_one_line_errors() {
    let tags = |width, height, bits, photometric| {
        page(&[
            (256, width),
            (257, height),
            (258, bits),
            (259, 1),
            (262, photometric),
            (273, 8),
            (278, height),
            (279, 8),
        ])
    };
    let sound = file::<colortype::Gray8>(Compression::Lzw, &[&[1, 2], &[3, 4]]);
    let cut = Source::from_bytes(Path::new("x.tif"), sound.bytes()[..sound.bytes().len() / 2].to_vec());
    for (what, source) in [
        ("billions of pixels", tags(60000, 60000, 8, 1)),
        ("overflow", tags(u32::MAX, u32::MAX, 64, 1)),
        ("no pixels", tags(0, 5, 8, 1)),
        ("bits", tags(8, 1, 1, 1)),
        ("twelve bits", tags(8, 1, 12, 1)),
        (
            "CMYK",
            page(&[(256, 1), (257, 1), (258, 8), (259, 1), (262, 5), (273, 8), (277, 4), (278, 1), (279, 4)]),
        ),
        ("no tags", page(&[])),
        (
            "only a preview",
            page(&[(254, 1), (256, 1), (257, 1), (258, 8), (259, 1), (262, 1), (273, 8), (279, 1)]),
        ),
        ("cut", cut),
        ("empty", Source::from_bytes(Path::new("x.tif"), vec![])),
    ] {
        let error = parse(&source).err().unwrap_or_else(|| panic!("{what} was read")).to_string();
        assert!(error.starts_with("x.tif: ") && !error.contains('\n'), "{what}: {error}");
        assert!(what != "cut" || error.contains("cut off"), "{error}");
    }
}

#[test]
fn real_files() {
    let Some(data) = crate::test_data() else { return };
    for name in ["vtk_data/beach.tif", "vtk_data/libtiff/test.tif", "vtk_data/ColorCells.tif"] {
        let path = data.join("formats").join(name);
        if !path.is_file() {
            println!("skipped: no {}", path.display());
            continue;
        }
        let volume = read(&path, &Overrides::default()).unwrap();
        assert_eq!(volume.grid().dims()[2], 1, "{name}");
    }
}
