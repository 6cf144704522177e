//! Convolutions and pooling.

use super::node::Node;
use super::tensor::{Tensor, volume};
use super::{LARGEST_TENSOR, too_large_a_tensor};
use crate::onnx::error::GraphError;
use std::ops::RangeInclusive;
use tract_onnx::pb::tensor_proto::DataType;

/// Longest side of a kernel, stride and dilation.
const MOST: usize = 4096;

/// How windows lie on an image, axis by axis.
struct Windows {
    strides: Vec<usize>,
    /// From the first to the last pixel of a window, dilation included.
    fields: Vec<usize>,
    padding: Padding,
}

enum Padding {
    /// So many pixels before, and after.
    By(Vec<[usize; 2]>),
    /// As many as make the result the operand's size over the stride.
    Same,
}

impl Windows {
    /// Of the sides of a kernel.
    fn new(node: &Node, kernel: &[usize]) -> Result<Self, GraphError> {
        let strides = each(node, "strides", kernel.len(), 1, 1..=MOST)?;
        let dilations = each(node, "dilations", kernel.len(), 1, 1..=MOST)?;
        let field = |(&side, dilation): (&usize, usize)| (side - 1) * dilation + 1;
        let fields = kernel.iter().zip(dilations).map(field).collect();
        let padding = match node.text("auto_pad") {
            None | Some(b"NOTSET" | b"") => {
                let pads = each(node, "pads", 2 * kernel.len(), 0, 0..=LARGEST_TENSOR)?;
                Padding::By((0..kernel.len()).map(|axis| [pads[axis], pads[axis + kernel.len()]]).collect())
            }
            Some(auto) => {
                node.lacks("pads", "either pads or auto_pad")?;
                match auto {
                    b"VALID" => Padding::By(vec![[0; 2]; kernel.len()]),
                    b"SAME_UPPER" | b"SAME_LOWER" => Padding::Same,
                    other => {
                        let got = format!("{:?}", String::from_utf8_lossy(other));
                        return Err(node.fault("auto_pad", got, "NOTSET, VALID, SAME_UPPER or SAME_LOWER"));
                    }
                }
            }
        };
        Ok(Self { strides, fields, padding })
    }

    /// Windows along each axis of an image; `rounded_up` lets the last one reach beyond the padding, as long as it begins within.
    fn positions(&self, node: &Node, sides: &[usize], rounded_up: bool) -> Result<Vec<usize>, GraphError> {
        let along = |axis: usize| {
            let (side, stride, field) = (sides[axis], self.strides[axis], self.fields[axis]);
            let Padding::By(pads) = &self.padding else { return Ok(side.div_ceil(stride)) };
            let [before, after] = pads[axis];
            let room = (before + side + after).checked_sub(field).ok_or_else(|| {
                let expected = format!("at most the {} of the padded operand", before + side + after);
                node.fault(format!("the kernel's reach along axis {}", axis + 2), field, expected)
            })?;
            if !rounded_up {
                return Ok(room / stride + 1);
            }
            let last = room.div_ceil(stride);
            Ok(if last * stride >= before + side { last } else { last + 1 })
        };
        (0..sides.len()).map(along).collect()
    }
}

/// A kernel `[outputs, inputs / group, sides ..]` over `[n, inputs, sides ..]`.
pub(super) fn conv(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let ([n, inputs], sides, kernel, group) = convolved(node)?;
    let (outputs, of_group) = (kernel[0], kernel[1]);
    if group * of_group != inputs || !outputs.is_multiple_of(group) {
        let got = format!("{kernel:?}, in {group} groups");
        return Err(node.fault("the kernel's shape", got, format!("[groups x any, {inputs} / groups, ..]")));
    }
    of_outputs(node, outputs)?;
    let windows = Windows::new(node, &kernel[2..])?;
    let positions = windows.positions(node, sides, false)?;
    if let Padding::By(pads) = &windows.padding {
        let padded: Vec<_> = sides.iter().zip(pads).map(|(side, pads)| side + pads[0] + pads[1]).collect();
        bounded(node, &[&[n, inputs][..], &padded].concat())?;
    }
    bounded(node, &[&kernel[1..], &positions].concat())?;
    node.made(DataType::Float, [&[n, outputs][..], &positions].concat())
}

/// A kernel `[inputs, outputs / group, sides ..]` over `[n, inputs, sides ..]`.
pub(super) fn conv_transpose(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    node.lacks("output_shape", "pads and output_padding")?;
    let ([n, inputs], sides, kernel, group) = convolved(node)?;
    if kernel[0] != inputs || !inputs.is_multiple_of(group) {
        let got = format!("{kernel:?}, in {group} groups");
        return Err(node.fault(
            "the kernel's shape",
            got,
            format!("[{inputs}, ..], a multiple of the groups"),
        ));
    }
    let outputs = group.saturating_mul(kernel[1]);
    of_outputs(node, outputs)?;
    let windows = Windows::new(node, &kernel[2..])?;
    let beyond = each(node, "output_padding", sides.len(), 0, 0..=MOST)?;
    let made = |axis: usize| {
        let (side, stride, field) = (sides[axis], windows.strides[axis], windows.fields[axis]);
        if beyond[axis] > 0 && beyond[axis] >= stride {
            return Err(node.fault("output_padding", beyond[axis], format!("less than the stride {stride}")));
        }
        let Padding::By(pads) = &windows.padding else {
            if beyond[axis] > 0 || field <= stride {
                let got = format!("a reach of {field} and an output_padding of {}", beyond[axis]);
                return Err(node.fault(
                    "the kernel",
                    got,
                    format!(
                        "a reach beyond the stride {stride} and no output_padding, where auto_pad is SAME"
                    ),
                ));
            }
            return Ok(side * stride);
        };
        let whole = (side - 1) * stride + field + beyond[axis];
        whole.checked_sub(pads[axis][0] + pads[axis][1]).filter(|&side| side > 0).ok_or_else(|| {
            let expected = format!("less than the result's {whole} together");
            node.fault("pads", format!("{:?}", pads[axis]), expected)
        })
    };
    let made: Vec<_> = (0..sides.len()).map(made).collect::<Result<_, _>>()?;
    bounded(node, &[&kernel[1..], sides].concat())?;
    node.made(DataType::Float, [&[n, outputs][..], &made].concat())
}

