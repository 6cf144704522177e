//! The range of a number that is outside of it, from the schema: a violated rule itself tells one end.

use schemars::{JsonSchema, schema_for};
use serde_json::Value;
use serde_saphyr::Localizer;

/// Messages that tell ranges, of files of one schema.
pub(super) struct Ranges(Value);

impl Ranges {
    pub(super) fn of<T: JsonSchema>() -> Self {
        Self(schema_for!(T).to_value())
    }

    /// Both ends of the range that a number at `path` violates at the end `violated`. A path does not name the variants it leads
    /// through, so that there may be several numbers; where their ranges differ, there is no telling.
    fn find(&self, path: &str, violated: f64) -> Option<[f64; 2]> {
        let steps: Vec<&str> = path.split(['.', '[', ']']).filter(|step| !step.is_empty()).collect();
        let mut found = Vec::new();
        self.collect(&self.0, &steps, &mut found);
        found.retain(|range: &[f64; 2]| range.contains(&violated));
        found.dedup();
        match found[..] {
            [range] => Some(range),
            _ => None,
        }
    }

    fn collect(&self, at: &Value, steps: &[&str], found: &mut Vec<[f64; 2]>) {
        if let Some(target) =
            at["$ref"].as_str().and_then(|name| self.0.pointer(name.trim_start_matches('#')))
        {
            self.collect(target, steps, found);
        }
        for alternative in ["allOf", "anyOf", "oneOf"].iter().filter_map(|key| at[key].as_array()).flatten() {
            self.collect(alternative, steps, found);
            let variant = alternative["properties"].as_object().filter(|properties| properties.len() == 1);
            variant
                .iter()
                .flat_map(|variant| variant.values())
                .for_each(|inner| self.collect(inner, steps, found));
        }
        match steps {
            [] => found
                .extend(at["minimum"].as_f64().zip(at["maximum"].as_f64()).map(|(low, high)| [low, high])),
            [step, rest @ ..] => {
                [&at["properties"][step], &at["items"]].into_iter().for_each(|inner| {
                    if !inner.is_null() {
                        self.collect(inner, rest, found);
                    }
                });
            }
        }
    }
}

impl Localizer for Ranges {
    fn validation_base_message(&self, entry: &str, path: &str) -> String {
        let violated = entry.strip_prefix("lower than ").or_else(|| entry.strip_prefix("greater than "));
        let field = path.trim_end_matches('.');
        let Some(end) = violated else { return format!("validation error: `{field}`: {entry}") };
        let range = end.parse().ok().and_then(|end| self.find(path, end));
        let expected = range.map(|[low, high]| format!(", expected {low} to {high}")).unwrap_or_default();
        format!("validation error: {entry} for `{field}`{expected}")
    }
}
