//! Lists of numbers, and files, as they are written on a command line.

/// Reads `N` finite numbers separated by commas, as in `0.5,1,0.3`.
///
/// # Errors
/// Another count, or something that is no finite number.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let bad = || format!("`{text}` is not {N} finite numbers separated by commas");
    let all: Vec<f64> =
        text.split(',').map(|s| s.trim().parse::<f64>()).collect::<Result<_, _>>().map_err(|_| bad())?;
    if all.iter().any(|x| !x.is_finite()) {
        return Err(bad());
    }
    all.try_into().map_err(|_| bad())
}

/// Reads `N` whole numbers separated by commas (or `x`), as in `256,256,128`.
///
/// # Errors
/// Another count, or something that is no whole number.
pub fn whole_numbers<const N: usize>(text: &str) -> Result<[usize; N], String> {
    let bad = || format!("`{text}` is not {N} whole numbers separated by commas");
    let all: Vec<usize> = text
        .split([',', 'x'])
        .map(|s| s.trim().parse::<usize>())
        .collect::<Result<_, _>>()
        .map_err(|_| bad())?;
    all.try_into().map_err(|_| bad())
}

/// Reads one finite number.
///
/// # Errors
/// Anything else, `nan` and `inf` included.
pub fn number(text: &str) -> Result<f64, String> {
    numbers::<1>(text).map(|[x]| x).map_err(|_| format!("`{text}` is no finite number"))
}

/// Takes the name of a file, or another word in its place; of whatever bytes a system allows, as the text that
/// [`fovol_core::text_of_path`] makes of them.
#[cfg(feature = "clap")]
pub fn file() -> impl clap::builder::TypedValueParser<Value = String> {
    use clap::builder::{OsStringValueParser, TypedValueParser};
    OsStringValueParser::new().map(|name| fovol_core::text_of_path(name.as_ref()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_have_their_length() {
        assert_eq!(numbers::<3>("0.5, 1,-0.3"), Ok([0.5, 1.0, -0.3]));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,inf,3"] {
            assert!(numbers::<3>(bad).is_err(), "{bad}");
        }
        assert_eq!(whole_numbers::<3>("4,5,6"), Ok([4, 5, 6]));
        assert!(whole_numbers::<3>("4,5,-6").is_err());
        assert!(number("NaN").is_err());
    }
}
