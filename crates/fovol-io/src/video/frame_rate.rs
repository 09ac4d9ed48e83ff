use std::fmt;
use std::str::FromStr;

/// Frames a second of a clip, as an exact fraction: above 0, up to 1000.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FrameRate {
    numerator: u32,
    denominator: u32,
}

/// Rates whose television variants run slower by 1000/1001: 24 as 23.976, 30 as 29.97.
const TELEVISION: [u32; 6] = [24, 30, 48, 60, 120, 240];
/// Decimals this close to a television rate mean that rate: people write 23.976 and 23.98.
const ROUNDING: f64 = 0.005;
/// The largest number on either side of the fraction, which containers can hold.
const LARGEST: u64 = 1_000_000;

impl FrameRate {
    /// `numerator`/`denominator` frames per second; none unless above 0 and at most 1000.
    pub fn new(numerator: u64, denominator: u64) -> Option<Self> {
        if numerator == 0 || denominator == 0 || numerator / denominator.max(1) > 1000 {
            return None;
        }
        let common = greatest_common_divisor(numerator, denominator);
        let [numerator, denominator] = [numerator / common, denominator / common];
        let is_held = numerator <= LARGEST && denominator <= LARGEST && numerator <= 1000 * denominator;
        is_held.then_some(Self { numerator: numerator as u32, denominator: denominator as u32 })
    }

    /// The number above the line.
    pub fn numerator(self) -> u32 {
        self.numerator
    }

    /// The number below the line.
    pub fn denominator(self) -> u32 {
        self.denominator
    }

    /// The television rate that `decimal` rounds; none for whole rates and all others.
    fn of_television(decimal: f64) -> Option<Self> {
        let near = |whole: &&u32| (decimal - f64::from(**whole) / 1.001).abs() < ROUNDING;
        TELEVISION.iter().find(near).and_then(|&whole| Self::new(u64::from(whole) * 1000, 1001))
    }
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl From<u32> for FrameRate {
    /// A whole rate, brought within 1 and 1000.
    fn from(rate: u32) -> Self {
        Self { numerator: rate.clamp(1, 1000), denominator: 1 }
    }
}

impl fmt::Display for FrameRate {
    /// Writes `30` or `30000/1001`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => write!(f, "{}", self.numerator),
            denominator => write!(f, "{}/{denominator}", self.numerator),
        }
    }
}

impl FromStr for FrameRate {
    type Err = String;

    /// Reads `30`, `30000/1001` or `23.976`.
    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || {
            format!(
                "`{text}` is no frame rate; write a number above 0 up to 1000, or a fraction as 30000/1001"
            )
        };
        let whole = |text: &str| text.trim().parse::<u64>().map_err(|_| bad());
        if let Some((numerator, denominator)) = text.split_once('/') {
            return Self::new(whole(numerator)?, whole(denominator)?).ok_or_else(bad);
        }
        let Some((before, after)) = text.trim().split_once('.') else {
            return Self::new(whole(text)?, 1).ok_or_else(bad);
        };
        let is_decimal = after.len() <= 6 && after.bytes().all(|b| b.is_ascii_digit());
        if !is_decimal || before.len() > 4 {
            return Err(bad());
        }
        let decimal: f64 = text.trim().parse().map_err(|_| bad())?;
        let scale = 10u64.pow(after.len() as u32);
        let exact = || Self::new(whole(&format!("{before}{after}")).ok()?, scale);
        Self::of_television(decimal).or_else(exact).ok_or_else(bad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_exact_fractions() {
        for (text, rate) in [
            ("30", "30"),
            ("30000/1001", "30000/1001"),
            ("60/2", "30"),
            ("23.976", "24000/1001"),
            ("23.98", "24000/1001"),
            ("29.97", "30000/1001"),
            ("59.94", "60000/1001"),
            ("59.9401", "60000/1001"),
            ("119.88", "120000/1001"),
            ("24.0", "24"),
            ("12.5", "25/2"),
            (".5", "1/2"),
            ("1000", "1000"),
        ] {
            assert_eq!(text.parse::<FrameRate>().unwrap().to_string(), rate, "{text}");
        }
        for bad in
            ["", "0", "0/1", "1/0", "-30", "1001", "nan", "inf", "30/", "1e3", "30:1", "2001/2", "1.2.3"]
        {
            assert!(bad.parse::<FrameRate>().is_err(), "{bad}");
        }
    }
}
