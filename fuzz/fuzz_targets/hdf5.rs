//! BigBIRD's numbers: a calibration, a pose or a turntable's axis.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use vantage_formats::hdf5::Hdf5;

fuzz_target!(|bytes: &[u8]| {
    let Ok(file) = Hdf5::decode(bytes.to_vec(), Path::new("calibration.h5")) else { return };
    for name in file.names() {
        for shape in [&[4, 4][..], &[3, 3], &[5], &[3], &[1]] {
            if let Ok(Some(numbers)) = file.floats(name, shape) {
                assert_eq!(numbers.len() as u64, shape.iter().product::<u64>());
                assert!(numbers.iter().all(|number| number.is_finite()));
            }
        }
    }
});
