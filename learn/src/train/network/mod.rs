//! What networks are made of: layers, functions, and weights as tensors and as plain numbers.

pub(crate) mod exponential;
pub(crate) mod half;
pub(crate) mod layers;
pub(crate) mod rows;
pub(crate) mod turn;
pub(crate) mod weights;
