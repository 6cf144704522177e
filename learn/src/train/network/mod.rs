//! What networks are made of: layers, functions, and weights as tensors and as plain numbers.

pub(crate) mod exponential;
pub(crate) mod half;
pub(crate) mod layers;
pub(crate) mod rows;
pub(crate) mod turn;
pub(crate) mod weights;

/// What a pixel in `[0, 1]` is centred by before the trunk.
pub(crate) const PIXEL_CENTER: f32 = 0.5;
/// Range of the logarithm of a latent's variance in one view's factor.
pub(crate) const LOG_VARIANCE: (f32, f32) = (-8.0, 4.0);
/// What a latent that is a class is multiplied by. With factors of variance `v = exp(4)`, the latent of `n` views is the sum of
/// their logarithms of likelihoods over `n + v`, so that `v` times it is their product, nearly.
pub(crate) const CLASS_SHARPNESS: f32 = 54.598_15;
