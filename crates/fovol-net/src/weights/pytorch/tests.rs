//! Tests with files that PyTorch did not write. `tests/reference.rs` has files that it did write.

use super::*;
use crate::plan::WNetConfig;
use proptest::prelude::*;
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Weights of `config()` with seed 7, saved by PyTorch.
const SAVED: &[u8] = include_bytes!("../../../tests/reference/state_dict.pt");

/// The pickle of [`SAVED`].
fn saved_pickle() -> Vec<u8> {
    Archive::open(SAVED).unwrap().pickle().unwrap()
}

fn config() -> NetworkConfig {
    let config = WNetConfig::paper().with(|options| {
        (options.encoder, options.decoder) = (vec![4, 4], vec![4]);
    });
    NetworkConfig::WNet(config.unwrap())
}

/// Zips `files`.
fn zipped(files: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default().compression_method(method)).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Zips a pickle alone.
fn pickled(pickle: &[u8]) -> Vec<u8> {
    zipped(&[("a/data.pkl", pickle)], CompressionMethod::Stored)
}

/// Encodes a text in a pickle.
fn text(text: &str) -> Vec<u8> {
    [b"X", &(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// Encodes a tuple of integers in a pickle.
fn tuple(numbers: &[usize]) -> Vec<u8> {
    let numbers = numbers.iter().flat_map(|&n| [b"J", &(n as u32).to_le_bytes()[..]].concat());
    b"(".iter().copied().chain(numbers).chain(*b"t").collect()
}

/// Encodes a tensor in a pickle. It covers a whole storage.
fn tensor(storage: &str, key: &str, shape: &[usize]) -> Vec<u8> {
    let strides: Vec<usize> = (0..shape.len()).map(|i| shape[i + 1..].iter().product()).collect();
    let length = (shape.iter().product::<usize>() as u32).to_le_bytes();
    [
        b"ctorch._utils\n_rebuild_tensor_v2\n((",
        &text("storage")[..],
        format!("ctorch\n{storage}\n").as_bytes(),
        &text(key),
        &text("cpu"),
        &[b"J", &length[..], b"tQK\0"].concat(),
        &tuple(shape),
        &tuple(&strides),
        b"\x89ccollections\nOrderedDict\n)RtR",
    ]
    .concat()
}

/// Encodes a dict in a pickle.
fn dict(items: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let items: Vec<Vec<u8>> = items.iter().flat_map(|(key, value)| [text(key), value.clone()]).collect();
    [&b"}("[..], &items.concat(), b"u"].concat()
}

/// Makes the pickle of one object.
fn program(object: &[u8]) -> Vec<u8> {
    [b"\x80\x02", object, b"."].concat()
}

/// Returns the error for the file `bytes`, and asserts that it is one short line.
fn problem(bytes: &[u8]) -> String {
    let problem = StateDict::parse(bytes).unwrap_err();
    assert!(!problem.contains(char::is_control) && problem.len() < 400, "{problem}");
    problem
}

/// Zips the state dict of `weights`, whose names get `prefix`, with one storage for each tensor.
fn state_dict(weights: &Weights, prefix: &str, method: CompressionMethod) -> Vec<u8> {
    let named: Vec<(String, &Array)> =
        weights.arrays().iter().map(|(name, array)| (format!("{prefix}{name}"), array)).collect();
    let tensors = named
        .iter()
        .enumerate()
        .map(|(key, (name, array))| (name.as_str(), tensor("FloatStorage", &key.to_string(), &array.shape)));
    let pickle = program(&dict(&tensors.collect::<Vec<_>>()));
    let storages: Vec<(String, Vec<u8>)> = named
        .iter()
        .enumerate()
        .map(|(key, (_, array))| {
            (format!("a/data/{key}"), array.values.iter().flat_map(|v| v.to_be_bytes()).collect())
        })
        .collect();
    let mut files = vec![("a/data.pkl", &pickle[..]), ("a/byteorder", b"big")];
    files.extend(storages.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])));
    zipped(&files, method)
}

#[test]
fn state_dicts_of_named_networks_say_which() {
    let weights = Weights::random(&Named::WNetFast.config(), 3).unwrap();
    for (prefix, method) in [
        ("", CompressionMethod::Stored),
        ("module.", CompressionMethod::Deflated),
        ("module._orig_mod.", CompressionMethod::Stored),
    ] {
        let bytes = state_dict(&weights, prefix, method);
        assert_eq!(StateDict::parse(&bytes).unwrap().network().unwrap(), Named::WNetFast);
        let found = Weights::parse(&bytes).unwrap();
        assert_eq!((found.arrays(), &found.config), (weights.arrays(), &weights.config));
    }
}

