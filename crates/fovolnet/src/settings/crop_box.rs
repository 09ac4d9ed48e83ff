use super::parse;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Part of a volume that is shown: from and to along x, y and z, as fractions of the sides of its grid. The sides are
/// checked when they are used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 6]", into = "[f64; 6]")]
pub struct CropBox {
    /// From and to along each axis.
    pub sides: [[f64; 2]; 3],
}

impl CropBox {
    /// Box of the whole volume.
    pub const WHOLE: Self = Self { sides: [[0.0, 1.0]; 3] };

    /// Checks that the sides lie within [0, 1] and rise.
    ///
    /// # Errors
    /// The first axis whose sides do not.
    pub fn check(&self) -> Result<()> {
        for ([from, to], name) in self.sides.into_iter().zip(["x", "y", "z"]) {
            if !(0.0 <= from && from < to && to <= 1.0) {
                return Err(Error::Setting(format!(
                    "{from},{to} is no part along {name}; --clip takes X0,X1,Y0,Y1,Z0,Z1, each pair rising within 0 and 1"
                )));
            }
        }
        Ok(())
    }

    /// Lower ends of the three sides, then upper ends.
    pub fn ends(&self) -> [[f64; 3]; 2] {
        [0, 1].map(|end| self.sides.map(|side| side[end]))
    }
}

impl From<[f64; 6]> for CropBox {
    fn from([x0, x1, y0, y1, z0, z1]: [f64; 6]) -> Self {
        Self { sides: [[x0, x1], [y0, y1], [z0, z1]] }
    }
}

impl From<CropBox> for [f64; 6] {
    fn from(CropBox { sides: [[x0, x1], [y0, y1], [z0, z1]] }: CropBox) -> Self {
        [x0, x1, y0, y1, z0, z1]
    }
}

impl fmt::Display for CropBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&<[f64; 6]>::from(*self).map(|number| number.to_string()).join(","))
    }
}

impl FromStr for CropBox {
    type Err = String;

    /// Parses `X0,X1,Y0,Y1,Z0,Z1`.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        parse::numbers::<6>(text).map(Self::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_read_back() {
        let half = CropBox { sides: [[0.0, 1.0], [0.25, 0.5], [0.0, 1.0]] };
        assert_eq!(half.to_string(), "0,1,0.25,0.5,0,1");
        assert_eq!(half.to_string().parse(), Ok(half));
        assert_eq!(half.ends(), [[0.0, 0.25, 0.0], [1.0, 0.5, 1.0]]);
    }

    #[test]
    fn sides_that_are_none_are_refused() {
        for side in [[0.5, 0.2], [-0.1, 1.0], [0.0, 1.1], [0.3, 0.3], [f64::NAN, 1.0]] {
            let bad = CropBox { sides: [[0.0, 1.0], side, [0.0, 1.0]] };
            let error = bad.check().unwrap_err().to_string();
            assert!(error.contains("along y") && error.contains("--clip"), "{error}");
        }
        CropBox::WHOLE.check().unwrap();
    }
}
