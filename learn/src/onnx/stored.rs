//! What a graph computes of its weights alone, which tract does as it reads the graph, however much that is.

use super::error::GraphError;
use crate::folder::LARGEST_FILE;
use std::collections::BTreeMap;
use tract_onnx::pb::{GraphProto, NodeProto, TensorProto};

/// Numbers that the nodes of weights alone may take and make together: enough to widen all of the largest file from 16 bits.
const MOST: usize = LARGEST_FILE as usize;

/// Operators that give as many numbers as they take, in the same shape.
const UNARY: [&str; 21] = [
    "Abs",
    "Cast",
    "Cos",
    "Elu",
    "Erf",
    "Exp",
    "HardSigmoid",
    "HardSwish",
    "Identity",
    "LeakyRelu",
    "Log",
    "Neg",
    "Reciprocal",
    "Relu",
    "Sigmoid",
    "Sign",
    "Sin",
    "Softmax",
    "Softplus",
    "Sqrt",
    "Tanh",
];
/// Those that give no more numbers than their first operand has.
const REARRANGING: [&str; 9] =
    ["Flatten", "ReduceMean", "ReduceSum", "Reshape", "Slice", "Split", "Squeeze", "Transpose", "Unsqueeze"];
/// Those that repeat operands along each other's axes.
const BROADCASTING: [&str; 9] = ["Add", "Clip", "Div", "Max", "Min", "Mul", "PRelu", "Pow", "Sub"];

/// Those that scale their first operand by vectors.
const NORMALIZING: [&str; 3] = ["BatchNormalization", "InstanceNormalization", "LayerNormalization"];

/// A tensor that depends on no input.
#[derive(Clone)]
struct Stored {
    /// At most so many numbers.
    volume: usize,
    /// Where it is known.
    shape: Option<Vec<usize>>,
}

impl Stored {
    fn of_shape(shape: Vec<usize>) -> Option<Self> {
        let volume = shape.iter().try_fold(1usize, |volume, &side| volume.checked_mul(side))?;
        Some(Self { volume, shape: Some(shape) })
    }

    fn of_volume(volume: usize) -> Self {
        Self { volume, shape: None }
    }

    fn weight(weight: &TensorProto) -> Option<Self> {
        let shape: Option<_> = weight.dims.iter().map(|&dim| usize::try_from(dim).ok()).collect();
        Self::of_shape(shape?)
    }
}

/// Refuses convolutions, pooling and padding of weights alone, and other nodes of them that take or make too many numbers. Expects checked weights, each
/// name defined before it is used.
pub(super) fn check_stored(graph: &GraphProto) -> Result<(), GraphError> {
    let weights =
        graph.initializer.iter().filter_map(|weight| Some((&*weight.name, Stored::weight(weight)?)));
    let mut stored: BTreeMap<&str, Stored> = weights.collect();
    let mut touched = 0;
    for node in &graph.node {
        let operands = node.input.iter().filter(|name| !name.is_empty()).map(|name| stored.get(&**name));
        let Some(operands) = operands.collect::<Option<Vec<_>>>() else { continue };
        let result = result(node, &operands);
        let volumes = operands.iter().copied().chain(&result).map(|tensor| tensor.volume);
        touched = volumes.fold(touched, usize::saturating_add);
        let Some(result) = result.filter(|_| touched <= MOST) else {
            let (node, operator) = (node.name.clone(), node.op_type.clone());
            return Err(GraphError::Stored { node, operator, limit: MOST });
        };
        for name in &node.output {
            stored.insert(name, result.clone());
        }
    }
    Ok(())
}

/// What a node makes of weights; `None` for an operator that is not expected to.
fn result(node: &NodeProto, operands: &[&Stored]) -> Option<Stored> {
    let operator = node.op_type.as_str();
    if operator == "Constant" {
        let attribute = node.attribute.first()?;
        let listed = attribute.floats.len().max(attribute.ints.len()).max(1);
        return attribute.t.as_ref().map_or(Some(Stored::of_volume(listed)), Stored::weight);
    }
    let (first, others) = operands.split_first()?;
    let shapes = || operands.iter().map(|operand| operand.shape.as_deref()).collect::<Option<Vec<_>>>();
    let shape = match (operator, shapes().as_deref()) {
        ("Transpose", Some([shape])) => Some(transposed(node, shape)),
        ("MatMul", Some([[_], [_]])) => Some(Vec::new()),
        ("MatMul", Some([[side, _], [_]] | [[_], [_, side]])) => Some(vec![*side]),
        ("MatMul", Some([[rows, _], [_, columns]])) => Some(vec![*rows, *columns]),
        ("Gemm", Some([a, b, bias @ ..])) if a.len() == 2 && b.len() == 2 => {
            let rows = a[usize::from(flag(node, "transA"))];
            let columns = b[usize::from(!flag(node, "transB"))];
            Some(broadcast(&[&[&[rows, columns][..]], bias].concat()))
        }
        (_, Some(shapes)) if BROADCASTING.contains(&operator) => Some(broadcast(shapes)),
        _ => None,
    };
    if let Some(shape) = shape {
        return Stored::of_shape(shape);
    }
    let mut volumes = operands.iter().map(|operand| operand.volume);
    match operator {
        _ if UNARY.contains(&operator) => return Some((*first).clone()),
        _ if REARRANGING.contains(&operator) => Some(first.volume),
        _ if NORMALIZING.contains(&operator) => {
            first.volume.checked_mul(others.iter().map(|scale| scale.volume).max()?)
        }
        "Concat" => volumes.try_fold(0usize, usize::checked_add),
        "Gather" | "Gemm" | "MatMul" => volumes.try_fold(1, usize::checked_mul),
        _ if BROADCASTING.contains(&operator) => volumes.try_fold(1, usize::checked_mul),
        _ => None,
    }
    .map(Stored::of_volume)
}

