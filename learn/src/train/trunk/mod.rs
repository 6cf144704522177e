//! Stage 1: the trunk learns features that tell what the objective needs, in IV-C's words "sensitive to viewpoint changes".

mod burn_convolution;
mod changes;
mod convolution;
pub(crate) mod info_nce;
pub(crate) mod network;
pub(crate) mod store;

use crate::architecture::{Architecture, UPRIGHT};
use crate::spec::{Task, TrainingSpec};
use crate::train::data::augmentation;
use crate::train::data::components::Components;
use crate::train::data::views::Views;
use crate::train::network::exponential::log_softmax;
use crate::train::network::rows::{numbers, table};
use crate::train::run::{Step, scalar};
use burn::optim::GradientsParams;
use burn::tensor::{Device, Tensor, TensorData};
use info_nce::Row;
use nalgebra::{Matrix3, Vector3};
use network::TrunkWithHead;
use std::f64::consts::PI;
use vantage_dataset::{Crop, Seed, Stream};

/// Angles that the head tells apart.
pub(crate) const BINS: usize = 48;
/// Concentration of an angle's soft label: about 13 degrees wide.
const CONCENTRATION: f64 = 20.0;
/// Weight of the squared error of what is not an angle.
const REST_WEIGHT: f64 = 2.0;
/// Views of a session that are compared with each other, in a step.
const TOGETHER: usize = 8;
/// The same where instances are told apart, too: fewer views of more instances.
const TOGETHER_OF_MORE: usize = 4;
/// Hidden numbers of a head that compares two views.
const COMPARED: usize = 128;
/// Size of the embedding by which the trunk tells instances apart.
const EMBEDDING: usize = 64;

impl Task {
    /// Numbers into and out of the head's layers.
    pub(crate) fn head(self, architecture: &Architecture) -> Vec<usize> {
        let m = architecture.measurement;
        match self {
            Task::Viewpoint => vec![m, BINS + UPRIGHT],
            Task::Change => vec![m, changes::LAYOUT.dimension()],
            Task::Motion => vec![2 * m, COMPARED, BINS + 9],
            Task::Image => vec![m, architecture.components],
            Task::Instance => vec![m, m],
        }
    }

    /// Whether crops come in pairs: the second half of a batch belongs to the first.
    fn paired(self) -> bool {
        matches!(self, Task::Motion | Task::Instance)
    }
}

/// Size of the embedding by which instances are told apart beside the task, if they are.
pub(crate) fn embedding_size(spec: &TrainingSpec) -> Option<usize> {
    (spec.trunk_instance_weight > 0.0).then_some(EMBEDDING)
}

/// What stage 1 descends over.
pub(crate) struct TrunkData<'a> {
    pub(crate) task: Task,
    pub(crate) views: &'a Views<'a>,
    /// Where the task is [`Task::Image`].
    pub(crate) components: Option<&'a Components>,
    pub(crate) spec: &'a TrainingSpec,
    pub(crate) seed: Seed,
    pub(crate) device: &'a Device,
    /// Whether burn's convolutions are the faster ones.
    pub(crate) on_gpu: bool,
}

/// The loss of the random batch of a step: cross-entropy of the angle over bins, which can be told apart or not (those of
/// symmetric objects cannot), and the squared error of the rest; or the task's own. Beside it, where the spec gives it a weight, the
/// InfoNCE loss of the embeddings.
pub(crate) fn step(network: &TrunkWithHead, data: &TrunkData, index: usize) -> Step<3> {
    let TrunkData { task, views, spec, seed, device, .. } = *data;
    let mut stream = seed.stream("trunk batch", index as u64);
    let batch = draw(task, views, spec, &mut stream);
    let mut crops = views.crops(batch.iter().copied());
    let altered: Vec<Crop>;
    if spec.trunk_augmentation > 0.0 {
        altered = crops
            .iter()
            .map(|crop| augmentation::altered(crop, spec.trunk_augmentation, &mut stream))
            .collect();
        crops = altered.iter().collect();
    }
    if data.on_gpu {
        let convolved = burn_convolution::convolved(&network.trunk, &crops, device);
        let (total, terms) = data.loss(network, network.trunk.features(convolved), &batch);
        let loss = scalar(&total);
        return Step { loss, terms, gradients: GradientsParams::from_grads(total.backward(), network) };
    }
    let convolutions = network.trunk.convolutions();
    let pass = convolutions.pass(&crops);
    let convolved = table(pass.outputs(), batch.len(), device).require_grad();
    let features = network.trunk.features(convolved.clone());
    let (total, terms) = data.loss(network, features, &batch);
    let tape = total.backward();
    let d_convolved = numbers(convolved.grad(&tape).expect("the loss depends on the convolutions"));
    let mut gradients = GradientsParams::from_grads(tape, network);
    network.trunk.register(
        convolutions.backward(pass, &d_convolved),
        &mut gradients,
        &device.clone().inner(),
    );
    Step { loss: scalar(&total), terms, gradients }
}

