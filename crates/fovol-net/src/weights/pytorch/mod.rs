//! State dicts of PyTorch, as `torch.save(network.state_dict(), "FILE.pt")` writes them since PyTorch 1.6.
//!
//! Such a file is a zip archive ([`archive`]) of a pickle and of bare numbers, one file for each storage. A pickle
//! is a program that builds Python objects and may call any function that Python has; [`pickle`] knows the few
//! that a state dict needs, and refuses the others by name. Tensors ([`tensor`]) are ways to read a storage, and
//! stay that until a network is known that they fit: then no file can ask for more memory than the network has and
//! the file itself unpacks to.

mod archive;
mod pickle;
mod tensor;
#[cfg(test)]
mod tests;

use super::{Array, Weights, misfits, one_line, shown};
use crate::plan::{Named, NetworkConfig};
use archive::Archive;
use pickle::{Objects, Value};
use std::collections::BTreeMap;
use tensor::View;

/// Where training scripts put the state dict when they save other things with it.
const WRAPPERS: [&str; 3] = ["state_dict", "model_state_dict", "model"];

/// How often such wrappers lie in each other at most.
const DEEPEST: usize = 3;

/// What `DataParallel` and `torch.compile` put before every name.
const PREFIXES: [&str; 2] = ["module.", "_orig_mod."];

/// How to mend a file that holds something else.
pub(super) const SAVE: &str = "save only the tensors, with torch.save(network.state_dict(), \"FILE.pt\")";

/// The beginning of a zip archive.
const ZIP: &[u8] = b"PK\x03\x04";

/// The number with which the format before PyTorch 1.6 begins, as its pickle has it.
const BEFORE_ZIP: &[u8] = b"\x8A\x0A\x6C\xFC\x9C\x46\xF9\x20\x6A\xA8\x50\x19.";

/// The tensors of a state dict by name: their shapes are known, their numbers still lie in the file.
///
/// The dict may be wrapped as `{"state_dict": …}`, `{"model_state_dict": …}` or `{"model": …}`; `module.` and
/// `_orig_mod.` before all names are left out, and whatever is no tensor is ignored.
#[derive(Debug)]
pub struct StateDict<'a> {
    archive: Archive<'a>,
    tensors: BTreeMap<String, View>,
}

impl<'a> StateDict<'a> {
    /// Whether `bytes` look like a file that PyTorch saved, in whichever format.
    pub fn is_likely(bytes: &[u8]) -> bool {
        bytes.starts_with(ZIP) || is_before_zip(bytes)
    }

    /// Finds the tensors in the bytes of a `.pt` or `.pth` file.
    ///
    /// # Errors
    /// What is wrong with them and how to mend it, in one line.
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

    /// The names of the tensors and their shapes.
    pub fn shapes(&self) -> BTreeMap<&str, &[usize]> {
        self.tensors.iter().map(|(name, view)| (name.as_str(), view.shape())).collect()
    }

    /// The one named network that these are the weights of: a state dict does not say it.
    ///
    /// # Errors
    /// The nearest network where none fits, and the first tensor that keeps them apart.
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

    /// The weights of the network of `config`.
    ///
    /// # Errors
    /// Tensors that are not this network's, and damaged numbers.
    pub fn weights(&self, config: &NetworkConfig) -> Result<Weights, String> {
        let problems = misfits(&config.plan()?.parameters(), &self.shapes());
        if let Some(problem) = problems.first() {
            return Err(format!(
                "its tensors are of another network: {problem}; give the state dict of this one"
            ));
        }
        Ok(Weights::new(config.clone(), self.arrays()?))
    }

    /// The numbers of all tensors. Their sizes come from the file: they have to be known to fit a network.
    fn arrays(&self) -> Result<BTreeMap<String, Array>, String> {
        let mut tensors: Vec<_> = self.tensors.iter().collect();
        // Tensors that share a storage come after each other, so that it is unpacked once.
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

/// Whether `bytes` begin as `torch.save` of PyTorch before 1.6 does: with a pickle of a number of its own.
fn is_before_zip(bytes: &[u8]) -> bool {
    // Before it come the protocol and, from protocol 4 on, a length.
    (2..=11).any(|start| bytes.get(start..).is_some_and(|rest| rest.starts_with(BEFORE_ZIP)))
}

/// The tensors of the state dict among `objects`, as the network names them.
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

/// `names` without `prefix`, if all of them have it.
fn without<'n>(prefix: &str, names: &[&'n str]) -> Option<Vec<&'n str>> {
    names.iter().map(|name| name.strip_prefix(prefix)).collect()
}

/// What is to be said of a tensor whose numbers no weights have.
fn kind(name: &str, view: &View) -> String {
    format!(
        "`{}` is of a torch.{}; save it as float, half, bfloat16 or double",
        shown(name),
        view.storage.kind
    )
}
