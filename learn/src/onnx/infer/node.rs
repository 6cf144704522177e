//! A node as its operator reads it: operands, attributes, and what is wrong with them.

use super::tensor::Tensor;
use crate::onnx::error::{GraphError, NodeFault};
use std::fmt::Display;
use std::ops::RangeInclusive;
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::{AttributeProto, NodeProto};

/// Most axes of a tensor.
const MOST_AXES: usize = 8;
/// Operators with operands that may be left out by an empty name.
const GAPPED: [&str; 3] = ["Clip", "Pad", "Slice"];
/// The attributes that operators here have.
const ATTRIBUTES: [(&str, AttributeType); 23] = [
    ("alpha", AttributeType::Float),
    ("auto_pad", AttributeType::String),
    ("axes", AttributeType::Ints),
    ("axis", AttributeType::Int),
    ("beta", AttributeType::Float),
    ("ceil_mode", AttributeType::Int),
    ("count_include_pad", AttributeType::Int),
    ("dilations", AttributeType::Ints),
    ("epsilon", AttributeType::Float),
    ("group", AttributeType::Int),
    ("keepdims", AttributeType::Int),
    ("kernel_shape", AttributeType::Ints),
    ("mode", AttributeType::String),
    ("output_padding", AttributeType::Ints),
    ("pads", AttributeType::Ints),
    ("perm", AttributeType::Ints),
    ("strides", AttributeType::Ints),
    ("to", AttributeType::Int),
    ("transA", AttributeType::Int),
    ("transB", AttributeType::Int),
    ("allowzero", AttributeType::Int),
    ("noop_with_empty_axes", AttributeType::Int),
    ("training_mode", AttributeType::Int),
];

/// A node with what is known of its operands.
pub(super) struct Node<'a> {
    pub(super) proto: &'a NodeProto,
    /// Operator set of the graph.
    pub(super) opset: i64,
    /// `None` where an operand is left out.
    operands: Vec<Option<&'a Tensor>>,
}

impl<'a> Node<'a> {
    /// A node whose attributes have the types of their names.
    pub(super) fn new(
        proto: &'a NodeProto,
        opset: i64,
        operands: Vec<Option<&'a Tensor>>,
    ) -> Result<Self, GraphError> {
        let node = Self { proto, opset, operands };
        for attribute in &proto.attribute {
            let known = ATTRIBUTES.iter().find(|(name, _)| *name == attribute.name);
            if let Some((name, kind)) = known.filter(|(_, kind)| attribute.r#type != *kind as i32) {
                let got =
                    AttributeType::try_from(attribute.r#type).map_or("unknown", |got| got.as_str_name());
                return Err(node.fault(format!("the type of {name}"), got, kind.as_str_name()));
            }
        }
        let gap = node.operands.iter().position(Option::is_none);
        match gap.filter(|_| !GAPPED.contains(&node.operator())) {
            Some(gap) => Err(node.fault(format!("operand {}", gap + 1), "left out", "a tensor")),
            None => Ok(node),
        }
    }

    pub(super) fn operator(&self) -> &'a str {
        &self.proto.op_type
    }

    /// Its name, or that of its first output where it has none.
    pub(super) fn name(&self) -> String {
        let named = Some(&self.proto.name).filter(|name| !name.is_empty());
        named.or(self.proto.output.first()).cloned().unwrap_or_default()
    }

    pub(super) fn fault(&self, what: impl Display, got: impl Display, expected: impl Display) -> GraphError {
        GraphError::Node(Box::new(NodeFault {
            node: self.name(),
            operator: self.operator().into(),
            what: what.to_string(),
            got: got.to_string(),
            expected: expected.to_string(),
        }))
    }