#[test]
fn no_two_named_networks_have_the_same_shapes() {
    for named in Named::ALL {
        let parameters = named.config().plan().unwrap().parameters();
        let shapes = parameters.iter().map(|p| (p.name.as_str(), p.shape.as_slice())).collect();
        let fits = |other: &Named| misfits(&other.config().plan().unwrap().parameters(), &shapes).is_empty();
        assert_eq!(Named::ALL.into_iter().filter(fits).collect::<Vec<_>>(), [named]);
    }
}

#[test]
fn networks_that_do_not_fit_are_named_with_a_tensor() {
    let mut weights = Weights::random(&Named::WNetFast.config(), 3).unwrap();
    let mut problem = |name: &str, shape: Option<Vec<usize>>| {
        weights.arrays.remove(name);
        if let Some(shape) = shape {
            let values = vec![0.0; shape.iter().product()];
            weights.arrays.insert(name.into(), Array { shape, values });
        }
        let bytes = state_dict(&weights, "", CompressionMethod::Stored);
        StateDict::parse(&bytes).unwrap().network().unwrap_err()
    };
    let error = problem("more.weight", Some(vec![2, 3]));
    assert!(error.contains("nearest is wnet-fast, but `more.weight` is not part"), "{error}");
    let error = problem("encoder.0.conv1.bias", Some(vec![3]));
    assert!(error.contains("nearest is wnet-fast, but `encoder.0.conv1.bias` has the shape [3]"), "{error}");
    let error = problem("encoder.0.conv1.bias", None);
    assert!(error.contains("nearest is wnet-fast, but `encoder.0.conv1.bias` is missing"), "{error}");

    let error = StateDict::parse(SAVED).unwrap().weights(&Named::WNetFast.config()).unwrap_err();
    assert!(error.contains("another network: `") && error.contains("give the state dict"), "{error}");
}

#[test]
fn wrappers_and_what_is_no_tensor_do_not_matter() {
    let files = |pickle: &[u8]| {
        zipped(&[("a/data.pkl", pickle), ("a/data/0", &[0, 0, 0x80, 0x3F])], CompressionMethod::Stored)
    };
    let other: [(&str, Vec<u8>); 8] = [
        ("none", b"N".to_vec()),
        ("flag", b"\x88".to_vec()),
        ("lr", b"G?\xB9\x99\x99\x99\x99\x99\x9A".to_vec()),
        ("epoch", b"M\xE8\x03".to_vec()),
        ("seed", b"\x8A\x09\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\0".to_vec()),
        ("losses", b"](K\x01K\x02eK\x03a".to_vec()),
        ("betas", b"K\x01K\x02\x86".to_vec()),
        ("optimiser", dict(&[("steps", tensor("LongStorage", "7", &[5]))])),
    ];
    let parameter =
        [b"ctorch._utils\n_rebuild_parameter\n", &tensor("FloatStorage", "0", &[1])[..], b"\x89}\x87R"]
            .concat();
    let mut inner = dict(&[&other[..], &[("w", parameter)]].concat());
    // Attributes, which modules give to their state dicts.
    inner.extend(dict(&[("_metadata", b"}".to_vec())]));
    inner.push(b'b');
    for wrappers in [&[][..], &["model"], &["state_dict"], &["model_state_dict"], &["model", "state_dict"]] {
        let wrapped = wrappers.iter().rev().fold(inner.clone(), |inner, &key| {
            dict(&[&other[..], &[(key, inner), ("loss", tensor("FloatStorage", "0", &[]))]].concat())
        });
        let bytes = files(&program(&wrapped));
        let state = StateDict::parse(&bytes).unwrap();
        assert_eq!(state.shapes().into_iter().collect::<Vec<_>>(), [("w", &[1usize][..])], "{wrappers:?}");
        assert_eq!(state.arrays().unwrap()["w"].values, [1.0]);
    }
}

#[test]
fn functions_are_refused_by_name() {
    let call = b"cos\nsystem\nX\x04\0\0\0true\x85R";
    let wrapped = dict(&[("w", tensor("FloatStorage", "0", &[1])), ("x", call.to_vec())]);
    for object in [&call[..], &wrapped] {
        let problem = problem(&pickled(&program(object)));
        assert!(problem.contains("wants to run `os.system`") && problem.contains("torch.save("), "{problem}");
    }
    for global in [
        "builtins\neval",
        "torch\nload",
        "torch\nFloatStorage.from_file",
        "torch\n_utils.FloatStorage",
        "torch._utils\n_rebuild_sparse_tensor",
        "torch.storage\nFloatStorage",
        "collections\nnamedtuple",
        "__main__\nNetwork",
    ] {
        let wanted = format!("`{}`", global.replace('\n', "."));
        let problem = problem(&pickled(&program(format!("c{global}\n").as_bytes())));
        assert!(problem.contains(&wanted), "{problem}");
    }
    let long = format!("c\x1b{}\nname\n", "x".repeat(100_000));
    assert!(problem(&pickled(&program(long.as_bytes()))).contains("…"));
}

