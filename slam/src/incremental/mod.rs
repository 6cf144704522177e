//! The posterior's maximum and marginals after every step, from what the step changed.

mod chart;
mod descent;
mod front;
mod linearized;
mod object;
mod order;
mod smoother;
mod step;
mod term;
mod tree;
mod update;

pub use smoother::Smoother;
pub use term::Term;
pub use tree::{Indefinite, Place, Solved, Tree};
pub use update::{Thresholds, Update};
