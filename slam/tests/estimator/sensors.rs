//! Estimators without a latent: azimuths as a plain sensor, and discrete classes.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Seed, Viewpoint};
use vantage_model::{
    AnswerError, AzimuthReading, AzimuthSensor, ClassModel, MeasurementNoise, ViewpointDerivative,
};
use vantage_slam::{AzimuthHead, DiscreteClass, Estimator, Outcome};

/// Reads azimuth and sigma off the crop's bytes.
struct Told;

impl AzimuthSensor for Told {
    fn read(&self, crop: &Crop) -> Result<AzimuthReading, AnswerError> {
        let numbers = numbers(crop, 2);
        Ok(AzimuthReading { azimuth: numbers[0], sigma: numbers[1] })
    }

    fn degrees_of_freedom(&self) -> f64 {
        5.0
    }
}

/// Linear in the viewpoint's conditioning, by class.
pub struct LinearClasses {
    coefficients: Vec<DMatrix<f64>>,
    noise: Vec<MeasurementNoise>,
}

impl LinearClasses {
    pub fn new(classes: usize, dimension: usize, sigma: f64, seed: Seed) -> Self {
        let mut stream = seed.stream("classes", 0);
        let mut of_class = |_| {
            DMatrix::from_fn(dimension, 1 + CONDITIONING, |_, j| stream.normal() / (1.0 + j as f64 / 4.0))
        };
        let coefficients = (0..classes).map(&mut of_class).collect();
        // Classes differ in their noise: scale and degrees of freedom have to count.
        let noise = (0..classes).map(|class| {
            let sigma = sigma * (1.0 + class as f64 / 2.0);
            let degrees_of_freedom = 3.0 * 4.0f64.powi(class as i32);
            MeasurementNoise::new(DMatrix::identity(dimension, dimension) / sigma, degrees_of_freedom)
                .unwrap()
        });
        Self { coefficients, noise: noise.collect() }
    }

    /// The same, all classes looking like the first.
    pub fn alike(self) -> Self {
        let coefficients = vec![self.coefficients[0].clone(); self.coefficients.len()];
        Self { coefficients, ..self }
    }
}

impl ClassModel for LinearClasses {
    fn classes(&self) -> usize {
        self.noise.len()
    }

    fn noise(&self, class: usize) -> &MeasurementNoise {
        &self.noise[class]
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        Ok(numbers(crop, self.coefficients[0].nrows()))
    }

    fn linearize(&self, class: usize, viewpoint: &Viewpoint) -> (DVector<f64>, ViewpointDerivative) {
        let by_coordinates = self.coefficients[class].columns(1, CONDITIONING).into_owned();
        let x = DVector::from_column_slice(&viewpoint.conditioning());
        (self.coefficients[class].column(0) + &by_coordinates * x, ViewpointDerivative::new(by_coordinates))
    }
}

fn numbers(crop: &Crop, count: usize) -> DVector<f64> {
    let numbers = crop.0.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap()));
    DVector::from_iterator(count, numbers.take(count))
}

/// Every crop becomes what `look` makes of the index of its detection, its track and its true viewpoint.
pub fn show(world: &mut World, mut look: impl FnMut(usize, usize, &Viewpoint) -> DVector<f64>) {
    for (index, detection) in world.observations.detections.iter_mut().enumerate() {
        let world_from_camera = world.world_from_robot[detection.step] * world.observations.robot_from_camera;
        let object_from_camera = world.world_from_object[detection.track].inv_mul(&world_from_camera);
        let viewpoint = Viewpoint::new(&object_from_camera, world.sizes[detection.track]).unwrap();
        detection.masked_crop = TanhModel::crop(&look(index, detection.track, &viewpoint));
    }
}

