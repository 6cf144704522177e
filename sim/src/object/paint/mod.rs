//! Procedural textures: a canvas, marks upon it, and how labels are laid out.

mod canvas;
mod emblem;
mod ground;
mod label;
mod marks;
mod palette;
mod region;

pub(crate) use canvas::{Canvas, Patch};
pub(crate) use emblem::Emblem;
pub(crate) use ground::Ground;
pub(crate) use label::Label;
pub(crate) use palette::{Palette, Rgb, hsl, mix};
pub(crate) use region::{Area, Region};
