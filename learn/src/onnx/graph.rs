//! A checked ONNX graph, ready to run on one input at a time.

use super::check::checked_model;
use super::contained::{contained, contained_in_silence};
use super::error::GraphError;
use super::memory::Memory;
use super::{Signature, TensorSpec};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tract_onnx::prelude::*;
use tract_onnx::tract_core::knobs;
use tract_onnx::tract_core::model::typed::TypedSimpleState;
use vantage_dataset::widest::widest;

/// Largest magnitude of an input. Far beyond all that a model is trained on; where sums overflow, tract's ReLU
/// turns NaN into 0, and a bad input would come out as a good output.
const LARGEST_INPUT: f32 = 1e6;

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
    memory: Option<Memory>,
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
        let zeros = || {
            let zeros = |spec: &TensorSpec| Ok(Tensor::zero::<f32>(&spec.shape)?.into_tvalue());
            signature.inputs.iter().map(zeros).collect::<TractResult<TVec<_>>>()
        };
        let prepared = contained_in_silence(|| {
            let plan = tract_onnx::onnx()
                .with_ignore_value_info(true)
                .model_for_proto_model(&model)?
                .into_optimized()?
                .into_runnable()?;
            // What cannot run shows here, whatever the numbers that it makes of zeros.
            let mut state = plan.spawn()?;
            state.run(zeros()?)?;
            Ok((plan, state))
        });
        let (plan, state) = prepared.map_err(refused)?;
        let states = Mutex::new(vec![state]);
        let graph = Self { plan, states, memory: None, signature: signature.clone() };
        graph.check_shapes()?;
        Ok(graph)
    }

    /// The same graph, which keeps what it makes of the last values of its first input, so many.
    pub(crate) fn keeping(self, most: usize) -> Self {
        Self { memory: Memory::new(&self.plan, most), ..self }
    }

    /// Whether it keeps anything.
    #[cfg(test)]
    pub(crate) fn keeps(&self) -> bool {
        self.memory.is_some()
    }

    /// Forgets what it keeps.
    pub(crate) fn forget(&self) {
        self.memory.iter().for_each(Memory::forget);
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
            let outputs = match &self.memory {
                Some(memory) => memory.run(&mut state, values)?,
                None => state.run(values)?,
            };
            Ok((outputs, state))
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