/// Views of a batch: those of a session one after the other, of two sessions at least where embeddings are learned beside the task; or, where
/// crops come in pairs, first views and then their partners, each of the group of its first, and of different groups beside
/// embeddings.
fn draw(task: Task, views: &Views, spec: &TrainingSpec, stream: &mut Stream) -> Vec<usize> {
    let count = spec.trunk_batch as usize;
    if task == Task::Change {
        let together = together(spec);
        let least = if spec.trunk_instance_weight > 0.0 { 2 } else { 1 };
        let session = |_| views.some(together, stream);
        return (0..(count / together).max(least)).flat_map(session).collect();
    }
    if spec.trunk_instance_weight > 0.0 {
        return views.pairs_of_different_groups((count / 2).max(2), stream);
    }
    if !task.paired() {
        return (0..count).map(|_| views.usable[stream.below(views.usable.len())]).collect();
    }
    views.pairs((count / 2).max(1), stream)
}

fn together(spec: &TrainingSpec) -> usize {
    if spec.trunk_instance_weight > 0.0 { TOGETHER_OF_MORE } else { TOGETHER }
}

impl TrunkData<'_> {
    /// The weighted loss, and its terms as [`crate::train::run::curve`] names them.
    fn loss(&self, network: &TrunkWithHead, features: Tensor<2>, batch: &[usize]) -> (Tensor<1>, [f64; 3]) {
        let (total, mut terms) = self.of_task(network, network.measure(features.clone()), batch);
        let Some(embedded) = network.embed(features) else { return (total, terms) };
        let row = |&view: &usize| Row { view, instance: self.views.set.views[view].instance };
        let rows: Vec<Row> = batch.iter().map(row).collect();
        let apart = info_nce::loss(embedded, &rows, self.device);
        terms[2] = scalar(&apart);
        (total + apart * self.spec.trunk_instance_weight, terms)
    }

    /// The task's own loss and its terms.
    fn of_task(&self, network: &TrunkWithHead, m: Tensor<2>, batch: &[usize]) -> (Tensor<1>, [f64; 3]) {
        let (views, half) = (self.views, batch.len() / 2);
        let pairs = || batch[..half].iter().zip(&batch[half..]);
        let uprights = || batch.iter().flat_map(|&view| views.upright(view)).collect();
        let beyond_bins = |answer: &Tensor<2>| {
            let rest = answer.dims()[1] - BINS;
            answer.clone().narrow(1, BINS, rest)
        };
        let (angle, rest, wanted): (Tensor<1>, Tensor<2>, Vec<f32>) = match self.task {
            Task::Viewpoint => {
                let answer = network.answer(m);
                let angles = batch.iter().map(|&view| views.azimuth(view));
                (of_bins(&answer, angles, self.device), beyond_bins(&answer), uprights())
            }
            Task::Change => {
                let answer = network.answer(m);
                let upright = answer.clone().narrow(1, 0, UPRIGHT);
                let azimuths = batch.iter().map(|&view| views.azimuth(view));
                let together = together(self.spec);
                (changes::loss(answer, azimuths, batch, together, self.device), upright, uprights())
            }
            Task::Motion => {
                let both = vec![m.clone().narrow(0, 0, half), m.narrow(0, half, half)];
                let answer = network.answer(Tensor::cat(both, 1));
                let motions: Vec<[f32; 9]> = pairs().map(|(&from, &to)| views.motion(from, to)).collect();
                let angle = of_bins(&answer, motions.iter().map(turn_to_the_left), self.device);
                (angle, beyond_bins(&answer), motions.into_iter().flatten().collect())
            }
            Task::Image => {
                let components = self.components.expect("a trunk that rebuilds crops has a basis");
                let crops = batch.iter().map(|&view| &views.set.views[view].crop);
                let wanted = table(components.coefficients(crops), batch.len(), self.device);
                let loss = (network.answer(m) - wanted).square().mean();
                let value = scalar(&loss);
                return (loss, [value, 0.0, 0.0]);
            }
            Task::Instance => {
                let embedded = network.answer(m);
                let loss = info_nce::loss_of_pairs(embedded, self.device);
                let value = scalar(&loss);
                return (loss, [0.0, 0.0, value]);
            }
        };
        let wanted = table(wanted, rest.dims()[0], self.device);
        let rest = (rest - wanted).square().mean();
        let terms = [scalar(&angle), scalar(&rest), 0.0];
        (angle + rest * REST_WEIGHT, terms)
    }
}

