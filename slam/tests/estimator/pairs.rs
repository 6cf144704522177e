//! Factors of two views (Eq. 15): against single views with the latent integrated out, and in the estimator.

use crate::consistency::{interval, nees_of_pose};
use crate::linear::dense;
use crate::model::TanhModel;
use crate::sensors::show;
use crate::steerable::Steerable;
use crate::world::{World, WorldSpec, matching_settings};
use approx::assert_relative_eq;
use nalgebra::{DVector, Point3, Vector3};
use vantage_dataset::{Pose, Seed, Stream, Tangent, Viewpoint, se3};
use vantage_model::{FirstView, MeasurementNoise, ObservationModel, PairModel};
use vantage_slam::factor::semantic::SemanticScaling;
use vantage_slam::factor::{PairFactor, SemanticFactor, StandardNormalPrior, UprightFactor};
use vantage_slam::graph::Graph;
use vantage_slam::noisy_first::NoisyFirst;
use vantage_slam::variable::{Value, Values};
use vantage_slam::{Estimate, Estimator, Geometric, Key, Outcome, Pairing, Semantic, ViewpointPairs};

const SIZE: f64 = 0.4;
const SCALING: SemanticScaling = SemanticScaling { noise: 1.0, information: 1.0 };

/// Two robots that look at an object's centre, and not quite at it.
fn two_views(mount: &Pose, stream: &mut Stream) -> Values {
    let mut values = Values::default();
    let center = Vector3::from_fn(|_, _| stream.normal());
    values.insert(Key::Object(0), Value::Point(center));
    for step in 0..2 {
        let (s, c) = stream.uniform(-3.0, 3.0).sin_cos();
        let eye = center + Vector3::new(c, s, stream.uniform(-0.4, 0.8)) * stream.uniform(1.0, 3.0);
        let looking = Pose::face_towards(&Point3::from(eye), &Point3::from(center), &-Vector3::z());
        let off = se3::exp(&Tangent::from_fn(|_, _| 0.1 * stream.normal()));
        values.insert(Key::Robot(step), Value::Pose(looking * off * mount.inverse()));
    }
    values
}

/// The negative log-posterior at the most probable latent, its gradient by the other variables, and the log-determinant of the latent's
/// information.
fn without_latent(graph: &Graph<'_>, values: &Values) -> (f64, DVector<f64>, f64) {
    let latent = Key::Latent(0);
    let dim = values.vector(latent).unwrap().len();
    let (hessian, gradient, first) = dense(graph, values);
    let at = first[&latent];
    let information = hessian.view((at, at), (dim, dim)).into_owned().cholesky().unwrap();
    let mut moved = values.clone();
    moved.retract(latent, (-information.solve(&gradient.rows(at, dim).into_owned())).as_slice());
    let (_, gradient, _) = dense(graph, &moved);
    assert_eq!(at + dim, gradient.len(), "the latent comes last");
    let log_determinant = information.determinant().ln();
    (graph.cost(&moved).unwrap(), gradient.rows(0, at).into_owned(), log_determinant)
}

fn log_determinant(noise: &MeasurementNoise) -> f64 {
    noise.sqrt_information().determinant().abs().ln()
}

#[test]
fn a_pair_of_views_tells_what_two_single_ones_do_without_their_latent() {
    let (all, pairs) = (Steerable::of_all(Seed(1)), Steerable::of_pairs(Seed(1)));
    let mut stream = Seed(1).stream("pairs", 0);
    let mut furthest: f64 = 0.0;
    for _ in 0..20 {
        let mount = se3::exp(&Tangent::from_fn(|i, _| if i < 3 { 0.5 } else { 0.2 } * stream.normal()));
        let mut values = two_views(&mount, &mut stream);
        let measured = [0; 2].map(|_| DVector::from_fn(4, |_, _| 2.0 * stream.normal()));
        let keys = |step| [Key::Robot(step), Key::Object(0), Key::Latent(0)];

        let mut singles = Graph::default();
        singles.push(StandardNormalPrior::new(Key::Latent(0)));
        for (step, measurement) in measured.iter().enumerate() {
            singles.push(SemanticFactor::new(keys(step), &all, measurement.clone(), mount, SIZE, SCALING));
        }
        let mut pair = Graph::default();
        pair.push(StandardNormalPrior::new(Key::Latent(0)));
        pair.push(SemanticFactor::new(keys(0), &pairs, measured[0].clone(), mount, SIZE, SCALING));
        let joined = [Key::Robot(0), Key::Robot(1), Key::Object(0), Key::Latent(0)];
        pair.push(PairFactor::new(joined, &pairs, measured.clone(), mount, SIZE, SCALING));

        // Gradients that are the same all about have the same derivatives.
        for _ in 0..5 {
            let mut of = |graph: &Graph<'_>, model: &Steerable| {
                values.insert(Key::Latent(0), Value::Vector(DVector::zeros(model.latent_dim())));
                without_latent(graph, &values)
            };
            let (cost, gradient, information) = of(&singles, &all);
            let (pair_cost, pair_gradient, pair_information) = of(&pair, &pairs);
            assert_relative_eq!(pair_cost, cost, epsilon = 1e-9, max_relative = 1e-9);
            assert_relative_eq!(pair_gradient, gradient, epsilon = 1e-9 * (1.0 + gradient.amax()));
            let evidence = cost + information / 2.0 - 2.0 * log_determinant(all.noise());
            let whitened = log_determinant(pairs.noise()) + log_determinant(pairs.pair_noise());
            let pair_evidence = pair_cost + pair_information / 2.0 - whitened;
            assert_relative_eq!(pair_evidence, evidence, epsilon = 1e-9, max_relative = 1e-9);
            furthest = furthest.max(gradient.amax());
            for key in [Key::Robot(0), Key::Robot(1), Key::Object(0)] {
                let step: Vec<f64> = (0..6).map(|_| 0.02 * stream.normal()).collect();
                let dim = values.get(key).unwrap().dim();
                values.retract(key, &step[..dim]);
            }
        }
    }
    assert!(furthest > 1.0, "the poses should be far from the best");
}

