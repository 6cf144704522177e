//! A tensor of a graph as far as it is known before any run.

use std::rc::Rc;
use tract_onnx::pb::TensorProto;
use tract_onnx::pb::tensor_proto::DataType;

/// Type and shape; and of weights of integers, which tell sizes and axes, the numbers.
#[derive(Clone, Debug)]
pub(super) struct Tensor {
    pub(super) kind: DataType,
    pub(super) shape: Vec<usize>,
    /// Whether it depends on no input.
    pub(super) stored: bool,
    pub(super) integers: Option<Rc<[i64]>>,
}

impl Tensor {
    /// A tensor that depends on inputs.
    pub(super) fn new(kind: DataType, shape: Vec<usize>) -> Self {
        Self { kind, shape, stored: false, integers: None }
    }

    /// Integers in a list, or one without axes.
    pub(super) fn of_integers(shape: Vec<usize>, integers: &[i64]) -> Self {
        Self { kind: DataType::Int64, shape, stored: true, integers: Some(integers.into()) }
    }

    /// A weight, which has to be a checked one.
    pub(super) fn weight(weight: &TensorProto) -> Self {
        let kind = DataType::try_from(weight.data_type).unwrap_or(DataType::Undefined);
        let shape = weight.dims.iter().map(|&dim| usize::try_from(dim).unwrap_or(0)).collect();
        let bytes = &weight.raw_data;
        let integers = match kind {
            DataType::Int64 => {
                let words = bytes.chunks_exact(8);
                Some(
                    words
                        .map(|b| i64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
                        .collect(),
                )
            }
            DataType::Int32 => {
                let words = bytes.chunks_exact(4);
                Some(words.map(|b| i64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]]))).collect())
            }
            _ => None,
        };
        Self { kind, shape, stored: true, integers }
    }

    /// Numbers in it.
    pub(super) fn volume(&self) -> usize {
        volume(&self.shape)
    }
}

/// Numbers of a shape; `usize::MAX` where there are more.
pub(super) fn volume(shape: &[usize]) -> usize {
    shape.iter().fold(1usize, |volume, &side| volume.saturating_mul(side))
}
