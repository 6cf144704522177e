//! The floor plan: flat geometry of what a scene says, without physics.
//!
//! World frame, z up, metres; the floor is `z = 0`, and heights stand on it.

pub mod block;
pub mod body;
pub mod chain;
pub mod circuit;
pub mod furnishing;
pub mod ground;
pub mod inside_and_outside;
pub mod random_loop;
pub mod revisit;
pub mod stand;
pub mod track;
pub mod waypoint;
