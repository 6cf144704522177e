//! What a training reads of view sets.

pub(crate) mod components;
pub(crate) mod views;
