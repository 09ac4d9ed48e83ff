//! Units of length, by their symbols.

/// The symbol of the unit called `name`; a name that is not known stays as it is.
pub fn symbol(name: &str) -> &str {
    match name.trim() {
        "millimeter" | "millimeters" | "millimetre" => "mm",
        "um" | "\u{3bc}m" | "micron" | "microns" | "micrometer" | "micrometre" | "\\u00B5m" => "µm",
        "nanometer" | "nanometre" => "nm",
        "centimeter" | "centimetre" => "cm",
        "meter" | "metre" => "m",
        "inches" => "inch",
        other => other,
    }
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
