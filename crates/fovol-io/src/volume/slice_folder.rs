//! Image stacks: folders of PNG, JPEG or BMP slices, in the natural order of their names.

use super::layout::Layout;
use super::{Overrides, Source};
use crate::{Error, Result, natural_order};
use fovol_core::{Contents, Dtype, Endian, Volume};
use image::{DynamicImage, ImageDecoder};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// File extensions of supported images.
const ENDINGS: [&str; 4] = [".png", ".jpg", ".jpeg", ".bmp"];

/// Bound on the compression ratio, reached by deflate.
const BYTES_PER_BYTE: u64 = 1100;

/// Bytes that any image may decode to, whatever its length.
const FREE_BYTES: u64 = 1 << 20;

/// Reads the images in the folder `path` as slices; none if it has no images.
///
/// # Errors
/// Damaged images, and images that differ in size or type.
pub fn parse(path: &Path, overrides: &Overrides) -> Result<Option<Volume>> {
    let files = files(path)?;
    let Some(first) = files.first() else { return Ok(None) };
    let mut slices = Vec::new();
    for file in &files {
        slices.push(
            Slice::of(&decoded(file)?).ok_or_else(|| unreadable(file, "its colours are of no known kind"))?,
        );
    }
    // Palettes and many cameras store grey as colours.
    if slices.iter().all(Slice::is_grey) {
        slices.iter_mut().for_each(Slice::make_grey);
    }
    if let Some(odd) = slices.iter().position(|slice| slice.kind != slices[0].kind) {
        let [found, expected] = [slices[odd].kind, slices[0].kind];
        return Err(Error::malformed(
            &files[odd],
            format!("it has {found}, but {} has {expected}; all slices must be alike", first.display()),
        ));
    }
    let planes: Vec<&[u8]> = slices.iter().map(|slice| slice.bytes.as_slice()).collect();
    let volume = slices[0].kind.volume(path, &planes)?;
    let volume = match overrides.spacing {
        Some(_) => volume,
        None => volume.with_note("pictures say no distances; 1,1,1 is taken; --spacing says others"),
    };
    Ok(Some(match gap(&files) {
        Some([before, after]) => volume.with_note(format!(
            "no slice lies between {before} and {after}, though their numbers differ by more"
        )),
        None => volume,
    }))
}

/// Lists the images in the folder `path`.
fn files(path: &Path) -> Result<Vec<PathBuf>> {
    let failed = |source| Error::io("read", path, source);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        let name = name(&file);
        let lower = name.to_ascii_lowercase();
        if !name.starts_with('.') && ENDINGS.iter().any(|ending| lower.ends_with(ending)) {
            files.push((name, file));
        }
    }
    files.sort_by(|(a, _), (b, _)| natural_order::compare(a, b));
    Ok(files.into_iter().map(|(_, file)| file).collect())
}

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn unreadable(file: &Path, problem: &str) -> Error {
    Error::malformed(file, format!("it cannot be read as a picture: {problem}; save it again as PNG"))
}

fn decoded(file: &Path) -> Result<DynamicImage> {
    let source = Source::open(file)?;
    let failed = |problem: String| {
        unreadable(file, &problem.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>())
    };
    let reader = image::ImageReader::new(std::io::Cursor::new(source.bytes()));
    let reader = reader.with_guessed_format().map_err(|e| failed(e.to_string()))?;
    let decoder = reader.into_decoder().map_err(|e| failed(e.to_string()))?;
    let most = (source.bytes().len() as u64).saturating_mul(BYTES_PER_BYTE).saturating_add(FREE_BYTES);
    if decoder.total_bytes() > most {
        let (x, y) = decoder.dimensions();
        return Err(failed(format!("it claims {x}x{y} pixels, more than it can hold")));
    }
    DynamicImage::from_decoder(decoder).map_err(|e| failed(e.to_string()))
}

/// Format of the slices; it is the same for all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Kind {
    size: [usize; 2],
    dtype: Dtype,
    components: usize,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size: [x, y], dtype, components } = self;
        write!(f, "{x}x{y} pixels of {components} x {dtype}")
    }
}

impl Kind {
    fn volume(&self, folder: &Path, slices: &[&[u8]]) -> Result<Volume> {
        let Self { size: [x, y], dtype, components } = *self;
        // Decoded pixels have the byte order of this machine.
        let endian = if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little };
        let layout = Layout { endian, components, ..Layout::new([x, y, slices.len()], dtype) };
        let contents = Contents { components, are_colours: components >= 3, ..Contents::default() };
        let source = Source::from_bytes(folder, Vec::new());
        let volume = layout.volume(&source, Arc::new(slices.concat()), 0)?;
        Ok(volume.with_format("folder of pictures").with_contents(contents))
    }
}

/// The pixels of one image.
struct Slice {
    kind: Kind,
    bytes: Vec<u8>,
}

impl Slice {
    fn of(picture: &DynamicImage) -> Option<Self> {
        let colour = picture.color();
        let components = usize::from(colour.channel_count());
        let dtype = match usize::from(colour.bytes_per_pixel()) / components {
            1 => Dtype::U8,
            2 => Dtype::U16,
            4 => Dtype::F32,
            _ => return None,
        };
        let size = [picture.width() as usize, picture.height() as usize];
        Some(Self { kind: Kind { size, dtype, components }, bytes: picture.as_bytes().to_vec() })
    }

