//! A robot on a loop among point landmarks, and the marginals of all that is estimated, from the whole problem and from the tree.

use crate::Failure;
use crate::numbers::Numbers;
use nalgebra::{DMatrix, Matrix6, Point3, UnitQuaternion, Vector2, Vector3, Vector6};
use std::f64::consts::TAU;
use std::path::Path;
use vantage_dataset::{Camera, LandmarkSighting, Pose, Seed, Tangent, se3};
use vantage_slam::Key;
use vantage_slam::covariance::Marginals;
use vantage_slam::factor::{BetweenFactor, PosePrior, ProjectionFactor};
use vantage_slam::graph::Graph;
use vantage_slam::incremental::{Smoother, Thresholds};
use vantage_slam::linear::Structure;
use vantage_slam::noise::Kernel;
use vantage_slam::solve::{Limits, solve};
use vantage_slam::variable::{Value, Values};

const POSES: usize = 60;
const LANDMARKS: usize = 40;
/// Deviations: the gauge, odometry (radians and metres), pixels.
const GAUGE: f64 = 1e-2;
const ODOMETRY: [f64; 2] = [0.01, 0.03];
const PIXELS: f64 = 1.0;
/// Sightings with which a landmark comes in.
const SIGHTINGS: usize = 3;
/// Metres.
const RADIUS: f64 = 4.0;

