//! The sRGB transfer function (IEC 61966-2-1).

/// Linear light of an encoded value, both in `[0, 1]`.
pub(crate) fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::powf((encoded + 0.055) / 1.055, 2.4) }
}

/// Encoded value of linear light, both in `[0, 1]`.
pub(crate) fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 }
}
