//! Products of matrices.

use super::node::Node;
use super::pointwise::{broadcast, repeated};
use super::tensor::Tensor;
use crate::onnx::error::GraphError;
use tract_onnx::pb::tensor_proto::DataType;

/// `A B`, as NumPy's `matmul`: of the last two axes, over all others; a vector is a row on the left and a column on the right.
pub(super) fn matmul(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let (a, b) = (&node.real(0)?.shape, &node.real(1)?.shape);
    if a.is_empty() || b.is_empty() || a.len() + b.len() == 2 {
        return Err(node.fault(
            "the operands' shapes",
            format!("{a:?} and {b:?}"),
            "a matrix and a matrix or vector",
        ));
    }
    let (mut left, mut right) = (a.clone(), b.clone());
    if a.len() == 1 {
        left.insert(0, 1);
    }
    if b.len() == 1 {
        right.push(1);
    }
    let ((left, of_a), (right, of_b)) = (left.split_at(left.len() - 2), right.split_at(right.len() - 2));
    if of_a[1] != of_b[0] {
        return Err(unfit(node, a, b));
    }
    let mut shape = broadcast(node, &[left, right])?;
    shape.extend((a.len() > 1).then_some(of_a[0]));
    shape.extend((b.len() > 1).then_some(of_b[1]));
    node.made(DataType::Float, shape)
}

/// `alpha A B + beta C`, each of two axes, `C` repeated.
pub(super) fn gemm(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let matrix = |index: usize, transposed: &str| {
        let shape = &node.real(index)?.shape;
        match (&shape[..], node.flag(transposed, false)?) {
            (&[rows, columns], false) | (&[columns, rows], true) => Ok([rows, columns]),
            _ => Err(node.fault(
                format!("the shape of operand {}", index + 1),
                format!("{shape:?}"),
                "two axes",
            )),
        }
    };
    let ([rows, inner], [other, columns]) = (matrix(0, "transA")?, matrix(1, "transB")?);
    if inner != other {
        return Err(unfit(node, &[rows, inner], &[other, columns]));
    }
    if node.optional(2).is_some() {
        repeated(node, "third operand", &node.real(2)?.shape, &[rows, columns])?;
    }
    node.made(DataType::Float, vec![rows, columns])
}

fn unfit(node: &Node, a: &[usize], b: &[usize]) -> GraphError {
    let got = format!("{a:?} and {b:?}");
    node.fault("the matrices' shapes", got, "as many columns on the left as rows on the right")
}
