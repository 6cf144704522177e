//! Objects of a few classes that are told by place alone: Mu's simulation, and worlds like it.

use crate::Failure;
use crate::clock::cpu_seconds;
use crate::scores::{Scores, paired, pairwise};
use nalgebra::{DVector, Vector2};
use std::f64::consts::PI;
use std::path::Path;
use vantage_dataset::Seed;
use vantage_formats::mu;
use vantage_slam::Key;
use vantage_slam::association::planar::{
    CLUTTER, Detection, Motion, PlanarBetween, PlanarPoint, PlanarPrior, Sensing, Sensor, landmark, pose,
    whitening,
};
use vantage_slam::association::{Addition, Hypotheses, Limits, LocalEstimator, SharedSmoother, Thresholds};
use vantage_slam::variable::Value;

/// Deviations: a detection, metres; odometry, metres and radians a step.
const DETECTION: f64 = 0.1;
const ODOMETRY: [f64; 3] = [0.02, 0.02, 0.01];
/// Squared Mahalanobis distance of two numbers within which 99% lie.
const GATE: f64 = 9.21;

/// A track, what is there, and what is seen of it, all true.
pub struct World {
    pub poses: Vec<Motion>,
    /// Places and classes.
    pub objects: Vec<(Vector2<f64>, usize)>,
    /// By pose.
    pub seen: Vec<Vec<usize>>,
    pub sensor: Sensor,
}

/// How detections are taken.
#[derive(Clone, Copy, PartialEq)]
pub enum Rule {
    Oracle,
    Greedy,
    Hypotheses,
}

/// Prints, for each noise and rule, means and deviations over the seeds.
pub fn mu(file: &Path, seeds: u64) -> Result<(), Failure> {
    let world = World::of_mu(&mu::read(file)?);
    table(|_| Ok(&world), 0..seeds)
}

/// The same of generated worlds, a new one for each seed.
pub fn generated(seeds: std::ops::Range<u64>) -> Result<(), Failure> {
    let worlds: Vec<World> = seeds.clone().map(|seed| World::generate(Seed(seed))).collect();
    let first = seeds.start;
    table(|seed| worlds.get((seed - first) as usize).ok_or_else(|| "no such world".into()), seeds)
}

fn table<'a>(
    world: impl Fn(u64) -> Result<&'a World, Failure>,
    seeds: std::ops::Range<u64>,
) -> Result<(), Failure> {
    println!(
        "noise rule ATE(m) objects F1 P R hypotheses dropped cpu(s): mean +- deviation over {} seeds; ATE less the oracle's: mean +- two \
         standard errors",
        seeds.end - seeds.start
    );
    for scale in [1.0, 3.0] {
        let mut oracle = Vec::new();
        for (name, rule) in
            [("oracle", Rule::Oracle), ("greedy", Rule::Greedy), ("hypotheses", Rule::Hypotheses)]
        {
            let mut all = Vec::new();
            for seed in seeds.clone() {
                all.push(run(world(seed)?, Seed(seed), scale, rule)?);
            }
            if rule == Rule::Oracle {
                oracle = all;
                println!("{scale} {name} {}", Scores::summary(&oracle));
            } else {
                println!("{scale} {name} {}; {}", Scores::summary(&all), paired(&all, &oracle));
            }
        }
    }
    Ok(())
}

impl World {
    fn of_mu(simulation: &mu::MuSimulation) -> Self {
        let poses: Vec<Motion> = (simulation.poses.iter()).map(|[x, y, h]| Motion::new(*x, *y, *h)).collect();
        let objects: Vec<(Vector2<f64>, usize)> =
            simulation.objects.iter().map(|(place, class)| (Vector2::from(*place), *class)).collect();
        let mut seen = vec![Vec::new(); poses.len()];
        simulation.detections.iter().for_each(|[pose, object]| seen[*pose].push(*object));
        // The sector of the file's own view (4 m, 60 degrees to either side), and what is likely in any such world: 95% detected, one false
        // detection in 100 views, one object in 10 square metres.
        let sensor = Sensor {
            range: simulation.range,
            half_angle: PI / 3.0,
            sqrt_information: whitening([DETECTION; 2]),
            detection: 0.95,
            clutter: 0.01,
            density: 0.1,
            classes: objects.iter().map(|(_, class)| class + 1).max().unwrap_or(1),
            candidates: 6,
        };
        Self { poses, objects, seen, sensor }
    }

