use std::fmt;
use std::str::FromStr;

/// Setting that is `auto` or a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Choice<T> {
    /// The program decides.
    Auto,
    /// The user decides for this value.
    Fixed(T),
}

impl<T: Copy> Choice<T> {
    /// The value, or `None` for `auto`.
    pub fn fixed(self) -> Option<T> {
        match self {
            Self::Auto => None,
            Self::Fixed(value) => Some(value),
        }
    }
}

impl<T> From<T> for Choice<T> {
    fn from(value: T) -> Self {
        Self::Fixed(value)
    }
}

impl<T: fmt::Display> fmt::Display for Choice<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Fixed(value) => value.fmt(f),
        }
    }
}

impl<T: FromStr<Err = String>> FromStr for Choice<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.eq_ignore_ascii_case("auto") {
            true => Ok(Self::Auto),
            false => text.parse().map(Self::Fixed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Sampling;
    use super::*;

    #[test]
    fn choices_read_back() {
        for choice in [Choice::Auto, Choice::Fixed(Sampling::Full)] {
            assert_eq!(choice.to_string().parse(), Ok(choice));
        }
        assert!("fulll".parse::<Choice<Sampling>>().unwrap_err().contains("did you mean full?"));
    }
}
