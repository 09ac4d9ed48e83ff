//! A hierarchy on a web server, such as an object store.

use super::{Blob, Store};
use crate::{http, natural_order};
use fovol_core::stop;
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use std::io::{self, Read};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use ureq::http::Response;
use ureq::{Agent, Body};

/// A silence longer than this counts as a broken connection.
const PATIENCE: Duration = Duration::from_secs(20);
/// How often a request is tried, and the wait before the second time; it doubles from one time to the next.
const TRIES: u32 = 3;
const WAIT: Duration = Duration::from_millis(250);

/// Files of metadata, which are read more than once.
const METADATA: [&str; 5] = ["zarr.json", ".zattrs", ".zgroup", ".zarray", ".zmetadata"];

/// A folder of a web server, by its address.
pub struct Remote {
    /// The address without its query, and the query with its question mark.
    base: String,
    query: String,
    agent: Agent,
    metadata: Mutex<HashMap<String, Option<Arc<[u8]>>>>,
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
            agent: http::agent(PATIENCE),
            metadata: Mutex::default(),
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
        let is_file = METADATA.contains(&path.rsplit('/').next().unwrap_or_default());
        let folder = if is_file { path.rsplit_once('/').map_or("", |(folder, _)| folder) } else { path };
        let mut parent = String::new();
        for name in folder.split('/').filter(|name| !name.is_empty()) {
            self.folders.entry(parent.clone()).or_default().insert(name.to_owned());
            parent = if parent.is_empty() { name.to_owned() } else { format!("{parent}/{name}") };
        }
    }

    fn url(&self, key: &str) -> String {
        format!("{}/{}{}", self.base, encoded(key), self.query)
    }

    /// The whole file `key`; none if there is none.
    fn get(&self, key: &str) -> io::Result<Option<Vec<u8>>> {
        let url = self.url(key);
        let Some(response) = asked(&url, || self.agent.get(&url).call())? else { return Ok(None) };
        body(response, &url).map(Some)
    }
}

impl Store for Remote {
    fn read(&self, key: &str, out: &mut Vec<u8>) -> io::Result<bool> {
        out.clear();
        let is_metadata = METADATA.contains(&key.rsplit('/').next().unwrap_or_default());
        if !is_metadata {
            let found = self.get(key)?;
            *out = found.unwrap_or_default();
            return Ok(!out.is_empty());
        }
        let known = || self.metadata.lock().unwrap_or_else(PoisonError::into_inner);
        let cached = known().get(key).cloned();
        let file = match cached {
            Some(file) => file,
            None => {
                let file = self.get(key)?.map(Arc::from);
                known().insert(key.to_owned(), file.clone());
                file
            }
        };
        out.extend_from_slice(file.as_deref().unwrap_or_default());
        Ok(file.is_some())
    }

    fn open(&self, key: &str) -> io::Result<Option<Box<dyn Blob>>> {
        let url = self.url(key);
        let Some(response) = asked(&url, || self.agent.head(&url).call())? else { return Ok(None) };
        let length =
            response.headers().get("content-length").and_then(|length| length.to_str().ok()?.parse().ok());
        Ok(match length {
            Some(length) => Some(Box::new(Part { url, length, agent: self.agent.clone() })),
            // Some servers tell no lengths.
            None => self.get(key)?.map(|bytes| Box::new(bytes) as Box<dyn Blob>),
        })
    }

    fn has(&self, key: &str) -> bool {
        let url = self.url(key);
        asked(&url, || self.agent.head(&url).call()).is_ok_and(|response| response.is_some())
    }

    fn folders(&self, key: &str) -> Vec<String> {
        let mut names: Vec<String> = self.folders.get(key).into_iter().flatten().cloned().collect();
        names.sort_by(|a, b| natural_order::compare(a, b));
        names
    }
}

/// A file on a web server, of which parts are asked for.
struct Part {
    url: String,
    length: usize,
    agent: Agent,
}

impl Blob for Part {
    fn length(&self) -> usize {
        self.length
    }

    fn part<'a>(&'a self, range: Range<usize>, scratch: &'a mut Vec<u8>) -> io::Result<&'a [u8]> {
        if range.is_empty() {
            return Ok(&[]);
        }
        let wanted = format!("bytes={}-{}", range.start, range.end - 1);
        let response = asked(&self.url, || self.agent.get(&self.url).header("Range", &wanted).call())?;
        let response = response.ok_or(io::ErrorKind::UnexpectedEof)?;
        // Servers without parts send the whole file.
        let is_whole = response.status().as_u16() == 200;
        *scratch = body(response, &self.url)?;
        let part = if is_whole {
            scratch.get(range)
        } else {
            Some(&scratch[..]).filter(|part| part.len() == range.len())
        };
        part.ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
    }
}

/// The answer to `ask`; none if there is no such file. Object stores say 403 for files that are not there.
fn asked(
    url: &str,
    ask: impl Fn() -> Result<Response<Body>, ureq::Error>,
) -> io::Result<Option<Response<Body>>> {
    let mut wait = WAIT;
    for attempt in 1.. {
        stop::point();
        let problem = match ask() {
            Ok(response) => match response.status().as_u16() {
                200 | 206 => return Ok(Some(response)),
                403 | 404 | 410 => return Ok(None),
                status @ (429 | 500..) if attempt < TRIES => format!("status {status}"),
                status => return Err(io::Error::other(format!("the server answers {status} to {url}"))),
            },
            Err(error) => error.to_string(),
        };
        if attempt == TRIES {
            return Err(io::Error::other(format!("{url} cannot be reached: {problem}")));
        }
        std::thread::sleep(wait);
        wait *= 2;
    }
    unreachable!("the last attempt returns")
}

fn body(response: Response<Body>, url: &str) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut reader = response.into_body().into_reader();
    // Memory grows with what has arrived, whatever the header claims.
    reader.read_to_end(&mut bytes).map_err(|error| io::Error::other(format!("{url} ends early: {error}")))?;
    Ok(bytes)
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
