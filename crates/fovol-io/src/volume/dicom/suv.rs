//! The factor from activity to standardised uptake by body weight, of PET.

use super::data_set::DataSet;
use super::tags;

/// What is known of the standardised uptake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Suv {
    /// SUVbw = value × this, for values in Bq/ml.
    Factor(f64),
    /// The values are SUVbw already.
    Applied,
}

/// The factor, where the file has all that it needs: the QIBA's formula, decay up to the start of the series.
pub fn of(set: &DataSet<'_>) -> Option<Suv> {
    match set.text(tags::UNITS)?.as_str() {
        "GML" => return Some(Suv::Applied),
        "BQML" => {}
        _ => return None,
    }
    let drug = set.item(tags::RADIOPHARMACEUTICAL)?;
    let weight = set.number(tags::PATIENT_WEIGHT).filter(|&weight| weight > 0.0)?;
    let dose = drug.number(tags::RADIONUCLIDE_DOSE).filter(|&dose| dose > 0.0)?;
    let decay = match set.text(tags::DECAY_CORRECTION)?.as_str() {
        // Values are corrected to the time of injection.
        "ADMIN" => 1.0,
        "START" => {
            let half_life = drug.number(tags::RADIONUCLIDE_HALF_LIFE).filter(|&half| half > 0.0)?;
            let injected = injection(&drug)?;
            let started = seconds(&set.text(tags::SERIES_TIME)?)?;
            // Over midnight at the latest.
            (-(started - injected).rem_euclid(86_400.0) * std::f64::consts::LN_2 / half_life).exp()
        }
        _ => return None,
    };
    let factor = 1000.0 * weight / (dose * decay);
    (factor.is_finite() && factor > 0.0).then_some(Suv::Factor(factor))
}

/// The time of the injection, in seconds of its day.
fn injection(drug: &DataSet<'_>) -> Option<f64> {
    let with_date = drug.text(tags::RADIOPHARMACEUTICAL_START_DATE);
    let with_date = with_date.and_then(|text| seconds(text.get(8..)?));
    with_date.or_else(|| seconds(&drug.text(tags::RADIOPHARMACEUTICAL_START)?))
}

/// Seconds of the day of a time like `134501.25`.
fn seconds(time: &str) -> Option<f64> {
    let part = |range: std::ops::Range<usize>| time.get(range)?.parse::<f64>().ok();
    let tail = time.get(4..).unwrap_or("0").split(['+', '-']).next()?;
    let tail = if tail.is_empty() { 0.0 } else { tail.parse().ok()? };
    Some(part(0..2)? * 3600.0 + part(2..4).unwrap_or(0.0) * 60.0 + tail)
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn times_of_the_day() {
        assert_eq!(seconds("134501.25"), Some(13.0 * 3600.0 + 45.0 * 60.0 + 1.25));
        assert_eq!(seconds("0930"), Some(9.5 * 3600.0));
        assert_eq!(seconds("093000+0100"), Some(9.5 * 3600.0));
        assert_eq!(seconds("x"), None);
    }
}
