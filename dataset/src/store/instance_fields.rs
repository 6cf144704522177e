//! An instance's id and symmetry as text.

use crate::{InstanceId, Symmetry};

/// What [`parse_id`] reads.
pub(super) const INSTANCE_ID: &str = "16 hexadecimal digits";
/// What [`parse_symmetry`] reads.
pub(super) const SYMMETRY: &str = "none, revolution, or cyclic_ and an order up to 255";

pub(crate) fn show_id(id: InstanceId) -> String {
    format!("{:016x}", id.0)
}

pub(crate) fn parse_id(text: &str) -> Option<InstanceId> {
    let digits = text.len() == 16 && text.bytes().all(|b| b.is_ascii_hexdigit());
    digits.then(|| u64::from_str_radix(text, 16).ok().map(InstanceId))?
}

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
