//! Transfer syntaxes (PS3.5, chapter 10): how elements are written and pixels compressed.

use super::elements::{EXPLICIT_LITTLE, Encoding, IMPLICIT_LITTLE};

/// How pixels are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Codec {
    /// Not at all.
    None,
    /// Run lengths of byte planes.
    Rle,
    /// JPEG: baseline, extended or lossless.
    Jpeg,
    /// JPEG-LS.
    JpegLs,
    /// JPEG 2000.
    Jpeg2000,
}

/// A transfer syntax.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Syntax {
    /// How elements are written.
    pub encoding: Encoding,
    /// How pixels are compressed.
    pub codec: Codec,
    /// Whether all elements are compressed together.
    pub is_deflated: bool,
}

/// Where all transfer syntaxes of the standard are.
const ROOT: &str = "1.2.840.10008.1.2";

impl Syntax {
    /// The transfer syntax called `uid`.
    ///
    /// # Errors
    /// One that is not read, with advice.
    pub fn of(uid: &str) -> Result<Self, String> {
        let plain = |encoding| Self { encoding, codec: Codec::None, is_deflated: false };
        let packed = |codec| Self { codec, ..plain(EXPLICIT_LITTLE) };
        let Some(rest) = uid.strip_prefix(ROOT) else { return Err(unread(uid)) };
        Ok(match rest {
            "" => plain(IMPLICIT_LITTLE),
            ".1" | ".1.98" => plain(EXPLICIT_LITTLE),
            ".1.99" => Self { is_deflated: true, ..plain(EXPLICIT_LITTLE) },
            ".2" => plain(Encoding { is_big: true, ..EXPLICIT_LITTLE }),
            ".4.50" | ".4.51" | ".4.57" | ".4.70" => packed(Codec::Jpeg),
            ".4.80" | ".4.81" => packed(Codec::JpegLs),
            ".4.90" | ".4.91" => packed(Codec::Jpeg2000),
            ".5" => packed(Codec::Rle),
            _ => return Err(unread(uid)),
        })
    }
}

fn unread(uid: &str) -> String {
    let what = match uid.strip_prefix("1.2.840.10008.1.2.4.") {
        Some("100" | "101" | "102" | "103" | "104" | "105" | "106" | "107" | "108") => "a video".into(),
        Some("110" | "111" | "112") => "compressed by JPEG XL".into(),
        Some("201" | "202" | "203") => "compressed by high-throughput JPEG 2000".into(),
        _ => format!("written in the transfer syntax {}", uid.escape_debug()),
    };
    format!("it is {what}, which is not read; unpack it with `gdcmconv --raw IN OUT` or `dcmconv`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn syntaxes_have_uids() {
        assert_eq!(Syntax::of("1.2.840.10008.1.2.4.70").unwrap().codec, Codec::Jpeg);
        assert!(Syntax::of("1.2.840.10008.1.2.2").unwrap().encoding.is_big);
        assert!(!Syntax::of("1.2.840.10008.1.2").unwrap().encoding.is_explicit);
        assert!(Syntax::of("1.2.840.10008.1.2.4.102").unwrap_err().contains("a video"));
        assert!(Syntax::of("1.2.3\n").unwrap_err().contains(r"1.2.3\n"));
    }
}
