//! What a graph made of the last values of its first input, such as crops, kept for the next runs.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tract_onnx::prelude::*;
use tract_onnx::tract_core::internal::TractErrorContext;
use tract_onnx::tract_core::model::typed::TypedSimpleState;
use tract_onnx::tract_core::plan::eval;

/// Numbers that are kept of a run: of a graph that would have more kept, nothing is.
const MOST_NUMBERS: usize = 1 << 16;
/// As many numbers are counted for a tensor's own fields.
const OF_A_TENSOR: usize = 64;

/// What the graph made of the last values of its first input.
///
/// What depends on that input alone is not made again. Of what depends on others, too, a node that takes the same as before is not run again. Nodes
/// run as they did, so that results have the same bits; only an operator that goes by the strides of what it takes could round otherwise.
pub(super) struct Memory {
    /// How many values.
    most: usize,
    /// Nodes of the first input alone whose results are taken by the rest, or come out.
    boundary: Vec<usize>,
    /// Nodes that depend on other inputs, in the order of a run.
    rest: Vec<usize>,
    /// The last used last.
    kept: Mutex<VecDeque<Kept>>,
}

struct Kept {
    /// Of the first input.
    hash: blake3::Hash,
    /// By boundary nodes.
    made: Vec<TVec<TValue>>,
    /// By the rest's nodes.
    rest: Vec<Step>,
}

/// What a node took and made.
struct Step {
    taken: TVec<TValue>,
    made: TVec<TValue>,
}

impl Memory {
    /// Of a graph, for so many values of its first input; `None` where too much would be kept of each, or a node has a state of its own.
    pub(super) fn new(plan: &Arc<TypedRunnableModel>, most: usize) -> Option<Self> {
        let model = plan.model();
        let first = model.inputs.first()?.node;
        let is_stateful = plan.spawn().ok()?.op_states.iter().any(Option::is_some);
        let order = plan.order_without_consts();
        let mut depends = vec![false; model.nodes().len()];
        for &id in order {
            let is_other_input = id != first && model.inputs.iter().any(|input| input.node == id);
            depends[id] = is_other_input || model.node(id).inputs.iter().any(|input| depends[input.node]);
        }
        let is_taken = |id: usize| {
            let mut takers = model.node(id).outputs.iter().flat_map(|output| &output.successors);
            takers.any(|taker| depends[taker.node]) || model.outputs.iter().any(|output| output.node == id)
        };
        let (rest, alone): (Vec<usize>, Vec<usize>) = order.iter().partition(|id| depends[**id]);
        let boundary: Vec<usize> = alone.into_iter().filter(|id| is_taken(*id)).collect();
        let kept = boundary.iter().chain(&rest).flat_map(|id| &model.node(*id).outputs);
        let numbers = kept.map(|output| numbers(&output.fact).unwrap_or(usize::MAX));
        let is_little = numbers.fold(0, usize::saturating_add) <= MOST_NUMBERS;
        (is_little && !is_stateful).then(|| Self { most, boundary, rest, kept: Mutex::default() })
    }

    /// Runs the graph in a state of its plan.
    pub(super) fn run(
        &self,
        state: &mut TypedSimpleState,
        inputs: TVec<TValue>,
    ) -> TractResult<TVec<TValue>> {
        let hash = blake3::hash(inputs[0].as_bytes());
        let (outputs, kept) = match self.take(&hash) {
            Some(kept) => self.run_again(state, kept, inputs)?,
            None => self.run_anew(state, hash, inputs)?,
        };
        let mut all = self.kept();
        if all.len() >= self.most {
            all.pop_front();
        }
        all.push_back(kept);
        Ok(outputs)
    }

    /// Forgets all.
    pub(super) fn forget(&self) {
        self.kept().clear();
    }

    fn kept(&self) -> MutexGuard<'_, VecDeque<Kept>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, hash: &blake3::Hash) -> Option<Kept> {
        let mut kept = self.kept();
        let at = kept.iter().position(|kept| kept.hash == *hash)?;
        kept.remove(at)
    }

    fn run_anew(
        &self,
        state: &mut TypedSimpleState,
        hash: blake3::Hash,
        inputs: TVec<TValue>,
    ) -> TractResult<(TVec<TValue>, Kept)> {
        let (mut made_of_first, mut rest) = (Vec::new(), Vec::new());
        let outputs = state.run_plan_with_eval(inputs, |context, of_node, node, taken| {
            if self.rest.get(rest.len()) == Some(&node.id) {
                let made = eval(context, of_node, node, taken.clone())?;
                rest.push(Step { taken, made: made.clone() });
                return Ok(made);
            }
            let made = eval(context, of_node, node, taken)?;
            if self.boundary.get(made_of_first.len()) == Some(&node.id) {
                made_of_first.push(made.clone());
            }
            TractResult::Ok(made)
        })?;
        Ok((outputs, Kept { hash, made: made_of_first, rest }))
    }

    fn run_again(
        &self,
        state: &mut TypedSimpleState,
        mut kept: Kept,
        inputs: TVec<TValue>,
    ) -> TractResult<(TVec<TValue>, Kept)> {
        state.set_inputs(inputs)?;
        for (id, made) in self.boundary.iter().zip(&kept.made) {
            state.set_values(*id, made.clone())?;
        }
        for (id, step) in self.rest.iter().zip(&mut kept.rest) {
            let taken = state.prepare_inputs(*id)?;
            if are_same(&step.taken, &taken) {
                state.set_values(*id, step.made.clone())?;
                continue;
            }
            state.compute_one_with_inputs(*id, taken.clone())?;
            let made = state.turn_state.values[*id].clone().context("a node that ran has made something")?;
            *step = Step { taken, made };
        }
        let outputs = state.outputs()?;
        state.reset_turn()?;
        Ok((outputs, kept))
    }
}

