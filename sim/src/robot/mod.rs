//! The robot: its path, its body and its camera, `x_{k+1} = f(x_k, u_k)`.

pub mod body;
pub mod drive;
pub mod mount;
pub mod path;
