//! Random nodes, sane and mad: what is let through is taken by the runtime.

use super::*;
use crate::onnx::build::GraphBuilder;
use crate::onnx::graph::Graph;
use vantage_dataset::{Seed, Stream};

/// Chains that begin with each operator.
const ROUNDS: u64 = 12;
/// Most nodes in a chain.
const LONGEST: usize = 4;

fn pick<T: Clone>(stream: &mut Stream, from: &[T]) -> T {
    from[stream.below(from.len())].clone()
}

fn shape(stream: &mut Stream, rank: usize) -> Vec<usize> {
    (0..rank).map(|_| pick(stream, &[1, 1, 2, 3, 4, 4, 6, 8, 9])).collect()
}

fn integers(stream: &mut Stream, count: usize, from: &[i64]) -> Vec<i64> {
    (0..count).map(|_| pick(stream, from)).collect()
}

fn maybe(
    attributes: &mut Vec<AttributeProto>,
    stream: &mut Stream,
    name: &str,
    value: impl FnOnce(&mut Stream) -> Value,
) {
    if stream.chance(0.5) {
        attributes.push(attribute(name, &value(stream)));
    }
}

/// What a node of an operator has beside its first operand.
struct Drawn {
    operator: &'static str,
    attributes: Vec<AttributeProto>,
    weights: Vec<Vec<usize>>,
    lists: Vec<Vec<i64>>,
    outputs: usize,
}

