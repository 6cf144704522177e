//! What a MAT-file holds.

/// An array of MATLAB.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Numbers of any class, real parts, column-major.
    Numbers {
        /// Extents.
        dims: Vec<usize>,
        /// One for each place.
        data: Vec<f64>,
    },
    /// Characters, in the order of the file.
    Text(String),
    /// Structs with equal fields.
    Structs(StructArray),
    /// Values of any kind.
    Cells(Vec<Value>),
    /// An array of a class that is not read, such as sparse: its number.
    Other(u8),
}

/// Structs with equal fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StructArray {
    /// Names of the fields, in order.
    pub fields: Vec<String>,
    /// Of each struct, one value for each field.
    pub elements: Vec<Vec<Value>>,
}

impl Value {
    /// A number.
    pub fn scalar(number: f64) -> Self {
        Self::matrix(1, 1, vec![number])
    }

    /// A matrix from its column-major numbers.
    pub fn matrix(rows: usize, columns: usize, data: Vec<f64>) -> Self {
        Self::Numbers { dims: vec![rows, columns], data }
    }

    /// MATLAB's `[]`.
    pub fn empty() -> Self {
        Self::matrix(0, 0, Vec::new())
    }

    /// The numbers, column-major.
    pub fn as_numbers(&self) -> Option<&[f64]> {
        if let Self::Numbers { data, .. } = self { Some(data) } else { None }
    }

    /// The text.
    pub fn as_text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// What it is, for messages.
    pub fn describe(&self) -> String {
        match self {
            Self::Numbers { dims, .. } => format!("numbers {dims:?}"),
            Self::Text(text) => format!("text {text:?}"),
            Self::Structs(array) => format!("{} structs of {:?}", array.elements.len(), array.fields),
            Self::Cells(cells) => format!("{} cells", cells.len()),
            Self::Other(class) => format!("an array of class {class}"),
        }
    }
}

impl StructArray {
    /// Position of a field.
    pub fn field(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|field| field == name)
    }
}
