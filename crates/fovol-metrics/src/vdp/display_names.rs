/// Names of the preset displays.
pub const NAMES: [&str; 3] = ["standard_4k", "standard_fhd", "standard_hmd"];