fn drawn(operator: &'static str, x: &[usize], stream: &mut Stream) -> Drawn {
    const AXES: [i64; 7] = [-3, -2, -1, 0, 1, 2, 3];
    const SIZES: [i64; 8] = [-1, 0, 1, 1, 2, 3, 4, 9];
    let rank = x.len();
    let mut attributes = Vec::new();
    let (mut weights, mut lists, mut outputs) = (Vec::new(), Vec::new(), 1);
    match operator {
        "Conv" | "ConvTranspose" | "AveragePool" | "MaxPool" => {
            let sides = rank.saturating_sub(2).max(1);
            let kernel = integers(stream, sides, &[1, 1, 2, 3, 3, 5]);
            let pooled = operator.ends_with("Pool");
            let channels = x.get(1).copied().unwrap_or(1);
            let group = pick(stream, &[1, 1, 1, 2, channels as i64]);
            if pooled {
                maybe(&mut attributes, stream, "ceil_mode", |_| Value::One(1));
                maybe(&mut attributes, stream, "count_include_pad", |_| Value::One(1));
            } else {
                let (of_group, multiple) = (channels / (group as usize).max(1), pick(stream, &[1, 2, 3]));
                let head = match operator {
                    "Conv" => [multiple * group as usize, of_group],
                    _ => [channels, multiple],
                };
                let reach = kernel.iter().map(|&side| side as usize);
                let outputs = if operator == "Conv" { head[0] } else { head[1] * group as usize };
                weights.push(head.into_iter().chain(reach).collect());
                if stream.chance(0.5) {
                    weights.push(vec![outputs]);
                }
                maybe(&mut attributes, stream, "output_padding", |stream| {
                    Value::Many(integers(stream, sides, &[0, 0, 1]))
                });
            }
            if pooled || stream.chance(0.5) {
                attributes.push(many("kernel_shape", &kernel));
            }
            attributes.push(one("group", group));
            maybe(&mut attributes, stream, "strides", |stream| {
                Value::Many(integers(stream, sides, &[1, 1, 2, 3, 7]))
            });
            maybe(&mut attributes, stream, "dilations", |stream| {
                Value::Many(integers(stream, sides, &[1, 1, 1, 2, 3]))
            });
            if stream.chance(0.3) {
                let auto = pick(stream, &["SAME_UPPER", "SAME_LOWER", "VALID", "NOTSET"]);
                attributes.push(attribute("auto_pad", &Value::Text(auto.into())));
            } else {
                maybe(&mut attributes, stream, "pads", |stream| {
                    Value::Many(integers(stream, 2 * sides, &[0, 0, 1, 2, 4]))
                });
            }
        }
        "Transpose" => {
            maybe(&mut attributes, stream, "perm", |stream| Value::Many(integers(stream, rank, &AXES[3..])))
        }
        "Flatten" | "Softmax" => {
            maybe(&mut attributes, stream, "axis", |stream| Value::One(pick(stream, &AXES)))
        }
        "Concat" => {
            attributes.push(one("axis", pick(stream, &AXES)));
            weights.push(x.to_vec());
        }
        "Gather" => {
            maybe(&mut attributes, stream, "axis", |stream| Value::One(pick(stream, &AXES)));
            let count = pick(stream, &[1, 2, 5]);
            lists.push(integers(stream, count, &SIZES));
        }
        "Reshape" => {
            let count = pick(stream, &[1, 2, 3, 4, 6]);
            lists.push(match stream.chance(0.5) {
                true => integers(stream, count, &SIZES),
                false => x.iter().rev().map(|&side| side as i64).collect(),
            });
        }
        "Squeeze" | "Unsqueeze" | "ReduceSum" => {
            let count = pick(stream, &[0, 1, 1, 2, 3]);
            lists.push(integers(stream, count, &AXES));
            maybe(&mut attributes, stream, "keepdims", |_| Value::One(0));
        }
        "ReduceMean" => {
            let count = pick(stream, &[0, 1, 1, 2]);
            maybe(&mut attributes, stream, "axes", |stream| Value::Many(integers(stream, count, &AXES)));
            maybe(&mut attributes, stream, "keepdims", |_| Value::One(0));
        }
        "Slice" => {
            const ENDS: [i64; 9] = [i64::MIN, -9, -2, -1, 0, 1, 3, 9, i64::MAX];
            let count = pick(stream, &[1, 1, 2]);
            lists.extend([integers(stream, count, &ENDS), integers(stream, count, &ENDS)]);
            lists.push((0..count as i64).collect());
            lists.push(integers(stream, count, &[-5, -2, -1, 1, 1, 2, 5]));
        }
        "Split" => {
            attributes.push(one("axis", pick(stream, &AXES)));
            outputs = pick(stream, &[1, 2, 3]);
            if stream.chance(0.5) {
                lists.push(integers(stream, outputs, &SIZES));
            }
        }
        "Pad" => {
            lists.push(integers(stream, 2 * rank, &[0, 0, 1, 2, 5]));
            maybe(&mut attributes, stream, "mode", |stream| {
                Value::Text(pick(stream, &["edge", "reflect", "constant"]).into())
            });
        }
        "MatMul" | "Gemm" => {
            let last = x.last().copied().unwrap_or(1);
            let mut other = x.to_vec();
            other.truncate(pick(stream, &[1, 2, 3]).min(rank));
            if let Some(side) = other.len().checked_sub(2).and_then(|at| other.get_mut(at)) {
                *side = last;
            } else {
                other = vec![last];
            }
            weights.push(other);
        }
        "BatchNormalization" => weights.extend(vec![vec![x.get(1).copied().unwrap_or(1)]; 4]),
        "InstanceNormalization" => weights.extend(vec![vec![x.get(1).copied().unwrap_or(1)]; 2]),
        "LayerNormalization" => {
            attributes.push(one("axis", pick(stream, &AXES)));
            weights.push(x[pick(stream, &[0, 1, 2]).min(rank)..].to_vec());
        }
        "Add" | "Div" | "Mul" | "Pow" | "Sub" | "Max" | "Min" | "PRelu" => {
            let kept = x[pick(stream, &[0, 0, 1, 2]).min(rank)..].iter();
            weights.push(kept.map(|&side| if stream.chance(0.3) { 1 } else { side }).collect());
        }
        "Clip" => weights.extend([vec![], vec![]]),
        _ => {}
    }
    Drawn { operator, attributes, weights, lists, outputs }
}

impl Drawn {
    /// The shapes that it makes of `x`.
    fn made(&self, x: &[usize]) -> Result<Vec<Vec<usize>>, GraphError> {
        let weights = self.weights.iter().map(|shape| weight(shape));
        let lists = self.lists.iter().map(|integers| list(integers));
        let operands: Vec<_> = [input(x)].into_iter().chain(weights).chain(lists).collect();
        made(OPSET, self.operator, self.attributes.clone(), &operands, self.outputs)
    }

