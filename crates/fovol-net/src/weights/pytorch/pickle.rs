//! Follows the pickle of a state dict without Python: only what `torch.save` writes for tensors is understood.
//!
//! A pickle is a program for a stack machine; its instructions are documented in Python's `pickletools`. Values
//! are kept in lists of [`Objects`] and refer to each other by their places there, so that whatever a program
//! builds can be copied and dropped in a step, cycles included. No instruction takes more memory than a fixed
//! number of bytes for each byte of the program.

use super::tensor::{Kind, Storage, View};
use super::{SAVE, shown};
use std::collections::BTreeMap;

/// The instructions that `torch.save` uses.
mod code {
    pub const MARK: u8 = b'(';
    pub const STOP: u8 = b'.';
    pub const BINFLOAT: u8 = b'G';
    pub const BININT: u8 = b'J';
    pub const BININT1: u8 = b'K';
    pub const BININT2: u8 = b'M';
    pub const NONE: u8 = b'N';
    pub const BINPERSID: u8 = b'Q';
    pub const REDUCE: u8 = b'R';
    pub const BINUNICODE: u8 = b'X';
    pub const EMPTY_LIST: u8 = b']';
    pub const APPEND: u8 = b'a';
    pub const BUILD: u8 = b'b';
    pub const GLOBAL: u8 = b'c';
    pub const APPENDS: u8 = b'e';
    pub const BINGET: u8 = b'h';
    pub const LONG_BINGET: u8 = b'j';
    pub const BINPUT: u8 = b'q';
    pub const LONG_BINPUT: u8 = b'r';
    pub const SETITEM: u8 = b's';
    pub const TUPLE: u8 = b't';
    pub const SETITEMS: u8 = b'u';
    pub const EMPTY_DICT: u8 = b'}';
    pub const EMPTY_TUPLE: u8 = b')';
    pub const PROTO: u8 = 0x80;
    pub const TUPLE1: u8 = 0x85;
    pub const TUPLE2: u8 = 0x86;
    pub const TUPLE3: u8 = 0x87;
    pub const NEWTRUE: u8 = 0x88;
    pub const NEWFALSE: u8 = 0x89;
    pub const LONG1: u8 = 0x8A;
}

/// The version of the instructions that `torch.save` uses unless it is told otherwise.
const PROTOCOL: u8 = 2;

/// A Python object. Numbers in brackets are places in [`Objects`].
#[derive(Debug, Clone, Copy)]
pub enum Value<'a> {
    /// Something that can be part of a checkpoint and says nothing about tensors.
    Ignored,
    Int(i64),
    Text(&'a str),
    List,
    /// Its first item and its length.
    Tuple(usize, usize),
    Dict(usize),
    Function(Function),
    StorageType(Kind),
    Storage(Storage),
    Tensor(usize),
}

/// The functions that a state dict may call; none of them is really called.
#[derive(Debug, Clone, Copy)]
pub enum Function {
    OrderedDict,
    RebuildTensor,
    RebuildParameter,
}

/// A dict, as far as its keys are text.
pub type Dict<'a> = BTreeMap<&'a str, Value<'a>>;

/// What a pickle has built.
#[derive(Debug)]
pub struct Objects<'a> {
    items: Vec<Value<'a>>,
    dicts: Vec<Dict<'a>>,
    views: Vec<View>,
    /// The object that was saved.
    pub root: Value<'a>,
}

