//! Operators that compute number by number, repeating operands along each other's axes where they take several.

use super::node::Node;
use super::tensor::Tensor;
use crate::onnx::error::GraphError;
use tract_onnx::pb::tensor_proto::DataType;

/// Most operands of an operator that takes any number.
pub(super) const MOST_OPERANDS: usize = 256;

/// A function of one operand.
pub(super) fn single(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    node.made(DataType::Float, node.real(0)?.shape.clone())
}

/// A function of two operands.
pub(super) fn pair(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    node.made(DataType::Float, broadcast(node, &[&node.real(0)?.shape, &node.real(1)?.shape])?)
}

/// The greatest or least of operands.
pub(super) fn several(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let mut shape = node.real(0)?.shape.clone();
    for index in 1..node.operands().count() {
        shape = broadcast(node, &[&shape, &node.real(index)?.shape])?;
    }
    node.made(DataType::Float, shape)
}

/// Bounds are single numbers.
pub(super) fn clip(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.real(0)?;
    for index in [1, 2].into_iter().filter(|&index| node.optional(index).is_some()) {
        let bound = &node.real(index)?.shape;
        if bound.len() > x.shape.len() || bound.iter().any(|&side| side != 1) {
            let what = format!("the shape of operand {}", index + 1);
            return Err(node.fault(what, format!("{bound:?}"), "[], a single number"));
        }
    }
    node.made(DataType::Float, x.shape.clone())
}

/// The slope is repeated along the axes of the operand, not the other way round.
pub(super) fn prelu(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let (x, slope) = (&node.real(0)?.shape, &node.real(1)?.shape);
    repeated(node, "slope", slope, x)?;
    node.made(DataType::Float, x.clone())
}

/// Refuses an operand that cannot be repeated along the axes of `whole`.
pub(super) fn repeated(node: &Node, what: &str, part: &[usize], whole: &[usize]) -> Result<(), GraphError> {
    let fits = part.len() <= whole.len()
        && part.iter().rev().zip(whole.iter().rev()).all(|(&part, &whole)| part == 1 || part == whole);
    if fits {
        return Ok(());
    }
    let expected = format!("a shape that repeats to {whole:?}");
    Err(node.fault(format!("the shape of the {what}"), format!("{part:?}"), expected))
}

/// The common shape, axes counted from the last.
pub(super) fn broadcast(node: &Node, shapes: &[&[usize]; 2]) -> Result<Vec<usize>, GraphError> {
    let [a, b] = *shapes;
    let rank = a.len().max(b.len());
    let side =
        |shape: &[usize], axis: usize| (axis + shape.len()).checked_sub(rank).map_or(1, |at| shape[at]);
    let common = (0..rank).map(|axis| match (side(a, axis), side(b, axis)) {
        (a, b) if a == b || b == 1 => Some(a),
        (1, b) => Some(b),
        _ => None,
    });
    common.collect::<Option<_>>().ok_or_else(|| {
        let got = format!("{a:?} and {b:?}");
        node.fault("the operands' shapes", got, "sides that are equal or 1, counted from the last")
    })
}
