//! Sensors: what the robot measures of the world, `z_k = h(x_k, o)` and `u_k`.

pub mod bounds;
pub mod close_up;
pub mod depth;
pub mod detector;
pub mod fault;
pub mod image;
pub mod landmark;
pub mod odometry;
