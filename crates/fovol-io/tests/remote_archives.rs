//! Zip archives of Zarr on a web server on this machine: what is read there is what is read from the same file here.
#![cfg(feature = "remote")]

#[allow(dead_code, reason = "the tests of downloads use the rest")]
mod loopback;
#[allow(dead_code, reason = "the tests of damaged files use the rest")]
#[path = "mutation/zarr_files.rs"]
mod zarr_files;

use fovol_core::Volume;
use fovol_io::volume::{Overrides, Source, parse, read};
use loopback::{Manners, Server};
use std::path::Path;

/// Reads `archive` from a server of these manners. Returns the bytes that the program asked for, too.
fn remote(archive: &[u8], manners: Manners, overrides: &Overrides) -> (fovol_io::Result<Volume>, usize) {
    let server = Server::start(archive.to_vec(), manners);
    let url = server.url.replace("file.raw", "cells.zarr.ZIP?key=1");
    let volume = read(Path::new(&url), overrides);
    let asked = server.ranges.lock().unwrap().iter().map(|range| length(range.as_deref())).sum();
    (volume, asked)
}

/// Bytes of `bytes=FIRST-LAST`; none may be asked for otherwise.
fn length(range: Option<&str>) -> usize {
    let (first, last) = range.unwrap().strip_prefix("bytes=").unwrap().split_once('-').unwrap();
    last.parse::<usize>().unwrap() + 1 - first.parse::<usize>().unwrap()
}

fn local(archive: &[u8], overrides: &Overrides) -> fovol_io::Result<Volume> {
    parse(&Source::from_bytes(Path::new("cells.zarr.zip"), archive.to_vec()), overrides)
}

fn said(archive: &[u8], manners: Manners) -> String {
    remote(archive, manners, &Overrides::default()).0.unwrap_err().to_string()
}

#[test]
fn archives_are_read_as_files_are() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/zarr_files");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let samples = files.filter(|path| path.extension().is_some_and(|end| end == "zip" || end == "ozx"));
    let mut archives: Vec<Vec<u8>> = samples.map(|path| std::fs::read(path).unwrap()).collect();
    archives.extend(zarr_files::all().iter().map(|text| zarr_files::archive(text)));
    assert!(archives.len() > 50);
    for archive in &archives {
        for time in [None, Some(1)] {
            let overrides = Overrides { time, ..Overrides::default() };
            match (local(archive, &overrides), remote(archive, Manners::Good, &overrides).0) {
                (Ok(here), Ok(there)) => {
                    assert!(here.data() == there.data() && here.grid() == there.grid());
                    assert_eq!(here.contents(), there.contents());
                }
                (Err(_), Err(_)) => {}
                (here, there) => panic!("{here:?} here, {there:?} there"),
            }
        }
    }
}

/// An archive of `count` chunks with 1 MiB each, along the time axis, each of one value, and a directory longer than the
/// part in which its end is looked for.
fn large(codecs: &str, tail: &[u8]) -> Vec<u8> {
    let chunk = if tail.is_empty() { "1, 64, 128, 128" } else { "2, 64, 128, 128" };
    let mut text = format!(
        r#"=== zarr.json
{{"zarr_format": 3, "node_type": "array", "shape": [4, 64, 128, 128], "data_type": "uint8", "fill_value": 0,
"dimension_names": ["t", "z", "y", "x"], "chunk_grid": {{"name": "regular", "configuration": {{"chunk_shape": [{chunk}]}}}},
"chunk_key_encoding": {{"name": "default"}}, "codecs": [{codecs}]}}
"#
    )
    .into_bytes();
    let values = |value: u8| vec![value; 1 << 20];
    if tail.is_empty() {
        for time in 0..4 {
            text.extend([format!("=== c/{time}/0/0/0\n").as_bytes(), &values(time), b"\n"].concat());
        }
    } else {
        for shard in 0..2 {
            let chunks = [values(2 * shard), values(2 * shard + 1)].concat();
            text.extend([format!("=== c/{shard}/0/0/0\n").as_bytes(), &chunks, tail, b"\n"].concat());
        }
    }
    for other in 0..1200 {
        text.extend(format!("=== notes/{other:050}\n{other}\n").into_bytes());
    }
    text.pop();
    zarr_files::archive(&text)
}

#[test]
fn chunks_that_are_not_shown_are_not_asked_for() {
    let archive = large(r#"{"name": "bytes"}"#, &[]);
    let index: Vec<u8> = [0u64, 1 << 20, 1 << 20, 1 << 20].iter().flat_map(|n| n.to_le_bytes()).collect();
    let sharding = r#"{"name": "sharding_indexed", "configuration": {"chunk_shape": [1, 64, 128, 128],
"codecs": [{"name": "bytes"}], "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}], "index_location": "end"}}"#;
    let sharded = large(sharding, &index);
    for archive in [archive, sharded] {
        let overrides = Overrides { time: Some(3), ..Overrides::default() };
        let (volume, asked) = remote(&archive, Manners::Good, &overrides);
        assert_eq!(volume.unwrap().value([127, 127, 63]), 3.0);
        let shown = 1 << 20;
        assert!(archive.len() > 4 * shown && asked < 2 * shown, "{asked} of {}", archive.len());
    }
}

#[test]
fn servers_without_parts_are_refused() {
    let archive = large(r#"{"name": "bytes"}"#, &[]);
    let message = said(&archive, Manners::NoRanges);
    assert!(
        message.contains("sends no parts of files") && message.contains("download the file"),
        "{message}"
    );
}

#[test]
fn bad_answers_are_errors() {
    let archive = large(r#"{"name": "bytes"}"#, &[]);
    for (manners, part) in [
        (Manners::WrongRange, "another part"),
        (Manners::HangsUpAfter(2), "ends early"),
        (Manners::HangsUpAfter(70_000), "ends early"),
        (Manners::Status(404), "no such file"),
        (Manners::Status(416), "416"),
    ] {
        let message = said(&archive, manners);
        assert!(message.contains(part) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn damaged_archives_are_errors() {
    let sound = zarr_files::archive(&zarr_files::all()[0]);
    let end = sound.len() - 22;
    let with = |at: usize, new: &[u8]| {
        let mut damaged = sound.clone();
        damaged[at..at + new.len()].copy_from_slice(new);
        damaged
    };
    let directory = u32::from_le_bytes(sound[end + 16..end + 20].try_into().unwrap()) as usize;
    for damaged in [
        sound[..end].to_vec(),
        b"PK\x03\x04 and no more".to_vec(),
        with(end + 16, &[0xFF; 4]),
        with(end + 10, &[0xFF; 2]),
        // The header of the first member lies beyond the end.
        with(directory + 42, &[0xF0; 4]),
        // It has more bytes than the archive.
        with(directory + 20, &[0xF0; 8]),
        with(0, b"XX"),
        // Encrypted, and packed in another way.
        with(directory + 8, &[1]),
        with(directory + 10, &[99]),
    ] {
        let message = said(&damaged, Manners::Good);
        assert!(!message.contains('\n') && message.contains("; "), "{message}");
        assert!(local(&damaged, &Overrides::default()).is_err());
    }
    let other = zarr_files::archive(b"=== readme.txt\nno volume");
    assert!(said(&other, Manners::Good).contains("holds no Zarr"));
}
