//! Parsers for values of command-line flags.

/// Parses `N` finite numbers separated by commas, such as `0.5,1,0.3`.
///
/// # Errors
/// Another count, or a part that is not a finite number.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let bad = || format!("`{text}` is not {N} finite numbers separated by commas");
    let all: Vec<f64> =
        text.split(',').map(|s| s.trim().parse::<f64>()).collect::<Result<_, _>>().map_err(|_| bad())?;
    if all.iter().any(|x| !x.is_finite()) {
        return Err(bad());
    }
    all.try_into().map_err(|_| bad())
}

/// Parses red, green and blue, such as `1,1,1` for white.
///
/// # Errors
/// Errors of [`numbers`], with examples.
pub fn colour(text: &str) -> Result<[f64; 3], String> {
    numbers(text).map_err(|problem| format!("{problem}; white is 1,1,1 and red is 1,0,0"))
}

/// Parses `N` whole numbers separated by commas (or `x`), such as `256,256,128`.
///
/// # Errors
/// Another count, or a part that is not a whole number.
pub fn whole_numbers<const N: usize>(text: &str) -> Result<[usize; N], String> {
    let bad = || format!("`{text}` is not {N} whole numbers separated by commas");
    let all: Vec<usize> = text
        .split([',', 'x'])
        .map(|s| s.trim().parse::<usize>())
        .collect::<Result<_, _>>()
        .map_err(|_| bad())?;
    all.try_into().map_err(|_| bad())
}

/// Parses one finite number.
///
/// # Errors
/// Anything else, also `nan` and `inf`.
pub fn number(text: &str) -> Result<f64, String> {
    numbers::<1>(text).map(|[x]| x).map_err(|_| format!("`{text}` is no finite number"))
}

/// Clap parser for file names, or words in their place. It accepts all bytes that the system allows, and returns the
/// text of [`fovol_core::text_of_path`].
#[cfg(feature = "clap")]
pub fn file() -> impl clap::builder::TypedValueParser<Value = String> {
    file_or::<String>()
}

/// Clap parser like [`file()`], for a type that takes file names and words apart.
#[cfg(feature = "clap")]
pub fn file_or<T>() -> impl clap::builder::TypedValueParser<Value = T>
where
    T: From<String> + Clone + Send + Sync + 'static,
{
    use clap::builder::{OsStringValueParser, TypedValueParser};
    OsStringValueParser::new().map(|name| T::from(fovol_core::text_of_path(name.as_ref())))
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
        assert_eq!(colour("1,0.5,0"), Ok([1.0, 0.5, 0.0]));
        assert!(colour("white").unwrap_err().contains("white is 1,1,1"));
        assert_eq!(whole_numbers::<3>("4,5,6"), Ok([4, 5, 6]));
        assert!(whole_numbers::<3>("4,5,-6").is_err());
        assert!(number("NaN").is_err());
    }
}
