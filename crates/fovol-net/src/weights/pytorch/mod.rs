//! PyTorch state dicts, written by `torch.save(network.state_dict(), "FILE.pt")` since PyTorch 1.6.
//!
//! Such a file is a zip archive ([`archive`]) of a pickle and of bare numbers, one file for each storage. A pickle
//! is a program that builds Python objects and may call any Python function. [`pickle`] knows the few functions
//! that a state dict needs, and refuses all others by name.
//!
//! Tensors ([`tensor`]) are views of storages. Numbers are only read once the shapes fit a network. A file can
//! therefore not claim more memory than the network has and the file itself unpacks to.

mod advice;
mod archive;
mod pickle;
mod tensor;
#[cfg(test)]
mod tests;

use super::{Array, Weights, misfits, one_line, shown};
use crate::plan::{Named, NetworkConfig};
use advice::SAVE;
use archive::{Archive, ZIP};
use pickle::{Objects, Value};
use std::collections::BTreeMap;
use tensor::View;

/// Keys under which training scripts save the state dict beside other things.
const WRAPPERS: [&str; 3] = ["state_dict", "model_state_dict", "model"];

/// Largest depth of nested wrappers.
const DEEPEST: usize = 3;

/// Prefixes that `DataParallel` and `torch.compile` add to every name.
const PREFIXES: [&str; 2] = ["module.", "_orig_mod."];

/// Magic number, pickled, with which the format before PyTorch 1.6 begins.
const BEFORE_ZIP: &[u8] = b"\x8A\x0A\x6C\xFC\x9C\x46\xF9\x20\x6A\xA8\x50\x19.";

/// Tensors of a state dict by name. Their shapes are known; their numbers are still in the file.
///
/// The dict may be wrapped as `{"state_dict": …}`, `{"model_state_dict": …}` or `{"model": …}`. The prefixes
/// `module.` and `_orig_mod.` are removed if all names have them. Values other than tensors are ignored.
#[derive(Debug)]
pub struct StateDict<'a> {
    archive: Archive<'a>,
    tensors: BTreeMap<String, View>,
}

impl<'a> StateDict<'a> {
    /// Whether `bytes` look like a file that PyTorch saved, in any of its formats.
    pub fn is_likely(bytes: &[u8]) -> bool {
        bytes.starts_with(ZIP) || is_before_zip(bytes)
    }

    /// Finds the tensors in the bytes of a `.pt` or `.pth` file.
    ///
    /// # Errors
    /// The problem and how to mend it, in one line.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, String> {
        if is_before_zip(bytes) {
            return Err("it has the format of PyTorch before 1.6; save it again with a newer PyTorch: \
                        torch.save(torch.load(\"OLD.pt\"), \"NEW.pt\")"
                .into());
        }
        let archive = Archive::open(bytes)?;
        let pickle = archive.pickle()?;
        let tensors = tensors(&pickle::follow(&pickle)?)?;
        Ok(Self { archive, tensors })
    }

    /// Names and shapes of the tensors.
    pub fn shapes(&self) -> BTreeMap<&str, &[usize]> {
        self.tensors.iter().map(|(name, view)| (name.as_str(), view.shape())).collect()
    }

    /// Finds the named network whose shapes these are. A state dict does not say it.
    ///
    /// # Errors
    /// The nearest network where none fits, and the first tensor that differs.
    pub fn network(&self) -> Result<Named, String> {
        let shapes = self.shapes();
        let mut nearest = Vec::new();
        for named in Named::ALL {
            nearest.push((named, misfits(&named.config().plan()?.parameters(), &shapes)));
        }
        nearest.sort_by_key(|(_, problems)| problems.len());
        match nearest.first().map(|(named, problems)| (named, problems.first())) {
            Some((named, None)) => Ok(*named),
            Some((named, Some(problem))) => Err(format!(
                "its {} tensors are of none of the networks {}; the nearest is {named}, but {problem}; give the \
                 state dict of one of them, or a safetensors file, which says what network it is of",
                shapes.len(),
                Named::ALL.map(Named::name).join(", ")
            )),
            None => Err("there are no networks that it could be of; use another version".into()),
        }
    }

    /// Reads the weights of the network of `config`.
    ///
    /// # Errors
    /// Tensors of another network, and damaged numbers.
    pub fn weights(&self, config: &NetworkConfig) -> Result<Weights, String> {
        let problems = misfits(&config.plan()?.parameters(), &self.shapes());
        if let Some(problem) = problems.first() {
            return Err(format!(
                "its tensors are of another network: {problem}; give the state dict of this one"
            ));
        }
        Ok(Weights::new(config.clone(), self.arrays()?))
    }

    /// Reads the numbers of all tensors. Their sizes come from the file, so callers first check that they fit a
    /// network.
    fn arrays(&self) -> Result<BTreeMap<String, Array>, String> {
        let mut tensors: Vec<_> = self.tensors.iter().collect();
        // Sorted by storage, so that each storage is unpacked once.
        tensors.sort_by_key(|(_, view)| view.storage.key);
        let mut unpacked = None;
        let mut arrays = BTreeMap::new();
        for (name, view) in tensors {
            let bytes = match unpacked.take() {
                Some((storage, bytes)) if storage == view.storage => bytes,
                _ => self.archive.storage(&view.storage)?,
            };
            let values = view.gather(&bytes, self.archive.byte_order()).ok_or_else(|| kind(name, view))?;
            arrays.insert(name.clone(), Array { shape: view.shape().to_vec(), values });
            unpacked = Some((view.storage, bytes));
        }
        Ok(arrays)
    }
}

/// Whether `bytes` begin like `torch.save` of PyTorch before 1.6: with the pickle of a magic number.
fn is_before_zip(bytes: &[u8]) -> bool {
    // The protocol precedes the magic number, and from protocol 4 on a length too.
    (2..=11).any(|start| bytes.get(start..).is_some_and(|rest| rest.starts_with(BEFORE_ZIP)))
}

/// Finds the tensors of the state dict among `objects`, with prefixes removed from their names.
fn tensors(objects: &Objects<'_>) -> Result<BTreeMap<String, View>, String> {
    let nothing = || format!("there are no tensors by name in it; {SAVE}");
    let mut dict = objects.dict(objects.root).ok_or_else(nothing)?;
    for _ in 0..DEEPEST {
        let inner = WRAPPERS.iter().find_map(|key| objects.dict(*dict.get(key)?));
        dict = inner.unwrap_or(dict);
    }
    let tensors = dict.iter().filter_map(|(&name, &value)| match value {
        Value::Tensor(id) => Some((name, objects.view(id)?)),
        _ => None,
    });
    let (mut names, views): (Vec<&str>, Vec<&View>) = tensors.unzip();
    if names.is_empty() {
        return Err(nothing());
    }
    while let Some(short) = PREFIXES.iter().find_map(|prefix| without(prefix, &names)) {
        names = short;
    }
    if let Some((name, view)) = names.iter().zip(&views).find(|(_, view)| !view.storage.is_readable()) {
        return Err(kind(name, view));
    }
    Ok(names.into_iter().map(str::to_owned).zip(views.into_iter().cloned()).collect())
}

/// Removes `prefix` from `names`, if all of them have it.
fn without<'n>(prefix: &str, names: &[&'n str]) -> Option<Vec<&'n str>> {
    names.iter().map(|name| name.strip_prefix(prefix)).collect()
}

/// Error message for a tensor of a number type that weights do not have.
fn kind(name: &str, view: &View) -> String {
    format!(
        "`{}` is of a torch.{}; save it as float, half, bfloat16 or double",
        shown(name),
        view.storage.kind
    )
}
