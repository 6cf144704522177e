//! What a training reads of view sets.

pub(crate) mod augmentation;
pub(crate) mod components;
pub(crate) mod views;
