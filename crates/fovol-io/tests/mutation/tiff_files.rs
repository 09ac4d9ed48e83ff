//! Sound TIFF files, with the descriptions of the programs that write stacks.

use std::io::Cursor;
use tiff::TiffResult;
use tiff::encoder::{Compression, DeflateLevel, Rational, TiffEncoder, colortype};
use tiff::tags::{ResolutionUnit, Tag};

type Pages<'a> = TiffEncoder<&'a mut Cursor<Vec<u8>>>;

/// A file of every compression, type and description.
pub fn all() -> Vec<Vec<u8>> {
    let gray16: Vec<u16> = (0..12).map(|i| i * 259).collect();
    let real: Vec<f32> = (0..12).map(|i| i as f32 * 0.5).collect();
    let colour: Vec<u8> = (0..36).collect();
    let bare = [
        pages(Compression::Uncompressed, 2, |file| file.write_image::<colortype::Gray16>(4, 3, &gray16)),
        pages(Compression::Lzw, 3, |file| file.write_image::<colortype::Gray32Float>(4, 3, &real)),
        pages(Compression::Packbits, 1, |file| file.write_image::<colortype::RGB8>(4, 3, &colour)),
        pages(Compression::Deflate(DeflateLevel::Fast), 2, |file| {
            file.write_image::<colortype::Gray8>(4, 3, &colour[..12])
        }),
    ];
    let described = DESCRIPTIONS.iter().map(|&(count, text)| described(count, text));
    bare.into_iter().chain(described).collect()
}

/// A file of `count` pages, each written by `fill`.
fn pages(compression: Compression, count: usize, fill: impl Fn(&mut Pages<'_>) -> TiffResult<()>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder =
        TiffEncoder::new(&mut file).expect("memory can be written").with_compression(compression);
    (0..count).for_each(|_| fill(&mut encoder).expect("memory can be written"));
    file.into_inner()
}

/// A file of `count` pages that `text` describes, and as many planes again behind them.
fn described(count: usize, text: &str) -> Vec<u8> {
    let mut file = pages(Compression::Uncompressed, count, |file| {
        let mut image = file.new_image::<colortype::Gray8>(4, 3)?;
        image.encoder().write_tag(Tag::ImageDescription, text)?;
        image.resolution(ResolutionUnit::Centimeter, Rational { n: 400, d: 3 });
        image.write_data(&[7; 12])
    });
    file.extend([9; 8 * 12]);
    file
}

/// Numbers of pages, and what the first says of all.
const DESCRIPTIONS: &[(usize, &str)] = &[
    (
        4,
        "ImageJ=1.11a\nimages=4\nchannels=2\nslices=2\nhyperstack=true\nmode=grayscale\nspacing=0.3\nunit=\\u00B5m\nloop=false\n",
    ),
    (6, "ImageJ=1.53k\nimages=6\nslices=3\nframes=2\nunit=micron\nspacing=-2.5\nfinterval=0.1\n"),
    (1, "ImageJ=1.11a\nimages=8\nslices=8\nspacing=0.3\nunit=um\n"),
    (4, r#"{"shape": [2, 2, 3, 4], "axes": "CZYX"}"#),
    (2, r#"{"shape": [2, 3, 4]}"#),
    (
        4,
        r#"<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:1"><Image ID="Image:0" Name="a">
<Pixels DimensionOrder="XYCZT" ID="Pixels:0" SizeC="2" SizeT="1" SizeX="4" SizeY="3" SizeZ="2" Type="uint8" PhysicalSizeX="0.5" PhysicalSizeXUnit="nm" PhysicalSizeZ="2">
<Channel ID="Channel:0:0" Name="DAPI" SamplesPerPixel="1"/><Channel ID="Channel:0:1" Name="GFP" SamplesPerPixel="1"/>
<TiffData FirstC="0" FirstT="0" FirstZ="0" IFD="0" PlaneCount="1"><UUID FileName="v.tif">urn:uuid:1</UUID></TiffData>
<TiffData FirstC="1" FirstT="0" FirstZ="0" IFD="1" PlaneCount="3"><UUID FileName="v.tif">urn:uuid:1</UUID></TiffData>
</Pixels></Image></OME>"#,
    ),
    (
        2,
        r#"<OME><Image ID="Image:0"><Pixels DimensionOrder="XYZCT" SizeC="1" SizeT="1" SizeX="4" SizeY="3" SizeZ="2" Type="uint8"><Channel SamplesPerPixel="1"/><TiffData/></Pixels></Image><Image ID="Image:1"/></OME>"#,
    ),
];
