use super::progress::{Stage, Watch};
use super::{Error, Result};
use crate::http::agent;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::time::Duration;
use ureq::Body;
use ureq::http::Response;

/// A silence longer than this counts as a broken connection; Ctrl-C is heard after it at the latest.
const PATIENCE: Duration = Duration::from_secs(20);

/// Receives the `total` bytes at `url` into `part`, from where an earlier run left off if the server
/// can; returns how many bytes were there already.
pub(super) fn receive(url: &str, total: u64, part: &Path, watch: &mut Watch<'_>) -> Result<u64> {
    let held = held_bytes(part, total)?;
    if held == total {
        return Ok(held);
    }
    let (start, response) = open(url, held)?;
    if let Some(length) = response.body().content_length()
        && start + length != total
    {
        return Err(Error::WrongSize { url: url.into(), found: start + length, expected: total });
    }
    let mut file = open_part(part, start).map_err(|source| failed(part, source))?;
    copy(response.into_body().into_reader(), &mut file, part, [start, total], watch)?;
    file.sync_all().map_err(|source| failed(part, source))?;
    Ok(start)
}

fn failed(part: &Path, source: std::io::Error) -> Error {
    crate::Error::io("write", part, source).into()
}

/// Number of bytes that an earlier run left; 0 if they exceed the size of the file.
fn held_bytes(part: &Path, total: u64) -> Result<u64> {
    match fs::metadata(part) {
        Ok(metadata) => Ok(if metadata.len() > total { 0 } else { metadata.len() }),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(0),
        Err(e) => Err(crate::Error::io("read", part, e).into()),
    }
}

/// Asks for what follows the first `held` bytes; returns the position that the answer starts at: 0 when
/// the server sends everything regardless.
fn open(url: &str, held: u64) -> Result<(u64, Response<Body>)> {
    let mut request = agent(PATIENCE).get(url);
    if held > 0 {
        request = request.header("Range", format!("bytes={held}-"));
    }
    let response =
        request.call().map_err(|source| Error::Unreachable { url: url.into(), source: Box::new(source) })?;
    match response.status().as_u16() {
        200 => Ok((0, response)),
        206 if held > 0 && range_start(&response) == Some(held) => Ok((held, response)),
        // The server and the file disagree: start over.
        206 | 416 if held > 0 => open(url, 0),
        status => Err(Error::Status { url: url.into(), status }),
    }
}

/// The first position in `Content-Range: bytes FIRST-LAST/TOTAL`.
fn range_start(response: &Response<Body>) -> Option<u64> {
    let range = response.headers().get("content-range")?.to_str().ok()?;
    range.strip_prefix("bytes ")?.split('-').next()?.trim().parse().ok()
}

fn open_part(part: &Path, start: u64) -> std::io::Result<File> {
    let mut file = OpenOptions::new().write(true).create(true).truncate(false).open(part)?;
    file.set_len(start)?;
    file.seek(SeekFrom::Start(start))?;
    Ok(file)
}

fn copy(
    mut from: impl Read,
    file: &mut File,
    part: &Path,
    [start, total]: [u64; 2],
    watch: &mut Watch<'_>,
) -> Result<()> {
    let mut buffer = vec![0; 1 << 18];
    let mut received = start;
    let interrupted =
        |received, cause: String| Error::Interrupted { part: part.into(), received, total, cause };
    while received < total {
        if !watch.goes_on(Stage::Download, received, total) {
            return Err(Error::Cancelled { part: part.into() });
        }
        let wanted = buffer.len().min(usize::try_from(total - received).unwrap_or(usize::MAX));
        let count = match from.read(&mut buffer[..wanted]) {
            Ok(0) => return Err(interrupted(received, "the server closed the connection".into())),
            Ok(count) => count,
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            Err(e) => return Err(interrupted(received, e.to_string())),
        };
        file.write_all(&buffer[..count]).map_err(|source| failed(part, source))?;
        received += count as u64;
    }
    // The last report comes even when nothing is left to receive.
    let _ = watch.goes_on(Stage::Download, received, total);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;
    use std::time::Instant;

    #[test]
    fn a_head_that_drips_is_given_up() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/x", listener.local_addr().unwrap());
        std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let _ = stream.write_all(b"HTTP/1.1 200 OK\r\nX: ");
            // Ten seconds of a header that never ends.
            for _ in 0..100 {
                if stream.write_all(b"1").is_err() {
                    return;
                }
                std::thread::sleep(Duration::from_millis(100));
            }
        });
        let begun = Instant::now();
        let error = agent(Duration::from_millis(500)).get(&url).call().unwrap_err();
        assert!(begun.elapsed() < Duration::from_secs(8), "{:?}: {error}", begun.elapsed());
        assert!(matches!(error, ureq::Error::Timeout(_)), "{error}");
    }
}