    /// Adds it to a graph, as a function of the tensor `x`; its outputs bear the names of [`output`].
    fn add(&self, builder: &mut GraphBuilder, x: &str, place: usize) {
        let mut inputs = vec![x.to_owned()];
        for (index, shape) in self.weights.iter().enumerate() {
            let numbers: Vec<f32> = (0..volume(shape)).map(|i| 0.1 + i as f32 % 3.0).collect();
            inputs.push(builder.weight(&format!("weight{place}.{index}"), shape, &numbers));
        }
        for (index, list) in self.lists.iter().enumerate() {
            inputs.push(builder.integers(&format!("list{place}.{index}"), list));
        }
        let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
        let outputs: Vec<String> = (0..self.outputs).map(|index| output(place, index)).collect();
        let outputs: Vec<&str> = outputs.iter().map(String::as_str).collect();
        builder.node_with(self.operator, &inputs, &outputs, self.attributes.clone());
    }

    fn told(&self) -> String {
        let attribute = |a: &AttributeProto| match AttributeType::try_from(a.r#type) {
            Ok(AttributeType::Int) => format!("{}={}", a.name, a.i),
            Ok(AttributeType::Ints) => format!("{}={:?}", a.name, a.ints),
            _ => format!("{}={}", a.name, String::from_utf8_lossy(&a.s)),
        };
        let attributes: Vec<String> = self.attributes.iter().map(attribute).collect();
        format!("{}({}) {:?} {:?}", self.operator, attributes.join(" "), self.weights, self.lists)
    }
}

fn output(place: usize, index: usize) -> String {
    format!("out{place}.{index}")
}

/// Random chains of nodes that are let through, each node a function of the first output of the one before.
#[test]
fn what_is_let_through_is_taken_by_tract_with_the_same_shapes_and_nothing_panics() {
    let operators: Vec<&str> =
        OPERATORS.into_iter().filter(|operator| !["Constant", "Cast"].contains(operator)).collect();
    let (mut let_through, mut refused) = (0, Vec::new());
    for (first, round) in operators.iter().flat_map(|first| (0..ROUNDS).map(move |round| (*first, round))) {
        let mut stream = Seed(7).stream(first, round);
        let rank = pick(&mut stream, &[1, 2, 3, 4, 4, 4, 5]);
        let x = shape(&mut stream, rank);
        let (mut chain, mut made) = (Vec::new(), vec![x.clone()]);
        for place in 0..LONGEST {
            let operator = if place == 0 { first } else { pick(&mut stream, &operators) };
            let node = drawn(operator, &made[0], &mut stream);
            if let Ok(shapes) = node.made(&made[0]) {
                made = shapes;
                chain.push(node);
            }
        }
        let Some(last) = chain.len().checked_sub(1) else { continue };
        let_through += chain.len();
        let outputs = made.iter().enumerate().map(|(i, shape)| TensorSpec::new(&output(last, i), shape));
        let signature = Signature { inputs: vec![TensorSpec::new("x", &x)], outputs: outputs.collect() };
        let mut builder = GraphBuilder::new("chain", &signature);
        for (place, node) in chain.iter().enumerate() {
            let input = place.checked_sub(1).map_or("x".to_owned(), |before| output(before, 0));
            node.add(&mut builder, &input, place);
        }
        let numbers: Vec<f32> = (0..volume(&x)).map(|i| 0.2 + i as f32 % 5.0).collect();
        let ran = Graph::from_bytes(&builder.finish(), &signature).and_then(|graph| graph.run(&[&numbers]));
        match ran {
            Ok(_) | Err(GraphError::NonFiniteOutput { .. }) => {}
            Err(error) => {
                let told: Vec<String> = chain.iter().map(Drawn::told).collect();
                refused.push(format!("{x:?} -> {}: {error}", told.join(" -> ")));
            }
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
    assert!(let_through as u64 > 30 * ROUNDS, "{let_through} nodes were let through");
}