    fn pixels(&self) -> impl Iterator<Item = &[u8]> {
        self.bytes.chunks_exact(self.kind.dtype.size() * self.kind.components)
    }

    /// Whether it is grey, or red, green and blue are the same in all pixels.
    fn is_grey(&self) -> bool {
        let size = self.kind.dtype.size();
        let is_grey = |pixel: &[u8]| {
            pixel[..size] == pixel[size..2 * size] && pixel[..size] == pixel[2 * size..3 * size]
        };
        self.kind.components < 3 || self.pixels().all(is_grey)
    }

    /// Keeps the first of several colours.
    fn make_grey(&mut self) {
        let size = self.kind.dtype.size();
        if self.kind.components >= 3 {
            self.bytes = self.pixels().flat_map(|pixel| pixel[..size].to_vec()).collect();
            self.kind.components = 1;
        }
    }
}

/// The names around the first hole in the numbers of `files`: where all others are one apart.
fn gap(files: &[PathBuf]) -> Option<[String; 2]> {
    let numbers: Option<Vec<u64>> = files.iter().map(|file| last_number(&name(file))).collect();
    let numbers = numbers?;
    let jumps: Vec<u64> = numbers.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
    let most = jumps.iter().filter(|&&jump| jump == 1).count();
    let hole = jumps.iter().position(|&jump| jump > 1)?;
    (2 * most >= jumps.len()).then(|| [name(&files[hole]), name(&files[hole + 1])])
}

/// The last number in `name`, before its ending.
fn last_number(name: &str) -> Option<u64> {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |at| at + 1);
    stem.get(start..end)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::read;
    use image::{GrayImage, ImageBuffer, Luma, Rgb, RgbImage};

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (i, name) in names.iter().enumerate() {
            let picture = GrayImage::from_fn(3, 2, |x, y| Luma([10 * i as u8 + x as u8 + 3 * y as u8]));
            picture.save(folder.path().join(name)).unwrap();
        }
        folder
    }

    fn notes(folder: &Path) -> String {
        read(folder, &Overrides::default()).unwrap().notes().join("|")
    }

    #[test]
    fn slices_stand_in_natural_order() {
        let folder = folder(&["1.png", "2.png", "10.PNG", "9.bmp"]);
        let volume = read(folder.path(), &Overrides::default()).unwrap();
        assert_eq!(volume.grid().dims(), [3, 2, 4]);
        assert_eq!([0, 1, 2, 3].map(|z| volume.value([1, 1, z])), [4.0, 14.0, 34.0, 24.0]);
        assert!(notes(folder.path()).contains("1,1,1 is taken"));
    }

    #[test]
    fn sixteen_bits_and_grey_colours() {
        let folder = tempfile::tempdir().unwrap();
        let deep: ImageBuffer<Luma<u16>, Vec<u16>> =
            ImageBuffer::from_fn(2, 2, |x, _| Luma([40_000 + x as u16]));
        deep.save(folder.path().join("a.png")).unwrap();
        let volume = read(folder.path(), &Overrides::default()).unwrap();
        assert_eq!((volume.dtype(), volume.value([1, 0, 0])), (Dtype::U16, 40_001.0));
        let error = {
            GrayImage::new(2, 2).save(folder.path().join("b.png")).unwrap();
            read(folder.path(), &Overrides::default()).unwrap_err().to_string()
        };
        assert!(error.contains("b.png") && error.contains("all slices must be alike"), "{error}");

        let folder = tempfile::tempdir().unwrap();
        RgbImage::from_pixel(2, 2, Rgb([7; 3])).save(folder.path().join("a.png")).unwrap();
        assert_eq!(read(folder.path(), &Overrides::default()).unwrap().components(), 1);
        RgbImage::from_pixel(2, 2, Rgb([7, 8, 9])).save(folder.path().join("b.png")).unwrap();
        let overrides = Overrides { component: Some(2), ..Overrides::default() };
        let volume = read(folder.path(), &overrides).unwrap();
        assert_eq!([0, 1].map(|z| volume.value([0, 0, z])), [7.0, 9.0]);
    }

    #[test]
    fn holes_in_the_numbers_are_said() {
        assert!(!notes(folder(&["s01.png", "s02.png", "s03.png"]).path()).contains("no slice"));
        assert!(!notes(folder(&["10.png", "20.png", "30.png"]).path()).contains("no slice"));
        let missing = notes(folder(&["s01.png", "s02.png", "s04.png", "s05.png"]).path());
        assert!(missing.contains("no slice lies between s02.png and s04.png"), "{missing}");
    }

    #[test]
    fn damaged_pictures_are_named() {
        let folder = folder(&["1.png"]);
        std::fs::write(folder.path().join("2.png"), b"\x89PNG\r\n\x1a\nnothing").unwrap();
        let error = read(folder.path(), &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains("2.png") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn pictures_that_claim_more_pixels_than_they_hold_take_no_memory() {
        let folder = folder(&["1.bmp"]);
        let path = folder.path().join("1.bmp");
        let mut bytes = std::fs::read(&path).unwrap();
        // Width and height.
        bytes[18..22].copy_from_slice(&30_000u32.to_le_bytes());
        bytes[22..26].copy_from_slice(&20_000u32.to_le_bytes());
        std::fs::write(&path, bytes).unwrap();
        let error = read(folder.path(), &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains("claims 30000x20000 pixels"), "{error}");
    }
}
