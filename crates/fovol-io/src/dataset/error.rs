use std::path::PathBuf;

/// Why a published volume was not got. Every message is one line: what, where, how to mend it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A name that is not in the catalogue.
    #[error("`{name}` is no published volume{}; `fovolnet data list` shows them all", suggestion(near))]
    UnknownName {
        /// The name asked for.
        name: String,
        /// Names that come near.
        near: Vec<&'static str>,
    },
    #[cfg(feature = "download")]
    /// The server was not reached, or did not answer as a server does.
    #[error("cannot reach {url}: {source}; check the network or the proxy and run the same command again")]
    Unreachable {
        /// The address.
        url: String,
        /// The error of the HTTP client.
        source: Box<ureq::Error>,
    },
    /// The server declines.
    #[error("{url} answers with status {status}{}", status_advice(*status))]
    Status {
        /// The address.
        url: String,
        /// The HTTP status code, for example 404 if the file does not exist.
        status: u16,
    },
    /// The server has a file of another size.
    #[error(
        "{url} has {found} bytes where {expected} are expected; it is another file than the catalogue means, download it by hand and give --dims and --dtype"
    )]
    WrongSize {
        /// The address.
        url: String,
        /// Bytes offered.
        found: u64,
        /// Bytes that dims and type need.
        expected: u64,
    },
    /// The connection broke before the end. What came is kept.
    #[error(
        "the download stopped at {received} of {total} bytes ({cause}); {} is kept, run the same command again to go on from there",
        part.display()
    )]
    Interrupted {
        /// The incomplete file.
        part: PathBuf,
        /// Bytes received so far.
        received: u64,
        /// Bytes of the whole file.
        total: u64,
        /// The cause of the interruption.
        cause: String,
    },
    /// The user stopped it. What came is kept.
    #[error("stopped; {} is kept, run the same command again to go on from there", part.display())]
    Cancelled {
        /// The incomplete file.
        part: PathBuf,
    },
    /// The download is complete but not what is expected; it was removed.
    #[error(
        "the download of {url} has another SHA-512 ({}…) than {} ({}…) and was removed; run the same command again{}",
        &found[..16], known.source(), &known.hash()[..16], known.advice()
    )]
    HashDiffers {
        /// The address.
        url: String,
        /// The hash of what was received.
        found: String,
        /// The hash that was expected.
        known: KnownHash,
    },
    /// A file of the final name is there already and holds something else.
    #[error("{} is there already but {problem}; move it away or delete it and run the same command again", path.display())]
    Occupied {
        /// The file.
        path: PathBuf,
        /// The difference between the existing file and the expected one.
        problem: String,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] crate::Error),
}

/// The result of getting a published volume.
pub type Result<T> = std::result::Result<T, Error>;

/// A reference hash and its source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum KnownHash {
    /// From the catalogue.
    Published(String),
    /// From an earlier download.
    Recorded {
        /// The hash.
        hash: String,
        /// The file that holds it.
        record: PathBuf,
    },
}

impl KnownHash {
    /// The SHA-512 in lower-case hexadecimal digits.
    pub fn hash(&self) -> &str {
        match self {
            Self::Published(hash) | Self::Recorded { hash, .. } => hash,
        }
    }

    fn source(&self) -> String {
        match self {
            Self::Published(_) => "the published one".into(),
            Self::Recorded { record, .. } => format!("an earlier download, kept in {}", record.display()),
        }
    }

    fn advice(&self) -> &'static str {
        match self {
            Self::Published(_) => "",
            Self::Recorded { .. } => ", or delete that record if the publisher has changed the file",
        }
    }
}

fn suggestion(near: &[&str]) -> String {
    if near.is_empty() { String::new() } else { format!(", did you mean {}", near.join(" or ")) }
}

fn status_advice(status: u16) -> &'static str {
    match status {
        404 | 410 => ": the file is no longer there; look for it on the publisher's page",
        401 | 403 => ": access is denied; look on the publisher's page whether an account is needed",
        429 | 500..=599 => ": the server is overloaded or down; try again later",
        _ => "; look for the file on the publisher's page",
    }
}
