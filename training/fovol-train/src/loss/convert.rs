//! Converts torchvision's weights of VGG into the safetensors file that the losses read.

use super::legacy::{self, Array};
use super::vgg::Depth;
use crate::{Error, Result};
use fovolnet::io::atomic;
use safetensors::tensor::{Dtype, TensorView, serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Report of [`convert_vgg`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Converted {
    /// The network of the weights.
    pub depth: Depth,
    /// SHA-256 of the weights file, in hexadecimal digits.
    pub sha256: String,
    /// SHA-256 of the file of LPIPS heads.
    pub heads_sha256: Option<String>,
    /// Whether the file is torchvision's own, whose name holds the beginning of its SHA-256.
    pub is_original: bool,
    /// Number of tensors written.
    pub tensors: usize,
    /// Number of values in these tensors.
    pub numbers: usize,
}

impl Depth {
    /// The network that has the convolutions in `names`, or `None`.
    fn of(names: &BTreeMap<String, Array>) -> Option<Self> {
        let has_all = |depth: &Self| {
            let numbers = depth.convolutions().concat();
            numbers.iter().all(|number| names.contains_key(&format!("features.{number}.weight")))
        };
        [Self::Vgg19, Self::Vgg16].into_iter().find(has_all)
    }
}

/// Converts the VGG convolutions in `from` into the safetensors file `to`.
///
/// `from` is torchvision's `vgg19-dcbb9e9d.pth` or `vgg16-397923af.pth`, or another file of that format. `heads` is
/// the optional `weights/v0.1/vgg.pth` of LPIPS.
///
/// # Errors
/// Files that cannot be read, have other content, or cannot be written; `to` equal to an input.
pub fn convert_vgg(from: &Path, heads: Option<&Path>, to: &Path) -> Result<Converted> {
    let (mut arrays, sha256) = read(from, "features.")?;
    let Some(depth) = Depth::of(&arrays) else {
        return Err(problem(
            from,
            "it has not the convolutions of VGG-16 or VGG-19; give torchvision's file",
        ));
    };
    arrays.retain(|name, _| {
        depth.convolutions().concat().iter().any(|i| name.starts_with(&format!("features.{i}.")))
    });
    let mut header = HashMap::from([
        ("source.sha256".to_owned(), sha256.clone()),
        ("network".to_owned(), depth.name().to_owned()),
    ]);
    let mut heads_sha256 = None;
    if let Some(heads) = heads {
        let (found, sha256) = read(heads, "lin")?;
        if found.is_empty() {
            return Err(problem(heads, "it has no heads; give LPIPS's weights/v0.1/vgg.pth"));
        }
        arrays.extend(found);
        header.insert("heads.sha256".to_owned(), sha256.clone());
        heads_sha256 = Some(sha256);
    }
    atomic::refuse_input(to)?;
    write(to, &arrays, header)?;
    let beginning = depth.original_file().split(['-', '.']).nth(1).unwrap_or_default();
    Ok(Converted {
        depth,
        is_original: sha256.starts_with(beginning),
        sha256,
        heads_sha256,
        tensors: arrays.len(),
        numbers: arrays.values().map(|array| array.values.len()).sum(),
    })
}

/// Reads the tensors whose names begin with `prefix`, and the file's SHA-256.
fn read(path: &Path, prefix: &str) -> Result<(BTreeMap<String, Array>, String)> {
    let bytes =
        fovol_core::input::read(path).map_err(|e| problem(path, &format!("it cannot be read: {e}")))?;
    if bytes.starts_with(b"PK") {
        let mend = "torchvision's own file is older; or save it again with \
                    torch.save(tensors, FILE, _use_new_zipfile_serialization=False)";
        return Err(problem(path, &format!("it has the format of PyTorch since 1.6; {mend}")));
    }
    let tensors = legacy::read(&bytes, |name| name.starts_with(prefix)).map_err(|e| problem(path, &e))?;
    let digest = Sha256::digest(&bytes);
    Ok((tensors, digest.iter().map(|byte| format!("{byte:02x}")).collect()))
}

/// Writes `arrays` as f32, atomically: the file is complete or absent.
fn write(path: &Path, arrays: &BTreeMap<String, Array>, header: HashMap<String, String>) -> Result<()> {
    let data: Vec<(&String, &Array, Vec<u8>)> = arrays
        .iter()
        .map(|(name, array)| (name, array, array.values.iter().flat_map(|v| v.to_le_bytes()).collect()))
        .collect();
    let views = data.iter().map(|(name, array, bytes)| {
        Ok((name.as_str(), TensorView::new(Dtype::F32, array.shape.clone(), bytes)?))
    });
    let views: std::result::Result<Vec<_>, safetensors::SafeTensorError> = views.collect();
    let bytes = views
        .and_then(|views| serialize(views, Some(header)))
        .map_err(|e| problem(path, &format!("it cannot be written: {e}")))?;
    Ok(atomic::write_bytes(path, &bytes)?)
}

fn problem(path: &Path, what: &str) -> Error {
    Error::Input(format!("{}: {what}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::super::vgg::{Vgg, read_tensors};
    use super::*;
    use tch::Device;

    /// VGG-16 with one channel per layer, made by `tests/reference/training/make_losses.py`.
    const LEGACY: &[u8] = include_bytes!("../../../../tests/reference/training/losses_legacy.pth");

    #[test]
    fn other_files_are_refused_with_a_mend() {
        let folder = tempfile::tempdir().unwrap();
        let (from, to) = (folder.path().join("a.pth"), folder.path().join("b.safetensors"));
        let convert = |bytes: &[u8]| {
            std::fs::write(&from, bytes).unwrap();
            convert_vgg(&from, None, &to).unwrap_err().to_string()
        };
        for (bytes, mend) in [
            (heads_alone().as_slice(), "give torchvision's file"),
            (b"PK\x03\x04", "_use_new_zipfile_serialization=False"),
            (b"nonsense", "before 1.6"),
        ] {
            let message = convert(bytes);
            assert!(message.contains(mend) && message.contains("a.pth"), "{message}");
        }
        assert!(!to.exists());
        assert!(convert_vgg(&folder.path().join("none"), None, &to).is_err());
    }

    /// The weights file with all tensors renamed.
    fn heads_alone() -> Vec<u8> {
        let mut bytes = LEGACY.to_vec();
        let places: Vec<usize> =
            (0..bytes.len() - 9).filter(|&at| bytes[at..].starts_with(b"features.")).collect();
        places.into_iter().for_each(|at| bytes[at..at + 3].copy_from_slice(b"lin"));
        bytes
    }

    #[test]
    fn what_is_converted_can_look_at_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        std::fs::write(file("vgg16.pth"), LEGACY).unwrap();
        std::fs::write(file("heads.pth"), heads_alone()).unwrap();
        let path = file("vgg16.safetensors");
        let found = convert_vgg(&file("vgg16.pth"), Some(&file("heads.pth")), &path).unwrap();
        assert_eq!((found.depth, found.is_original, found.tensors), (Depth::Vgg16, false, 52));
        assert_eq!((found.numbers, found.sha256.len()), (2 * (27 + 12 * 9 + 13), 64));
        let tensors = read_tensors(&path, Depth::Vgg16).unwrap();
        assert_eq!(Vgg::new(Depth::Vgg16, &tensors, Device::Cpu).unwrap().channels(), [1; 5]);
        let first = tensors["features.2.weight"].view([-1]).double_value(&[1]);
        assert_eq!(first, 5.0);
        let message = Vgg::new(Depth::Vgg19, &tensors, Device::Cpu).unwrap_err().to_string();
        assert!(message.contains("`features.16.weight` is missing"), "{message}");
        let message = read_tensors(&file("none"), Depth::Vgg19).unwrap_err().to_string();
        assert!(message.contains("fovolnet-train convert-vgg vgg19-dcbb9e9d.pth"), "{message}");
    }
}