fn flag(node: &NodeProto, name: &str) -> bool {
    node.attribute.iter().any(|attribute| attribute.name == name && attribute.i != 0)
}

fn transposed(node: &NodeProto, shape: &[usize]) -> Vec<usize> {
    let order = node.attribute.iter().find(|attribute| attribute.name == "perm");
    match order {
        Some(order) => order.ints.iter().map(|&axis| *shape.get(axis as usize).unwrap_or(&1)).collect(),
        None => shape.iter().rev().copied().collect(),
    }
}

/// The common shape, axes counted from the last; where sides do not fit, the greatest, and tract refuses the graph.
fn broadcast(shapes: &[&[usize]]) -> Vec<usize> {
    let rank = shapes.iter().map(|shape| shape.len()).max().unwrap_or(0);
    (0..rank)
        .map(|axis| {
            let sides = shapes.iter().filter_map(|shape| shape.get((axis + shape.len()).checked_sub(rank)?));
            sides.max().copied().unwrap_or(1)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tract_onnx::pb::AttributeProto;

    /// Name, integer and integers.
    type Attribute = (&'static str, i64, &'static [i64]);
    type Case<'a> = (&'static str, &'a [Attribute], &'a [&'a [usize]], Option<usize>);

    fn node(operator: &str, attributes: &[Attribute]) -> NodeProto {
        let attribute = |&(name, i, ints): &Attribute| AttributeProto {
            name: name.into(),
            i,
            ints: ints.to_vec(),
            ..AttributeProto::default()
        };
        NodeProto {
            op_type: operator.into(),
            attribute: attributes.iter().map(attribute).collect(),
            ..NodeProto::default()
        }
    }

    #[test]
    fn a_result_is_no_larger_than_thought() {
        let cases: [Case<'_>; 16] = [
            ("Cast", &[], &[&[64, 8192]], Some(64 * 8192)),
            ("Div", &[], &[&[64, 8192], &[]], Some(64 * 8192)),
            ("Mul", &[], &[&[8, 1, 1, 1], &[3, 3, 3]], Some(216)),
            ("MatMul", &[], &[&[64, 8192], &[8192]], Some(64)),
            ("MatMul", &[], &[&[64], &[64, 8192]], Some(8192)),
            ("MatMul", &[], &[&[8192], &[8192]], Some(1)),
            ("MatMul", &[], &[&[64, 8192], &[8192, 2]], Some(128)),
            ("MatMul", &[], &[&[2, 3, 4], &[4, 5]], Some(24 * 20)),
            ("Gemm", &[("transB", 1, &[])], &[&[4, 16], &[8, 16], &[8]], Some(32)),
            ("Gemm", &[("transA", 1, &[])], &[&[16, 4], &[16, 8], &[5, 1]], Some(40)),
            ("Transpose", &[("perm", 0, &[1, 0])], &[&[2, 3]], Some(6)),
            ("LayerNormalization", &[], &[&[4, 16], &[16], &[16]], Some(64 * 16)),
            ("Concat", &[], &[&[2, 3], &[4, 3]], Some(18)),
            ("Gather", &[], &[&[7, 2], &[3]], Some(42)),
            ("Conv", &[], &[&[1, 3, 32, 32], &[8, 3, 3, 3]], None),
            ("Mul", &[], &[&[usize::MAX, 1], &[2]], None),
        ];
        for (operator, attributes, shapes, volume) in cases {
            let operands: Vec<_> = shapes
                .iter()
                .map(|shape| Stored { volume: shape.iter().product(), shape: Some(shape.to_vec()) })
                .collect();
            let operands: Vec<_> = operands.iter().collect();
            let made = result(&node(operator, attributes), &operands).map(|made| made.volume);
            assert_eq!(made, volume, "{operator} {shapes:?}");
        }
    }

    #[test]
    fn shapes_are_followed_as_far_as_they_are_known() {
        let matrix = Stored::of_shape(vec![64, 8192]).unwrap();
        let turned = result(&node("Transpose", &[]), &[&matrix]).unwrap();
        assert_eq!(turned.shape, Some(vec![8192, 64]));
        let product = result(&node("MatMul", &[]), &[&matrix, &turned]).unwrap();
        assert_eq!(product.volume, 64 * 64);
        let flat = result(&node("Reshape", &[]), &[&product, &Stored::of_volume(1)]).unwrap();
        assert_eq!((flat.volume, flat.shape.is_some()), (64 * 64, false));
        assert_eq!(result(&node("Add", &[]), &[&flat, &turned]).unwrap().volume, 64 * 64 * 64 * 8192);
    }
}
