//! Reader of PyTorch's file format before 1.6, which torchvision's VGG weights still have.
//!
//! A file is five pickles (a magic number, a version, facts about the machine, the state dict, the storage keys) and
//! then the values of each storage. A pickle is a program for a stack machine that may call any Python function. This
//! reader implements the few calls of a state dict and refuses all others.

use std::collections::{BTreeMap, HashMap};

/// Magic number at the beginning of such files.
const MAGIC: [u8; 10] = [0x6C, 0xFC, 0x9C, 0x46, 0xF9, 0x20, 0x6A, 0xA8, 0x50, 0x19];
/// Upper bound of instructions in a pickle.
const LONGEST: usize = 1_000_000;

/// Tensor of a file, values row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// Values; their number is the product of `shape`.
    pub values: Vec<f32>,
}

/// Whether `bytes` begin like a file of this format.
pub fn is_legacy(bytes: &[u8]) -> bool {
    bytes.len() > 14 && bytes[0] == 0x80 && bytes[2..4] == [0x8A, 10] && bytes[4..14] == MAGIC
}

/// Reads the tensors whose names `wanted` accepts.
///
/// # Errors
/// A few words that say what is wrong with the file.
pub fn read(bytes: &[u8], wanted: impl Fn(&str) -> bool) -> Result<BTreeMap<String, Array>, String> {
    if !is_legacy(bytes) {
        return Err("it has not the format of PyTorch before 1.6".into());
    }
    let mut machine = Machine { bytes, at: 0, arena: Vec::new() };
    for _ in 0..3 {
        machine.run()?;
    }
    let dict = machine.run()?;
    let keys = machine.run()?;
    let storages = machine.storages(keys)?;
    let Node::Dict(entries) = &machine.arena[dict] else {
        return Err("it holds no tensors by name".into());
    };
    let mut tensors = BTreeMap::new();
    for &(name, value) in entries {
        if let (Node::Text(name), Node::Tensor(tensor)) = (&machine.arena[name], &machine.arena[value])
            && wanted(name)
        {
            let array = tensor.gather(&storages).ok_or_else(|| format!("`{name}` is damaged"))?;
            tensors.insert(name.clone(), array);
        }
    }
    Ok(tensors)
}

/// Index of a value in the arena.
type Id = usize;

/// Value of a pickle.
#[derive(Debug, Clone)]
enum Node {
    /// Value that is not used here: None, a boolean, a hook.
    Other,
    Int(i64),
    Text(String),
    /// Name of a function or class.
    Global(String),
    /// Tuple or list.
    Sequence(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    /// Key of an f32 storage.
    Storage(String),
    Tensor(View),
}

/// Layout of a tensor in its storage.
#[derive(Debug, Clone)]
struct View {
    storage: String,
    offset: usize,
    shape: Vec<usize>,
    strides: Vec<usize>,
}

impl View {
    /// Gathers the values row by row; `None` if the storage is too short.
    fn gather(&self, storages: &HashMap<String, &[u8]>) -> Option<Array> {
        let storage = storages.get(&self.storage)?;
        let count = self.shape.iter().try_fold(1usize, |count, &side| count.checked_mul(side))?;
        // Strides may repeat values, but a tensor with more values than the storage has bytes is damaged.
        if count > storage.len() || self.shape.len() != self.strides.len() {
            return None;
        }
        let value = |mut rest: usize| {
            let mut at = self.offset;
            for (&side, &stride) in self.shape.iter().zip(&self.strides).rev() {
                at = at.checked_add((rest % side).checked_mul(stride)?)?;
                rest /= side;
            }
            let start = at.checked_mul(4)?;
            let four = storage.get(start..start.checked_add(4)?)?;
            Some(f32::from_le_bytes(four.try_into().ok()?))
        };
        let values = (0..count).map(value).collect::<Option<_>>()?;
        Some(Array { shape: self.shape.clone(), values })
    }
}

/// Stack machine that runs pickles one after another; all values share one arena.
struct Machine<'a> {
    bytes: &'a [u8],
    at: usize,
    arena: Vec<Node>,
}

/// Entry of the stack.
enum Item {
    Mark,
    Value(Id),
}

fn damaged() -> String {
    "it is damaged; copy or download it again".into()
}

