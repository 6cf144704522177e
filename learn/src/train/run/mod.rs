//! One training: its folder, what it tells, and the descent that both stages share.

pub(crate) mod adam;
pub(crate) mod checkpoint;
pub(crate) mod curve;
pub(crate) mod device;
pub(crate) mod files;
pub(crate) mod origin;
pub(crate) mod progress;

use crate::architecture::Architecture;
use crate::spec::TrainingSpec;
use crate::train::error::TrainError;
use crate::train::network::rows::numbers;
use adam::Adam;
use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::GradientsParams;
use burn::tensor::Tensor;
use checkpoint::{Checkpoint, State};
use curve::{Curve, Loss};
use device::TrainingDevice;
use progress::{Progress, Stage};
use std::ops::ControlFlow;
use std::path::Path;
use vantage_dataset::Seed;

/// What all parts of a training share.
pub(crate) struct Run<'a> {
    pub(crate) spec: &'a TrainingSpec,
    pub(crate) architecture: Architecture,
    pub(crate) seed: Seed,
    pub(crate) folder: &'a Path,
    /// Hash of everything that decides what the training does.
    pub(crate) key: String,
    pub(crate) curve: Curve,
    pub(crate) device: TrainingDevice,
    pub(crate) progress: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
}

/// The loss of a step, its terms, and where it descends to.
pub(crate) struct Step<const N: usize> {
    pub(crate) loss: f64,
    pub(crate) terms: [f64; N],
    pub(crate) gradients: GradientsParams,
}

/// A module as far as a checkpoint brought it.
pub(crate) struct Started<M> {
    pub(crate) module: M,
    pub(crate) optimizer: Adam,
    pub(crate) done: usize,
}

impl<M: Module> Started<M> {
    /// At the first step.
    pub(crate) fn fresh(module: M) -> Self {
        Self { module, optimizer: Adam::default(), done: 0 }
    }

    /// After the steps of a checkpoint.
    pub(crate) fn resumed(module: M, bytes: &[u8], checkpoint: &Checkpoint) -> Result<Self, String> {
        Ok(Self {
            module: checkpoint::module_from(module, bytes)?,
            optimizer: Adam::from_bytes(&checkpoint.optimizer).ok_or("its optimiser is cut short")?,
            done: checkpoint.state.step,
        })
    }
}

impl Run<'_> {
    /// Tells what happened.
    ///
    /// Only [`Run::descend`] heeds the wish to stop; the other stages are over in seconds.
    pub(crate) fn tell(&mut self, progress: &Progress) -> ControlFlow<()> {
        (self.progress)(progress)
    }

    /// Makes the remaining steps of a stage, with a checkpoint now and then; the module is on the CPU afterwards.
    ///
    /// `step` gives the loss of a module at a step, from nothing but the step's index; `parts` gives the
    /// checkpoint's trunk and autoencoder.
    pub(crate) fn descend<M: Module, const N: usize>(
        &mut self,
        stage: Stage,
        steps: usize,
        started: Started<M>,
        step: impl Fn(&M, usize) -> Step<N>,
        parts: impl Fn(&M) -> Result<[Vec<u8>; 2], String>,
    ) -> Result<M, TrainError> {
        let Started { mut module, mut optimizer, done } = started;
        let every = self.spec.checkpoint_every as usize;
        for index in done..steps {
            let Step { loss, terms, gradients } = step(&module, index);
            let reached = index + 1;
            self.keep(stage, reached, loss, terms)?;
            module = optimizer.step(self.learning_rate(index, steps), module, gradients);
            if reached.is_multiple_of(every) || reached == steps {
                let unwritable = |error: String| files::unwritable(self.folder, &error);
                let [trunk, autoencoder] = parts(&module).map_err(unwritable)?;
                let optimizer = optimizer.to_bytes();
                let state = State { key: self.key.clone(), stage, step: reached, curve: self.curve.clone() };
                Checkpoint { state, trunk, autoencoder, optimizer }.write(self.folder)?;
                self.curve.write_table(self.folder)?;
            }
            let step = Progress::Step { stage, step: reached, steps, loss };
            if self.tell(&step).is_break() {
                return Err(TrainError::Stopped { stage, step: reached });
            }
        }
        // No step has seen what the last one made of the weights, and a ReLU may hide from a loss that they are no numbers.
        let Step { loss, terms, .. } = step(&module, steps);
        let loss = if Finite::of(&module) { loss } else { f64::NAN };
        if !loss.is_finite() {
            self.keep(stage, steps + 1, loss, terms)?;
        }
        Ok(self.device.to_cpu(module))
    }

    /// Adds a loss to the curve; one that is not finite ends the training.
    fn keep<const N: usize>(
        &mut self,
        stage: Stage,
        step: usize,
        loss: f64,
        terms: [f64; N],
    ) -> Result<(), TrainError> {
        let terms = std::array::from_fn(|term| terms.get(term).copied().unwrap_or(0.0));
        self.curve.0.push(Loss { stage, step, total: loss, terms });
        if loss.is_finite() {
            return Ok(());
        }
        let log = self.curve.write_table(self.folder)?;
        Err(TrainError::NonFiniteLoss { stage, step, loss, log })
    }

    /// A linear warm-up, then a cosine down to a hundredth.
    fn learning_rate(&self, index: usize, steps: usize) -> f64 {
        let warm_up = (steps / 10).clamp(1, 200) as f64;
        let done = index as f64 / steps as f64;
        let cosine = 0.5 * (1.0 + libm::cos(std::f64::consts::PI * done));
        self.spec.learning_rate * ((index + 1) as f64 / warm_up).min(1.0) * (0.99 * cosine + 0.01)
    }
}

