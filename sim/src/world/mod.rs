//! Worlds: rapier's step, the robot and its sensors.
