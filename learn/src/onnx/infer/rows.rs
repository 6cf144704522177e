//! Operators along some axes: sums and means, softmax, normalisations.

use super::node::Node;
use super::pointwise::repeated;
use super::tensor::Tensor;
use crate::onnx::error::GraphError;
use tract_onnx::pb::tensor_proto::DataType;

/// The axes are an attribute, or an operand: of sums from opset 13, of means from 18.
pub(super) fn reduce(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let as_operand = node.operator() == "ReduceSum" || node.opset >= 18;
    node.takes(&(1..=if as_operand { 2 } else { 1 }))?;
    let x = node.real(0)?;
    let rank = x.shape.len();
    let axes = if as_operand {
        node.lacks("axes", "an operand in its place")?;
        node.optional(1).map(|_| node.listed(1)).transpose()?
    } else {
        let axes = node.integers("axes");
        if axes == Some(&[]) {
            return Err(node.fault("axes", "an empty list", "at least one axis, or no list for all"));
        }
        axes
    };
    let axes = axes.filter(|axes| !axes.is_empty());
    let axes = match axes {
        Some(axes) => node.axes("axes", axes, rank)?,
        None if as_operand && node.flag("noop_with_empty_axes", false)? => Vec::new(),
        None => (0..rank).collect(),
    };
    let kept = node.flag("keepdims", true)?;
    let side = |(axis, &side): (usize, &usize)| match axes.contains(&axis) {
        true => kept.then_some(1),
        false => Some(side),
    };
    node.made(DataType::Float, x.shape.iter().enumerate().filter_map(side).collect())
}

pub(super) fn softmax(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.real(0)?;
    node.axis("axis", node.integer("axis").unwrap_or(-1), x.shape.len())?;
    node.made(DataType::Float, x.shape.clone())
}

/// Four weights for each channel, the second axis: scale, shift, mean and variance.
pub(super) fn batch_normalization(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    if node.flag("training_mode", false)? {
        return Err(node.fault("training_mode", 1, "0: export the model for evaluation"));
    }
    let x = node.real(0)?;
    let channels = channels(node, x, 2)?;
    for index in 1..5 {
        if !node.real(index)?.stored {
            return Err(node.fault(format!("operand {}", index + 1), "computed of the inputs", "a weight"));
        }
        of_channels(node, index, channels)?;
    }
    node.made(DataType::Float, x.shape.clone())
}

/// Scale and shift of each channel, the second axis.
pub(super) fn instance_normalization(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.real(0)?;
    let channels = channels(node, x, 3)?;
    of_channels(node, 1, channels)?;
    of_channels(node, 2, channels)?;
    node.made(DataType::Float, x.shape.clone())
}

pub(super) fn layer_normalization(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.real(0)?;
    node.axis("axis", node.integer("axis").unwrap_or(-1), x.shape.len())?;
    repeated(node, "scale", &node.real(1)?.shape, &x.shape)?;
    if node.optional(2).is_some() {
        repeated(node, "shift", &node.real(2)?.shape, &x.shape)?;
    }
    node.made(DataType::Float, x.shape.clone())
}

fn channels(node: &Node, x: &Tensor, least: usize) -> Result<usize, GraphError> {
    match x.shape.get(1).filter(|_| x.shape.len() >= least) {
        Some(&channels) => Ok(channels),
        None => {
            Err(node.fault("the operand's shape", format!("{:?}", x.shape), format!("{least} axes or more")))
        }
    }
}

fn of_channels(node: &Node, index: usize, channels: usize) -> Result<(), GraphError> {
    let shape = &node.real(index)?.shape;
    if shape[..] == [channels] {
        return Ok(());
    }
    let what = format!("the shape of operand {}", index + 1);
    Err(node.fault(what, format!("{shape:?}"), format!("[{channels}], one number a channel")))
}