impl<'a> Machine<'a> {
    /// Runs one pickle and returns its result.
    fn run(&mut self) -> Result<Id, String> {
        let mut stack: Vec<Item> = Vec::new();
        let mut memo: HashMap<usize, Id> = HashMap::new();
        for _ in 0..LONGEST {
            let code = self.take(1)?[0];
            match code {
                b'.' => return pop(&mut stack),
                0x80 => drop(self.take(1)?),
                b'(' => stack.push(Item::Mark),
                b'0' => drop(stack.pop()),
                b'q' | b'r' => {
                    let key = self.number(if code == b'q' { 1 } else { 4 })?;
                    let Some(Item::Value(id)) = stack.last() else { return Err(damaged()) };
                    memo.insert(key, *id);
                }
                b'h' | b'j' => {
                    let key = self.number(if code == b'h' { 1 } else { 4 })?;
                    stack.push(Item::Value(*memo.get(&key).ok_or_else(damaged)?));
                }
                b'a' | b'e' | b's' | b'u' | b'b' => self.change(code, &mut stack)?,
                b't' => {
                    let items = marked(&mut stack)?;
                    self.push(&mut stack, Node::Sequence(items));
                }
                0x85..=0x87 => {
                    let count = usize::from(code - 0x84);
                    let mut items: Vec<Id> = (0..count).map(|_| pop(&mut stack)).collect::<Result<_, _>>()?;
                    items.reverse();
                    self.push(&mut stack, Node::Sequence(items));
                }
                b'R' => {
                    let (arguments, function) = (pop(&mut stack)?, pop(&mut stack)?);
                    let made = self.call(function, arguments)?;
                    stack.push(Item::Value(made));
                }
                b'Q' => {
                    let id = pop(&mut stack)?;
                    let storage = self.storage(id)?;
                    self.push(&mut stack, storage);
                }
                _ => {
                    let constant = self.constant(code)?;
                    self.push(&mut stack, constant);
                }
            }
        }
        Err(damaged())
    }

    fn push(&mut self, stack: &mut Vec<Item>, node: Node) {
        self.arena.push(node);
        stack.push(Item::Value(self.arena.len() - 1));
    }

    /// Value pushed by an instruction that takes no operands from the stack.
    fn constant(&mut self, code: u8) -> Result<Node, String> {
        Ok(match code {
            b'N' | 0x88 | 0x89 => Node::Other,
            b'}' => Node::Dict(Vec::new()),
            b']' | b')' => Node::Sequence(Vec::new()),
            b'K' => Node::Int(self.number(1)? as i64),
            b'M' => Node::Int(self.number(2)? as i64),
            b'J' => Node::Int(i64::from(self.number(4)? as u32 as i32)),
            0x8A => {
                let length = self.number(1)?;
                let digits = self.take(length)?;
                // Integers longer than 8 bytes occur, but nowhere that they are used.
                let mut wide = [if digits.last().is_some_and(|&last| last >= 0x80) { 0xFF } else { 0 }; 8];
                let kept = length.min(8);
                wide[..kept].copy_from_slice(&digits[..kept]);
                Node::Int(i64::from_le_bytes(wide))
            }
            b'G' => {
                self.take(8)?;
                Node::Other
            }
            b'U' => self.text(1)?,
            b'X' | b'T' => self.text(4)?,
            b'c' => Node::Global(format!("{}.{}", self.line()?, self.line()?)),
            _ => {
                return Err(format!(
                    "it has an instruction {code:#04x} that no state dict needs; {}",
                    damaged()
                ));
            }
        })
    }

    /// Adds content to a list, dict or object.
    fn change(&mut self, code: u8, stack: &mut Vec<Item>) -> Result<(), String> {
        let items = match code {
            b'a' | b'b' => vec![pop(stack)?],
            b's' => {
                let (item, key) = (pop(stack)?, pop(stack)?);
                vec![key, item]
            }
            _ => marked(stack)?,
        };
        let Some(Item::Value(target)) = stack.last() else { return Err(damaged()) };
        match (code, &mut self.arena[*target]) {
            // The state of objects (metadata of dicts, hooks of tensors) is ignored.
            (b'b', _) => {}
            (b'a' | b'e', Node::Sequence(list)) => list.extend(items),
            (b's' | b'u', Node::Dict(entries)) => {
                entries.extend(items.chunks_exact(2).map(|pair| (pair[0], pair[1])));
            }
            _ => return Err(damaged()),
        }
        Ok(())
    }

