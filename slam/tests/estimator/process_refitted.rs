//! A process per object that corrects the model, its size refitted on the run: it is taken where objects differ from what the model says of
//! them, each in its own way, and not where they do not.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings, nothing_to_learn_from};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Crop, Seed, Viewpoint};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, ViewpointDerivative,
};
use vantage_slam::{AzimuthDiscrepancy, Estimator, Learner, Lesson, ProcessRefitted, Semantic};

const SIGMA: f64 = 0.03;

fn model() -> TanhModel {
    TanhModel::new([8, 12, 32], SIGMA, f64::INFINITY, Seed(1))
}

/// `h(e, x) + sigma (b_1 cos a + b_2 sin a)` at the azimuth `a`; latents are `[e, b_1, b_2]`.
struct Corrected<'m> {
    model: &'m TanhModel,
    sigma: f64,
}

impl Corrected<'_> {
    fn correction(&self, latent: &DVector<f64>, [cos, sin]: [f64; 2]) -> DVector<f64> {
        let (d, m) = (self.model.latent_dim(), self.measurement_dim());
        (latent.rows(d, m) * cos + latent.rows(d + m, m) * sin) * self.sigma
    }
}

impl ObservationModel for Corrected<'_> {
    fn latent_dim(&self) -> usize {
        self.model.latent_dim() + 2 * self.measurement_dim()
    }

    fn noise(&self) -> &MeasurementNoise {
        self.model.noise()
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.model.measure(crop)
    }

    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        let LatentGaussian { mean, variance } = self.model.encode(crop, viewpoint)?;
        let dim = self.latent_dim();
        Ok(LatentGaussian {
            mean: mean.resize_vertically(dim, 0.0),
            variance: variance.resize_vertically(dim, 1.0),
        })
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        let own = latent.rows(0, self.model.latent_dim()).into_owned();
        let (sin, cos) = viewpoint.azimuth().sin_cos();
        Ok(self.model.predict(&own, viewpoint)? + self.correction(latent, [cos, sin]))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let own = latent.rows(0, self.model.latent_dim()).into_owned();
        let of_model = self.model.linearize(&own, viewpoint)?;
        let (sin, cos) = viewpoint.azimuth().sin_cos();
        let (d, m) = (own.len(), self.measurement_dim());
        let mut d_latent = DMatrix::zeros(m, self.latent_dim());
        d_latent.columns_mut(0, d).copy_from(&of_model.d_latent);
        for j in 0..m {
            d_latent[(j, d + j)] = self.sigma * cos;
            d_latent[(j, d + m + j)] = self.sigma * sin;
        }
        let by_azimuth = self.correction(latent, [-sin, cos]);
        let upright = DMatrix::zeros(m, 0);
        let of_correction = ViewpointDerivative::by_azimuth_and_upright(viewpoint, &by_azimuth, &upright);
        Ok(Linearization {
            mean: of_model.mean + self.correction(latent, [cos, sin]),
            d_latent,
            d_viewpoint: ViewpointDerivative::new(
                of_model.d_viewpoint.by_coordinates() + of_correction.by_coordinates(),
            ),
        })
    }
}

/// Every object `deviations` of the noise off in its own way.
fn world(model: &TanhModel, deviations: f64, seed: u64) -> World {
    let mut world = World::new(&WorldSpec::sparse_loop(), Some(model), Seed(seed));
    let process = Corrected { model, sigma: SIGMA * deviations };
    for detection in &mut world.observations.detections {
        let mut coefficients = Seed(seed).stream("correction", detection.track as u64);
        let latent = DVector::from_fn(process.latent_dim(), |_, _| coefficients.normal());
        let world_from_camera = world.world_from_robot[detection.step] * world.observations.robot_from_camera;
        let object_from_camera = world.world_from_object[detection.track].inv_mul(&world_from_camera);
        let viewpoint = Viewpoint::new(&object_from_camera, world.sizes[detection.track]).unwrap();
        let (sin, cos) = viewpoint.azimuth().sin_cos();
        let measured = model.measure(&detection.masked_crop).unwrap();
        detection.masked_crop = TanhModel::crop(&(measured + process.correction(&latent, [cos, sin])));
    }
    world
}