#[test]
fn a_first_view_with_noise_of_its_own_has_all_of_it_alone_and_its_pairs_the_derivatives_of_differences() {
    let pairs = Steerable::of_pairs(Seed(1));
    let noisy = NoisyFirst::new(&pairs, 0.4, 1.0).unwrap();
    let mut stream = Seed(2).stream("noisy", 0);
    let mount = Pose::identity();
    let mut values = two_views(&mount, &mut stream);
    let first = DVector::from_fn(4, |_, _| stream.normal());
    let keys = [Key::Robot(0), Key::Object(0), Key::Latent(0)];
    let mut evidence = |model: &dyn PairModel| {
        let mut alone = Graph::default();
        alone.push(StandardNormalPrior::new(Key::Latent(0)));
        alone.push(SemanticFactor::new(keys, model, first.clone(), mount, SIZE, SCALING));
        values.insert(Key::Latent(0), Value::Vector(DVector::zeros(model.latent_dim())));
        let (cost, _, information) = without_latent(&alone, &values);
        cost + information / 2.0 - log_determinant(model.noise())
    };
    assert_relative_eq!(evidence(&noisy), evidence(&pairs), max_relative = 1e-9);

    let viewpoints = [0, 1].map(|step| {
        let center = values.get(Key::Object(0)).unwrap().position().unwrap();
        let world_from_object = Pose::from_parts(center.into(), Default::default());
        Viewpoint::new(&world_from_object.inv_mul(values.pose(Key::Robot(step)).unwrap()), SIZE).unwrap()
    });
    let given = FirstView { measurement: &first, viewpoint: &viewpoints[0] };
    let latent = DVector::from_fn(noisy.latent_dim(), |_, _| stream.normal());
    let near = noisy.linearize_pair(&latent, given, &viewpoints[1]).unwrap();
    for column in 0..latent.len() {
        let by = |step: f64| {
            let mut moved = latent.clone();
            moved[column] += step;
            noisy.predict_pair(&moved, given, &viewpoints[1]).unwrap()
        };
        let differences = (by(1e-5) - by(-1e-5)) / 2e-5;
        assert_relative_eq!(near.d_latent.column(column).into_owned(), differences, epsilon = 1e-8);
    }
}

/// A world whose crops are those of [`Steerable`] objects.
fn world(seed: Seed) -> World {
    let all = Steerable::of_all(Seed(1));
    let mut world = World::new(&WorldSpec::sparse_loop(), None, seed);
    let mut noise = seed.stream("steerable noise", 0);
    show(&mut world, |_, track, viewpoint| {
        let mut stream = seed.stream("steerable latent", track as u64);
        let latent = DVector::from_fn(all.latent_dim(), |_, _| stream.normal());
        let white = DVector::from_fn(4, |_, _| noise.normal());
        let root = all.noise().sqrt_information().clone().try_inverse().unwrap();
        all.predict(&latent, viewpoint).unwrap() + root * white
    });
    world
}

#[test]
fn where_views_share_what_no_latent_tells_pairs_are_better_than_single_ones_and_tell_latents_without_orientations()
 {
    let pairs = Steerable::of_pairs(Seed(1));
    let settings = matching_settings(&WorldSpec::sparse_loop());
    let [mut geometric, mut single, mut paired] = [0.0; 3];
    let mut nees = 0.0;
    for seed in 0..16 {
        let world = world(Seed(seed));
        let of = |estimator: &dyn Estimator| estimator.estimate(&world.observations).unwrap();
        let estimate = of(&ViewpointPairs::new(&settings, &pairs));
        assert_eq!(estimate.outcome, Outcome::Converged, "seed {seed}");
        for object in estimate.objects.iter().flatten() {
            assert!(object.orientation.is_none() && object.semantic_views > 1);
            assert_eq!(object.latent.as_ref().unwrap().mean.len(), pairs.latent_dim());
        }
        geometric += world.ate(&of(&Geometric::new(&settings))) / 16.0;
        single += world.ate(&of(&Semantic::new(&settings, &pairs))) / 16.0;
        paired += world.ate(&estimate) / 16.0;
        nees += nees_of_pose(&world, &estimate, 40) / 16.0;
    }
    println!("mean ATE: geometric {geometric:.4}, single views {single:.4}, pairs {paired:.4}");
    assert!(paired < 0.95 * geometric.min(single), "{paired} of {geometric} and {single}");
    let bounds = interval(6.0 * 16.0);
    assert!(bounds.0 < nees && nees < bounds.1, "NEES per dimension {nees} in {bounds:?}");
}

