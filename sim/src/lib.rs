//! Simulated worlds: a checked scene becomes episodes.
//!
//! `x_{k+1} = f(x_k, u_k)` is rapier's step, `z_k = h(x_k, o)` the renderer and the detector: this crate draws
//! from the generative side of the posterior that the estimator inverts.

pub mod budget;
pub mod capture;
pub mod episode;
pub mod error;
pub mod mesh;
pub mod mesh_file;
pub mod model;
pub mod object;
pub mod observer;
pub mod render;
pub mod robot;
pub mod rollout;
pub mod scene;
pub mod sensor;
pub mod texture;
pub mod views;
pub mod world;

pub use episode::simulate;
