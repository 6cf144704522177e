//! What a hypothesis's own estimator can do.

use super::local::Local;
use crate::factor::Factor;
use crate::variable::{Key, Value};
use nalgebra::Point3;
use std::rc::Rc;
use vantage_dataset::Pose;

/// Factors, and the variables that come in with them.
#[derive(Clone, Default)]
pub struct Addition<'m> {
    /// New terms of the negative log-posterior.
    pub factors: Vec<Rc<dyn Factor + 'm>>,
    /// New variables at their first values.
    pub fresh: Vec<(Key, Value)>,
    /// Variables that are there already and are set down elsewhere; what they are joined with is all but indifferent to that.
    pub moved: Moved,
}

/// Values that one motion of the world takes elsewhere. Copies share the values.
#[derive(Clone, Default)]
pub struct Moved {
    motion: Pose,
    values: Rc<[(Key, Value)]>,
}

impl Moved {
    /// These values, moved.
    pub fn new(motion: Pose, values: Rc<[(Key, Value)]>) -> Self {
        Self { motion, values }
    }

    /// Whether nothing is moved.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values where they are now.
    pub fn iter(&self) -> impl Iterator<Item = (Key, Value)> {
        self.values.iter().map(|(key, value)| {
            let moved = match value {
                Value::Pose(pose) => Value::Pose(self.motion * pose),
                Value::Point(point) => Value::Point((self.motion * Point3::from(*point)).coords),
                Value::Vector(vector) => Value::Vector(vector.clone()),
            };
            (*key, moved)
        })
    }
}

impl<'m> Addition<'m> {
    /// One factor more.
    pub fn with(mut self, factor: impl Factor + 'm) -> Self {
        self.factors.push(Rc::new(factor));
        self
    }

    /// One variable more.
    pub fn with_variable(mut self, key: Key, value: Value) -> Self {
        self.fresh.push((key, value));
        self
    }
}

/// Why an estimate could not be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unsolved {
    /// The factors leave a variable free.
    #[error(
        "the factors leave {0} free; anchor the first pose and give every new variable a factor that fixes it"
    )]
    Free(Key),
    /// A factor is undefined at the values.
    #[error("a factor of {0} is undefined at the values; give new variables a value at which it is")]
    Undefined(Key),
}

/// The estimate under one hypothesis. A copy is cheap, and shares what neither of the two has changed.
pub trait LocalEstimator<'m>: Clone {
    /// Takes in factors and variables; the estimate may stay as it was until [`LocalEstimator::update`].
    ///
    /// # Errors
    /// A factor that is undefined at the values.
    fn add(&mut self, addition: &Addition<'m>) -> Result<(), Unsolved>;

    /// Brings the estimate up to date, linearising anew what is no longer near its linearisation.
    ///
    /// # Errors
    /// A variable that nothing fixes.
    fn update(&mut self) -> Result<(), Unsolved>;

    /// Brings the estimate to the maximum from where it is, by all its factors.
    ///
    /// # Errors
    /// A variable that nothing fixes.
    fn solve_anew(&mut self) -> Result<(), Unsolved>;

    /// `log` of the integral of `exp(-cost)` over all variables, by Laplace's method, as of the last update.
    fn log_evidence(&self) -> f64;

    /// The value of a variable, or none where there is none.
    fn value(&self, key: Key) -> Option<Value>;

    /// The joint marginal of a few variables as of the last update, or none where one of them is not there.
    fn joint(&self, keys: &[Key]) -> Option<Local>;

    /// How far the newest state of two estimates lie apart, in the deviations of the first.
    fn distance(&self, other: &Self) -> f64;
}