/// Runs `with` a learner whose processes have 1, 3 and 9 deviations of the noise.
fn refitted<T>(model: &TanhModel, with: impl FnOnce(&ProcessRefitted<'_>) -> T) -> T {
    let [small, middle, large] =
        [1.0, 3.0, 9.0].map(|deviations| Corrected { model, sigma: SIGMA * deviations });
    with(&ProcessRefitted::new(
        &matching_settings(&WorldSpec::sparse_loop()),
        model,
        [&small, &middle, &large],
    ))
}

/// Of a row of log-evidences, the first of the largest.
fn likeliest(odds: &[f64]) -> usize {
    (0..odds.len()).rev().max_by(|&a, &b| odds[a].total_cmp(&odds[b])).unwrap()
}

#[test]
fn the_process_of_the_right_size_is_the_most_probable() {
    let model = model();
    for (deviations, expected) in [(0.0, 0), (1.0, 1), (3.0, 2)] {
        let world = world(&model, deviations, 0);
        let learnt =
            refitted(&model, |learner| learner.learn(&world.observations, &Lesson::default()).unwrap());
        let odds = learnt.lesson.process;
        println!("{deviations} deviations: {odds:.1?}");
        assert_eq!(likeliest(&odds.size), expected, "{deviations}: {odds:?}");
        assert_eq!(likeliest(&odds.noise.spread), 0, "{deviations}: the noise is right: {odds:?}");
    }
}

#[test]
fn evidences_of_models_of_other_sizes_and_other_noise_have_one_constant() {
    let (model, spec) = (model(), WorldSpec::sparse_loop());
    let world = World::new(&spec, Some(&model), Seed(0));
    let idle = Corrected { model: &model, sigma: 0.0 };
    let twice = TanhModel::new([8, 12, 32], 2.0 * SIGMA, f64::INFINITY, Seed(1));
    let discrepancy = AzimuthDiscrepancy { sigma: 0.05, concentration: 4.0 };
    let mut settings = matching_settings(&spec);
    for azimuth_discrepancy in [None, Some(discrepancy)] {
        settings.semantics.azimuth_discrepancy = azimuth_discrepancy;
        let learner = ProcessRefitted::new(&settings, &model, [&idle, &twice, &twice]);
        let odds = learner.learn(&world.observations, &Lesson::default()).unwrap().lesson.process;
        println!("{odds:.4?}");
        assert!(odds.size[1].abs() < 1e-3, "latents that do nothing: {odds:?}");
        let by_spread = odds.noise.spread[2];
        assert!((odds.size[2] - by_spread).abs() < 1e-3 * by_spread.abs(), "twice the noise: {odds:?}");
    }
}

#[test]
fn what_each_object_has_of_its_own_is_found_on_the_run_and_costs_nothing_where_there_is_nothing() {
    let model = model();
    let settings = matching_settings(&WorldSpec::sparse_loop());
    let mut sums = [0.0; 2];
    for seed in 0..4 {
        let off = world(&model, 9.0, seed);
        let frozen = Semantic::new(&settings, &model);
        let estimate = refitted(&model, |learner| learner.estimate(&off.observations).unwrap());
        sums[0] += off.ate(&frozen.estimate(&off.observations).unwrap()) / 4.0;
        sums[1] += off.ate(&estimate) / 4.0;
        let known = estimate.objects.iter().flatten().filter_map(|object| object.latent.as_ref());
        known.for_each(|latent| assert_eq!(latent.mean.len(), model.latent_dim(), "of the model alone"));

        let right = world(&model, 0.0, seed);
        let estimate = refitted(&model, |learner| learner.estimate(&right.observations).unwrap());
        let frozen = frozen.estimate(&right.observations).unwrap();
        assert_eq!(
            estimate.world_from_robot, frozen.world_from_robot,
            "seed {seed}: nothing was there to correct"
        );
    }
    println!("frozen, refitted: {sums:.3?} m");
    assert!(sums[1] < 0.75 * sums[0], "{sums:?}");
}

#[test]
fn crops_of_later_drives_are_known_better_and_a_life_goes_on_from_what_was_stored() {
    let model = model();
    let worlds = [0, 1, 2].map(|seed| world(&model, 3.0, seed));
    refitted(&model, |learner| {
        let mut lesson = Lesson::default();
        let mut gains = Vec::new();
        for world in &worlds {
            let stored: Lesson = serde_json::from_str(&serde_json::to_string(&lesson).unwrap()).unwrap();
            assert_eq!(stored, lesson);
            let learnt = learner.learn(&world.observations, &stored).unwrap();
            gains.push(learnt.gain.unwrap());
            lesson = learnt.lesson;
        }
        println!("{gains:.2?} nat a crop");
        assert_eq!(gains[0], 0.0, "on a first drive nothing is known");
        assert!(gains[1] > 0.5 && gains[2] > 0.5, "{gains:?}");
    });
}

#[test]
fn where_there_is_nothing_to_learn_from_the_answer_is_finite() {
    let model = model();
    for (what, spec, garbage) in nothing_to_learn_from() {
        let mut world = World::new(&spec, Some(&model), Seed(2));
        for detection in world.observations.detections.iter_mut().filter(|_| garbage) {
            detection.masked_crop =
                TanhModel::crop(&(model.measure(&detection.masked_crop).unwrap() * -30.0));
        }
        let learnt =
            refitted(&model, |learner| learner.learn(&world.observations, &Lesson::default()).unwrap());
        println!("{what}: {}, {:.3} m", learnt.estimate.outcome, world.ate(&learnt.estimate));
        assert_eq!(learnt.estimate.world_from_robot.len(), world.observations.steps(), "{what}");
        assert!(world.ate(&learnt.estimate).is_finite(), "{what}");
        let odds = learnt.lesson.process;
        assert!(odds.size.iter().chain(&odds.noise.spread).all(|x| x.is_finite()), "{what}: {odds:?}");
    }
}

#[test]
fn wrong_associations_do_no_more_harm_than_to_the_model_alone() {
    let (model, spec) = (model(), WorldSpec::sparse_loop());
    let settings = matching_settings(&spec);
    for every in [10, 3] {
        let mut sums = [0.0; 2];
        for seed in 0..4 {
            let mut world = world(&model, 3.0, seed);
            for detection in world.observations.detections.iter_mut().step_by(every) {
                detection.track = (detection.track + 1) % spec.objects;
            }
            let frozen = Semantic::new(&settings, &model).estimate(&world.observations).unwrap();
            let own = refitted(&model, |learner| learner.estimate(&world.observations).unwrap());
            sums[0] += world.ate(&frozen) / 4.0;
            sums[1] += world.ate(&own) / 4.0;
        }
        println!("one association of {every} wrong: frozen and refitted {sums:.3?} m");
        assert!(sums[1] < 1.1 * sums[0], "{sums:?}");
    }
}
