//! Procedural objects.