/// The prior of a latent that turns with its object is the same at all yaws.
#[test]
fn a_yaw_that_no_view_tells_may_be_held_and_poses_stay_as_they_are() {
    let all = Steerable::of_all(Seed(1));
    for seed in 0..4 {
        let world = world(Seed(seed));
        let by = |yaw_sigma: f64| {
            let mut settings = matching_settings(&WorldSpec::sparse_loop());
            settings.semantics.yaw_sigma = yaw_sigma;
            settings.orientation.yaw_candidates = 1;
            settings.solver.tolerance = 1e-10;
            Semantic::new(&settings, &all).estimate(&world.observations).unwrap()
        };
        let (free, held) = (by(UprightFactor::FREE_YAW), by(0.05));
        let yaws = |of: &Estimate| -> Vec<f64> {
            let turns = of.objects.iter().flatten().filter_map(|object| object.orientation.as_ref());
            turns.map(|turn| turn.covariance.unwrap()[(2, 2)].sqrt()).collect()
        };
        assert!(yaws(&held).iter().all(|sigma| (sigma / 0.05 - 1.0).abs() < 0.1), "{:?}", yaws(&held));
        assert!(yaws(&free).iter().all(|&sigma| sigma > 0.1), "{:?}", yaws(&free));
        let of_free = free.world_from_robot.iter().zip(free.pose_covariances.as_ref().unwrap());
        let of_held = held.world_from_robot.iter().zip(held.pose_covariances.as_ref().unwrap());
        for ((pose, covariance), (again, other)) in of_free.zip(of_held).skip(1) {
            let apart = se3::log(&pose.inv_mul(again));
            for i in 0..6 {
                assert!(apart[i].abs() < 1e-2 * covariance[(i, i)].sqrt(), "seed {seed}: {apart}");
                assert_relative_eq!(other[(i, i)], covariance[(i, i)], max_relative = 0.05);
            }
        }
    }
}

#[test]
fn crops_without_finite_numbers_are_dropped_and_without_any_left_it_is_geometric() {
    let pairs = Steerable::of_pairs(Seed(1));
    let settings = matching_settings(&WorldSpec::sparse_loop());
    let mut world = world(Seed(3));
    let nan = TanhModel::crop(&DVector::from_element(4, f64::NAN));
    world.observations.detections[4].masked_crop = nan.clone();
    let of = |world: &World| ViewpointPairs::new(&settings, &pairs).estimate(&world.observations).unwrap();
    assert_eq!(of(&world).dropped_detections.non_finite, 1);
    world.observations.detections.iter_mut().for_each(|detection| detection.masked_crop = nan.clone());
    let none = of(&world);
    let geometric = Geometric::new(&settings).estimate(&world.observations).unwrap();
    assert_eq!(none.world_from_robot, geometric.world_from_robot);
    assert!(none.objects.iter().flatten().all(|object| object.latent.is_none()));
}

#[test]
fn no_share_of_noise_is_a_star_and_all_of_it_is_refused() {
    let pairs = Steerable::of_pairs(Seed(1));
    let settings = matching_settings(&WorldSpec::sparse_loop());
    let world = world(Seed(3));
    let by = |pairing| ViewpointPairs::new(&settings, &pairs).paired(pairing).estimate(&world.observations);
    let (star, none) = (by(Pairing::Star).unwrap(), by(Pairing::NoisyStar(0.0)).unwrap());
    let apart = star.world_from_robot.iter().zip(&none.world_from_robot);
    assert!(apart.into_iter().all(|(a, b)| se3::log(&a.inv_mul(b)).norm() < 1e-6));
    for of in [1.0, 2.0, -0.1, f64::NAN] {
        assert!(by(Pairing::NoisyStar(of)).is_err(), "{of}");
    }
    for pairing in [Pairing::NoisyStar(0.5), Pairing::Chain, Pairing::Neighbours, Pairing::Halves] {
        let estimate = by(pairing).unwrap();
        assert_eq!(estimate.outcome, Outcome::Converged, "{pairing:?}");
        assert!(estimate.world_from_robot != star.world_from_robot, "{pairing:?}");
    }
}

#[test]
fn noise_that_does_not_fit_the_measurement_is_refused() {
    let model = Steerable::of_pairs(Seed(1)).with_noise_of_a_pair_too_many();
    let settings = matching_settings(&WorldSpec::sparse_loop());
    let told = ViewpointPairs::new(&settings, &model).estimate(&world(Seed(3)).observations).unwrap_err();
    assert!(told.to_string().contains("got 6 numbers, expected 4"), "{told}");
}