    /// A robot that drives from one random place of a square to the next, among objects of five classes.
    fn generate(seed: Seed) -> Self {
        let (side, speed, turn) = (10.0, 0.1, 0.1);
        let mut stream = seed.stream("world", 0);
        let mut place = || Vector2::new(stream.uniform(0.0, side), stream.uniform(0.0, side));
        let objects: Vec<(Vector2<f64>, usize)> = (0..15).map(|i| (place(), i % 5)).collect();
        let mut robot = Motion::new(place().x, place().y, 0.0);
        let mut poses = vec![robot];
        let mut goal = place();
        while poses.len() < 600 {
            let to = robot.seen(goal);
            if to.norm() < 0.5 {
                goal = place();
                continue;
            }
            let bearing = libm::atan2(to.y, to.x).clamp(-turn, turn);
            robot = robot.then(Motion::new(speed, 0.0, bearing));
            poses.push(robot);
        }
        let sensor = Sensor {
            range: 4.0,
            half_angle: PI / 3.0,
            sqrt_information: whitening([DETECTION; 2]),
            detection: 0.95,
            clutter: 0.01,
            density: 0.1,
            classes: 5,
            candidates: 6,
        };
        let mut stream = seed.stream("seen", 0);
        let mut seen = Vec::new();
        for pose in &poses {
            let visible = (0..objects.len()).filter(|i| sensor.sees(*pose, objects[*i].0));
            seen.push(visible.filter(|_| stream.chance(sensor.detection)).collect());
        }
        Self { poses, objects, seen, sensor }
    }
}

/// One run: odometry noisier by `scale`.
pub fn run(world: &World, seed: Seed, scale: f64, rule: Rule) -> Result<Scores, Failure> {
    let deviations = ODOMETRY.map(|deviation| deviation * scale);
    let mut noise = seed.stream("odometry", 0);
    let odometry: Vec<Motion> = (world.poses.windows(2))
        .map(|pair| {
            let Motion { x, y, heading } = pair[0].to(pair[1]);
            let mut noisy = |value: f64, deviation: f64| value + deviation * noise.normal();
            Motion::new(noisy(x, deviations[0]), noisy(y, deviations[1]), noisy(heading, deviations[2]))
        })
        .collect();
    let mut noise = seed.stream("detections", 0);
    let (mut truth, mut frames) = (Vec::new(), Vec::new());
    for (pose, seen) in world.poses.iter().zip(&world.seen) {
        let mut frame = Vec::new();
        for &object in seen {
            let (place, class) = world.objects[object];
            let measured = pose.seen(place) + Vector2::new(noise.normal(), noise.normal()) * DETECTION;
            frame.push(Detection { number: truth.len(), measured, class });
            truth.push(object);
        }
        frames.push(frame);
    }
    let start = cpu_seconds();
    let (labels, estimator, hypotheses, dropped) = match rule {
        Rule::Oracle | Rule::Greedy => by_rule(world, &deviations, &odometry, &frames, &truth, rule)?,
        Rule::Hypotheses => by_hypotheses(world, &deviations, &odometry, &frames)?,
    };
    let cpu = cpu_seconds() - start;
    let squares: f64 = (0..world.poses.len())
        .filter_map(|step| {
            let at = world.poses[0].then(pose(&estimator, step)?);
            Some((at.x - world.poses[step].x).powi(2) + (at.y - world.poses[step].y).powi(2))
        })
        .sum();
    let ate = (squares / world.poses.len() as f64).sqrt();
    let mut objects: Vec<usize> = labels.iter().copied().filter(|label| *label != CLUTTER).collect();
    objects.sort_unstable();
    objects.dedup();
    let (precision, recall) = pairwise(&truth, &labels, CLUTTER);
    Ok(Scores { ate, objects: objects.len() as f64, precision, recall, hypotheses, dropped, cpu })
}

type Answer = (Vec<usize>, SharedSmoother<'static>, f64, f64);

fn first_pose() -> Addition<'static> {
    let origin = Motion::new(0.0, 0.0, 0.0);
    let prior = PlanarPrior::new(Key::Robot(0), origin, whitening([1e-3; 3]));
    Addition::default().with_variable(Key::Robot(0), origin.to_value()).with(prior)
}

