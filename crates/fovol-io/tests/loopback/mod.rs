//! A web server for one file on this machine, as well or as badly behaved as a test needs.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;

/// How the server behaves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Manners {
    /// Honours ranges.
    Good,
    /// Sends everything, whatever range is asked for.
    NoRanges,
    /// Answers a range with other bytes than asked for.
    WrongRange,
    /// Closes the connection after so many bytes of the body.
    HangsUpAfter(usize),
    /// Answers with this status.
    Status(u16),
}

/// A running server; it ends with the test.
pub struct Server {
    /// The address of the file.
    pub url: String,
    /// The `Range` header of each request so far.
    pub ranges: Arc<Mutex<Vec<Option<String>>>>,
}

impl Server {
    /// Serves `content`.
    pub fn start(content: Vec<u8>, manners: Manners) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/file.raw", listener.local_addr().unwrap());
        let ranges = Arc::new(Mutex::new(Vec::new()));
        let seen = Arc::clone(&ranges);
        thread::spawn(move || {
            for stream in listener.incoming() {
                let range = read_request(stream.as_ref().unwrap());
                seen.lock().unwrap().push(range.clone());
                // The client may leave early: that is what some tests are about.
                let _ = answer(stream.unwrap(), &content, manners, range.as_deref());
            }
        });
        Self { url, ranges }
    }
}

fn read_request(stream: &TcpStream) -> Option<String> {
    let mut range = None;
    for line in BufReader::new(stream).lines() {
        let line = line.unwrap();
        if line.is_empty() {
            break;
        }
        if let Some(("range", value)) = line.to_ascii_lowercase().split_once(": ") {
            range = Some(value.to_owned());
        }
    }
    range
}

fn answer(mut to: TcpStream, content: &[u8], manners: Manners, range: Option<&str>) -> std::io::Result<()> {
    if let Manners::Status(status) = manners {
        return write!(to, "HTTP/1.1 {status} No\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    }
    let asked = range.filter(|_| manners != Manners::NoRanges).and_then(|range| bounds(range, content.len()));
    let (start, last) = asked.unwrap_or((0, content.len()));
    let length = last.saturating_sub(start);
    // A whole file from the beginning is no part.
    if length == content.len() {
        write!(to, "HTTP/1.1 200 OK\r\n")?;
    } else {
        let told = if manners == Manners::WrongRange { start.abs_diff(1) } else { start };
        write!(
            to,
            "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes {told}-{}/{}\r\n",
            last - 1,
            content.len()
        )?;
    }
    write!(to, "Content-Length: {length}\r\nConnection: close\r\n\r\n")?;
    let end = match manners {
        Manners::HangsUpAfter(bytes) => (start + bytes).min(last),
        _ => last,
    };
    to.write_all(&content[start..end])?;
    to.flush()
}

/// First position and end of `bytes=FIRST-LAST` or `bytes=FIRST-` in a file of `length` bytes.
fn bounds(range: &str, length: usize) -> Option<(usize, usize)> {
    let (first, last) = range.strip_prefix("bytes=")?.split_once('-')?;
    let end = if last.is_empty() { length } else { last.parse::<usize>().ok()? + 1 };
    Some((first.parse().ok()?, end.min(length)))
}
