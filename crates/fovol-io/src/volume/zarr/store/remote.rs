//! A hierarchy in a folder on a web server, such as an object store.

use super::known_metadata::Known;
use super::metadata::is_metadata;
use super::web_file::{Parts, WebFile};
use super::{Blob, Store};
use crate::natural_order;
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use std::io;
use ureq::Agent;

/// A folder of a web server, by its address.
pub struct Remote {
    /// The address without its query, and the query with its question mark.
    base: String,
    query: String,
    agent: Agent,
    metadata: Known,
    /// Names of folders by the folder that they are in, as far as the consolidated metadata have them: servers list nothing.
    folders: HashMap<String, BTreeSet<String>>,
}

impl Remote {
    /// The hierarchy at the address `url`.
    ///
    /// # Errors
    /// A server that cannot be reached.
    pub fn open(url: &str) -> io::Result<Self> {
        let (base, query) =
            url.split_once('?').map_or((url, String::new()), |(base, query)| (base, format!("?{query}")));
        let mut remote = Self {
            base: base.trim_end_matches('/').to_owned(),
            query,
            agent: WebFile::agent(),
            metadata: Known::default(),
            folders: HashMap::new(),
        };
        for (file, of) in [("zarr.json", "consolidated_metadata"), (".zmetadata", "")] {
            let mut text = Vec::new();
            if remote.read(file, &mut text)? {
                let said = serde_json::from_slice::<Value>(&text).unwrap_or_default();
                let said = if of.is_empty() { &said } else { &said[of] };
                said["metadata"]
                    .as_object()
                    .into_iter()
                    .flatten()
                    .for_each(|(path, _)| remote.add_folders(path));
            }
        }
        Ok(remote)
    }

    /// Notes the folders of the path of a node, or of a file of its metadata.
    fn add_folders(&mut self, path: &str) {
        let folder =
            if is_metadata(path) { path.rsplit_once('/').map_or("", |(folder, _)| folder) } else { path };
        let mut parent = String::new();
        for name in folder.split('/').filter(|name| !name.is_empty()) {
            self.folders.entry(parent.clone()).or_default().insert(name.to_owned());
            parent = if parent.is_empty() { name.to_owned() } else { format!("{parent}/{name}") };
        }
    }

    fn file(&self, key: &str) -> WebFile {
        let url = format!("{}/{}{}", self.base, encoded(key), self.query);
        WebFile::new(url, self.agent.clone())
    }
}

impl Store for Remote {
    fn read(&self, key: &str, out: &mut Vec<u8>) -> io::Result<bool> {
        self.metadata.read(key, out, || self.file(key).read())
    }

    fn open(&self, key: &str) -> io::Result<Option<Box<dyn Blob>>> {
        let file = self.file(key);
        Ok(match file.head()? {
            None => None,
            Some(Some(length)) => Some(Box::new(Parts { file, length })),
            // Some servers tell no lengths.
            Some(None) => file.read()?.map(|bytes| Box::new(bytes) as Box<dyn Blob>),
        })
    }

    fn has(&self, key: &str) -> bool {
        self.file(key).head().is_ok_and(|found| found.is_some())
    }

    fn folders(&self, key: &str) -> Vec<String> {
        let mut names: Vec<String> = self.folders.get(key).into_iter().flatten().cloned().collect();
        names.sort_by(|a, b| natural_order::compare(a, b));
        names
    }
}

/// `key` as a part of an address.
fn encoded(key: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte);
    let part = |byte: u8| if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    key.bytes().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use std::io::{BufRead, BufReader, Write};
    use std::net::TcpListener;

    /// Serves `files` on this machine until the test ends; returns the address. With `parts`, it answers requests for parts.
    fn serve(files: BTreeMap<&'static str, Vec<u8>>, parts: bool) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                let mut stream = stream.unwrap();
                let mut lines = BufReader::new(stream.try_clone().unwrap()).lines().map_while(Result::ok);
                let first = lines.next().unwrap_or_default();
                let range = lines.take_while(|line| !line.is_empty()).find_map(|line| {
                    let range = line.to_lowercase().strip_prefix("range: bytes=")?.to_owned();
                    let (first, last) = range.split_once('-')?;
                    Some(first.parse::<usize>().ok()?..last.parse::<usize>().ok()? + 1)
                });
                let mut words = first.split_whitespace();
                let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
                let (status, content) = match (files.get(&path[1.min(path.len())..]), range) {
                    (None, _) => ("404 Not Found", &[][..]),
                    (Some(file), Some(range)) if parts => ("206 Partial Content", &file[range]),
                    (Some(file), _) => ("200 OK", &file[..]),
                };
                let head = format!(
                    "HTTP/1.1 {status}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
                    content.len()
                );
                let body = if method == "HEAD" { &[][..] } else { content };
                let _ = stream.write_all(&[head.as_bytes(), body].concat());
            }
        });
        address
    }

    #[test]
    fn files_are_read_whole_and_in_parts() {
        for parts in [true, false] {
            let files = BTreeMap::from([("a/c/0%200", b"0123456789".to_vec())]);
            let remote = Remote::open(&format!("{}/a/", serve(files, parts))).unwrap();
            let mut out = Vec::new();
            assert!(remote.read("c/0 0", &mut out).unwrap() && out == b"0123456789");
            assert!(!remote.read("c/0/1", &mut out).unwrap() && out.is_empty());
            assert!(remote.has("c/0 0") && !remote.has("c"));
            let blob = remote.open("c/0 0").unwrap().unwrap();
            assert_eq!((blob.length(), blob.part(3..6, &mut out).unwrap()), (10, &b"345"[..]));
            assert!(remote.open("d").unwrap().is_none());
        }
    }

    #[test]
    fn consolidated_metadata_list_folders() {
        let v2 =
            br#"{"metadata":{".zgroup":{},"scans/.zgroup":{},"scans/b10/.zarray":{},"scans/b9/.zarray":{}}}"#;
        let v3 = br#"{"consolidated_metadata":{"metadata":{"scans":{},"scans/b10":{},"scans/b9":{}}}}"#;
        for (name, text) in [(".zmetadata", &v2[..]), ("zarr.json", &v3[..])] {
            let remote = Remote::open(&serve(BTreeMap::from([(name, text.to_vec())]), true)).unwrap();
            assert_eq!(remote.folders(""), ["scans"]);
            assert_eq!(remote.folders("scans"), ["b9", "b10"]);
        }
    }

    #[test]
    fn servers_that_are_not_there_are_named() {
        let address = format!("http://{}", TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap());
        let error = Remote::open(&address).err().unwrap().to_string();
        assert!(error.contains(&address) && error.contains("cannot be reached"), "{error}");
    }
}