#[test]
fn files_of_another_kind_are_told_from_damaged_ones() {
    let old = b"\x80\x02\x8A\x0Al\xFC\x9CF\xF9 j\xA8P\x19.\x80\x02M\xE9\x03.";
    let framed = b"\x80\x04\x95\x0D\0\0\0\0\0\0\0\x8A\x0Al\xFC\x9CF\xF9 j\xA8P\x19.";
    for old in [&old[..], framed] {
        assert!(problem(old).contains("torch.save(torch.load("));
        assert_eq!(Weights::parse(old).unwrap_err(), problem(old));
    }
    let zipped = |files: &[(&str, &[u8])]| zipped(files, CompressionMethod::Stored);
    assert!(problem(b"nothing").contains("no zip archive"));
    assert!(problem(&SAVED[..5000]).contains("damaged"));
    assert!(problem(&zipped(&[("arr_0.npy", b"x")])).contains("none that torch.save wrote"));
    assert!(problem(&zipped(&[("data.pkl", b"x")])).contains("none that torch.save wrote"));
    assert!(problem(&zipped(&[("a/data.pkl", b"N."), ("a/constants.pkl", b"")])).contains("TorchScript"));
    assert!(problem(&zipped(&[("a/data.pkl", b"N."), ("a/byteorder", b"middle")])).contains("byteorder"));
    assert!(problem(&pickled(b"\x80\x04}.")).contains("protocol 4"));
    assert!(problem(&pickled(b"\x80\x02I1\n.")).contains("instruction 0x49 at byte 2"));
    for nothing in [&b"\x80\x02}."[..], b"\x80\x02K\x01.", b"\x80\x02]."] {
        assert!(problem(&pickled(nothing)).contains("no tensors by name"));
    }
    let whole = program(&dict(&[("w", tensor("LongStorage", "0", &[1]))]));
    assert!(problem(&pickled(&whole)).contains("`w` is of a torch.LongStorage"));
}

#[test]
fn broken_programs_are_refused() {
    for broken in [
        &b""[..],
        b"\x80\x02",
        b".",
        b"(.",
        b"K\x01(.",
        b"t.",
        b"\x85.",
        b"h\0.",
        b"q\0.",
        b"j\0\0\0\xFF.",
        b"}K\x01\x85u.",
        b"}(K\x01u.",
        b"K\x01(K\x01K\x02u.",
        b"K\x01K\x01a.",
        b"K\x01}b.",
        b"K\x01)R.",
        b"ccollections\nOrderedDict\nK\x01R.",
        b"ccollections\nOrderedDict\nK\x01\x85R.",
        b"ctorch\nFloatStorage\n)R.",
        b"ctorch._utils\n_rebuild_parameter\nK\x01K\x01K\x01\x87R.",
        b"ctorch._utils\n_rebuild_tensor_v2\n)R.",
        b"ctorch",
        b"c\xFF\n\xFF\n",
        b"X\xFF\xFF\xFF\xFFabc",
        b"X\x01\0\0\0\xFF.",
        b"\x8A\xFFabc",
        b"K\x01Q.",
        b")Q.",
    ] {
        assert!(problem(&pickled(broken)).contains("pickle is damaged at byte"), "{broken:?}");
    }
}

#[test]
fn sizes_that_a_file_does_not_have_cost_nothing() {
    // A tensor of four numbers that claims 10¹²: by its storage as well, or by its strides alone.
    let large = |length: &[u8], shape: &[u8], stride: &[u8]| {
        let storage =
            [&b"("[..], &text("storage"), b"ctorch\nFloatStorage\n", &text("0"), &text("cpu"), length, b"tQ"];
        let tensor =
            [b"ctorch._utils\n_rebuild_tensor_v2\n(", &storage.concat()[..], b"K\0", shape, b"\x85", stride];
        let pickle = program(&dict(&[("w", [&tensor.concat()[..], b"\x85\x89}tR"].concat())]));
        zipped(&[("a/data.pkl", &pickle), ("a/data/0", &[0; 16])], CompressionMethod::Deflated)
    };
    let (four, million, huge) = (b"K\x04", b"\x8A\x06\0\x10\xA5\xD4\xE8\0", b"\x8A\x08\0\0\0\0\0\0\0\x7F");
    let bytes = large(million, million, b"K\x01");
    assert!(StateDict::parse(&bytes).unwrap().arrays().unwrap_err().contains("has 16 bytes instead of"));
    let bytes = large(huge, huge, b"K\x01");
    assert!(StateDict::parse(&bytes).unwrap().arrays().unwrap_err().contains("too large"));
    assert!(problem(&large(four, million, b"K\x01")).contains("not within its storage"));
    assert!(problem(&large(four, huge, huge)).contains("not within its storage"));
    // One number, repeated, is valid. No network has such a tensor, and this is found before the data is read.
    let bytes = large(four, million, b"K\0");
    let state = StateDict::parse(&bytes).unwrap();
    assert!(state.network().is_err() && state.weights(&config()).is_err());
    let bytes = large(b"K\x03", b"K\x03", b"K\x01");
    assert!(StateDict::parse(&bytes).unwrap().arrays().unwrap_err().contains("more than 12 bytes"));
    // A pickle that is a thousand times larger than the file.
    let long = zipped(&[("a/data.pkl", &[b'N'; 1 << 20])], CompressionMethod::Deflated);
    assert!(problem(&long).contains("`data.pkl` has more than"));
}