/// As many as a tensor takes the memory of; `None` where its size is not known.
fn numbers(fact: &TypedFact) -> Option<usize> {
    let volume: usize = fact.shape.as_concrete()?.iter().product();
    // A packed matrix has but its batch in its shape.
    let packed = match fact.exotic_fact() {
        Some(packed) => usize::try_from(packed.mem_size().as_i64()?).ok()? / size_of::<f32>(),
        None => 0,
    };
    Some(OF_A_TENSOR.saturating_add(volume.saturating_mul(packed.saturating_add(1))))
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
        assert!(keeping.keeps() && !plain.keeps());
        let numbers = [[0.1f32, -0.7, 2.0], [0.3, 0.0, -1.0], [0.3, -0.0, -1.0], [1.5, 0.2, 0.9]];
        for (x, y) in [(0, 1), (0, 2), (1, 2), (0, 3), (2, 2), (1, 1), (3, 0), (0, 1), (2, 1), (0, 1)] {
            let inputs = [&numbers[x][..], &numbers[y]];
            let [got, expected] = [&keeping, &plain].map(|graph| graph.run(&inputs).unwrap());
            let bits = |outputs: &[Vec<f32>]| outputs[0].iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&got), bits(&expected), "{x} {y}");
        }
    }

    #[test]
    fn what_takes_the_same_is_not_made_again() {
        let (bytes, _) = graph();
        let plan = tract_onnx::onnx().model_for_read(&mut &*bytes).unwrap();
        let plan = plan.into_optimized().unwrap().into_runnable().unwrap();
        let memory = Memory::new(&plan, 2).unwrap();
        assert_eq!((memory.boundary.len(), memory.rest.len()), (1, 3), "twice; y, other and out");
        let mut state = plan.spawn().unwrap();
        let input = |number: f32| Tensor::from_shape(&SHAPE, &[number; 3]).unwrap().into_tvalue();
        let mut made = |x: f32, y: f32| {
            memory.run(&mut state, tvec![input(x), input(y)]).unwrap();
            let kept = memory.kept();
            let Kept { made, rest, .. } = kept.back().unwrap();
            let tensors = made.iter().chain(rest.iter().map(|step| &step.made));
            (kept.len(), tensors.map(|made| std::ptr::from_ref::<Tensor>(&made[0])).collect::<Vec<_>>())
        };
        let (one, first) = made(0.5, 1.0);
        assert_eq!((one, made(0.5, 1.0)), (1, (1, first.clone())));
        let (_, other) = made(0.5, 2.0);
        assert_eq!(first[0], other[0]);
        assert!(first[1..].iter().zip(&other[1..]).all(|(before, after)| before != after));
        let (two, of_another) = made(0.7, 2.0);
        assert!(two == 2 && of_another[0] != first[0]);
        assert_eq!(made(0.5, 2.0), (2, other));
        assert_eq!(made(0.9, 2.0).0, 2);
        let is_kept = |x: f32| memory.take(&blake3::hash(input(x).as_bytes())).is_some();
        assert!(!is_kept(0.7) && is_kept(0.5) && is_kept(0.9), "the oldest was given up");
    }

    #[test]
    fn a_graph_that_would_keep_much_keeps_nothing() {
        let side = 1 << 9;
        let spec = |name, shape: [usize; 2]| TensorSpec::new(name, &shape);
        let inputs = vec![spec("x", [side, 1]), spec("y", [side, 1])];
        let signature = Signature { inputs, outputs: vec![spec("out", [side, 1])] };
        let mut builder = GraphBuilder::new("outer", &signature);
        builder.node("Mul", &["x", "ones"], "wide");
        builder.weight("ones", &[1, side], &vec![1.0; side]);
        builder.node("MatMul", &["wide", "y"], "out");
        assert!(!Graph::from_bytes(&builder.finish(), &signature).unwrap().keeping(2).keeps());
    }

    #[test]
    fn runs_beside_each_other_have_the_same_bits() {
        let (bytes, signature) = graph();
        let plain = Graph::from_bytes(&bytes, &signature).unwrap();
        let keeping = Graph::from_bytes(&bytes, &signature).unwrap().keeping(3);
        let threads = 4;
        std::thread::scope(|scope| {
            for thread in 0..threads {
                let (plain, keeping) = (&plain, &keeping);
                scope.spawn(move || {
                    for turn in 0..200 {
                        let (x, y) = ([(turn + thread) as f32 % 5.0; 3], [turn as f32 % 7.0; 3]);
                        assert_eq!(keeping.run(&[&x, &y]).unwrap(), plain.run(&[&x, &y]).unwrap());
                    }
                });
            }
        });
    }
}
