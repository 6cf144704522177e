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
            Error::SerdeMissingField { field, .. } => format!(
                "missing field `{field}`; is it left out, or indented otherwise than what it stands beside?"
            )
            .into(),
            _ => UserMessageFormatter.with_localizer(self.0).format_message(error).into_owned().into(),
        }
    }

    fn format_validation_issue_lines(&self, error: &Error) -> Option<Vec<String>> {
        UserMessageFormatter.with_localizer(self.0).format_validation_issue_lines(error)
    }
}

fn expected(type_name: &str) -> String {
    let is = |letter: char| type_name.strip_prefix(letter).is_some_and(|bits| bits.parse::<u32>().is_ok());
    match type_name {
        _ if is('u') => "expected a whole number, 0 or more".to_owned(),
        _ if is('i') => "expected a whole number".to_owned(),
        "floating point" => "expected a number".to_owned(),
        "boolean" => "expected true or false".to_owned(),
        _ => format!("expected a value of type {type_name}"),
    }
}