#[test]
fn entries_that_are_one_are_refused() {
    let mut bytes = pickled(&program(b"}"));
    let mut zip = ZipWriter::new_append(Cursor::new(&mut bytes)).unwrap();
    zip.shallow_copy_file("a/data.pkl", "a/data/0").unwrap();
    zip.finish().unwrap();
    assert!(problem(&bytes).contains("two entries are one"));
}

/// Asserts that a file is read or refused with one line, and that weights, once read, are the saved ones.
fn check(bytes: &[u8], expected: Option<&Weights>) {
    let found = StateDict::parse(bytes).and_then(|state| {
        let _ = state.network();
        state.weights(&config())
    });
    match found {
        Ok(weights) => assert!(expected.is_none_or(|expected| weights.arrays() == expected.arrays())),
        Err(problem) => assert!(!problem.contains(char::is_control) && problem.len() < 600, "{problem}"),
    }
}

#[test]
fn no_truncation_and_no_flipped_bit_makes_other_weights() {
    let weights = Weights::random(&config(), 7).unwrap();
    for length in 0..SAVED.len() {
        assert!(StateDict::parse(&SAVED[..length]).is_err(), "{length}");
    }
    let mut bytes = SAVED.to_vec();
    for at in 0..SAVED.len() {
        bytes[at] ^= 1 << (at % 8);
        check(&bytes, Some(&weights));
        bytes[at] = SAVED[at];
    }
}

proptest! {
    #[test]
    fn damaged_pickles_are_one_line_errors(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
    ) {
        let mut pickle = saved_pickle();
        for (at, byte) in changes {
            *at.get_mut(&mut pickle) = byte;
        }
        if is_cut {
            pickle.truncate(cut.index(pickle.len()));
        }
        check(&with_pickle(&pickle), None);
    }

    #[test]
    fn programs_of_random_instructions_are_one_line_errors(
        instructions in prop::collection::vec((0..INSTRUCTIONS.len(), any::<u8>()), 0..60),
    ) {
        let program = instructions.iter().flat_map(|&(at, byte)| {
            let operands = if b"Kqh".contains(&INSTRUCTIONS[at][0]) { vec![byte % 4] } else { vec![] };
            [INSTRUCTIONS[at], &operands[..]].concat()
        });
        check(&with_pickle(&program.collect::<Vec<_>>()), None);
    }
}

/// Instructions that are complete, or need one more byte.
const INSTRUCTIONS: [&[u8]; 28] = [
    b"(",
    b"N",
    b"Q",
    b"R",
    b"]",
    b"a",
    b"b",
    b"e",
    b"s",
    b"t",
    b"u",
    b"}",
    b")",
    b"\x85",
    b"\x86",
    b"\x87",
    b"\x89",
    b"K",
    b"q",
    b"h",
    b".",
    b"X\x07\0\0\0storage",
    b"X\x01\0\0\x000",
    b"X\x05\0\0\0model",
    b"ctorch\nHalfStorage\n",
    b"ccollections\nOrderedDict\n",
    b"ctorch._utils\n_rebuild_tensor_v2\n",
    b"ctorch._utils\n_rebuild_parameter\n",
];

/// Replaces the pickle in the file that PyTorch saved.
fn with_pickle(pickle: &[u8]) -> Vec<u8> {
    let archive = Archive::open(SAVED).unwrap();
    let storages: Vec<(String, Vec<u8>)> = (0..20)
        .map(|key| (format!("a/data/{key}"), archive.read(&format!("data/{key}"), 10_000).unwrap()))
        .collect();
    let mut files = vec![("a/data.pkl", pickle)];
    files.extend(storages.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])));
    zipped(&files, CompressionMethod::Stored)
}
