//! The text of an NRRD header: `field: value` lines, comments, key/value pairs, an empty line.

use crate::Result;
use crate::volume::Source;

/// A header is shorter than this, a list of many data files included.
const LONGEST: usize = 4 << 20;

/// The fields of a header, and where it ends.
pub struct Header {
    /// Names in lower case without blanks, and values.
    fields: Vec<(String, String)>,
    /// The key/value pairs; they are never fields, even under the name of one.
    keys: Vec<(String, String)>,
    /// The lines below `data file: LIST`.
    pub listed: Vec<String>,
    /// Where the data begins when it is attached; none when no empty line ends the header.
    pub end: Option<usize>,
}

impl Header {
    /// Reads the header of `source`.
    ///
    /// # Errors
    /// Lines that no header has.
    pub fn parse(source: &Source) -> Result<Self> {
        if !source.bytes().starts_with(b"NRRD000") {
            return Err(
                source.malformed("it does not begin with NRRD000 as NRRD headers do; is the name right?")
            );
        }
        let mut header = Self { fields: Vec::new(), keys: Vec::new(), listed: Vec::new(), end: None };
        let bytes = &source.bytes()[..source.bytes().len().min(LONGEST)];
        let mut at = 0;
        let mut is_list = false;
        for (number, line) in bytes.split_inclusive(|&byte| byte == b'\n').enumerate() {
            at += line.len();
            let line = String::from_utf8_lossy(line);
            let line = line.trim_end_matches(['\n', '\r']);
            if number == 0 {
                continue;
            }
            if line.is_empty() {
                header.end = Some(at);
                break;
            }
            if line.starts_with('#') {
                continue;
            }
            if is_list {
                header.listed.push(line.trim().to_owned());
                continue;
            }
            let Line { is_key, name, value } = Line::of(line).ok_or_else(|| {
                let shown: String = line.chars().take(40).collect();
                source.malformed(format!(
                    "line {} of its NRRD header is no field: `{}`",
                    number + 1,
                    shown.escape_debug()
                ))
            })?;
            if is_key {
                header.keys.push((name, value));
                continue;
            }
            is_list = name == "datafile" && value.split_whitespace().next() == Some("LIST");
            header.fields.push((name, value));
        }
        Ok(header)
    }

    /// The value of `field`, a name in lower case without blanks.
    pub fn get(&self, field: &str) -> Option<&str> {
        let found = value_of(&self.fields, field);
        // Some writers put `byte skip:= -1`.
        found.or_else(|| self.key(field).filter(|_| matches!(field, "byteskip" | "lineskip")))
    }

    /// The value of `key`, a name in lower case without blanks.
    pub fn key(&self, key: &str) -> Option<&str> {
        value_of(&self.keys, key)
    }
}

fn value_of<'a>(pairs: &'a [(String, String)], name: &str) -> Option<&'a str> {
    pairs.iter().find(|(found, _)| found == name).map(|(_, value)| value.as_str())
}

/// `name: value` or `key:=value`.
struct Line {
    is_key: bool,
    name: String,
    value: String,
}

impl Line {
    fn of(line: &str) -> Option<Self> {
        // Keys may hold colons, and so may the values of fields.
        let key = line.split_once(":=").filter(|(name, _)| !name.contains(": "));
        let (name, value) = key.or_else(|| line.split_once(':'))?;
        let name = name.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_ascii_lowercase();
        Some(Self { is_key: key.is_some(), name, value: value.trim().to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn header(text: &str) -> Result<Header> {
        Header::parse(&Source::from_bytes(Path::new("x.nrrd"), text.as_bytes().to_vec()))
    }

    #[test]
    fn fields_comments_and_the_end() {
        let text = "NRRD0004\r\n# note: no\r\nData File: a.raw\r\nbyte skip:= -1\r\n\r\nDATA";
        let header = header(text).unwrap();
        assert_eq!(header.get("datafile"), Some("a.raw"));
        assert_eq!(header.get("byteskip"), Some("-1"));
        assert_eq!(header.get("note"), None);
        assert_eq!(header.end, Some(text.len() - 4));
    }

    #[test]
    fn keys_are_no_fields() {
        let header =
            header("NRRD0004\nsizes:=9 9\nSpace:=MNI\nsizes: 2 2\nnote: a:=b\nSegment0_ID:=x\n\n").unwrap();
        assert_eq!(header.get("sizes"), Some("2 2"));
        assert_eq!((header.get("space"), header.key("space")), (None, Some("MNI")));
        assert_eq!((header.get("note"), header.key("segment0_id")), (Some("a:=b"), Some("x")));
    }

    #[test]
    fn lists_go_on_to_the_end() {
        let header = header("NRRD0004\ndata file: LIST\na:1.raw\nb.raw").unwrap();
        assert_eq!(header.listed, ["a:1.raw", "b.raw"]);
        assert_eq!(header.end, None);
    }

    #[test]
    fn lines_without_a_field_are_errors() {
        let error = header("NRRD0004\nsizes 3 3").err().unwrap().to_string();
        assert!(error.contains("line 2") && !error.contains('\n'), "{error}");
    }
}
