//! Semantic factors: an accurate model helps, one without information changes nothing, bad crops are dropped.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::DVector;
use vantage_dataset::{Seed, se3};
use vantage_slam::{Outcome, Settings};

#[test]
fn an_accurate_model_lowers_ate_against_geometric() {
    let model = TanhModel::new([8, 12, 32], 0.03, f64::INFINITY, Seed(1));
    let spec = WorldSpec::sparse_loop();
    let settings = matching_settings(&spec);
    let mut differences = Vec::new();
    let (mut geometric, mut semantic) = (0.0, 0.0);
    let mut orientation = Vec::new();
    for seed in 0..20 {
        let world = World::new(&spec, Some(&model), Seed(seed));
        let of = |which| estimate(&world.observations, which, Some(&model), &settings).unwrap();
        let (a, b) = (of(Which::Geometric), of(Which::Semantic));
        assert_eq!(b.outcome, Outcome::Converged, "seed {seed}");
        orientation.extend(world.orientation_errors(&b).iter().map(|e| e.to_degrees()));
        let (a, b) = (world.ate(&a), world.ate(&b));
        println!("seed {seed}: geometric {a:.4} m, viewpoint-dependent {b:.4} m");
        differences.push(b - a);
        geometric += a / 20.0;
        semantic += b / 20.0;
    }
    orientation.sort_by(f64::total_cmp);
    let mean = differences.iter().sum::<f64>() / 20.0;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 19.0;
    let half = 2.093 * (variance / 20.0).sqrt();
    println!(
        "mean ATE: geometric {geometric:.4}, viewpoint-dependent {semantic:.4}; paired difference {mean:.4} +- {half:.4} (95%); \
         orientation error median {:.2} deg, worst {:.1} deg of {}",
        orientation[orientation.len() / 2],
        orientation[orientation.len() - 1],
        orientation.len()
    );
    assert!(mean + half < 0.0);
    assert!(orientation[orientation.len() / 2] < 5.0);
}

#[test]
fn without_information_it_equals_geometric_to_rounding() {
    let model = TanhModel::new([8, 12, 32], 0.03, 5.0, Seed(1));
    let spec = WorldSpec::sparse_loop();
    for settings in [matching_settings(&spec), Settings::default()] {
        let world = World::new(&spec, Some(&model), Seed(8));
        let of = |which| estimate(&world.observations, which, Some(&model), &settings).unwrap();
        let (geometric, control) = (of(Which::Geometric), of(Which::Uninformative));
        assert_eq!(control.outcome, Outcome::Converged);
        for (a, b) in geometric.world_from_robot.iter().zip(&control.world_from_robot) {
            assert!(se3::log(&a.inv_mul(b)).norm() < 1e-9);
        }
        for (a, b) in geometric.objects.iter().zip(&control.objects) {
            let (a, b) = (a.as_ref().unwrap(), b.as_ref().unwrap());
            assert!((a.position - b.position).norm() < 1e-9);
            assert!(b.semantic_views > 0 && b.orientation.is_some());
            let latent = b.latent.as_ref().unwrap();
            assert!(
                latent.mean.norm() < 1e-9 && (&latent.variance - DVector::from_element(8, 1.0)).amax() < 1e-9
            );
            let (a, b) = (a.position_covariance.unwrap(), b.position_covariance.unwrap());
            assert!((a - b).amax() < 1e-9 * a.amax());
        }
        let (a, b) = (geometric.pose_covariances.unwrap(), control.pose_covariances.unwrap());
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).amax() < 1e-9 * a.amax());
        }
    }
}

#[test]
fn crops_the_model_cannot_measure_are_dropped_and_counted() {
    let model = TanhModel::new([8, 12, 32], 0.03, 5.0, Seed(1));
    let spec = WorldSpec::sparse_loop();
    let mut world = World::new(&spec, Some(&model), Seed(8));
    let of = |world: &World, which| {
        estimate(&world.observations, which, Some(&model), &matching_settings(&spec)).unwrap()
    };
    let before = of(&world, Which::Semantic);
    assert_eq!(before.dropped_detections.non_finite, 0);
    let whole = |i: &usize| {
        let camera = world.observations.camera;
        !world.observations.detections[*i].bounding_box.is_truncated(&camera)
    };
    let spoilt: Vec<usize> = (0..world.observations.detections.len()).filter(whole).step_by(7).collect();
    for &index in &spoilt {
        let nan = TanhModel::crop(&DVector::from_element(12, f64::NAN));
        world.observations.detections[index].masked_crop = nan;
    }
    for which in [Which::Semantic, Which::Uninformative] {
        let after = of(&world, which);
        assert_eq!(after.dropped_detections.non_finite, spoilt.len());
        assert!(after.world_from_robot.iter().all(|p| p.translation.vector.norm().is_finite()));
        let views = |e: &vantage_slam::Estimate| -> usize {
            e.objects.iter().flatten().map(|o| o.semantic_views).sum()
        };
        assert_eq!(views(&before) - views(&after), spoilt.len());
    }
    for detection in &mut world.observations.detections {
        detection.masked_crop = TanhModel::crop(&DVector::from_element(12, f64::INFINITY));
    }
    let none = of(&world, Which::Semantic);
    let geometric = of(&world, Which::Geometric);
    assert_eq!(none.world_from_robot, geometric.world_from_robot);
    assert!(none.objects.iter().flatten().all(|o| o.orientation.is_none() && o.latent.is_none()));
}

#[test]
fn view_separation_thins_and_tempering_widens() {
    let model = TanhModel::new([8, 12, 32], 0.03, f64::INFINITY, Seed(1));
    let spec = WorldSpec::sparse_loop();
    let world = World::new(&spec, Some(&model), Seed(8));
    let with = |changed: &dyn Fn(&mut Settings)| {
        let mut settings = matching_settings(&spec);
        changed(&mut settings);
        estimate(&world.observations, Which::Semantic, Some(&model), &settings).unwrap()
    };
    let all = with(&|_| ());
    let thinned = with(&|settings| settings.semantics.minimum_view_separation = 0.3);
    assert!(thinned.dropped_detections.redundant_viewpoint > 0);
    let views =
        |e: &vantage_slam::Estimate| -> usize { e.objects.iter().flatten().map(|o| o.semantic_views).sum() };
    assert_eq!(views(&all), views(&thinned) + thinned.dropped_detections.redundant_viewpoint);

    let tempered = with(&|settings| settings.semantics.information_scale = 0.1);
    let volume = |e: &vantage_slam::Estimate| e.pose_covariances.as_ref().unwrap().last().unwrap().trace();
    assert!(volume(&tempered) > volume(&all));
}

#[test]
fn the_same_direction_a_lap_later_is_not_redundant() {
    let model = TanhModel::new([8, 12, 32], 0.03, f64::INFINITY, Seed(1));
    let views = |laps: usize| -> usize {
        let spec = WorldSpec { steps: 1 + 40 * laps, laps: laps as f64, ..WorldSpec::sparse_loop() };
        let world = World::new(&spec, Some(&model), Seed(8));
        let mut settings = matching_settings(&spec);
        settings.semantics.minimum_view_separation = 0.2;
        let answer = estimate(&world.observations, Which::Semantic, Some(&model), &settings).unwrap();
        assert!(answer.dropped_detections.redundant_viewpoint > 0);
        answer.objects.iter().flatten().map(|object| object.semantic_views).sum()
    };
    assert!(2 * views(2) > 3 * views(1));
}
