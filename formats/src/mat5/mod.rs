//! MATLAB's MAT-files of version 5 (of which 6 and 7 are variants): numbers, text, structs and cells.
//!
//! A variable may be compressed. Nothing is allocated by a declared size before the file proves to hold as much.

mod reader;
mod value;
mod writer;

pub use reader::{decode, read};
pub use value::{StructArray, Value};
pub use writer::encode;

/// Kinds of a data element.
mod kind {
    pub(super) const INT8: u32 = 1;
    pub(super) const UINT8: u32 = 2;
    pub(super) const INT16: u32 = 3;
    pub(super) const UINT16: u32 = 4;
    pub(super) const INT32: u32 = 5;
    pub(super) const UINT32: u32 = 6;
    pub(super) const SINGLE: u32 = 7;
    pub(super) const DOUBLE: u32 = 9;
    pub(super) const INT64: u32 = 12;
    pub(super) const UINT64: u32 = 13;
    pub(super) const MATRIX: u32 = 14;
    pub(super) const COMPRESSED: u32 = 15;
    pub(super) const UTF8: u32 = 16;
    pub(super) const UTF16: u32 = 17;
}

/// Classes of an array.
mod class {
    pub(super) const CELL: u8 = 1;
    pub(super) const STRUCT: u8 = 2;
    pub(super) const CHAR: u8 = 4;
    pub(super) const DOUBLE: u8 = 6;
    pub(super) const UINT64: u8 = 15;
}
