//! What a run of a graph made, kept for the next.

use tract_onnx::prelude::*;
use tract_onnx::tract_core::model::typed::TypedSimpleState;
use tract_onnx::tract_core::plan::eval;

/// Numbers that are kept of a run: a graph that makes more keeps nothing.
const MOST_KEPT: usize = 1 << 18;

/// Of the last run what each node took and made: a node that takes the same again is not run again, and its results are the same to the bit.
#[derive(Default)]
pub(super) struct Memory {
    /// By the node's number.
    nodes: Vec<Option<Kept>>,
    /// Numbers that they made.
    numbers: usize,
}

struct Kept {
    taken: TVec<TValue>,
    made: TVec<TValue>,
}

impl Memory {
    /// Runs a graph, and keeps what it makes.
    pub(super) fn run(
        &mut self,
        state: &mut TypedSimpleState,
        inputs: TVec<TValue>,
    ) -> TractResult<TVec<TValue>> {
        state.run_plan_with_eval(inputs, |context, of_node, node, taken| {
            if of_node.is_some() || self.numbers > MOST_KEPT {
                return eval(context, of_node, node, taken);
            }
            if self.nodes.len() <= node.id {
                self.nodes.resize_with(node.id + 1, || None);
            }
            let kept = &mut self.nodes[node.id];
            if let Some(kept) = kept.as_ref().filter(|kept| are_same(&kept.taken, &taken)) {
                return Ok(kept.made.clone());
            }
            let made = eval(context, None, node, taken.clone())?;
            if kept.is_none() {
                self.numbers += made.iter().map(|value| value.len()).sum::<usize>();
            }
            *kept = Some(Kept { taken, made: made.clone() });
            if self.numbers > MOST_KEPT {
                self.nodes = Vec::new();
            }
            Ok(made)
        })
    }
}

fn are_same(some: &[TValue], others: &[TValue]) -> bool {
    some.len() == others.len() && some.iter().zip(others).all(|(one, other)| is_same(one, other))
}

/// Whether two are one tensor, or hold the same bits. Such as have other numbers than `f32` count as the same only where they are one.
fn is_same(one: &Tensor, other: &Tensor) -> bool {
    let is_real = |tensor: &Tensor| tensor.datum_type() == f32::datum_type() && tensor.is_plain_ram();
    std::ptr::eq(one, other)
        || is_real(one)
            && is_real(other)
            && one.shape() == other.shape()
            && one.as_bytes() == other.as_bytes()
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::super::build::GraphBuilder;
    use super::super::graph::Graph;
    use super::super::{Signature, TensorSpec};
    use super::*;

    const SHAPE: [usize; 2] = [1, 3];

    /// `tanh(tanh(x)) * tanh(y)`.
    fn graph() -> (Vec<u8>, Signature) {
        let spec = |name| TensorSpec::new(name, &SHAPE);
        let signature = Signature { inputs: vec![spec("x"), spec("y")], outputs: vec![spec("out")] };
        let mut builder = GraphBuilder::new("of_two", &signature);
        builder.node("Tanh", &["x"], "once");
        builder.node("Tanh", &["once"], "twice");
        builder.node("Tanh", &["y"], "other");
        builder.node("Mul", &["twice", "other"], "out");
        (builder.finish(), signature)
    }

    #[test]
    fn what_is_kept_changes_no_bit() {
        let (bytes, signature) = graph();
        let plain = Graph::from_bytes(&bytes, &signature).unwrap();
        let keeping = Graph::from_bytes(&bytes, &signature).unwrap().keeping(2);
        let numbers = [[0.1f32, -0.7, 2.0], [0.3, 0.0, -1.0], [0.3, -0.0, -1.0], [1.5, 0.2, 0.9]];
        for (x, y) in [(0, 1), (0, 2), (1, 2), (0, 3), (2, 2), (1, 1), (3, 0), (0, 1), (2, 1), (0, 1)] {
            let inputs = [&numbers[x][..], &numbers[y]];
            let [got, expected] = [&keeping, &plain].map(|graph| graph.run(&inputs).unwrap());
            let bits = |outputs: &[Vec<f32>]| outputs[0].iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&got), bits(&expected), "{x} {y}");
        }
    }

    #[test]
    fn a_node_that_takes_the_same_is_not_run_again() {
        let (bytes, _) = graph();
        let plan = tract_onnx::onnx().model_for_read(&mut &*bytes).unwrap();
        let plan = plan.into_optimized().unwrap().into_runnable().unwrap();
        let (mut state, mut memory) = (plan.spawn().unwrap(), Memory::default());
        let mut made = |x: f32, y: f32| {
            let input = |number| Tensor::from_shape(&SHAPE, &[number; 3]).unwrap().into_tvalue();
            memory.run(&mut state, tvec![input(x), input(y)]).unwrap();
            let kept = memory.nodes.iter().flatten();
            kept.map(|kept| std::ptr::from_ref::<Tensor>(&kept.made[0])).collect::<Vec<_>>()
        };
        let first = made(0.5, 1.0);
        let same = |later: &[*const Tensor]| first.iter().zip(later).filter(|(a, b)| a == b).count();
        assert!(first.len() >= 5, "{} nodes", first.len());
        assert_eq!(same(&made(0.5, 1.0)), first.len());
        let other = same(&made(0.5, 2.0));
        assert!((2..first.len()).contains(&other), "{other} of {}", first.len());
    }
}
