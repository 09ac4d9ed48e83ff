//! Requests for files on web servers, whole or in part.

use super::Blob;
use crate::http;
use fovol_core::stop;
use std::io::{self, Read};
use std::ops::Range;
use std::time::Duration;
use ureq::http::Response;
use ureq::{Agent, Body};

/// A silence longer than this counts as a broken connection.
const PATIENCE: Duration = Duration::from_secs(20);
/// How often a request is tried, and the wait before the second time; it doubles from one time to the next.
const TRIES: u32 = 3;
const WAIT: Duration = Duration::from_millis(250);

/// A file on a web server.
#[derive(Clone)]
pub struct WebFile {
    /// The address.
    url: String,
    agent: Agent,
}

/// Answer of a server that was asked for a part of a file.
pub enum Answer {
    /// The part, and the bytes of the whole file if the server tells.
    Part(Vec<u8>, Option<usize>),
    /// The beginning of the whole file: the server sends no parts.
    Whole(Box<Response<Body>>),
}

impl WebFile {
    /// An agent for requests.
    pub fn agent() -> Agent {
        http::agent(PATIENCE)
    }

    /// The file at the address `url`.
    pub fn new(url: String, agent: Agent) -> Self {
        Self { url, agent }
    }

    /// The whole file; none if there is none.
    ///
    /// # Errors
    /// A server that cannot be reached, refuses or hangs up.
    pub fn read(&self) -> io::Result<Option<Vec<u8>>> {
        let Some(response) = self.asked(|| self.agent.get(&self.url).call())? else { return Ok(None) };
        self.body(response, u64::MAX).map(Some)
    }

    /// The answer to a request for the head of the file; none if there is no file. It has the length if the server tells.
    ///
    /// # Errors
    /// A server that cannot be reached or refuses.
    pub fn head(&self) -> io::Result<Option<Option<usize>>> {
        let Some(response) = self.asked(|| self.agent.head(&self.url).call())? else { return Ok(None) };
        let length = response.headers().get("content-length");
        Ok(Some(length.and_then(|length| length.to_str().ok()?.parse().ok())))
    }

    /// Asks for the bytes in `range`, which is not empty; none if there is no file. Less than the range comes where the
    /// file ends in it.
    ///
    /// # Errors
    /// A server that cannot be reached, refuses, hangs up or sends another part.
    pub fn ask(&self, range: Range<usize>) -> io::Result<Option<Answer>> {
        let wanted = format!("bytes={}-{}", range.start, range.end - 1);
        let Some(response) = self.asked(|| self.agent.get(&self.url).header("Range", &wanted).call())? else {
            return Ok(None);
        };
        // Servers without parts send the whole file.
        if response.status().as_u16() == 200 {
            return Ok(Some(Answer::Whole(Box::new(response))));
        }
        let told = told(&response);
        if told.is_some_and(|(first, _)| first != range.start) {
            return Err(self.failed("the server sends another part than it was asked for"));
        }
        let part = self.body(response, range.len() as u64)?;
        Ok(Some(Answer::Part(part, told.and_then(|(_, total)| total))))
    }

    /// The answer to `ask`; none if there is no such file. Object stores say 403 for files that are not there.
    fn asked(
        &self,
        ask: impl Fn() -> Result<Response<Body>, ureq::Error>,
    ) -> io::Result<Option<Response<Body>>> {
        let url = &self.url;
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

    /// The content of `response`, which may have `most` bytes.
    ///
    /// # Errors
    /// A server that hangs up or sends more.
    pub fn body(&self, response: Response<Body>, most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut reader = response.into_body().into_reader().take(most.saturating_add(1));
        // Memory grows with what has arrived, whatever the header claims.
        reader.read_to_end(&mut bytes).map_err(|error| self.failed(&format!("it ends early: {error}")))?;
        if bytes.len() as u64 > most {
            return Err(self.failed("the server sends more than it was asked for"));
        }
        Ok(bytes)
    }

    /// The error of a `problem` with the file.
    fn failed(&self, problem: &str) -> io::Error {
        io::Error::other(format!("{}: {problem}", self.url))
    }
}

/// The first position and the total in `Content-Range: bytes FIRST-LAST/TOTAL`.
fn told(response: &Response<Body>) -> Option<(usize, Option<usize>)> {
    let range = response.headers().get("content-range")?.to_str().ok()?.strip_prefix("bytes ")?;
    let (positions, total) = range.split_once('/')?;
    Some((positions.split('-').next()?.trim().parse().ok()?, total.trim().parse().ok()))
}

/// A file of a known length on a web server, of which parts are asked for.
pub struct Parts {
    /// The file.
    pub file: WebFile,
    /// Its length in bytes.
    pub length: usize,
}

impl Blob for Parts {
    fn length(&self) -> usize {
        self.length
    }

    fn part<'a>(&'a self, range: Range<usize>, scratch: &'a mut Vec<u8>) -> io::Result<&'a [u8]> {
        if range.is_empty() {
            return Ok(&[]);
        }
        let early = || io::Error::from(io::ErrorKind::UnexpectedEof);
        let part = match self.file.ask(range.clone())?.ok_or_else(early)? {
            Answer::Part(part, _) => {
                *scratch = part;
                Some(&scratch[..]).filter(|part| part.len() == range.len())
            }
            Answer::Whole(response) => {
                *scratch = self.file.body(*response, self.length as u64)?;
                scratch.get(range)
            }
        };
        part.ok_or_else(early)
    }
}
