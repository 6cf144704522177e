//! Simulated worlds: a checked scene becomes episodes.
//!
//! `x_{k+1} = f(x_k, u_k)` is rapier's step, `z_k = h(x_k, o)` the renderer and the detector: this crate draws
//! from the generative side of the posterior that the estimator inverts.

pub mod mesh;
pub mod model;
pub mod object;
pub mod render;
pub mod texture;
pub mod world;
