//! Sensors: what the robot measures of the world, `z_k = h(x_k, o)` and `u_k`.

pub mod bounds;
pub mod detector;
pub mod odometry;
