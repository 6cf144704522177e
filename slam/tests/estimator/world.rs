//! Simulated episodes: a robot circles, a camera looks at objects, and all noise is as the factors assume.

use crate::model::TanhModel;
use nalgebra::{Matrix3, Matrix6, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{
    BoundingBox, Camera, Crop, Detection, Observations, Odometry, Pose, Seed, Tangent, Viewpoint, se3,
};
use vantage_model::ObservationModel;
use vantage_slam::bearing_offset::BearingOffset;
use vantage_slam::factor::OffsetBearingFactor;
use vantage_slam::noise::{BearingNoise, Kernel};
use vantage_slam::odometry_bias::OdometryBias;
use vantage_slam::{Estimate, GeometrySettings, OdometrySettings, Settings};

#[derive(Clone, Copy)]
pub struct WorldSpec {
    pub steps: usize,
    pub laps: f64,
    pub objects: usize,
    /// Camera looks into the loop, where the objects are; else out of it.
    pub inward: bool,
    /// Radians and metres a step.
    pub odometry_sigma: [f64; 2],
    /// Tangent of the angle.
    pub bearing_sigma: f64,
    pub semantic_sigma: f64,
    /// How boxes lie off their objects.
    pub bearing_offset: Option<BearingOffset>,
    pub odometry_bias: Option<OdometryBias>,
}

impl WorldSpec {
    /// One or two of 8 objects in view at a time, one and a half laps.
    pub fn sparse_loop() -> Self {
        Self {
            steps: 60,
            laps: 1.5,
            objects: 8,
            inward: false,
            odometry_sigma: [0.01, 0.01],
            bearing_sigma: 0.01,
            semantic_sigma: 0.03,
            bearing_offset: None,
            odometry_bias: None,
        }
    }

    pub fn noiseless(self) -> Self {
        Self { odometry_sigma: [0.0; 2], bearing_sigma: 0.0, semantic_sigma: 0.0, ..self }
    }
}

pub struct World {
    pub observations: Observations,
    /// In the frame of the first pose.
    pub world_from_robot: Vec<Pose>,
    pub world_from_object: Vec<Pose>,
    pub sizes: Vec<f64>,
}

/// Worlds that teach a robot nothing, and whether their crops are to be made garbage.
pub fn nothing_to_learn_from() -> [(&'static str, WorldSpec, bool); 4] {
    let sparse = WorldSpec::sparse_loop();
    [
        ("a robot that stands still", WorldSpec { laps: 0.0, ..sparse }, false),
        ("one object", WorldSpec { objects: 1, ..sparse }, false),
        ("no object", WorldSpec { objects: 0, ..sparse }, false),
        ("measurements of another model", sparse, true),
    ]
}

/// Diameter over box side in these worlds.
pub const SIZE_OVER_BOX_SIDE: f64 = 1.2;

/// Settings that match the worlds' noise exactly, where it is not zero.
pub fn matching_settings(world: &WorldSpec) -> Settings {
    let geometry = GeometrySettings {
        bearing_noise: BearingNoise { fixed: world.bearing_sigma.max(1e-3), proportional: 0.0 },
        bearing_offset: world.bearing_offset,
        bearing_kernel: Kernel::Gaussian,
        size_over_box_side: SIZE_OVER_BOX_SIDE,
        ..GeometrySettings::default()
    };
    let odometry = OdometrySettings { bias: world.odometry_bias };
    Settings { odometry, geometry, ..Settings::default() }
}

impl World {
    pub fn new(spec: &WorldSpec, model: Option<&TanhModel>, seed: Seed) -> Self {
        let robot_from_camera = mount(spec.inward);
        let camera = Camera::with_horizontal_fov(512, 384, 70f64.to_radians());
        let circle = |step: usize| {
            let angle = 2.0 * PI * spec.laps * step as f64 / (spec.steps.max(2) - 1) as f64;
            Pose::new(
                Vector3::new(2.0 * angle.cos(), 2.0 * angle.sin(), 0.0),
                Vector3::z() * (angle + PI / 2.0),
            )
        };
        let first_from_world = circle(0).inverse();
        let world_from_robot: Vec<Pose> =
            (0..spec.steps).map(|step| first_from_world * circle(step)).collect();

        let mut layout = seed.stream("layout", 0);
        let radius = if spec.inward { 0.7 } else { 4.0 };
        let (mut world_from_object, mut sizes) = (Vec::new(), Vec::new());
        for track in 0..spec.objects {
            let angle = 2.0 * PI * (track as f64 + layout.uniform(-0.2, 0.2)) / spec.objects as f64;
            let place = Vector3::new(radius * angle.cos(), radius * angle.sin(), layout.uniform(0.1, 0.6));
            let pose = Pose::new(place, Vector3::z() * layout.uniform(-PI, PI));
            world_from_object.push(first_from_world * pose);
            sizes.push(layout.uniform(0.2, 0.35));
        }

        let mut world = Self {
            observations: Observations {
                timestamps: (0..spec.steps).map(|step| step as f64 / 10.0).collect(),
                camera,
                robot_from_camera,
                odometry: Vec::new(),
                detections: Vec::new(),
                landmarks: Vec::new(),
            },
            world_from_robot,
            world_from_object,
            sizes,
        };
        world.drive(spec, seed);
        world.look(spec, model, seed);
        world
    }

    fn drive(&mut self, spec: &WorldSpec, seed: Seed) {
        let [rotation, translation] = spec.odometry_sigma;
        let sigma = |i: usize| if i < 3 { rotation } else { translation };
        let covariance = Matrix6::from_diagonal(&Tangent::from_fn(|i, _| sigma(i).max(1e-3).powi(2)));
        let mut noise = seed.stream("odometry", 0);
        let mut bias_stream = seed.stream("odometry bias", 0);
        let bias = Vector2::from_fn(|_, _| bias_stream.normal());
        for to in 1..spec.steps {
            let motion = self.world_from_robot[to - 1].inv_mul(&self.world_from_robot[to]);
            let error = Tangent::from_fn(|i, _| sigma(i) * noise.normal());
            let mut odometry = Odometry { from: to - 1, to, robot_from_robot: motion, covariance };
            let shared = spec.odometry_bias.map(|of| of.response(&odometry) * bias);
            odometry.robot_from_robot = motion * se3::exp(&(error + shared.unwrap_or_else(Tangent::zeros)));
            if let Some(of) = spec.odometry_bias {
                let response = of.response(&odometry);
                odometry.covariance += response * response.transpose();
            }
            self.observations.odometry.push(odometry);
        }
    }

    /// Adds what the camera sees at all steps.
    pub fn look(&mut self, spec: &WorldSpec, model: Option<&TanhModel>, seed: Seed) {
        let camera = self.observations.camera;
        let mut noise = seed.stream("bearing", 0);
        let mut semantic_noise = seed.stream("semantic", 0);
        for step in 0..spec.steps {
            let world_from_camera = self.world_from_robot[step] * self.observations.robot_from_camera;
            for track in 0..spec.objects {
                let object_from_camera = self.world_from_object[track].inv_mul(&world_from_camera);
                let p_in_camera = object_from_camera.inverse().translation.vector;
                let Some(center) = camera.project(&p_in_camera.into()) else { continue };
                let error = Vector2::from_fn(|_, _| spec.bearing_sigma * camera.fx * noise.normal());
                let side = camera.fx * self.sizes[track] / SIZE_OVER_BOX_SIDE / p_in_camera.z;
                let direction =
                    world_from_camera.translation.vector - self.world_from_object[track].translation.vector;
                let center = center + error + box_offset(spec, track, seed, &direction) * side;
                let half = Vector2::new(side, side) / 2.0;
                let bounding_box = BoundingBox { min: center - half, max: center + half };
                let inside = |p: Vector2<f64>| {
                    p.x >= 0.0
                        && p.y >= 0.0
                        && p.x <= f64::from(camera.width)
                        && p.y <= f64::from(camera.height)
                };
                if !inside(center) {
                    continue;
                }
                let crop = model.map_or_else(Crop::black, |model| {
                    let mut latent = seed.stream("latent", track as u64);
                    let e = nalgebra::DVector::from_fn(model.latent_dim(), |_, _| latent.normal());
                    let viewpoint = Viewpoint::new(&object_from_camera, self.sizes[track]).unwrap();
                    let mean = model.predict(&e, &viewpoint).unwrap();
                    TanhModel::crop(&mean.map(|x| x + spec.semantic_sigma * semantic_noise.normal()))
                });
                self.observations.detections.push(Detection {
                    step,
                    track,
                    bounding_box,
                    mask_pixels: (side * side) as u32,
                    center_depth: None,
                    masked_crop: crop.clone(),
                    boxed_crop: crop,
                });
            }
        }
    }

    /// Root mean square error of the robot's position, first poses aligned.
    pub fn ate(&self, estimate: &Estimate) -> f64 {
        let pairs = estimate.world_from_robot.iter().zip(&self.world_from_robot);
        let squares = pairs.map(|(a, b)| (a.translation.vector - b.translation.vector).norm_squared());
        (squares.sum::<f64>() / self.world_from_robot.len() as f64).sqrt()
    }

    /// Angle between estimated and true orientation of each object that has one, radians.
    pub fn orientation_errors(&self, estimate: &Estimate) -> Vec<f64> {
        estimate
            .objects
            .iter()
            .zip(&self.world_from_object)
            .filter_map(|(object, truth)| {
                Some(object.as_ref()?.orientation?.world_from_object.angle_to(&truth.rotation))
            })
            .collect()
    }
}

/// How a box lies off its object that is seen from `direction`, box sides.
fn box_offset(spec: &WorldSpec, track: usize, seed: Seed, direction: &Vector3<f64>) -> Vector2<f64> {
    let Some(offset) = spec.bearing_offset else { return Vector2::zeros() };
    let mut stream = seed.stream("offset", track as u64);
    let coefficients = nalgebra::DVector::from_fn(OffsetBearingFactor::dim(&offset), |_, _| stream.normal());
    let distance = direction.xy().norm();
    let (phi, _) = offset.harmonics().at([direction.x / distance, direction.y / distance]);
    let along = |first| phi.dot(&coefficients.rows(first, phi.len()));
    Vector2::new(offset.horizontal * along(0), offset.vertical * along(phi.len()))
}

/// A camera 0.5 m up, pitched down a little, that looks to the robot's left (into the loop) or right.
fn mount(inward: bool) -> Pose {
    let side = if inward { 1.0 } else { -1.0 };
    let axes = Matrix3::from_columns(&[Vector3::x() * side, -Vector3::z(), Vector3::y() * side]);
    let looking = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let pitch = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -0.1);
    Pose::from_parts(Translation3::new(0.1, 0.0, 0.5), looking * pitch)
}