impl<'a> Objects<'a> {
    /// The dict that `value` is.
    pub fn dict(&self, value: Value<'a>) -> Option<&Dict<'a>> {
        match value {
            Value::Dict(id) => self.dicts.get(id),
            _ => None,
        }
    }

    /// A tensor.
    pub fn view(&self, id: usize) -> Option<&View> {
        self.views.get(id)
    }

    /// The items of the tuple that `value` is.
    fn tuple(&self, value: Value<'a>) -> Option<&[Value<'a>]> {
        match value {
            Value::Tuple(start, length) => self.items.get(start..start + length),
            _ => None,
        }
    }

    /// The tuple of whole numbers that `value` is.
    fn numbers(&self, value: Value<'a>) -> Option<Vec<usize>> {
        self.tuple(value)?.iter().copied().map(whole).collect()
    }

    fn new_tuple(&mut self, items: &[Value<'a>]) -> Value<'a> {
        self.items.extend_from_slice(items);
        Value::Tuple(self.items.len() - items.len(), items.len())
    }

    fn new_dict(&mut self) -> Value<'a> {
        self.dicts.push(Dict::new());
        Value::Dict(self.dicts.len() - 1)
    }
}

/// Why a pickle cannot be followed.
enum Fault {
    /// What no sound pickle does.
    Damaged(&'static str),
    /// What is not done here; the whole message.
    Refused(String),
}

impl From<&'static str> for Fault {
    fn from(what: &'static str) -> Self {
        Self::Damaged(what)
    }
}

/// Builds what `pickle` describes.
pub fn follow(pickle: &[u8]) -> Result<Objects<'_>, String> {
    let objects = Objects { items: Vec::new(), dicts: Vec::new(), views: Vec::new(), root: Value::Ignored };
    let mut machine =
        Machine { rest: pickle, stack: Vec::new(), marks: Vec::new(), memo: BTreeMap::new(), objects };
    loop {
        let at = pickle.len() - machine.rest.len();
        match machine.step(at) {
            Ok(false) => {}
            Ok(true) => return Ok(machine.objects),
            Err(Fault::Refused(problem)) => return Err(problem),
            Err(Fault::Damaged(what)) => {
                return Err(format!(
                    "its pickle is damaged at byte {at} ({what}); copy the file again, or {SAVE}"
                ));
            }
        }
    }
}

/// The stack machine.
struct Machine<'a> {
    /// What is still to be done.
    rest: &'a [u8],
    stack: Vec<Value<'a>>,
    /// Heights of the stack, to which a following instruction will take things from it.
    marks: Vec<usize>,
    memo: BTreeMap<u32, Value<'a>>,
    objects: Objects<'a>,
}

impl<'a> Machine<'a> {
    /// Follows one instruction, the one at byte `at`; whether it was the last.
    fn step(&mut self, at: usize) -> Result<bool, Fault> {
        let [instruction] = self.bytes()?;
        match instruction {
            code::PROTO => self.check_protocol()?,
            code::STOP => {
                self.objects.root = self.pop()?;
                return Ok(true);
            }
            code::NONE | code::NEWTRUE | code::NEWFALSE => self.stack.push(Value::Ignored),
            code::BINFLOAT => {
                self.bytes::<8>()?;
                self.stack.push(Value::Ignored);
            }
            code::BININT | code::BININT1 | code::BININT2 | code::LONG1 => self.number(instruction)?,
            code::BINUNICODE => self.text()?,
            code::MARK => self.marks.push(self.stack.len()),
            code::EMPTY_TUPLE | code::TUPLE | code::TUPLE1 | code::TUPLE2 | code::TUPLE3 => {
                self.tuple(instruction)?;
            }
            code::EMPTY_LIST => self.stack.push(Value::List),
            code::APPEND | code::APPENDS => self.append(instruction)?,
            code::EMPTY_DICT => {
                let dict = self.objects.new_dict();
                self.stack.push(dict);
            }
            code::SETITEM | code::SETITEMS => self.set_items(instruction)?,
            code::BINPUT | code::LONG_BINPUT => self.remember(instruction)?,
            code::BINGET | code::LONG_BINGET => self.recall(instruction)?,
            code::GLOBAL => self.global()?,
            code::BINPERSID => self.storage()?,
            code::REDUCE => self.call()?,
            code::BUILD => self.build()?,
            other => {
                return Err(Fault::Refused(format!(
                    "its pickle has the instruction {other:#04x} at byte {at}, which torch.save does not use by \
                     default; save it again without `pickle_protocol` and `pickle_module`"
                )));
            }
        }
        Ok(false)
    }

