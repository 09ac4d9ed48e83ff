//! Interprets the pickle of a state dict without Python. It only understands what `torch.save` writes for tensors.
//!
//! A pickle is a program for a stack machine; Python's `pickletools` documents its instructions. Values are kept in
//! lists of [`Objects`] and refer to each other by index. Whatever a program builds, cycles included, can thus be
//! copied and dropped in one step. Memory is bounded by a fixed number of bytes for each byte of the program.

use super::advice::SAVE;
use super::shown;
use super::tensor::{Kind, Storage, View};
use std::collections::BTreeMap;

/// Opcodes that `torch.save` uses.
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

/// Pickle protocol that `torch.save` uses by default.
const PROTOCOL: u8 = 2;

/// A Python object. Numbers in brackets are indices into the lists of [`Objects`].
#[derive(Debug, Clone, Copy)]
pub enum Value<'a> {
    /// An object that may be part of a checkpoint and has nothing to do with tensors.
    Ignored,
    Int(i64),
    Text(&'a str),
    List,
    /// Index of the first item, and number of items.
    Tuple(usize, usize),
    Dict(usize),
    Function(Function),
    StorageType(Kind),
    Storage(Storage),
    Tensor(usize),
}

/// Functions that a state dict may call. None of them is really called.
#[derive(Debug, Clone, Copy)]
pub enum Function {
    OrderedDict,
    RebuildTensor,
    RebuildParameter,
}

/// A dict; only its text keys are kept.
pub type Dict<'a> = BTreeMap<&'a str, Value<'a>>;

/// Objects that a pickle has built.
#[derive(Debug)]
pub struct Objects<'a> {
    items: Vec<Value<'a>>,
    dicts: Vec<Dict<'a>>,
    views: Vec<View>,
    /// The saved object.
    pub root: Value<'a>,
}

impl<'a> Objects<'a> {
    /// Returns the dict that `value` refers to.
    pub fn dict(&self, value: Value<'a>) -> Option<&Dict<'a>> {
        match value {
            Value::Dict(id) => self.dicts.get(id),
            _ => None,
        }
    }

    /// Returns the tensor of this index.
    pub fn view(&self, id: usize) -> Option<&View> {
        self.views.get(id)
    }

    /// Returns the items of the tuple `value`.
    fn tuple(&self, value: Value<'a>) -> Option<&[Value<'a>]> {
        match value {
            Value::Tuple(start, length) => self.items.get(start..start + length),
            _ => None,
        }
    }

    /// Returns the tuple of integers `value`.
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

/// Reason why a pickle cannot be interpreted.
enum Fault {
    /// The pickle is damaged.
    Damaged(&'static str),
    /// The pickle needs something that is not supported. Has the whole message.
    Refused(String),
}

impl From<&'static str> for Fault {
    fn from(what: &'static str) -> Self {
        Self::Damaged(what)
    }
}

/// Interprets `pickle` and returns the objects that it builds.
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
    /// Instructions that are still to be executed.
    rest: &'a [u8],
    stack: Vec<Value<'a>>,
    /// Heights of the stack at marks. Some instructions take all values above the last mark.
    marks: Vec<usize>,
    memo: BTreeMap<u32, Value<'a>>,
    objects: Objects<'a>,
}

impl<'a> Machine<'a> {
    /// Executes one instruction, the one at byte `at`. Returns whether it was the last.
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

    /// Takes the next `count` bytes of the program.
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

    /// Takes the next line of the program.
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

    /// Pops the operands of an instruction that exists with a fixed number of operands (`one`) and with all above
    /// the mark.
    fn operands(&mut self, one: Option<usize>) -> Result<Vec<Value<'a>>, Fault> {
        let Some(count) = one else { return self.pop_to_mark() };
        let mut operands = (0..count).map(|_| self.pop()).collect::<Result<Vec<_>, _>>()?;
        operands.reverse();
        Ok(operands)
    }

    /// Returns the top of the stack without popping it.
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

    /// Reads an integer of variable length: a length byte, then two's complement.
    fn long_number(&mut self) -> Result<(), Fault> {
        let [length] = self.bytes()?;
        let bytes = self.take(usize::from(length))?;
        let sign = if bytes.last().is_some_and(|byte| byte & 0x80 != 0) { 0xFF } else { 0 };
        let mut number = [sign; 8];
        let value = number.get_mut(..bytes.len()).map(|low| low.copy_from_slice(bytes));
        // Seeds of random generators can be longer than 8 bytes; sizes cannot.
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

    /// Pops the items of a list and drops them: lists never contain tensors.
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

    /// Reads an index of the memo.
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

    /// Looks a function or type up by name. Only those that state dicts use are known.
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

    /// Builds a storage from `("storage", type, key, device, length)`.
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

    /// Sets attributes of an object. State dicts keep versions of modules there, which are ignored.
    fn build(&mut self) -> Result<(), Fault> {
        self.pop()?;
        match self.top()? {
            Value::Dict(_) => Ok(()),
            _ => Err("attributes are given to what has none".into()),
        }
    }
}

/// Returns the non-negative integer `value`.
fn whole(value: Value<'_>) -> Option<usize> {
    match value {
        Value::Int(number) => usize::try_from(number).ok(),
        _ => None,
    }
}