/// The number in a tensor of one.
pub(crate) fn scalar(tensor: &Tensor<1>) -> f64 {
    f64::from(tensor.clone().into_scalar::<f32>())
}

/// Whether all weights are finite.
struct Finite(bool);

impl Finite {
    fn of<M: Module>(module: &M) -> bool {
        let mut finite = Self(true);
        module.visit(&mut finite);
        finite.0
    }
}

impl ModuleVisitor for Finite {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.0 &= numbers(param.val()).iter().all(|number| number.is_finite());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::nn::{Linear, LinearConfig};
    use checkpoint::module_bytes;

    /// A stage of three steps whose loss is `w^2`, but at step `broken` its root at 0, which has no derivative.
    fn descended(broken: usize) -> Result<Linear, TrainError> {
        let folder = tempfile::tempdir().unwrap();
        let spec = TrainingSpec::default();
        let device = TrainingDevice::default();
        let layer = LinearConfig::new(1, 1).with_bias(false).init(&device.tensors());
        let mut run = Run {
            spec: &spec,
            architecture: Architecture::new(&spec).unwrap(),
            seed: Seed(0),
            folder: folder.path(),
            key: String::new(),
            curve: Curve::default(),
            device,
            progress: &mut |_| ControlFlow::Continue(()),
        };
        let step = |layer: &Linear, index: usize| {
            let square = layer.weight.val().square().sum();
            let loss = if index + 1 == broken { (square * 0.0).sqrt() } else { square };
            let gradients = GradientsParams::from_grads(loss.backward(), layer);
            Step { loss: scalar(&loss), terms: [scalar(&loss)], gradients }
        };
        let parts = |layer: &Linear| Ok([module_bytes(layer)?, Vec::new()]);
        run.descend(Stage::Trunk, 3, Started::fresh(layer), step, parts)
    }

    #[test]
    fn weights_that_are_no_numbers_are_found() {
        let device = TrainingDevice::default().tensors();
        let mut layer: Linear = LinearConfig::new(2, 1).init(&device);
        assert!(Finite::of(&layer));
        for broken in [f32::NAN, f32::INFINITY] {
            layer.weight = Param::from_data([[0.5], [broken]], &device);
            assert!(!Finite::of(&layer), "{broken}");
        }
    }

    #[test]
    fn weights_that_no_step_can_go_on_from_end_the_training_at_the_last_step_too() {
        descended(0).unwrap();
        for broken in [1, 2, 3] {
            let error = descended(broken).unwrap_err();
            assert!(
                matches!(error, TrainError::NonFiniteLoss { step, .. } if step == broken + 1),
                "{broken}: {error}"
            );
        }
    }
}
