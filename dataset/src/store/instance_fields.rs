//! An instance's symmetry as text, and what its fields expect.

use crate::Symmetry;

/// What [`InstanceId::parse`](crate::InstanceId::parse) reads.
pub(super) const INSTANCE_ID: &str = "16 hexadecimal digits";
/// What [`parse_symmetry`] reads.
pub(super) const SYMMETRY: &str = "none, revolution, or cyclic_ and an order up to 255";

pub(super) fn show_symmetry(symmetry: Symmetry) -> String {
    match symmetry {
        Symmetry::None => "none".to_owned(),
        Symmetry::Revolution => "revolution".to_owned(),
        Symmetry::Cyclic { order } => format!("cyclic_{order}"),
    }
}

pub(super) fn parse_symmetry(text: &str) -> Option<Symmetry> {
    match text {
        "none" => Some(Symmetry::None),
        "revolution" => Some(Symmetry::Revolution),
        _ => Some(Symmetry::Cyclic { order: text.strip_prefix("cyclic_")?.parse().ok()? }),
    }
}