    /// The next bytes of the program.
    fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("it ends too early")?;
        self.rest = rest;
        Ok(taken)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let (taken, rest) = self.rest.split_first_chunk().ok_or("it ends too early")?;
        self.rest = rest;
        Ok(*taken)
    }

    /// The next line of the program.
    fn line(&mut self) -> Result<&'a str, Fault> {
        let end = self.rest.iter().position(|&byte| byte == b'\n').ok_or("a name has no end")?;
        let line = self.take(end)?;
        self.take(1)?;
        Ok(str::from_utf8(line).map_err(|_| "a name is no text")?)
    }

    fn pop(&mut self) -> Result<Value<'a>, Fault> {
        if self.stack.len() <= self.marks.last().copied().unwrap_or(0) {
            return Err("something is missing on its stack".into());
        }
        Ok(self.stack.pop().ok_or("something is missing on its stack")?)
    }

    fn pop_to_mark(&mut self) -> Result<Vec<Value<'a>>, Fault> {
        let mark = self.marks.pop().ok_or("a mark is missing")?;
        Ok(self.stack.split_off(mark))
    }

    /// What an instruction with one and one with many operands take: `one` of them, or those above the mark.
    fn operands(&mut self, one: Option<usize>) -> Result<Vec<Value<'a>>, Fault> {
        let Some(count) = one else { return self.pop_to_mark() };
        let mut operands = (0..count).map(|_| self.pop()).collect::<Result<Vec<_>, _>>()?;
        operands.reverse();
        Ok(operands)
    }

    /// The object that the next instruction would take.
    fn top(&self) -> Result<Value<'a>, Fault> {
        Ok(self.stack.last().copied().ok_or("its stack is empty")?)
    }

    fn check_protocol(&mut self) -> Result<(), Fault> {
        match self.bytes()? {
            [PROTOCOL] => Ok(()),
            [other] => Err(Fault::Refused(format!(
                "its pickle has protocol {other}, not {PROTOCOL}; save it again without `pickle_protocol`"
            ))),
        }
    }

    fn number(&mut self, instruction: u8) -> Result<(), Fault> {
        let number = match instruction {
            code::BININT1 => i64::from(u8::from_le_bytes(self.bytes()?)),
            code::BININT2 => i64::from(u16::from_le_bytes(self.bytes()?)),
            code::BININT => i64::from(i32::from_le_bytes(self.bytes()?)),
            _ => return self.long_number(),
        };
        self.stack.push(Value::Int(number));
        Ok(())
    }

    /// A number of as many bytes as a length says, in two's complement.
    fn long_number(&mut self) -> Result<(), Fault> {
        let [length] = self.bytes()?;
        let bytes = self.take(usize::from(length))?;
        let sign = if bytes.last().is_some_and(|byte| byte & 0x80 != 0) { 0xFF } else { 0 };
        let mut number = [sign; 8];
        let value = number.get_mut(..bytes.len()).map(|low| low.copy_from_slice(bytes));
        // Seeds of random generators can be longer; sizes cannot.
        self.stack.push(value.map_or(Value::Ignored, |()| Value::Int(i64::from_le_bytes(number))));
        Ok(())
    }

    fn text(&mut self) -> Result<(), Fault> {
        let length = u32::from_le_bytes(self.bytes()?);
        let bytes = self.take(usize::try_from(length).map_err(|_| "a text is too long")?)?;
        self.stack.push(Value::Text(str::from_utf8(bytes).map_err(|_| "a text is not UTF-8")?));
        Ok(())
    }

    fn tuple(&mut self, instruction: u8) -> Result<(), Fault> {
        let items = self.operands(match instruction {
            code::EMPTY_TUPLE => Some(0),
            code::TUPLE1 => Some(1),
            code::TUPLE2 => Some(2),
            code::TUPLE3 => Some(3),
            _ => None,
        })?;
        let tuple = self.objects.new_tuple(&items);
        self.stack.push(tuple);
        Ok(())
    }

    /// Lists are never tensors: what is put into them is forgotten.
    fn append(&mut self, instruction: u8) -> Result<(), Fault> {
        self.operands((instruction == code::APPEND).then_some(1))?;
        match self.top()? {
            Value::List => Ok(()),
            _ => Err("something is appended to what is no list".into()),
        }
    }

    fn set_items(&mut self, instruction: u8) -> Result<(), Fault> {
        let items = self.operands((instruction == code::SETITEM).then_some(2))?;
        let Value::Dict(id) = self.top()? else { return Err("items are set in what is no dict".into()) };
        let dict = self.objects.dicts.get_mut(id).ok_or("a dict is missing")?;
        let (pairs, rest) = items.as_chunks();
        for &[key, value] in pairs {
            if let Value::Text(key) = key {
                dict.insert(key, value);
            }
        }
        if rest.is_empty() { Ok(()) } else { Err("a key has no value".into()) }
    }

    /// The number of a place to remember things in.
    fn place(&mut self, is_short: bool) -> Result<u32, Fault> {
        Ok(if is_short {
            u32::from(u8::from_le_bytes(self.bytes()?))
        } else {
            u32::from_le_bytes(self.bytes()?)
        })
    }

    fn remember(&mut self, instruction: u8) -> Result<(), Fault> {
        let place = self.place(instruction == code::BINPUT)?;
        let value = self.top()?;
        self.memo.insert(place, value);
        Ok(())
    }

    fn recall(&mut self, instruction: u8) -> Result<(), Fault> {
        let place = self.place(instruction == code::BINGET)?;
        let value = *self.memo.get(&place).ok_or("something is used before it is there")?;
        self.stack.push(value);
        Ok(())
    }

    /// A function or a type by name: the few that state dicts use, and no others.
    fn global(&mut self) -> Result<(), Fault> {
        let (module, name) = (self.line()?, self.line()?);
        let known = match (module, name) {
            ("collections", "OrderedDict") => Some(Value::Function(Function::OrderedDict)),
            ("torch._utils", "_rebuild_tensor_v2") => Some(Value::Function(Function::RebuildTensor)),
            ("torch._utils", "_rebuild_parameter") => Some(Value::Function(Function::RebuildParameter)),
            ("torch", storage) => Kind::of_storage(storage).map(Value::StorageType),
            _ => None,
        };
        self.stack.push(known.ok_or_else(|| {
            let wanted = format!("{module}.{name}");
            Fault::Refused(format!(
                "the file wants to run `{}`, which no state dict needs, so nothing of it was run; {SAVE}",
                shown(&wanted)
            ))
        })?);
        Ok(())
    }

    /// A storage, from `("storage", type, key, device, length)`.
    fn storage(&mut self) -> Result<(), Fault> {
        let id = self.pop()?;
        let storage = match self.objects.tuple(id) {
            Some(
                &[Value::Text("storage"), Value::StorageType(kind), Value::Text(key), Value::Text(_), length],
            ) => {
                let key = key.parse().map_err(|_| "the key of a storage is no number")?;
                Storage { kind, key, length: whole(length).ok_or("the length of a storage is none")? }
            }
            _ => return Err("a storage is named in an unknown way".into()),
        };
        self.stack.push(Value::Storage(storage));
        Ok(())
    }

    fn call(&mut self) -> Result<(), Fault> {
        let (arguments, function) = (self.pop()?, self.pop()?);
        let arguments = self.objects.tuple(arguments).ok_or("a function is called without a tuple")?;
        let result = match (function, arguments) {
            (Value::Function(Function::OrderedDict), []) => self.objects.new_dict(),
            (
                Value::Function(Function::RebuildTensor),
                &[Value::Storage(storage), offset, shape, strides, _, _],
            ) => {
                let view = self.view(storage, offset, shape, strides)?;
                self.objects.views.push(view);
                Value::Tensor(self.objects.views.len() - 1)
            }
            (Value::Function(Function::RebuildParameter), &[Value::Tensor(id), _, _]) => Value::Tensor(id),
            _ => return Err("a function is called with something else than its arguments".into()),
        };
        self.stack.push(result);
        Ok(())
    }

    fn view(
        &self,
        storage: Storage,
        offset: Value<'a>,
        shape: Value<'a>,
        strides: Value<'a>,
    ) -> Result<View, Fault> {
        let offset = whole(offset).ok_or("the offset of a tensor is no whole number")?;
        let shape = self.objects.numbers(shape).ok_or("the shape of a tensor is not of whole numbers")?;
        let strides = self.objects.numbers(strides).ok_or("the strides of a tensor are no whole numbers")?;
        Ok(View::new(storage, offset, shape, strides).ok_or("a tensor is not within its storage")?)
    }

    /// Gives an object its attributes: state dicts have versions of modules there, which mean nothing here.
    fn build(&mut self) -> Result<(), Fault> {
        self.pop()?;
        match self.top()? {
            Value::Dict(_) => Ok(()),
            _ => Err("attributes are given to what has none".into()),
        }
    }
}

/// The whole number that `value` is.
fn whole(value: Value<'_>) -> Option<usize> {
    match value {
        Value::Int(number) => usize::try_from(number).ok(),
        _ => None,
    }
}
