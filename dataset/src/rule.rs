//! Rules of numbers in settings that garde has none for: each refuses NaN, which YAML can write and `range` lets pass.

/// Refuses NaN.
pub fn not_nan(value: &f64, _: &()) -> garde::Result {
    if value.is_nan() { Err(garde::Error::new("got NaN, expected a number")) } else { Ok(()) }
}

/// Refuses what is not a positive, finite number.
pub fn positive(value: &f64, _: &()) -> garde::Result {
    if *value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(garde::Error::new(format!("got {value}, expected a positive number")))
}

/// Refuses negative numbers and NaN.
pub fn not_negative(value: &f64, _: &()) -> garde::Result {
    if *value >= 0.0 {
        return Ok(());
    }
    Err(garde::Error::new(format!("got {value}, expected 0 or more")))
}