    /// Result of calling `function` with `arguments`.
    fn call(&mut self, function: Id, arguments: Id) -> Result<Id, String> {
        let Node::Global(name) = &self.arena[function] else { return Err(damaged()) };
        let given = self.sequence(arguments)?.to_vec();
        let node = match name.as_str() {
            "collections.OrderedDict" => self.ordered(&given)?,
            // These wrap their first argument, and only that is needed.
            "torch._utils._rebuild_parameter"
            | "torch.nn.parameter.Parameter"
            | "torch.autograd.variable.Variable"
            | "torch.Size" => return given.first().copied().ok_or_else(damaged),
            "torch._utils._rebuild_tensor" | "torch._utils._rebuild_tensor_v2" => self.tensor(&given)?,
            other => return Err(format!("it calls {other}, which no state dict needs; {SAVE}")),
        };
        self.arena.push(node);
        Ok(self.arena.len() - 1)
    }

    /// A dict of the pairs in the first argument, if there is one.
    fn ordered(&self, given: &[Id]) -> Result<Node, String> {
        let Some(&pairs) = given.first() else { return Ok(Node::Dict(Vec::new())) };
        let pair = |&id: &Id| match self.sequence(id)? {
            &[key, item] => Ok((key, item)),
            _ => Err(damaged()),
        };
        Ok(Node::Dict(self.sequence(pairs)?.iter().map(pair).collect::<Result<_, _>>()?))
    }

    fn tensor(&self, given: &[Id]) -> Result<Node, String> {
        let &[storage, offset, shape, strides, ..] = given else { return Err(damaged()) };
        let Node::Storage(storage) = &self.arena[storage] else { return Err(damaged()) };
        let lengths = |id| self.sequence(id)?.iter().map(|&id| self.count(id)).collect::<Result<Vec<_>, _>>();
        let (shape, strides) = (lengths(shape)?, lengths(strides)?);
        Ok(Node::Tensor(View { storage: storage.clone(), offset: self.count(offset)?, shape, strides }))
    }

    /// The storage of a persistent id: ("storage", type, key, location, length, view or None).
    fn storage(&self, id: Id) -> Result<Node, String> {
        let &[_, kind, key, _, _, ref rest @ ..] = self.sequence(id)? else { return Err(damaged()) };
        let (Node::Global(kind), Node::Text(key)) = (&self.arena[kind], &self.arena[key]) else {
            return Err(damaged());
        };
        let is_part = rest.first().is_some_and(|&part| !matches!(self.arena[part], Node::Other));
        match kind.as_str() {
            _ if is_part => Err(format!("its storages are parts of each other; {SAVE}")),
            "torch.FloatStorage" | "torch.cuda.FloatStorage" => Ok(Node::Storage(key.clone())),
            // Other types are counters of batch normalisation and the like, which nothing reads.
            _ => Ok(Node::Other),
        }
    }

    /// Reads the storages that follow the pickles: for each of `keys`, its length and its values.
    fn storages(&mut self, keys: Id) -> Result<HashMap<String, &'a [u8]>, String> {
        let mut storages = HashMap::new();
        for key in self.sequence(keys)?.to_vec() {
            let Node::Text(key) = self.arena[key].clone() else { return Err(damaged()) };
            let bytes = self.number(8)?.checked_mul(4).ok_or_else(damaged)?;
            storages.insert(key, self.take(bytes)?);
        }
        Ok(storages)
    }

    fn sequence(&self, id: Id) -> Result<&[Id], String> {
        match &self.arena[id] {
            Node::Sequence(items) => Ok(items),
            _ => Err(damaged()),
        }
    }

    fn count(&self, id: Id) -> Result<usize, String> {
        match self.arena[id] {
            Node::Int(count) => usize::try_from(count).map_err(|_| damaged()),
            _ => Err(damaged()),
        }
    }

    /// Takes the next `count` bytes.
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count).ok_or_else(damaged)?;
        let taken = self.bytes.get(self.at..end).ok_or_else(damaged)?;
        self.at = end;
        Ok(taken)
    }

    /// Reads a little-endian integer of `bytes` bytes.
    fn number(&mut self, bytes: usize) -> Result<usize, String> {
        let digits = self.take(bytes)?;
        Ok(digits.iter().rev().fold(0usize, |number, &digit| number << 8 | usize::from(digit)))
    }

    /// Reads a text whose length of `bytes` bytes precedes it.
    fn text(&mut self, bytes: usize) -> Result<Node, String> {
        let length = self.number(bytes)?;
        let text = std::str::from_utf8(self.take(length)?).map_err(|_| damaged())?;
        Ok(Node::Text(text.to_owned()))
    }

    /// Reads the rest of the line.
    fn line(&mut self) -> Result<&'a str, String> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| byte == b'\n').ok_or_else(damaged)?;
        let line = self.take(length + 1)?;
        std::str::from_utf8(&line[..length]).map_err(|_| damaged())
    }
}