pub(super) fn pool(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.real(0)?;
    let ([n, channels], sides) = image(node, x)?;
    if node.attribute("kernel_shape").is_none() {
        return Err(node.fault("kernel_shape", "missing", format!("{} sides", sides.len())));
    }
    let kernel = each(node, "kernel_shape", sides.len(), 1, 1..=MOST)?;
    let windows = Windows::new(node, &kernel)?;
    node.flag("count_include_pad", false)?;
    if let Padding::By(pads) = &windows.padding {
        for ([before, after], &field) in pads.iter().zip(&windows.fields) {
            if *before.max(after) >= field {
                let expected = format!("less than the window's reach of {field}");
                return Err(node.fault("pads", before.max(after), expected));
            }
        }
    }
    let rounded_up = node.flag("ceil_mode", false)?;
    if rounded_up {
        node.lacks("auto_pad", "pads beside a ceil_mode of 1")?;
    }
    let positions = windows.positions(node, sides, rounded_up)?;
    node.made(DataType::Float, [&[n, channels][..], &positions].concat())
}

pub(super) fn global_pool(node: &Node) -> Result<Vec<Tensor>, GraphError> {
    let x = node.real(0)?;
    let ([n, channels], sides) = image(node, x)?;
    node.made(DataType::Float, [vec![n, channels], vec![1; sides.len()]].concat())
}

type Convolved<'a> = ([usize; 2], &'a [usize], &'a [usize], usize);

/// Batch and channels of an image, its sides, the kernel's shape, groups.
fn convolved<'a>(node: &Node<'a>) -> Result<Convolved<'a>, GraphError> {
    let (x, kernel) = (node.real(0)?, &node.real(1)?.shape);
    let (head, sides) = image(node, x)?;
    if kernel.len() != x.shape.len() || kernel.contains(&0) || kernel[2..].iter().any(|&side| side > MOST) {
        let expected = format!("{} axes, sides of 1 to {MOST}", x.shape.len());
        return Err(node.fault("the kernel's shape", format!("{kernel:?}"), expected));
    }
    let told = each(node, "kernel_shape", sides.len(), 1, 1..=MOST)?;
    if node.attribute("kernel_shape").is_some() && told != kernel[2..] {
        return Err(node.fault(
            "kernel_shape",
            format!("{told:?}"),
            format!("the kernel's {:?}", &kernel[2..]),
        ));
    }
    let group = node.integer("group").unwrap_or(1);
    match usize::try_from(group).ok().filter(|group| (1..=head[1]).contains(group)) {
        Some(group) => Ok((head, sides, kernel, group)),
        None => Err(node.fault("group", group, format!("1 to the {} channels", head[1]))),
    }
}

/// Batch and channels of an image, and one to three sides.
fn image<'a>(node: &Node, x: &'a Tensor) -> Result<([usize; 2], &'a [usize]), GraphError> {
    match &x.shape[..] {
        [n, channels, sides @ ..] if (1..=3).contains(&sides.len()) => Ok(([*n, *channels], sides)),
        shape => Err(node.fault("the operand's shape", format!("{shape:?}"), "[n, channels, 1 to 3 sides]")),
    }
}

/// The shift of each output, where there is one.
fn of_outputs(node: &Node, outputs: usize) -> Result<(), GraphError> {
    match node.optional(2) {
        Some(_) if node.real(2)?.shape[..] != [outputs] => Err(node.fault(
            "the shape of operand 3",
            format!("{:?}", node.real(2)?.shape),
            format!("[{outputs}]"),
        )),
        _ => Ok(()),
    }
}

/// An attribute of so many integers, in a range.
fn each(
    node: &Node,
    name: &str,
    count: usize,
    default: usize,
    range: RangeInclusive<usize>,
) -> Result<Vec<usize>, GraphError> {
    let Some(listed) = node.integers(name) else { return Ok(vec![default; count]) };
    let inside = |&number: &i64| usize::try_from(number).ok().filter(|number| range.contains(number));
    let numbers: Option<Vec<usize>> = listed.iter().map(inside).collect();
    numbers.filter(|numbers| numbers.len() == count).ok_or_else(|| {
        let shown = &listed[..listed.len().min(2 * count)];
        let got = if shown.len() < listed.len() {
            format!("{} numbers", listed.len())
        } else {
            format!("{shown:?}")
        };
        node.fault(name, got, format!("{count} numbers from {} to {}", range.start(), range.end()))
    })
}

/// Refuses what a runtime may have to lay out in memory beside operands and result.
fn bounded(node: &Node, shape: &[usize]) -> Result<(), GraphError> {
    if volume(shape) > LARGEST_TENSOR { Err(too_large_a_tensor(node, shape)) } else { Ok(()) }
}
