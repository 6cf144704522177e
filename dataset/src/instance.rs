//! Object instances: their identity, split and symmetry.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Which part of the work may see an instance. Instances of different splits are never the same object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// Fits the model.
    Train,
    /// Calibrates noise and stops training.
    Validation,
    /// Is scored.
    Test,
}

impl Split {
    /// The split's name, as used in streams, files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Split::Train => "train",
            Split::Validation => "validation",
            Split::Test => "test",
        }
    }
}

/// An object instance: the hash of everything that makes its mesh and texture.
///
/// Two instances of equal id look equal, so that disjoint ids prove that splits are disjoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct InstanceId(pub u64);

impl InstanceId {
    /// The id of an object of which only the name is known: of a real one a hash of the name, of a simulated one, whose name in
    /// exported layouts ends with its id, that.
    ///
    /// BigBIRD and Active Vision name their objects alike, so that an object of both has one id.
    pub fn of_name(name: &str) -> Self {
        if let Some(id) = name.rsplit_once('_').and_then(|(_, digits)| Self::parse(digits)) {
            return id;
        }
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&blake3::hash(name.as_bytes()).as_bytes()[..8]);
        Self(u64::from_le_bytes(bytes))
    }

    /// The id of 16 hexadecimal digits, as it is shown; none of anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let digits = text.len() == 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        digits.then(|| u64::from_str_radix(text, 16).ok().map(Self))?
    }
}

impl fmt::Display for InstanceId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// Rotations about the object's z axis that leave its look unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// None: every azimuth looks different.
    None,
    /// Turns by `2 pi / order`.
    Cyclic {
        /// How many turns make a full one, at least 2.
        order: u8,
    },
    /// Any turn (a surface of revolution with rings only).
    Revolution,
}

impl Symmetry {
    /// The smallest absolute difference, radians, of two azimuths modulo this symmetry; `None` where every
    /// azimuth is equivalent.
    pub fn azimuth_distance(self, a: f64, b: f64) -> Option<f64> {
        let period = match self {
            Symmetry::None => 2.0 * std::f64::consts::PI,
            Symmetry::Cyclic { order } => 2.0 * std::f64::consts::PI / f64::from(order),
            Symmetry::Revolution => return None,
        };
        let difference = (a - b).rem_euclid(period);
        Some(difference.min(period - difference))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn an_id_reads_back_as_it_is_shown() {
        for id in [InstanceId(0), InstanceId(0x0123_4567_89ab_cdef), InstanceId(u64::MAX)] {
            assert_eq!(InstanceId::parse(&id.to_string()), Some(id));
            assert_eq!(InstanceId::of_name(&format!("toy_mug_{id}")), id);
        }
        for text in ["", "0", "+123456789abcdef", "0123456789abcdef0", "0123456789abcdeg"] {
            assert_eq!(InstanceId::parse(text), None, "{text}");
        }
    }

    #[test]
    fn azimuth_distance_wraps_at_the_symmetry() {
        let close = |a: Option<f64>, b: f64| a.is_some_and(|a| (a - b).abs() < 1e-12);
        assert!(close(Symmetry::None.azimuth_distance(0.1, 2.0 * PI - 0.1), 0.2));
        assert!(close(Symmetry::None.azimuth_distance(0.0, PI), PI));
        assert!(close(Symmetry::Cyclic { order: 4 }.azimuth_distance(0.0, PI / 2.0 + 0.3), 0.3));
        assert_eq!(Symmetry::Revolution.azimuth_distance(0.0, 1.0), None);
    }
}