    /// All operands that are not left out.
    pub(super) fn operands(&self) -> impl Iterator<Item = &'a Tensor> {
        self.operands.iter().copied().flatten()
    }

    /// Checks how many operands there are.
    pub(super) fn takes(&self, expected: &RangeInclusive<usize>) -> Result<(), GraphError> {
        let got = self.operands.len();
        if expected.contains(&got) {
            return Ok(());
        }
        let (least, most) = (expected.start(), expected.end());
        let expected = if least == most { least.to_string() } else { format!("{least} to {most}") };
        Err(self.fault("the number of operands", got, expected))
    }

    pub(super) fn operand(&self, index: usize) -> Result<&'a Tensor, GraphError> {
        self.optional(index)
            .ok_or_else(|| self.fault(format!("operand {}", index + 1), "left out", "a tensor"))
    }

    pub(super) fn optional(&self, index: usize) -> Option<&'a Tensor> {
        self.operands.get(index).copied().flatten()
    }

    /// An operand of `f32`, which is all that is computed with.
    pub(super) fn real(&self, index: usize) -> Result<&'a Tensor, GraphError> {
        let operand = self.operand(index)?;
        if operand.kind == DataType::Float {
            return Ok(operand);
        }
        let what = format!("the type of operand {}", index + 1);
        Err(self.fault(what, operand.kind.as_str_name(), "FLOAT, which weights of other types are cast to"))
    }

    /// The integers of an operand that has to be a weight of at most one axis.
    pub(super) fn listed(&self, index: usize) -> Result<&'a [i64], GraphError> {
        let integers = self.indices(index)?;
        let shape = &self.operand(index)?.shape;
        if shape.len() <= 1 {
            return Ok(integers);
        }
        Err(self.fault(format!("the shape of operand {}", index + 1), format!("{shape:?}"), "a list"))
    }

    /// The integers of an operand that has to be a weight.
    pub(super) fn indices(&self, index: usize) -> Result<&'a [i64], GraphError> {
        let operand = self.operand(index)?;
        let integers = operand.integers.as_deref();
        integers.ok_or_else(|| {
            let kind = operand.kind.as_str_name();
            let got = if operand.stored {
                format!("{kind}, or computed")
            } else {
                format!("{kind}, of the inputs")
            };
            self.fault(format!("operand {}", index + 1), got, "a weight or Constant of integers")
        })
    }

    pub(super) fn attribute(&self, name: &str) -> Option<&'a AttributeProto> {
        self.proto.attribute.iter().find(|attribute| attribute.name == name)
    }

    pub(super) fn integer(&self, name: &str) -> Option<i64> {
        self.attribute(name).map(|attribute| attribute.i)
    }

    pub(super) fn integers(&self, name: &str) -> Option<&'a [i64]> {
        self.attribute(name).map(|attribute| &*attribute.ints)
    }

    pub(super) fn text(&self, name: &str) -> Option<&'a [u8]> {
        self.attribute(name).map(|attribute| &*attribute.s)
    }

    /// An attribute that is 0 or 1.
    pub(super) fn flag(&self, name: &str, default: bool) -> Result<bool, GraphError> {
        match self.integer(name) {
            None => Ok(default),
            Some(flag @ (0 | 1)) => Ok(flag == 1),
            Some(got) => Err(self.fault(name, got, "0 or 1")),
        }
    }

    /// Refuses an attribute that this operator does not have here, and what takes its place.
    pub(super) fn lacks(&self, name: &str, instead: &str) -> Result<(), GraphError> {
        match self.attribute(name) {
            Some(_) => Err(self.fault(format!("attribute {name}"), "there", instead)),
            None => Ok(()),
        }
    }

    /// An axis of a tensor of `rank` axes, counted from the last where it is negative.
    pub(super) fn axis(&self, what: &str, axis: i64, rank: usize) -> Result<usize, GraphError> {
        let from_first = if axis < 0 { axis.saturating_add(rank as i64) } else { axis };
        usize::try_from(from_first).ok().filter(|&axis| axis < rank).ok_or_else(|| {
            let expected = match rank {
                0 => "an operand with axes".to_owned(),
                _ => format!("-{rank} to {}", rank - 1),
            };
            self.fault(what, axis, expected)
        })
    }

    /// Different axes of a tensor of `rank` axes.
    pub(super) fn axes(&self, what: &str, axes: &[i64], rank: usize) -> Result<Vec<usize>, GraphError> {
        if axes.len() > rank.min(MOST_AXES) {
            return Err(self.fault(what, format!("{} axes", axes.len()), format!("at most {rank}")));
        }
        let mut found = Vec::with_capacity(axes.len());
        for &axis in axes {
            let axis = self.axis(what, axis, rank)?;
            if found.contains(&axis) {
                return Err(self.fault(what, format!("{axes:?}"), "each axis once"));
            }
            found.push(axis);
        }
        Ok(found)
    }

    /// [`Node::tensor`] as the one result.
    pub(super) fn made(&self, kind: DataType, shape: Vec<usize>) -> Result<Vec<Tensor>, GraphError> {
        Ok(vec![self.tensor(kind, shape)?])
    }

    /// A tensor of a shape without an empty side, and not of too many axes.
    pub(super) fn tensor(&self, kind: DataType, shape: Vec<usize>) -> Result<Tensor, GraphError> {
        if shape.len() > MOST_AXES {
            return Err(self.fault(
                "the result",
                format!("{} axes", shape.len()),
                format!("at most {MOST_AXES}"),
            ));
        }
        if shape.contains(&0) {
            return Err(self.fault("the result's shape", format!("{shape:?}"), "no empty side"));
        }
        Ok(Tensor::new(kind, shape))
    }
}
