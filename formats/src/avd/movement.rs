//! The movements of the robot.

/// A movement of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Movement {
    /// To the next point of the grid ahead.
    Forward,
    /// To the one behind.
    Backward,
    /// To the one on the left.
    Left,
    /// To the one on the right.
    Right,
    /// 30 degrees to the left, on the spot.
    RotateCcw,
    /// 30 degrees to the right, on the spot.
    RotateCw,
}

impl Movement {
    /// All movements, in the order of a step's moves.
    pub const ALL: [Self; 6] =
        [Self::Forward, Self::Backward, Self::Left, Self::Right, Self::RotateCcw, Self::RotateCw];
}