/// Writes counts (poses, landmarks, sightings), deviations (gauge, odometry, pixels), the camera (fx, fy, cx, cy, `robot_from_camera`), then
/// the start of poses and of landmarks, motions to the next pose, and sightings (pose, landmark, pixel); and beside it covariances of poses
/// `[6 x 6]` and of landmarks `[3 x 3]`, twice: of the whole problem, and of the tree grown pose by pose.
pub fn run(graph_file: &Path, marginals_file: &Path) -> Result<(), Failure> {
    let mut stream = Seed(5).stream("landmarks", 0);
    let camera = Camera::with_horizontal_fov(640, 480, 1.5);
    // The camera looks along the robot's y axis, towards the middle of its loop.
    let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -TAU / 4.0 - 0.05);
    let robot_from_camera = Pose::from_parts(Vector3::new(0.1, 0.05, 0.4).into(), tilt);
    let on_loop = |turn: f64| {
        Pose::translation(RADIUS * libm::cos(turn), RADIUS * libm::sin(turn), 0.0)
            * Pose::rotation(Vector3::new(0.0, 0.0, turn + TAU / 4.0))
    };
    let robots: Vec<Pose> = (0..POSES).map(|step| on_loop(TAU * step as f64 / (POSES - 10) as f64)).collect();
    let landmarks: Vec<Vector3<f64>> = (0..LANDMARKS)
        .map(|_| Vector3::from_fn(|i, _| stream.uniform(-1.5, 1.5) * if i < 2 { 1.0 } else { 0.5 }))
        .collect();
    let mut random = |[rotation, translation]: [f64; 2]| {
        Tangent::from_fn(|i, _| stream.normal() * if i < 3 { rotation } else { translation })
    };
    let motions: Vec<Pose> =
        robots.windows(2).map(|pair| pair[0].inv_mul(&pair[1]) * se3::exp(&random(ODOMETRY))).collect();
    let mut sightings = Vec::new();
    for (step, robot) in robots.iter().enumerate() {
        for (landmark, point) in landmarks.iter().enumerate() {
            let at: Point3<f64> = (robot * robot_from_camera).inverse_transform_point(&Point3::from(*point));
            let noise = random([PIXELS, 0.0]);
            let size = Vector2::new(f64::from(camera.width), f64::from(camera.height));
            let seen = camera
                .project(&at)
                .filter(|pixel| pixel.iter().zip(&size).all(|(x, n)| (0.0..*n).contains(x)));
            if let Some(pixel) = seen.filter(|_| (step + landmark) % 3 == 0) {
                let pixel = pixel + Vector2::new(noise[0], noise[1]);
                sightings.push(LandmarkSighting { step, landmark, pixel, sigma: PIXELS });
            }
        }
    }
    let mut start = Values::default();
    let mut robot = robots[0];
    for (step, motion) in std::iter::once(&Pose::identity()).chain(&motions).enumerate() {
        robot *= motion;
        start.insert(Key::Robot(step), Value::Pose(robot));
    }
    for (landmark, point) in landmarks.iter().enumerate() {
        let noise = random([0.1, 0.0]);
        start.insert(Key::Landmark(landmark), Value::Point(point + noise.fixed_rows::<3>(0)));
    }
    write(graph_file, &camera, &robot_from_camera, &start, &motions, &sightings)?;

    let deviations = Vector6::from_fn(|i, _| ODOMETRY[i / 3]);
    let odometry = Matrix6::from_diagonal(&deviations.map(|deviation| 1.0 / deviation));
    let motion = |step: usize, graph: &mut Graph<'static>| {
        let (before, after) = (Key::Robot(step - 1), Key::Robot(step));
        graph.push(BetweenFactor::new(before, after, motions[step - 1], odometry));
    };
    let gauge = PosePrior::new(Key::Robot(0), robots[0], Matrix6::identity() / GAUGE);
    let sight = |sighting: &LandmarkSighting, graph: &mut Graph<'static>| {
        graph.push(ProjectionFactor::new(sighting, camera, robot_from_camera, Kernel::Gaussian));
    };
    let mut whole = Graph::default();
    whole.push(gauge.clone());
    (1..POSES).for_each(|step| motion(step, &mut whole));
    sightings.iter().for_each(|sighting| sight(sighting, &mut whole));

    let mut smoother =
        Smoother::new(Thresholds { relinearization: 0.01, propagation: 1e-5, iterations: 2, rejections: 8 });
    let mut first = start.clone();
    for step in 0..POSES {
        let mut graph = Graph::default();
        match step.checked_sub(1) {
            Some(before) => {
                let before = smoother.values().pose(Key::Robot(before)).ok_or("no pose before")?;
                first.insert(Key::Robot(step), Value::Pose(before * motions[step - 1]));
                motion(step, &mut graph);
            }
            None => graph.push(gauge.clone()),
        }
        for new in sightings.iter().filter(|sighting| sighting.step == step) {
            let of_it = sightings.iter().filter(|s| s.landmark == new.landmark && s.step <= step);
            match of_it.clone().count() {
                0..SIGHTINGS => {}
                SIGHTINGS => of_it.for_each(|sighting| sight(sighting, &mut graph)),
                _ => sight(new, &mut graph),
            }
        }
        if smoother.add(graph, &first) > 0 {
            return Err("a landmark behind the camera".into());
        }
        smoother.update().map_err(|error| format!("{error:?}"))?;
    }
    // Twice, since the second linearises all anew, at the maximum.
    for _ in 0..2 {
        if !smoother.settle(1e-16, 50).map_err(|error| format!("{error:?}"))? {
            return Err("the tree does not settle".into());
        }
    }
    let solution = solve(&whole, start, |_| true, Limits { iterations: 100, tolerance: 1e-16 });
    println!("cost {}\ntree {}", solution.cost, whole.cost(smoother.values()).ok_or("undefined")?);

    let keys: Vec<Key> = solution.values.iter().map(|(key, _)| key).collect();
    let structure = Structure::new(&whole, &solution.values, |_| true).ok_or("too large")?;
    let system = structure.linearize(&whole, &solution.values).ok_or("undefined")?;
    let marginals = Marginals::new(&system).ok_or("not positive definite")?;
    let of_tree = keys.iter().map(|key| smoother.covariance(*key));
    let mut numbers = Numbers::create(marginals_file)?;
    for covariance in marginals.covariances(&keys).into_iter().chain(of_tree) {
        let covariance: DMatrix<f64> = covariance.ok_or("a variable without a covariance")?;
        numbers.put(covariance.as_slice())?;
    }
    numbers.finish()
}

fn write(
    file: &Path,
    camera: &Camera,
    robot_from_camera: &Pose,
    start: &Values,
    motions: &[Pose],
    sightings: &[LandmarkSighting],
) -> Result<(), Failure> {
    let mut numbers = Numbers::create(file)?;
    numbers.put(&[POSES, LANDMARKS, sightings.len()].map(|count| count as f64))?;
    numbers.put(&[GAUGE, ODOMETRY[0], ODOMETRY[1], PIXELS])?;
    numbers.put(&[camera.fx, camera.fy, camera.cx, camera.cy])?;
    numbers.put_pose(robot_from_camera)?;
    for (_, value) in start.iter() {
        match value {
            Value::Pose(pose) => numbers.put_pose(pose)?,
            Value::Point(point) => numbers.put(point.as_slice())?,
            Value::Vector(vector) => numbers.put(vector.as_slice())?,
        }
    }
    motions.iter().try_for_each(|motion| numbers.put_pose(motion))?;
    for LandmarkSighting { step, landmark, pixel, .. } in sightings {
        numbers.put(&[*step as f64, *landmark as f64, pixel.x, pixel.y])?;
    }
    numbers.finish()
}
