//! Paths as text, for settings and session files that hold only text.
//!
//! A Unix path may contain any bytes. Bytes that are not UTF-8 are written `\xff`, as shells write them in `$'…'`.
//! Where a path itself has a backslash, `x` and two hexadecimal digits, that backslash is written `\x5c`. All other
//! paths are written unchanged. On other systems every Unicode path is written unchanged.

use std::borrow::Cow;
use std::path::Path;

/// Text of `path`, from which [`path_of_text`] restores the path exactly.
pub fn text_of_path(path: &Path) -> String {
    #[cfg(unix)]
    {
        use std::fmt::Write;
        use std::os::unix::ffi::OsStrExt;
        let mut text = String::new();
        for chunk in path.as_os_str().as_bytes().utf8_chunks() {
            let mut valid = chunk.valid();
            while let Some((at, _)) = escaped(valid) {
                text += &valid[..at];
                text += r"\x5c";
                valid = &valid[at + 1..];
            }
            text += valid;
            for byte in chunk.invalid() {
                write!(text, r"\x{byte:02x}").expect("strings take everything");
            }
        }
        text
    }
    #[cfg(not(unix))]
    path.display().to_string()
}

/// Path of the text `text`; inverse of [`text_of_path`].
pub fn path_of_text(text: &str) -> Cow<'_, Path> {
    #[cfg(unix)]
    if escaped(text).is_some() {
        use std::os::unix::ffi::OsStringExt;
        let (mut bytes, mut rest) = (Vec::new(), text);
        while let Some((at, byte)) = escaped(rest) {
            bytes.extend_from_slice(&rest.as_bytes()[..at]);
            bytes.push(byte);
            rest = &rest[at + ESCAPE..];
        }
        bytes.extend_from_slice(rest.as_bytes());
        return Cow::Owned(std::ffi::OsString::from_vec(bytes).into());
    }
    Cow::Borrowed(Path::new(text))
}

/// Display form of the path text `text`; bytes that are not Unicode become U+FFFD.
pub fn shown_path(text: &str) -> String {
    path_of_text(text).display().to_string()
}

/// Length of an escape such as `\xff`.
#[cfg(unix)]
const ESCAPE: usize = 4;

/// First escape `\xff` in `text`: its place and the byte.
#[cfg(unix)]
fn escaped(text: &str) -> Option<(usize, u8)> {
    let digit = |byte: u8| char::from(byte).to_digit(16);
    text.as_bytes().windows(ESCAPE).enumerate().find_map(|(at, window)| match window {
        [b'\\', b'x', high, low] => {
            let byte = 16 * digit(*high)? + digit(*low)?;
            Some((at, u8::try_from(byte).ok()?))
        }
        _ => None,
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    fn path(bytes: &[u8]) -> &Path {
        Path::new(OsStr::from_bytes(bytes))
    }

    #[test]
    fn what_is_unicode_is_its_own_text() {
        for text in ["head", "a/b c.nrrd", "Schädel×2.raw", r"a\b\xyz", r"a\x", r"\xf", ""] {
            assert_eq!(text_of_path(Path::new(text)), text);
            assert_eq!(path_of_text(text), Path::new(text));
        }
    }

    #[test]
    fn other_bytes_are_written_as_shells_do() {
        assert_eq!(text_of_path(path(b"scan\xff.nrrd")), r"scan\xff.nrrd");
        assert_eq!(path_of_text(r"scan\xFf.nrrd"), path(b"scan\xff.nrrd"));
        assert_eq!(text_of_path(Path::new(r"scan\xff.nrrd")), r"scan\x5cxff.nrrd");
        assert_eq!(shown_path(r"scan\xff.nrrd"), "scan\u{fffd}.nrrd");
    }

    proptest! {
        #[test]
        fn every_path_comes_back(bytes in proptest::collection::vec(prop_oneof![
            Just(b'\\'), Just(b'x'), Just(b'f'), Just(b'5'), Just(b'c'), Just(0xc3u8), any::<u8>()
        ], 0..24)) {
            let found = text_of_path(path(&bytes));
            let back = path_of_text(&found);
            prop_assert_eq!(back.as_os_str().as_bytes(), &bytes[..], "{}", found);
        }
    }
}
