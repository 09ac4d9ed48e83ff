//! Units of length, by their symbols.

/// The symbol of the unit called `name`; a name that is not known stays as it is.
pub fn symbol(name: &str) -> &str {
    match name.trim() {
        "millimeter" | "millimeters" | "millimetre" => "mm",
        "um" | "\u{3bc}m" | "micron" | "microns" | "micrometer" | "micrometre" | "\\u00B5m" => "µm",
        "nanometer" | "nanometre" => "nm",
        "centimeter" | "centimetre" => "cm",
        "meter" | "metre" => "m",
        "kilometer" | "kilometre" => "km",
        "angstrom" | "ångström" => "Å",
        "inches" => "inch",
        other => other,
    }
}

/// The length of the unit of this symbol in metres, if it is a length.
pub fn metres(symbol: &str) -> Option<f64> {
    Some(match symbol {
        "Å" => 1e-10,
        "nm" => 1e-9,
        "µm" => 1e-6,
        "mm" => 1e-3,
        "cm" => 1e-2,
        "m" => 1.0,
        "km" => 1e3,
        "inch" => 0.0254,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn micrometres_have_many_names() {
        for name in ["um", "μm", "µm", "micron", "microns", "micrometer", "\\u00B5m"] {
            assert_eq!(symbol(name), "µm", "{name}");
        }
        assert_eq!(symbol("furlong"), "furlong");
    }
}
