//! The variables: robot poses X, objects O with their extents, latents E, landmarks L, and what is shared by many measurements, with
//! their retraction.

use nalgebra::{DVector, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::fmt;
use vantage_dataset::{Pose, Tangent, se3};

/// Names a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Key {
    /// `x_k`: `world_from_robot` at a step.
    Robot(usize),
    /// `o_i`: `world_from_object`, or its centre alone, of a track.
    Object(usize),
    /// `e_i`: the latent of a track.
    Latent(usize),
    /// `l_j`: a point landmark, by its number.
    Landmark(usize),
    /// Logarithms of the semi-axes, metres, of the object of a track.
    Extents(usize),
    /// How the centre of a track's boxes lies off the object's centre, by azimuth.
    Offset(usize),
    /// The bias of odometry, along and yaw, in its own deviations.
    OdometryBias,
    /// What all predictions of the model are changed by.
    Domain,
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Key::Robot(step) => write!(f, "the robot's pose at step {step}"),
            Key::Object(track) => write!(f, "the object of track {track}"),
            Key::Latent(track) => write!(f, "the latent of track {track}"),
            Key::Landmark(landmark) => write!(f, "landmark {landmark}"),
            Key::Extents(track) => write!(f, "the extents of track {track}"),
            Key::Offset(track) => write!(f, "the offset of the boxes of track {track}"),
            Key::OdometryBias => write!(f, "the bias of odometry"),
            Key::Domain => write!(f, "the domain"),
        }
    }
}

/// The value of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// SE(3), 6 degrees of freedom.
    Pose(Pose),
    /// A point in the world, metres.
    Point(Vector3<f64>),
    /// A vector of any length.
    Vector(DVector<f64>),
}

impl Value {
    /// Degrees of freedom.
    pub fn dim(&self) -> usize {
        match self {
            Value::Pose(_) => 6,
            Value::Point(_) => 3,
            Value::Vector(v) => v.len(),
        }
    }

    /// Whether another value is of the same kind and dimension.
    pub fn is_like(&self, other: &Value) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other) && self.dim() == other.dim()
    }

    /// The value moved by `step` (of [`Value::dim`] numbers): `T * Exp(step)`, or a sum.
    pub fn retract(&self, step: &[f64]) -> Value {
        match self {
            Value::Pose(pose) => {
                let moved = pose * se3::exp(&Tangent::from_column_slice(step));
                let rotation = UnitQuaternion::new_normalize(moved.rotation.into_inner());
                Value::Pose(Pose::from_parts(moved.translation, rotation))
            }
            Value::Point(point) => Value::Point(point + Vector3::from_column_slice(step)),
            Value::Vector(v) => Value::Vector(v + DVector::from_column_slice(step)),
        }
    }

    /// The place of a pose or point in the world.
    pub fn position(&self) -> Option<Vector3<f64>> {
        match self {
            Value::Pose(pose) => Some(pose.translation.vector),
            Value::Point(point) => Some(*point),
            Value::Vector(_) => None,
        }
    }
}

/// Values of variables, in the order of their keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values(BTreeMap<Key, Value>);

impl Values {
    /// Sets a variable.
    pub fn insert(&mut self, key: Key, value: Value) {
        self.0.insert(key, value);
    }

    /// Forgets a variable.
    pub fn remove(&mut self, key: Key) {
        self.0.remove(&key);
    }

    /// A variable's value.
    pub fn get(&self, key: Key) -> Option<&Value> {
        self.0.get(&key)
    }

    /// A variable's value if it is a pose.
    pub fn pose(&self, key: Key) -> Option<&Pose> {
        match self.get(key) {
            Some(Value::Pose(pose)) => Some(pose),
            _ => None,
        }
    }

    /// A variable's value if it is a vector.
    pub fn vector(&self, key: Key) -> Option<&DVector<f64>> {
        match self.get(key) {
            Some(Value::Vector(vector)) => Some(vector),
            _ => None,
        }
    }

    /// Moves a variable by a step of its own dimension, if it is there.
    pub fn retract(&mut self, key: Key, step: &[f64]) {
        if let Some(value) = self.0.get_mut(&key) {
            *value = value.retract(step);
        }
    }

    /// All variables in the order of their keys.
    pub fn iter(&self) -> impl Iterator<Item = (Key, &Value)> {
        self.0.iter().map(|(key, value)| (*key, value))
    }
}
