//! The robot: its path, its body and its camera, `x_{k+1} = f(x_k, u_k)`.

pub mod body;
pub mod chain;
pub mod circuit;
pub mod drive;
pub mod hand;
pub mod mount;
pub mod stations;
pub mod track;
pub mod walk;