/// A world whose crops tell azimuths with errors of `sigma`; every `wrong`-th is off by half a turn.
fn told_azimuths(spec: &WorldSpec, seed: Seed, sigma: f64, wrong: usize) -> World {
    let mut world = World::new(spec, None, seed);
    let mut noise = seed.stream("azimuths", 0);
    show(&mut world, |index, _, viewpoint| {
        let off = if index % wrong == wrong - 1 { PI } else { 0.0 };
        let azimuth = viewpoint.azimuth() + off + sigma * noise.normal();
        DVector::from_vec(vec![azimuth, sigma.max(1e-3)])
    });
    world
}

#[test]
fn exact_azimuths_tell_every_yaw() {
    let spec = WorldSpec::sparse_loop().noiseless();
    let world = told_azimuths(&spec, Seed(3), 0.0, usize::MAX);
    let answer = AzimuthHead::new(&matching_settings(&spec), Told).estimate(&world.observations).unwrap();
    assert_eq!(answer.outcome, Outcome::Converged);
    assert!(world.ate(&answer) < 1e-4, "{}", world.ate(&answer));
    let errors = world.orientation_errors(&answer);
    assert_eq!(errors.len(), spec.objects);
    assert!(errors.iter().all(|e| *e < 1e-3), "{errors:?}");
    assert!(
        answer.objects.iter().flatten().all(|object| object.latent.is_none() && object.classes.is_none())
    );
}

#[test]
fn azimuths_lower_ate_against_geometric_though_one_in_nine_is_wrong() {
    let spec = WorldSpec { objects: 3, inward: true, ..WorldSpec::sparse_loop() };
    let settings = matching_settings(&spec);
    let (mut geometric, mut sensed, mut turned) = (0.0, 0.0, Vec::new());
    for seed in 0..20 {
        let world = told_azimuths(&spec, Seed(seed), 0.02, 9);
        let answer = AzimuthHead::new(&settings, Told).estimate(&world.observations).unwrap();
        geometric +=
            world.ate(&estimate(&world.observations, Which::Geometric, None, &settings).unwrap()) / 20.0;
        sensed += world.ate(&answer) / 20.0;
        turned.extend(world.orientation_errors(&answer));
    }
    turned.sort_by(f64::total_cmp);
    let median = turned[turned.len() / 2].to_degrees();
    println!(
        "mean ATE: geometric {geometric:.4}, azimuth head {sensed:.4}; orientation median {median:.2} deg"
    );
    assert!(sensed < 0.95 * geometric && median < 5.0);
}

#[test]
fn without_usable_crops_they_equal_geometric() {
    let spec = WorldSpec::sparse_loop();
    let settings = matching_settings(&spec);
    let classes = LinearClasses::new(3, 6, 0.05, Seed(1));
    let mut world = World::new(&spec, None, Seed(8));
    show(&mut world, |_, _, _| DVector::from_element(6, f64::NAN));
    let geometric = estimate(&world.observations, Which::Geometric, None, &settings).unwrap();
    let others: [Box<dyn Estimator>; 2] =
        [Box::new(AzimuthHead::new(&settings, Told)), Box::new(DiscreteClass::new(&settings, classes))];
    for estimator in &others {
        let answer = estimator.estimate(&world.observations).unwrap();
        assert_eq!(answer.world_from_robot, geometric.world_from_robot);
        assert!(answer.dropped_detections.non_finite > 0);
        assert!(answer.objects.iter().flatten().all(|object| object.orientation.is_none()));
    }
    world.observations.detections.clear();
    for estimator in &others {
        assert_eq!(estimator.estimate(&world.observations).unwrap().outcome, Outcome::NothingObserved);
    }
    world.observations.odometry.clear();
    world.observations.timestamps.clear();
    for estimator in &others {
        assert_eq!(estimator.estimate(&world.observations).unwrap().outcome, Outcome::NothingObserved);
    }
}