fn next_pose(
    estimator: &SharedSmoother<'static>,
    step: usize,
    motion: Motion,
    deviations: &[f64; 3],
) -> Addition<'static> {
    let (before, now) = (Key::Robot(step - 1), Key::Robot(step));
    let between = PlanarBetween::new(before, now, motion, whitening(*deviations));
    let first = pose(estimator, step - 1).map_or(motion, |pose| pose.then(motion));
    Addition::default().with_variable(now, first.to_value()).with(between)
}

/// By the truth, or by the nearest object of the class in the gate.
fn by_rule(
    world: &World,
    deviations: &[f64; 3],
    odometry: &[Motion],
    frames: &[Vec<Detection>],
    truth: &[usize],
    rule: Rule,
) -> Result<Answer, Failure> {
    let mut estimator = SharedSmoother::new(Thresholds::default());
    let mut classes: Vec<(usize, usize)> = Vec::new();
    let mut labels = Vec::new();
    for (step, frame) in frames.iter().enumerate() {
        let motion = if step == 0 {
            first_pose()
        } else {
            next_pose(&estimator, step, odometry[step - 1], deviations)
        };
        estimator.add(&motion)?;
        for detection in frame {
            let factor = |number| {
                let key = Key::Landmark(number);
                PlanarPoint::new(Key::Robot(step), key, detection.measured, world.sensor.sqrt_information)
            };
            let label = match rule {
                Rule::Oracle => {
                    let same = truth.iter().position(|object| *object == truth[detection.number]);
                    same.unwrap_or(detection.number)
                }
                _ => {
                    estimator.update()?;
                    let mut nearest = (GATE, detection.number);
                    for &(number, _) in classes.iter().filter(|(_, class)| *class == detection.class) {
                        let keys = [Key::Robot(step), Key::Landmark(number)];
                        let factors = Addition::default().with(factor(number)).factors;
                        let weighed = estimator.joint(&keys).and_then(|local| local.weigh(&factors, &[]));
                        let distance = weighed.map_or(f64::INFINITY, |weighed| weighed.distance);
                        if distance < nearest.0 {
                            nearest = (distance, number);
                        }
                    }
                    nearest.1
                }
            };
            let mut addition = Addition::default().with(factor(label));
            if label == detection.number {
                classes.push((label, detection.class));
                let robot = pose(&estimator, step).ok_or("no pose")?;
                let first = robot.point(detection.measured);
                let first = Value::Vector(DVector::from_column_slice(first.as_slice()));
                addition = addition.with_variable(Key::Landmark(label), first);
            }
            estimator.add(&addition)?;
            labels.push(label);
        }
        if !frame.is_empty() {
            estimator.update()?;
        }
    }
    estimator.update()?;
    estimator.solve_anew()?;
    Ok((labels, estimator, 1.0, 0.0))
}

fn by_hypotheses(
    world: &World,
    deviations: &[f64; 3],
    odometry: &[Motion],
    frames: &[Vec<Detection>],
) -> Result<Answer, Failure> {
    let mut hypotheses = Hypotheses::new(SharedSmoother::new(Thresholds::default()), Limits::default());
    let mut sensing = Sensing::new(world.sensor);
    for (step, frame) in frames.iter().enumerate() {
        hypotheses.observe(|hypothesis| match step {
            0 => first_pose(),
            _ => next_pose(hypothesis.estimator(), step, odometry[step - 1], deviations),
        })?;
        hypotheses.choose(|hypothesis| sensing.frame(hypothesis, step, frame))?;
        sensing.look(step, frame);
    }
    hypotheses.refine()?;
    let best = hypotheses.best().ok_or("no hypothesis")?;
    let labels = best.verdicts().iter().map(|verdict| verdict.label).collect();
    for place in best.verdicts().iter().filter(|verdict| verdict.choice == verdict.label) {
        landmark(best.estimator(), place.label).ok_or("an object without a place")?;
    }
    Ok((labels, best.estimator().clone(), hypotheses.work().most as f64, hypotheses.given_up().dropped))
}
