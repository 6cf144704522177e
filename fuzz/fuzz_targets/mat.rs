//! Active Vision's poses: MAT-files of version 5. What reads can be written, and read again.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use vantage_formats::mat5;

fuzz_target!(|bytes: &[u8]| {
    let file = Path::new("image_structs.mat");
    let Ok(variables) = mat5::decode(bytes, file) else { return };
    let variables: Vec<_> = variables.iter().map(|(name, value)| (name.as_str(), value)).collect();
    let _ = mat5::decode(&mat5::encode(&variables), file);
});
