#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fovol_io_fuzz::parse("v.ozx", bytes));