/// Advice for files with other content.
const SAVE: &str = "save only the tensors, with torch.save(network.state_dict(), FILE)";

fn pop(stack: &mut Vec<Item>) -> Result<Id, String> {
    match stack.pop() {
        Some(Item::Value(id)) => Ok(id),
        _ => Err(damaged()),
    }
}

/// Pops the values above the topmost mark, and the mark.
fn marked(stack: &mut Vec<Item>) -> Result<Vec<Id>, String> {
    let at = stack.iter().rposition(|item| matches!(item, Item::Mark)).ok_or_else(damaged)?;
    let values = stack.drain(at..).filter_map(|item| match item {
        Item::Value(id) => Some(id),
        Item::Mark => None,
    });
    Ok(values.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Made by `tests/reference/training/make_losses.py`.
    const FILE: &[u8] = include_bytes!("../../../../tests/reference/training/losses_legacy.pth");

    #[test]
    fn parameters_are_read_whichever_way_they_lie() {
        let tensors = read(FILE, |_| true).unwrap();
        assert_eq!(tensors.len(), 27);
        assert_eq!(tensors["features.0.weight"].shape, [1, 3, 3, 3]);
        assert!(tensors["features.0.weight"].values.iter().all(|v| v.abs() <= 0.5));
        assert_eq!(tensors["classifier.6.bias"], Array { shape: vec![2], values: vec![0.0; 2] });
        let turned = [1.0, 5.0, 9.0, 2.0, 6.0, 10.0, 3.0, 7.0, 11.0];
        assert_eq!(tensors["features.2.weight"], Array { shape: vec![1, 1, 3, 3], values: turned.to_vec() });
        assert_eq!(read(FILE, |name| name.ends_with("6.bias")).unwrap().len(), 2);
    }

    #[test]
    fn the_heads_of_lpips_are_read() {
        let data = std::env::var_os("FOVOL_TEST_DATA").map_or_else(
            || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
            std::path::PathBuf::from,
        );
        let Ok(bytes) = std::fs::read(data.join("lpips/v0.1/vgg.pth")) else {
            println!("skipped: no lpips/v0.1/vgg.pth in {}", data.display());
            return;
        };
        let heads = read(&bytes, |_| true).unwrap();
        let sums = [6.926, 8.858, 17.515, 51.521, 47.035];
        assert_eq!(heads.len(), 5);
        for ((name, head), expected) in heads.iter().zip(sums) {
            let sum: f32 = head.values.iter().sum();
            assert!((sum - expected).abs() < 1e-3, "{name}: {sum}");
        }
    }

    #[test]
    fn damaged_files_are_errors() {
        for length in 0..FILE.len() {
            assert!(read(&FILE[..length], |_| true).is_err(), "{length}");
        }
        for at in 0..FILE.len() {
            let mut bytes = FILE.to_vec();
            for flip in [1, 0x80, 0xFF] {
                bytes[at] = FILE[at] ^ flip;
                // Flipped bits may change values, but must not panic.
                let _ = read(&bytes, |_| true);
            }
        }
        let message = read(&FILE[1..], |_| true).unwrap_err();
        assert!(message.contains("before 1.6"), "{message}");
    }

    #[test]
    fn other_functions_are_not_called() {
        let text = b"torch._utils\n_rebuild_parameter";
        let at = FILE.windows(text.len()).position(|window| window == text).unwrap();
        let mut bytes = FILE.to_vec();
        bytes[at..at + 12].copy_from_slice(b"posix.system");
        let message = read(&bytes, |_| true).unwrap_err();
        assert!(message.contains("posix.system._rebuild_parameter"), "{message}");
    }
}