#[test]
fn classes_and_yaws_are_found_together() {
    let spec = WorldSpec::sparse_loop();
    let settings = matching_settings(&spec);
    let (mut geometric, mut semantic, mut right, mut all) = (0.0, 0.0, 0, 0);
    for seed in 0..10 {
        let classes = LinearClasses::new(4, 6, 0.1, Seed(1));
        let mut world = World::new(&spec, None, Seed(seed));
        let mut noise = Seed(seed).stream("looks", 0);
        show(&mut world, |_, track, viewpoint| {
            let class = track % 4;
            let sigma = 0.1 * (1.0 + class as f64 / 2.0);
            classes.linearize(class, viewpoint).0.map(|x| x + sigma * noise.normal())
        });
        let answer = DiscreteClass::new(&settings, classes).estimate(&world.observations).unwrap();
        geometric +=
            world.ate(&estimate(&world.observations, Which::Geometric, None, &settings).unwrap()) / 10.0;
        semantic += world.ate(&answer) / 10.0;
        for (track, object) in answer.objects.iter().enumerate() {
            let belief = object.as_ref().unwrap().classes.as_ref().unwrap();
            assert!((belief.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            all += 1;
            right += usize::from(belief[track % 4] > 0.9);
        }
        let turned = world.orientation_errors(&answer);
        assert!(turned.iter().filter(|e| e.to_degrees() < 15.0).count() + 1 >= turned.len(), "{turned:?}");
    }
    println!("mean ATE: geometric {geometric:.4}, discrete class {semantic:.4}; {right} of {all} classes");
    assert!(semantic < geometric && right * 20 >= all * 19);
}

/// Views that are exactly as predicted tell classes apart by how sharp their densities are.
#[test]
fn classes_of_one_look_are_told_apart_by_their_noise() {
    let spec = WorldSpec::sparse_loop();
    let mut settings = matching_settings(&spec);
    settings.semantics.minimum_view_separation = 1.0;
    let classes = LinearClasses::new(2, 6, 0.1, Seed(1)).alike();
    let mut world = World::new(&spec, None, Seed(3));
    show(&mut world, |_, _, viewpoint| classes.linearize(0, viewpoint).0);
    let peaks = [0, 1].map(|class| classes.noise(class).log_normalizer());
    // Of a t of 3 and one of 12 degrees of freedom, 1.5 times as wide.
    assert!((peaks[0] - peaks[1] - (6.0 * libm::log(1.5) + 0.9)).abs() < 0.1, "{peaks:?}");
    let answer = DiscreteClass::new(&settings, classes).estimate(&world.observations).unwrap();
    for object in answer.objects.iter().flatten().filter(|object| object.semantic_views > 0) {
        let belief = object.classes.as_ref().unwrap();
        let odds = libm::log(belief[0] / belief[1]);
        // But for the poses, of which the sharper class leaves less: one nat.
        let expected = object.semantic_views as f64 * (peaks[0] - peaks[1]);
        assert!(odds > expected - 1.4 && odds < expected - 0.6, "{odds}, {expected}");
    }
}

#[test]
fn a_measurement_of_another_length_is_refused() {
    struct Long(LinearClasses);
    impl ClassModel for Long {
        fn classes(&self) -> usize {
            self.0.classes()
        }
        fn noise(&self, class: usize) -> &MeasurementNoise {
            self.0.noise(class)
        }
        fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
            Ok(numbers(crop, 7).map(|_| 0.0))
        }
        fn linearize(&self, class: usize, viewpoint: &Viewpoint) -> (DVector<f64>, ViewpointDerivative) {
            self.0.linearize(class, viewpoint)
        }
    }
    let spec = WorldSpec::sparse_loop();
    let world = World::new(&spec, None, Seed(8));
    let model = Long(LinearClasses::new(2, 6, 0.1, Seed(1)));
    let told = DiscreteClass::new(&matching_settings(&spec), model).estimate(&world.observations);
    assert!(told.unwrap_err().to_string().contains("got 7 numbers, expected 6"));
}
