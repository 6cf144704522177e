//! A checked ONNX graph, ready to run on one input at a time.

use super::Signature;
use super::check::checked_model;
use super::error::GraphError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tract_onnx::prelude::*;
use tract_onnx::tract_core::knobs;
use tract_onnx::tract_core::model::typed::TypedSimpleState;
use vantage_dataset::widest::widest;

/// Largest magnitude of an input. Far beyond all that a model is trained on; where sums overflow, tract's ReLU
/// turns NaN into 0, and a bad input would come out as a good output.
const LARGEST_INPUT: f32 = 1e6;

/// Numbers of the largest tensor within a graph: 64 MiB of `f32`.
const LARGEST_TENSOR: usize = 16 << 20;

/// Ways of computing that round otherwise, which the environment could ask tract for.
const OTHER_WAYS: [&str; 5] = [
    "TRACT_AMX_BF16",
    "TRACT_AVGPOOL_SEPARABLE",
    "TRACT_DISABLE_DEPTHWISE_DECONV",
    "TRACT_DISABLE_DIRECT_SPATIAL",
    "TRACT_ENABLE_BLOCKED_CONV",
];

/// A graph of fixed shapes, optimised by tract.
pub(crate) struct Graph {
    plan: Arc<TypedRunnableModel>,
    /// States of tract that wait for the next run; at most as many as ever ran at once.
    states: Mutex<Vec<TypedSimpleState>>,
    signature: Signature,
}

impl Graph {
    /// Checks and prepares a graph of the given signature.
    pub(crate) fn from_bytes(bytes: &[u8], signature: &Signature) -> Result<Self, GraphError> {
        let model = checked_model(bytes, signature)?;
        let refused = |reason: String| GraphError::Refused { reason };
        #[cfg(target_arch = "x86_64")]
        super::kernels::choose_kernels();
        for way in OTHER_WAYS {
            knobs::set_str(way, "false");
        }
        let typed = || tract_onnx::onnx().model_for_proto_model(&model)?.into_typed();
        let typed = contained(typed).map_err(refused)?;
        check_tensors(&typed)?;
        let plan = contained(|| typed.into_optimized()?.into_runnable()).map_err(refused)?;
        let graph = Self { plan, states: Mutex::default(), signature: signature.clone() };
        graph.check_shapes()?;
        Ok(graph)
    }

    /// What goes in and comes out.
    pub(crate) fn signature(&self) -> &Signature {
        &self.signature
    }

    /// Runs the graph: one slice an input, one vector an output, row-major; outputs are finite.
    pub(crate) fn run(&self, inputs: &[&[f32]]) -> Result<Vec<Vec<f32>>, GraphError> {
        self.read(inputs, |outputs| outputs.iter().map(|numbers| numbers.to_vec()).collect())
    }

    /// [`Graph::run`] without a copy of the outputs.
    pub(crate) fn read<T>(
        &self,
        inputs: &[&[f32]],
        read: impl FnOnce(&[&[f32]]) -> T,
    ) -> Result<T, GraphError> {
        let mut values = tvec!();
        for (spec, &data) in self.signature.inputs.iter().zip(inputs) {
            if !within(data, LARGEST_INPUT) {
                return Err(GraphError::InputRange { input: spec.name.clone() });
            }
            let tensor = Tensor::from_shape(&spec.shape, data).map_err(|_| GraphError::Input {
                input: spec.name.clone(),
                got: data.len(),
                expected: spec.volume(),
            })?;
            values.push(tensor.into_tvalue());
        }
        let kept = self.states().pop();
        let ran = contained(|| {
            let mut state = kept.map_or_else(|| self.plan.spawn(), Ok)?;
            Ok((state.run(values)?, state))
        });
        let (outputs, state) = ran.map_err(|reason| GraphError::Refused { reason })?;
        self.states().push(state);
        let mut results: TVec<&[f32]> = tvec!();
        for (spec, value) in self.signature.outputs.iter().zip(outputs.iter()) {
            let numbers = value.try_as_plain_ram().and_then(|plain| plain.as_slice::<f32>());
            let numbers = numbers.map_err(|error| GraphError::Refused { reason: error.to_string() })?;
            if !within(numbers, f32::MAX) {
                return Err(GraphError::NonFiniteOutput { output: spec.name.clone() });
            }
            results.push(numbers);
        }
        Ok(read(&results))
    }

    fn states(&self) -> MutexGuard<'_, Vec<TypedSimpleState>> {
        self.states.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The shapes tract infers must be the declared ones, which the check alone cannot know.
    fn check_shapes(&self) -> Result<(), GraphError> {
        for (index, spec) in self.signature.outputs.iter().enumerate() {
            let fact = self.plan.model().output_fact(index);
            let fact = fact.map_err(|error| GraphError::Refused { reason: error.to_string() })?;
            if fact.shape.as_concrete() != Some(&spec.shape) || fact.datum_type != f32::datum_type() {
                return Err(GraphError::Signature {
                    side: "computed outputs",
                    got: format!("{:?} {fact:?}", spec.name),
                    expected: format!("{:?} FLOAT {:?}", spec.name, spec.shape),
                });
            }
        }
        Ok(())
    }
}

/// Before anything is allocated that a node's attributes ask for.
fn check_tensors(model: &TypedModel) -> Result<(), GraphError> {
    for node in model.nodes() {
        for output in &node.outputs {
            let shape = output.fact.shape.as_concrete();
            let volume =
                shape.and_then(|dims| dims.iter().try_fold(1usize, |all, &dim| all.checked_mul(dim)));
            if volume.is_none_or(|volume| volume > LARGEST_TENSOR) {
                let (node, shape) = (node.name.clone(), format!("{:?}", output.fact.shape));
                return Err(GraphError::TensorSize { node, shape, limit: LARGEST_TENSOR });
            }
        }
    }
    Ok(())
}

/// Whether all magnitudes are at most `most`, and all are numbers.
fn within(numbers: &[f32], most: f32) -> bool {
    widest(
        #[inline(always)]
        || {
            numbers.iter().fold(
                true,
                #[inline(always)]
                |all, number| all & (number.abs() <= most),
            )
        },
    )
}

/// The last wall before a runtime that was written for models one trusts.
fn contained<T>(work: impl FnOnce() -> TractResult<T>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.map_err(|error| format!("{error:#}")),
        Err(_) => Err("it panicked".into()),
    }
}
