//! What is said of a value of the wrong type.

use super::range::Ranges;
use serde_saphyr::{Error, Localizer, MessageFormatter, UserMessageFormatter};
use std::borrow::Cow;

/// Messages in terms of YAML rather than of our types; violated rules with their [`Ranges`].
pub(super) struct Words<'a>(pub(super) &'a Ranges);

impl MessageFormatter for Words<'_> {
    fn localizer(&self) -> &dyn Localizer {
        self.0
    }

    fn format_message<'a>(&self, error: &'a Error) -> Cow<'a, str> {
        match error {
            Error::InvalidScalar { ty, .. } => expected(ty).into(),
            Error::Unexpected { expected: "string scalar", .. } => {
                "expected a single value, no list or mapping".into()
            }
            Error::ExpectedMappingEndAfterEnumVariantValue { .. } => {
                "expected one choice, and here is a second".into()
            }
            _ => UserMessageFormatter.with_localizer(self.0).format_message(error).into_owned().into(),
        }
    }

    fn format_validation_issue_lines(&self, error: &Error) -> Option<Vec<String>> {
        UserMessageFormatter.with_localizer(self.0).format_validation_issue_lines(error)
    }
}

fn expected(type_name: &str) -> String {
    let bits = type_name.strip_prefix('u').and_then(|bits| bits.parse::<u32>().ok());
    match (type_name, bits) {
        (_, Some(bits @ 1..=64)) => format!("expected a whole number from 0 to {}", u64::MAX >> (64 - bits)),
        ("floating point", _) => "expected a number".to_owned(),
        ("bool" | "boolean", _) => "expected true or false".to_owned(),
        _ => format!("expected a value of type {type_name}"),
    }
}