/// The turn about the camera's upward axis (y points down) of a motion as [`Views::motion`] gives it, radians.
fn turn_to_the_left(motion: &[f32; 9]) -> f64 {
    let column = |at: usize| Vector3::from_fn(|row, _| f64::from(motion[3 * at + row]));
    let rotation = Matrix3::from_columns(&[column(0), column(1), column(0).cross(&column(1))]);
    libm::atan2(-rotation[(0, 2)], rotation[(2, 2)])
}

/// Cross-entropy of angles over bins, which an answer begins with.
fn of_bins(answer: &Tensor<2>, angles: impl ExactSizeIterator<Item = f64>, device: &Device) -> Tensor<1> {
    let labels = soft_labels(angles, device);
    (log_softmax(answer.clone().narrow(1, 0, BINS)) * labels).sum_dim(1).mean().neg()
}

/// A von Mises bump around each true angle, over bins of which the first begins at angle 0.
pub(crate) fn soft_labels(angles: impl ExactSizeIterator<Item = f64>, device: &Device) -> Tensor<2> {
    let rows = angles.len();
    let mut labels = Vec::with_capacity(rows * BINS);
    for angle in angles {
        let center = |bin: usize| (bin as f64 + 0.5) * 2.0 * PI / BINS as f64;
        let bump = |bin| libm::exp(CONCENTRATION * (libm::cos(angle - center(bin)) - 1.0));
        let bumps: [f64; BINS] = std::array::from_fn(bump);
        let total: f64 = bumps.iter().sum();
        labels.extend(bumps.map(|bump| (bump / total) as f32));
    }
    Tensor::from_data(TensorData::new(labels, [rows, BINS]), device)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::synthetic;
    use vantage_dataset::Split;

    #[test]
    fn changes_are_learned_from_fewer_views_of_more_sessions_where_instances_are_told_apart() {
        let set = synthetic::views(Split::Train, 12, 8, 1);
        for (weight, batch, together, sessions) in
            [(0.0, 128, 8, 16), (0.0, 4, 8, 1), (0.5, 128, 4, 32), (0.5, 4, 4, 2)]
        {
            let spec =
                TrainingSpec { trunk_instance_weight: weight, trunk_batch: batch, ..TrainingSpec::default() };
            let views = Views::new(&set, Split::Train, 2, &spec, Seed(0), false).unwrap();
            let rows = draw(Task::Change, &views, &spec, &mut Seed(1).stream("batch", 0));
            assert_eq!(rows.len(), together * sessions);
            let mut instances = Vec::new();
            for session in rows.chunks_exact(together) {
                let mut different = session.to_vec();
                different.sort_unstable();
                different.dedup();
                assert_eq!(different.len(), together);
                instances.push(set.views[session[0]].instance);
                assert!(
                    session.iter().all(|&view| set.views[view].instance == instances[instances.len() - 1])
                );
            }
            instances.dedup();
            assert!(sessions <= 2 || instances.len() > sessions / 2);
        }
    }
}
