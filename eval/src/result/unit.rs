//! Units of metrics.

/// What a metric is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Meter,
    /// Radians in files, degrees in tables.
    Radian,
    /// Decibels.
    Decibel,
    /// Natural units of information.
    Nat,
    /// A share or index without unit.
    Ratio,
}
