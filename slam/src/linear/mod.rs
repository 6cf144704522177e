//! The normal equations `(J^T W J + lambda D) delta = -J^T W r`, and how they are solved.
//!
//! A latent or an offset meets only factors of its own object, so its block is eliminated there first, densely
//! ([`system`], [`reduced`], [`step`]); poses and objects remain in a sparse system ([`structure`]) that faer orders
//! (AMD, which takes objects before the poses that see them) and factorises.

pub mod cholesky;
pub mod rank;
pub mod reduced;
pub mod step;
pub mod structure;
pub mod system;

pub use cholesky::{Cholesky, Memory};
pub use rank::least_constrained;
pub use reduced::Reduced;
pub use step::Step;
pub use structure::Structure;
pub use system::{System, more_damped};
