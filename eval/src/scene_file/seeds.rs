//! The seeds of a scene file: how many, or which.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;
use vantage_dataset::Seed;

/// A scene has no more seeds than this.
pub const MAX_SEEDS: usize = 1000;

/// At least one seed, none twice. In YAML a count `n`, which means `0..n`, or a list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Seeds(Vec<Seed>);

impl Seeds {
    /// The seeds `0..count`; `None` for no seed, or more than [`MAX_SEEDS`].
    pub fn count(count: usize) -> Option<Self> {
        (1..=MAX_SEEDS).contains(&count).then(|| Self((0..count as u64).map(Seed).collect()))
    }

    /// The seeds.
    pub fn as_slice(&self) -> &[Seed] {
        &self.0
    }
}

impl<'de> Deserialize<'de> for Seeds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SeedsVisitor)
    }
}

struct SeedsVisitor;

impl<'de> Visitor<'de> for SeedsVisitor {
    type Value = Seeds;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a number of seeds from 1 to {MAX_SEEDS}, or a list of as many different seeds")
    }

    fn visit_u64<E: Error>(self, count: u64) -> Result<Seeds, E> {
        let refuse = || E::custom(format!("{count} seeds: expected 1 to {MAX_SEEDS}"));
        usize::try_from(count).ok().and_then(Seeds::count).ok_or_else(refuse)
    }

    fn visit_i64<E: Error>(self, count: i64) -> Result<Seeds, E> {
        u64::try_from(count)
            .map_err(|_| E::custom(format!("{count} seeds: expected 1 to {MAX_SEEDS}")))
            .and_then(|count| self.visit_u64(count))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Seeds, A::Error> {
        let mut seeds = Vec::new();
        while let Some(seed) = list.next_element::<u64>()? {
            if seeds.len() == MAX_SEEDS {
                return Err(A::Error::custom(format!("more than {MAX_SEEDS} seeds")));
            }
            if seeds.contains(&Seed(seed)) {
                return Err(A::Error::custom(format!("seed {seed} is there twice: each may be used once")));
            }
            seeds.push(Seed(seed));
        }
        if seeds.is_empty() {
            return Err(A::Error::custom("no seed: expected at least one"));
        }
        Ok(Seeds(seeds))
    }
}

impl JsonSchema for Seeds {
    fn schema_name() -> Cow<'static, str> {
        "Seeds".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number of seeds n, which means 0 to n - 1, or a list of different seeds.",
            "oneOf": [
                { "type": "integer", "minimum": 1, "maximum": MAX_SEEDS },
                {
                    "type": "array",
                    "items": { "type": "integer", "minimum": 0 },
                    "minItems": 1,
                    "maxItems": MAX_SEEDS,
                    "uniqueItems": true
                }
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seeds(yaml: &str) -> Result<Vec<u64>, String> {
        let seeds: Result<Seeds, _> = serde_saphyr::from_str(yaml);
        seeds.map(|s| s.0.iter().map(|s| s.0).collect()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_count_or_a_list() {
        assert_eq!(seeds("3"), Ok(vec![0, 1, 2]));
        assert_eq!(seeds("[0, 18446744073709551615]"), Ok(vec![0, u64::MAX]));
    }

    #[test]
    fn anything_else_says_what_is_expected() {
        for (yaml, expected) in [
            ("0", "expected 1 to 1000"),
            ("-1", "expected 1 to 1000"),
            ("1001", "expected 1 to 1000"),
            ("[]", "at least one"),
            ("[1, 2, 1]", "seed 1 is there twice"),
            ("ten", "a number of seeds"),
            ("{ count: 3 }", "a number of seeds"),
        ] {
            let error = seeds(yaml).unwrap_err();
            assert!(error.contains(expected), "{yaml}: {error}");
        }
    }

    #[test]
    fn written_as_json_a_count_is_its_list() {
        assert_eq!(serde_json::to_string(&Seeds::count(2).unwrap()).unwrap(), "[0,1]");
    }
}
