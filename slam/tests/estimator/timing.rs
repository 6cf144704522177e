//! What an estimate costs at full size, and how much of it is the model. Run by hand:
//! `cargo test --release -p vantage-slam --test estimator timing -- --ignored --nocapture`.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_spec};
use nalgebra::{DVector, Matrix6};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Pose, Seed, Viewpoint};
use vantage_slam::covariance::Marginals;
use vantage_slam::factor::semantic::SemanticScaling;
use vantage_slam::factor::{
    BearingFactor, BetweenFactor, PosePrior, SemanticFactor, StandardNormalPrior, UprightFactor,
};
use vantage_slam::graph::Graph;
use vantage_slam::linear::{Structure, least_constrained};
use vantage_slam::noise::Kernel;
use vantage_slam::variable::{Value, Values};
use vantage_slam::{
    Key, LatentGaussian, Linearization, MeasurementNoise, ModelError, ObservationModel, Row, estimate,
};

/// Counts and times the calls of encode, predict and linearize.
struct Timed {
    inner: TanhModel,
    calls: [AtomicU64; 3],
    nanoseconds: [AtomicU64; 3],
}

impl Timed {
    fn time<T>(&self, which: usize, call: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let before = cpu_time(start);
        let answer = call();
        let spent = cpu_time(start) - before;
        self.calls[which].fetch_add(1, Ordering::Relaxed);
        self.nanoseconds[which].fetch_add(spent.as_nanos() as u64, Ordering::Relaxed);
        answer
    }
}

impl ObservationModel for Timed {
    fn latent_dim(&self) -> usize {
        self.inner.latent_dim()
    }
    fn measurement_dim(&self) -> usize {
        self.inner.measurement_dim()
    }
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        self.inner.measure(crop)
    }
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        self.time(0, || self.inner.encode(crop, viewpoint))
    }
    fn predict(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<DVector<f64>, ModelError> {
        self.time(1, || self.inner.predict(latent, x))
    }
    fn linearize(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Linearization, ModelError> {
        self.time(2, || self.inner.linearize(latent, x))
    }
    fn noise(&self) -> &MeasurementNoise {
        self.inner.noise()
    }
}

/// CPU time of this thread where Linux tells, else the time since `start`.
fn cpu_time(start: Instant) -> Duration {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse().ok())
        .map_or_else(|| start.elapsed(), Duration::from_nanos)
}

fn full_size() -> (World, WorldSpec) {
    let inner = TanhModel::new([128, 32, 128], 0.03, 5.0, Seed(1));
    let spec = WorldSpec { steps: 100, laps: 1.2, objects: 12, inward: true, ..WorldSpec::sparse_loop() };
    let mut world = World::new(&spec, Some(&inner), Seed(1));
    let mut index = 0;
    world.observations.detections.retain(|_| {
        index += 1;
        index * 5 % 13 < 5
    });
    (world, spec)
}

#[test]
#[ignore = "prints times; nothing to fail on"]
fn timing_of_an_iteration() {
    let model = TanhModel::new([128, 32, 128], 0.03, 5.0, Seed(1));
    let (world, spec) = full_size();
    let (mut graph, mut values) = (Graph::default(), Values::default());
    let information = Matrix6::identity() * 100.0;
    graph.push(PosePrior::new(Key::Robot(0), Pose::identity(), information));
    for (step, pose) in world.world_from_robot.iter().enumerate() {
        values.insert(Key::Robot(step), Value::Pose(*pose));
    }
    for o in &world.observations.odometry {
        graph.push(BetweenFactor::new(Key::Robot(o.from), Key::Robot(o.to), o.robot_from_robot, information));
    }
    for (track, pose) in world.world_from_object.iter().enumerate() {
        values.insert(Key::Object(track), Value::Pose(*pose));
        values.insert(Key::Latent(track), Value::Vector(DVector::zeros(128)));
        graph.push(StandardNormalPrior::new(Key::Latent(track)));
        graph.push(UprightFactor::new(Key::Object(track), 0.05, pose.rotation));
    }
    let (camera, mount) = (world.observations.camera, world.observations.robot_from_camera);
    for d in &world.observations.detections {
        let (robot, object) = (Key::Robot(d.step), Key::Object(d.track));
        let ray = camera.ray_in_camera(&d.bounding_box.center());
        graph.push(BearingFactor::new(robot, object, mount, &ray, spec.bearing_sigma, Kernel::Gaussian));
        let measurement = model.measure(&d.masked_crop).unwrap();
        let scaling = SemanticScaling { noise: 1.0, information: 1.0 };
        let keys = [robot, object, Key::Latent(d.track)];
        let size = world.sizes[d.track];
        graph.push(SemanticFactor::new(keys, &model, measurement, mount, size, scaling));
    }
    let begin = Instant::now();
    let mut last = cpu_time(begin);
    let mut lap = |what: &str| {
        let now = cpu_time(begin);
        println!("    {what}: {:?}", now - last);
        last = now;
    };
    println!("{} detections", world.observations.detections.len());
    let structure = Structure::new(&graph, &values, |_| true).unwrap();
    lap("ordering and symbolic factorisation");
    graph.cost(&values).unwrap();
    lap("cost");
    for factor in graph.factors() {
        std::hint::black_box(factor.linearize(&values));
    }
    lap("linearisation of all factors, model included");
    let system = structure.linearize(&graph, &values).unwrap();
    lap("the same with assembly of the normal equations");
    system.step(1e-5).unwrap();
    lap("elimination of the latents, factorisation, step");
    assert_eq!(least_constrained(&system), None);
    lap("rank");
    let marginals = Marginals::new(&system).unwrap();
    let robots: Vec<Key> = (0..100).map(Key::Robot).collect();
    marginals.covariances(&robots);
    lap("covariances of all poses");
    for track in 0..12 {
        marginals.latent_variance(Key::Latent(track)).unwrap();
    }
    lap("variances of all latents");
}

#[test]
#[ignore = "prints times; nothing to fail on"]
fn timing_of_100_steps_12_objects_latent_128() {
    let (world, spec) = full_size();
    for row in Row::ALL {
        let inner = TanhModel::new([128, 32, 128], 0.03, 5.0, Seed(1));
        let model = Timed { inner, calls: Default::default(), nanoseconds: Default::default() };
        let start = Instant::now();
        let before = cpu_time(start);
        let answer = estimate(&world.observations, row, Some(&model), &matching_spec(&spec)).unwrap();
        println!(
            "{row}: {:?} in all, {} iterations, {}, ATE {:.4}",
            cpu_time(start) - before,
            answer.iterations,
            answer.outcome,
            world.ate(&answer)
        );
        for (index, name) in ["encode", "predict", "linearize"].iter().enumerate() {
            let of = |counters: &[AtomicU64; 3]| counters[index].load(Ordering::Relaxed);
            println!(
                "    {name}: {} calls, {:?}",
                of(&model.calls),
                Duration::from_nanos(of(&model.nanoseconds))
            );
        }
    }
}
