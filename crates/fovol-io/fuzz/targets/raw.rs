#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fovol_io_fuzz::parse("v_4x3x2_uint16.raw.gz", bytes));
