//! Operators that arrange numbers and compute none.

use super::node::Node;
use super::pointwise::MOST_OPERANDS;
use super::tensor::{Tensor, volume};
use crate::onnx::error::GraphError;
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::tensor_proto::DataType;

/// Types that a `Cast` makes.
const CAST_TO: [DataType; 3] = [DataType::Float, DataType::Int32, DataType::Int64];

pub(super) fn constant(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let [attribute] = &node.proto.attribute[..] else {
        return Err(node.fault("the number of attributes", node.proto.attribute.len(), 1));
    };
    let of_reals = |shape| Tensor { stored: true, ..Tensor::new(DataType::Float, shape) };
    let kind = AttributeType::try_from(attribute.r#type).unwrap_or(AttributeType::Undefined);
    let made = match (&*attribute.name, kind, &attribute.t) {
        ("value", AttributeType::Tensor, Some(weight)) => Tensor::weight(weight),
        ("value_int", AttributeType::Int, _) => Tensor::of_integers(Vec::new(), &[attribute.i]),
        ("value_ints", AttributeType::Ints, _) => {
            Tensor::of_integers(vec![attribute.ints.len()], &attribute.ints)
        }
        ("value_float", AttributeType::Float, _) => of_reals(Vec::new()),
        ("value_floats", AttributeType::Floats, _) => of_reals(vec![attribute.floats.len()]),
        (name, kind, _) => {
            let got = format!("{name:?} {}", kind.as_str_name());
            return Err(node.fault(
                "the attribute",
                got,
                "value, value_int, value_ints, value_float or value_floats",
            ));
        }
    };
    Ok(vec![made])
}

pub(super) fn identity(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    Ok(vec![node.operand(0)?.clone()])
}

pub(super) fn cast(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.operand(0)?;
    let to = node.integer("to").and_then(|to| DataType::try_from(i32::try_from(to).ok()?).ok());
    match to.filter(|to| CAST_TO.contains(to)) {
        Some(to) => node.made(to, x.shape.clone()),
        None => {
            let got = to.map_or("no known type", |to| to.as_str_name());
            Err(node.fault("to", got, "FLOAT, INT32 or INT64"))
        }
    }
}

pub(super) fn concat(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let first = node.operand(0)?;
    let axis = node.integer("axis").ok_or_else(|| node.fault("axis", "missing", "an axis"))?;
    let axis = node.axis("axis", axis, first.shape.len())?;
    let mut shape = first.shape.clone();
    for operand in node.operands().skip(1) {
        let mut expected = operand.shape.clone();
        if let Some(side) = expected.get_mut(axis) {
            *side = first.shape[axis];
        }
        if operand.kind != first.kind || expected != first.shape {
            let told = |t: &Tensor| format!("{} {:?}", t.kind.as_str_name(), t.shape);
            let got = format!("{} beside {}", told(operand), told(first));
            return Err(node.fault("an operand", got, format!("the same but along axis {axis}")));
        }
        shape[axis] = shape[axis].saturating_add(operand.shape[axis]);
    }
    node.made(first.kind, shape)
}

pub(super) fn flatten(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.operand(0)?;
    let (axis, rank) = (node.integer("axis").unwrap_or(1), x.shape.len());
    let at = if axis == rank as i64 { rank } else { node.axis("axis", axis, rank)? };
    let (rows, columns) = x.shape.split_at(at);
    node.made(x.kind, vec![volume(rows), volume(columns)])
}

pub(super) fn gather(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let (x, indices) = (node.operand(0)?, node.indices(1)?);
    let axis = node.axis("axis", node.integer("axis").unwrap_or(0), x.shape.len())?;
    let side = x.shape[axis] as i64;
    if let Some(index) = indices.iter().find(|&&index| index < -side || index >= side) {
        return Err(node.fault("an index", index, format!("-{side} to {}", side - 1)));
    }
    let (before, after) = (&x.shape[..axis], &x.shape[axis + 1..]);
    node.made(x.kind, [before, &node.operand(1)?.shape, after].concat())
}

/// Pads are not negative; those of a reflection are less than the side.
pub(super) fn pad(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    node.takes(&(2..=if node.opset >= 18 { 4 } else { 3 }))?;
    let (x, pads) = (node.real(0)?, node.listed(1)?);
    let rank = x.shape.len();
    let axes = match node.optional(3) {
        Some(_) => node.axes("axes", node.listed(3)?, rank)?,
        None => (0..rank).collect(),
    };
    let mode = node.text("mode").unwrap_or(b"constant");
    if ![&b"constant"[..], b"edge", b"reflect"].contains(&mode) {
        let got = format!("{:?}", String::from_utf8_lossy(mode));
        return Err(node.fault("mode", got, "constant, edge or reflect"));
    }
    if node.optional(2).is_some_and(|value| !value.stored || !value.shape.is_empty() || value.kind != x.kind)
    {
        return Err(node.fault("operand 3", "something else", "a weight that is a single number, [] FLOAT"));
    }
    if pads.len() != 2 * axes.len() {
        return Err(node.fault("the number of pads", pads.len(), 2 * axes.len()));
    }
    let mut shape = x.shape.clone();
    for (&by, &axis) in pads.iter().zip(axes.iter().chain(&axes)) {
        let most = if mode == b"reflect" { x.shape[axis] - 1 } else { i32::MAX as usize };
        match usize::try_from(by).ok().filter(|&by| by <= most) {
            Some(by) => shape[axis] += by,
            None => return Err(node.fault(format!("a pad of axis {axis}"), by, format!("0 to {most}"))),
        }
    }
    node.made(x.kind, shape)
}

/// 0 stands for the operand's side, -1 for whatever is left.
pub(super) fn reshape(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let (x, sides) = (node.operand(0)?, node.listed(1)?);
    let kept = !node.flag("allowzero", false)?;
    let unfit = || {
        let expected = format!("as many numbers as {:?}", x.shape);
        node.fault("the new shape", format!("{:?}", &sides[..sides.len().min(16)]), expected)
    };
    let side = |(axis, &side): (usize, &i64)| match side {
        0 if kept => x.shape.get(axis).copied(),
        -1 => Some(1),
        side => usize::try_from(side).ok(),
    };
    let shape: Option<Vec<_>> = sides.iter().enumerate().map(side).collect();
    let mut shape = shape.ok_or_else(unfit)?;
    let (whole, part) = (x.volume(), volume(&shape));
    let mut free = sides.iter().enumerate().filter(|(_, side)| **side == -1).map(|(axis, _)| axis);
    match (free.next(), free.next()) {
        (Some(axis), None) if part > 0 && whole.is_multiple_of(part) => shape[axis] = whole / part,
        (None, _) if part == whole => {}
        _ => return Err(unfit()),
    }
    node.made(x.kind, shape)
}

/// As NumPy's `x[start:end:step]` along some axes.
pub(super) fn slice(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let (x, starts, ends) = (node.operand(0)?, node.listed(1)?, node.listed(2)?);
    let rank = x.shape.len();
    let axes = match node.optional(3) {
        Some(_) => node.axes("axes", node.listed(3)?, rank)?,
        None => (0..starts.len()).collect(),
    };
    let steps = match node.optional(4) {
        Some(_) => node.listed(4)?.to_vec(),
        None => vec![1; starts.len()],
    };
    let lengths = [starts.len(), ends.len(), axes.len(), steps.len()];
    if lengths.iter().any(|&length| length != starts.len()) || starts.len() > rank {
        let got = format!("{lengths:?}");
        return Err(node.fault(
            "the numbers of starts, ends, axes and steps",
            got,
            format!("the same, at most {rank}"),
        ));
    }
    let mut shape = x.shape.clone();
    for (index, &axis) in axes.iter().enumerate() {
        let (side, step) = (x.shape[axis] as i64, steps[index]);
        if step == 0 || i32::try_from(step).is_err() {
            return Err(node.fault("a step", step, "not 0, of 32 bits"));
        }
        let from_first = |at: i64| if at < 0 { at.saturating_add(side) } else { at };
        let (start, end) = (from_first(starts[index]), from_first(ends[index]));
        let taken = match step > 0 {
            true => (end.clamp(0, side) - start.clamp(0, side)).max(0) as u64,
            false => (start.clamp(-1, side - 1) - end.clamp(-1, side - 1)).max(0) as u64,
        };
        shape[axis] = taken.div_ceil(step.unsigned_abs()) as usize;
    }
    node.made(x.kind, shape)
}

/// The sizes are an operand; without it all parts are of one size.
pub(super) fn split(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    node.lacks("split", "an operand in its place")?;
    let (x, count) = (node.operand(0)?, node.proto.output.len());
    let axis = node.axis("axis", node.integer("axis").unwrap_or(0), x.shape.len())?;
    if !(1..=MOST_OPERANDS).contains(&count) {
        return Err(node.fault("the number of results", count, format!("1 to {MOST_OPERANDS}")));
    }
    let side = x.shape[axis];
    let sizes: Option<Vec<usize>> = match node.optional(1) {
        Some(_) => {
            node.listed(1)?.iter().map(|&size| usize::try_from(size).ok().filter(|&s| s <= side)).collect()
        }
        None => side.is_multiple_of(count).then(|| vec![side / count; count]),
    };
    let sizes = sizes.filter(|sizes| sizes.len() == count && sizes.iter().sum::<usize>() == side);
    let Some(sizes) = sizes else {
        let got = match node.optional(1) {
            Some(_) => format!("{:?}", &node.listed(1)?.iter().take(16).collect::<Vec<_>>()),
            None => "not given".into(),
        };
        return Err(node.fault("the sizes", got, format!("{count} that add up to {side}")));
    };
    let part = |size| {
        let mut shape = x.shape.clone();
        shape[axis] = size;
        node.tensor(x.kind, shape)
    };
    sizes.into_iter().map(part).collect()
}

pub(super) fn squeeze(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.operand(0)?;
    let axes = match node.optional(1) {
        Some(_) => node.axes("axes", node.listed(1)?, x.shape.len())?,
        None => (0..x.shape.len()).filter(|&axis| x.shape[axis] == 1).collect(),
    };
    // The runtime takes them out one by one, as if each were counted after those before it are gone.
    if !axes.is_sorted() {
        return Err(node.fault("axes", format!("{axes:?}"), "ascending order"));
    }
    if let Some(axis) = axes.iter().find(|&&axis| x.shape[axis] != 1) {
        return Err(node.fault(format!("the side of axis {axis}"), x.shape[*axis], 1));
    }
    let kept = (0..x.shape.len()).filter(|axis| !axes.contains(axis)).map(|axis| x.shape[axis]);
    node.made(x.kind, kept.collect())
}

pub(super) fn transpose(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.operand(0)?;
    let rank = x.shape.len();
    let order: Vec<usize> = match node.integers("perm") {
        None => (0..rank).rev().collect(),
        Some(perm) => {
            let axis = |&axis: &i64| usize::try_from(axis).ok().filter(|&axis| axis < rank);
            let order: Option<Vec<usize>> = perm.iter().map(axis).collect();
            let order =
                order.filter(|order| order.len() == rank && (0..rank).all(|axis| order.contains(&axis)));
            order.ok_or_else(|| {
                let got = format!("{:?}", &perm[..perm.len().min(16)]);
                node.fault("perm", got, format!("each axis from 0 up to {rank} once"))
            })?
        }
    };
    node.made(x.kind, order.into_iter().map(|axis| x.shape[axis]).collect())
}

pub(super) fn unsqueeze(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let (x, axes) = (node.operand(0)?, node.listed(1)?);
    let rank = x.shape.len().saturating_add(axes.len());
    let axes = node.axes("axes", axes, rank)?;
    let mut sides = x.shape.iter().copied();
    let side = |axis| if axes.contains(&axis) { Some(1) } else { sides.next() };
    node.made(x.kind, (0..rank).filter_map(side).collect())
}
