//! What each objective trains, and what it may read.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

#[expect(dead_code, reason = "other tests use the rest")]
mod support;

use nalgebra::{DVector, Point3, Vector3};
use std::path::Path;
use support::{tiny_spec, trained, training_views, validation_views};
use vantage_dataset::sighting::DIAMETER_PER_BOX;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Pose, Sighting, Split, ViewSet, Viewpoint};
use vantage_learn::{
    CURVE_TABLE, ClassSpec, Frames, InstanceTerm, Kind, Model, Motion, Objective, Pairs, PredictiveSpec,
    Progress, Stage, TrainError, TrainingSpec, TrunkTarget,
};
use vantage_model::{FirstView, LatentGaussian};

/// The same views in two sessions of a robot whose odometry is right but for a heading of its own; the objects are 1 metre
/// large.
fn toured(mut set: ViewSet) -> ViewSet {
    for (index, view) in set.views.iter_mut().enumerate() {
        view.session = index % 2;
        let distance = view.viewpoint.log_distance.exp();
        let seen = view.viewpoint.turned(0.7 + view.session as f64);
        let eye = Point3::from(seen.direction * distance);
        let looking = Pose::face_towards(&eye, &Point3::origin(), &-Vector3::z());
        let camera = looking * Pose::rotation(Vector3::z() * -seen.roll);
        let angular_size = 1.0 / DIAMETER_PER_BOX / distance;
        view.sighting =
            Some(Sighting { step: index, session_from_camera: camera, ray: [0.0; 2], angular_size });
    }
    set
}

fn trained_on(set: &ViewSet, spec: &TrainingSpec, folder: &Path) -> Result<Vec<Progress>, TrainError> {
    trained([set, &toured(validation_views())], spec, folder, None, |_| false)
}

fn curve(set: &ViewSet, spec: &TrainingSpec) -> String {
    let folder = tempfile::tempdir().unwrap();
    trained_on(set, spec, folder.path()).unwrap();
    std::fs::read_to_string(folder.path().join(CURVE_TABLE)).unwrap()
}

/// Numbers of the tiny spec's latent that do not turn.
const STEADY: usize = 10;

fn predictive(predictive: PredictiveSpec) -> TrainingSpec {
    TrainingSpec { objective: Objective::ViewpointPredictive, predictive, ..tiny_spec() }
}

#[test]
fn every_objective_leaves_a_model_of_its_kind_that_runs() {
    let camera = PredictiveSpec { motion: Motion::Camera, ..PredictiveSpec::default() };
    let adjacent = PredictiveSpec { pairs: Pairs::Adjacent, source: 0.0, ..PredictiveSpec::default() };
    let single = TrainingSpec { views: 1, context: 1, instance_weight: 0.0, ..tiny_spec() };
    let likelihood =
        TrainingSpec { instance_term: InstanceTerm::Likelihood, instance_weight: 1.0, ..tiny_spec() };
    let augmented = TrainingSpec { trunk_augmentation: 0.5, ..tiny_spec() };
    let rival = |objective| TrainingSpec { objective, ..tiny_spec() };
    let framed = |objective, frames| TrainingSpec { frames, ..rival(objective) };
    let set = toured(training_views());
    for (spec, kind, viewing, steady) in [
        (TrainingSpec { pairs_per_harmonic: 0, ..tiny_spec() }, Kind::ViewpointDependent, true, 30),
        (single, Kind::ViewpointDependent, true, STEADY),
        (augmented, Kind::ViewpointDependent, true, STEADY),
        (likelihood, Kind::ViewpointDependent, true, STEADY),
        (predictive(PredictiveSpec::default()), Kind::ViewpointPredictive, true, STEADY),
        (predictive(adjacent), Kind::ViewpointPredictive, true, STEADY),
        (predictive(camera), Kind::ViewpointPredictive, false, 30),
        (rival(Objective::DiscreteClass), Kind::ViewpointDependent, true, 30),
        (rival(Objective::Autoencoder), Kind::Embedding, false, 30),
        (rival(Objective::Contrastive), Kind::Embedding, false, 30),
        (framed(Objective::ViewpointDependent, Frames::Random), Kind::ViewpointDependent, true, STEADY),
        (framed(Objective::ViewpointDependent, Frames::None), Kind::ViewpointDependent, true, STEADY),
        (framed(Objective::DiscreteClass, Frames::Random), Kind::ViewpointDependent, true, 30),
        (framed(Objective::DiscreteClass, Frames::None), Kind::ViewpointDependent, true, 30),
    ] {
        let folder = tempfile::tempdir().unwrap();
        trained_on(&set, &spec, folder.path()).unwrap();
        let model = Model::load(folder.path()).unwrap();
        assert_eq!(model.manifest().kind, kind, "{spec:?}");
        assert_eq!((model.viewing().is_some(), spec.is_viewing()), (viewing, viewing), "{spec:?}");
        let view = &set.views[0];
        let embedded = model.embed(&view.crop, Some(&view.viewpoint)).unwrap();
        assert_eq!(embedded.len(), steady, "{spec:?}");
        assert!(embedded.iter().all(|number| number.is_finite()) && embedded.iter().any(|n| n.abs() > 1e-6));
    }
}

#[test]
fn a_predictive_model_as_one_of_looks_turns_with_the_object() {
    let set = toured(training_views());
    let folder = tempfile::tempdir().unwrap();
    trained_on(&set, &predictive(PredictiveSpec::default()), folder.path()).unwrap();
    let model = Model::load(folder.path()).unwrap();
    let viewing = model.viewing().unwrap();
    let view = &set.views[0];
    let one = viewing.encode(&view.crop, &view.viewpoint).unwrap();
    let turned = viewing.encode(&view.crop, &view.viewpoint.turned(1.1)).unwrap();
    assert!((&one.mean - &turned.mean).norm() > 1e-3);
    let ahead = viewing.predict(&one.mean, &view.viewpoint.turned(0.4)).unwrap();
    let same = viewing.predict(&turned.mean, &view.viewpoint.turned(1.5)).unwrap();
    assert!((&ahead - &same).norm() < 1e-4 * (1.0 + ahead.norm()), "{ahead} {same}");
    let still = viewing.predict(&one.mean, &view.viewpoint).unwrap();
    assert!((ahead - &still).norm() > 1e-3);

    let at = viewing.linearize(&one.mean, &view.viewpoint).unwrap();
    assert!((&at.mean - &still).norm() < 1e-4);
    let step = 1e-2;
    let after = |angle: f64| viewing.predict(&one.mean, &view.viewpoint.turned(angle)).unwrap();
    let by_azimuth = at.d_viewpoint.by_azimuth(&view.viewpoint);
    let differences = (after(step) - after(-step)) / (2.0 * step);
    assert!(
        (&by_azimuth - &differences).norm() < 2e-2 * (0.1 + differences.norm()),
        "{by_azimuth} {differences}"
    );
    let direction = DVector::from_fn(one.mean.len(), |i, _| libm::cos(i as f64));
    let moved = |by: f64| viewing.predict(&(&one.mean + &direction * by), &view.viewpoint).unwrap();
    let differences = (moved(step) - moved(-step)) / (2.0 * step);
    let by_latent = at.d_latent * direction;
    assert!(
        (&by_latent - &differences).norm() < 2e-2 * (0.1 + differences.norm()),
        "{by_latent} {differences}"
    );
}

#[test]
fn a_predictive_model_as_one_of_pairs_turns_with_the_object_and_has_the_derivatives_of_differences() {
    let set = toured(training_views());
    let folder = tempfile::tempdir().unwrap();
    trained_on(&set, &predictive(PredictiveSpec::default()), folder.path()).unwrap();
    let model = Model::load(folder.path()).unwrap();
    let pairs = model.pairs().unwrap();
    let (view, second) = (&set.views[0], set.views[1].viewpoint.turned(0.4));
    let latent = pairs.encode(&view.crop, &view.viewpoint).unwrap().mean;
    let measurement = pairs.measure(&view.crop).unwrap();
    let predicted = |latent: &DVector<f64>, measurement: &DVector<f64>, first, second| {
        pairs.predict_pair(latent, FirstView { measurement, viewpoint: &first }, &second).unwrap()
    };
    let here = predicted(&latent, &measurement, view.viewpoint, second);
    let alone = pairs.predict(&latent, &second).unwrap();
    assert!((&here - alone).norm() > 1e-4, "the first view tells nothing");
    let turned = model.manifest().latent.steerable.unwrap().turned(&latent, 1.1);
    let same = predicted(&turned, &measurement, view.viewpoint.turned(1.1), second.turned(1.1));
    assert!((&here - &same).norm() < 1e-4 * (1.0 + here.norm()), "{here} {same}");

    let first = FirstView { measurement: &measurement, viewpoint: &view.viewpoint };
    let at = pairs.linearize_pair(&latent, first, &second).unwrap();
    assert!((&at.mean - &here).norm() < 1e-4);
    let along = |dimension: usize| DVector::from_fn(dimension, |i, _| libm::cos(i as f64));
    let (of_latent, of_measurement) = (along(latent.len()), along(measurement.len()));
    let lifted = |viewpoint: Viewpoint, by: f64| Viewpoint {
        roll: viewpoint.roll + by,
        log_distance: viewpoint.log_distance + by,
        ..viewpoint
    };
    let by_lift = |viewpoint: &Viewpoint| {
        let mut by = DVector::zeros(CONDITIONING);
        let (s, c) = libm::sincos(viewpoint.roll);
        by.rows_mut(CONDITIONING - 3, 3).copy_from_slice(&[-s, c, 1.0]);
        by
    };
    let (m, x) = (&measurement, view.viewpoint);
    type Moved<'a> = &'a dyn Fn(f64) -> DVector<f64>;
    let checked: [(&str, DVector<f64>, Moved); 6] = [
        ("latent", &at.d_latent * &of_latent, &|by| predicted(&(&latent + &of_latent * by), m, x, second)),
        ("measurement", &at.d_first_measurement * &of_measurement, &|by| {
            predicted(&latent, &(m + &of_measurement * by), x, second)
        }),
        ("first azimuth", at.d_first_viewpoint.by_azimuth(&x), &|by| {
            predicted(&latent, m, x.turned(by), second)
        }),
        ("second azimuth", at.d_second_viewpoint.by_azimuth(&second), &|by| {
            predicted(&latent, m, x, second.turned(by))
        }),
        ("first upright", at.d_first_viewpoint.by_coordinates() * by_lift(&x), &|by| {
            predicted(&latent, m, lifted(x, by), second)
        }),
        ("second upright", at.d_second_viewpoint.by_coordinates() * by_lift(&second), &|by| {
            predicted(&latent, m, x, lifted(second, by))
        }),
    ];
    for (what, exact, moved) in checked {
        let differences = (moved(1e-2) - moved(-1e-2)) / 2e-2;
        let off = (&exact - &differences).norm();
        assert!(off < 2e-2 * (0.1 + differences.norm()), "{what}: {exact} {differences}");
    }
}

#[test]
fn the_predictive_model_reads_odometry_and_nothing_true() {
    let set = toured(training_views());
    let mut lied_to = set.clone();
    for (index, view) in lied_to.views.iter_mut().enumerate() {
        view.viewpoint = view.viewpoint.turned(index as f64);
        view.viewpoint.log_distance += 0.3;
    }
    let spec = predictive(PredictiveSpec::default());
    for spec in [TrainingSpec { trunk_instance_weight: 1.0, ..spec.clone() }, spec.clone()] {
        assert!(curve(&set, &spec) == curve(&lied_to, &spec));
    }
    for frames in [Frames::Random, Frames::None] {
        assert!(curve(&set, &spec) == curve(&set, &TrainingSpec { frames, ..spec.clone() }));
    }
    let told = predictive(PredictiveSpec { motion: Motion::TrueObjectCentred, ..PredictiveSpec::default() });
    assert!(curve(&set, &told) != curve(&lied_to, &told));
}

#[test]
fn an_augmented_trunk_learns_from_other_crops_and_again_from_the_same() {
    let set = training_views();
    let by = |trunk_augmentation| curve(&set, &TrainingSpec { trunk_augmentation, ..tiny_spec() });
    assert!(by(0.5) == by(0.5));
    assert!(by(0.5) != by(0.0));
    assert!(by(0.0) == curve(&set, &tiny_spec()));
}

#[test]
fn a_predictive_model_may_have_the_trunk_of_one_that_is_told_viewpoints() {
    let set = toured(training_views());
    let trunk = |spec: &TrainingSpec| -> Vec<String> {
        curve(&set, spec).lines().filter(|line| line.starts_with("trunk")).map(str::to_owned).collect()
    };
    let known =
        predictive(PredictiveSpec { trunk: TrunkTarget::TrueViewpoints, ..PredictiveSpec::default() });
    assert!(trunk(&known) == trunk(&tiny_spec()));
    assert!(trunk(&known) != trunk(&predictive(PredictiveSpec::default())));
    let asked = |spec| TrainingSpec { trunk_instance_weight: 1.0, ..spec };
    assert!(trunk(&asked(known)) == trunk(&asked(tiny_spec())));
}

#[test]
fn without_sightings_the_predictive_model_is_refused_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let error =
        trained_on(&training_views(), &predictive(PredictiveSpec::default()), folder.path()).unwrap_err();
    assert!(matches!(error, TrainError::Sighting { split: Split::Train, view: 0 }));
    assert!(error.to_string().contains("views.odometry"), "{error}");
}

#[test]
fn classes_are_read_by_the_class_term_alone() {
    let set = training_views();
    let mut renamed = set.clone();
    for (index, instance) in renamed.instances.iter_mut().enumerate() {
        instance.family = format!("family {}", index % 3);
    }
    assert!(curve(&set, &tiny_spec()) == curve(&renamed, &tiny_spec()));
    let with_class = TrainingSpec { class: Some(ClassSpec { tagged: 0.5, sigma: 1.0 }), ..tiny_spec() };
    assert!(curve(&set, &with_class) != curve(&renamed, &with_class));
    let untagged = TrainingSpec { class: Some(ClassSpec { tagged: 0.0, sigma: 1.0 }), ..tiny_spec() };
    assert!(curve(&set, &untagged) == curve(&renamed, &untagged));
}

#[test]
fn a_discrete_class_is_told_by_several_views_together_and_needs_a_latent_as_large() {
    let mut set = training_views();
    for (index, instance) in set.instances.iter_mut().enumerate() {
        instance.family = format!("family {:02}", index % 12);
    }
    let spec = TrainingSpec { objective: Objective::DiscreteClass, latent_dim: 12, ..tiny_spec() };
    let folder = tempfile::tempdir().unwrap();
    trained_on(&set, &spec, folder.path()).unwrap();
    let model = Model::load(folder.path()).unwrap();
    let viewing = model.viewing().unwrap();
    let factors: Vec<_> =
        set.views[..2].iter().map(|view| viewing.encode(&view.crop, &view.viewpoint).unwrap()).collect();
    let variance = factors[0].variance[0];
    assert!((variance - 4f64.exp()).abs() < 1e-3, "{variance}");
    assert!(factors.iter().all(|factor| (&factor.variance - &factors[0].variance).norm() < 1e-9));
    let together = LatentGaussian::posterior(12, &factors).mean;
    let product = (&factors[0].mean + &factors[1].mean) / (2.0 + variance);
    assert!((together - product).norm() < 1e-6);
    let seen = |latent: f64| {
        let mut latents = vec![0.0; 12];
        latents[3] = latent;
        viewing.predict(&latents.into(), &set.views[0].viewpoint).unwrap()
    };
    assert!((seen(1.0) - seen(9.0)).norm() < 1e-5, "certain is certain");
    assert!((seen(1.0) - seen(-1.0)).norm() > 1e-3);

    let small = TrainingSpec { latent_dim: 11, ..spec };
    let error = trained_on(&set, &small, tempfile::tempdir().unwrap().path()).unwrap_err();
    assert!(matches!(error, TrainError::Classes { got: 12, latent: 11 }), "{error}");
}

#[test]
fn a_trunk_learns_instances_beside_viewpoints_where_it_is_asked_to() {
    let asked = |spec| TrainingSpec { trunk_instance_weight: 1.0, trunk_steps: 160, ..spec };
    let (set, validation) = (toured(training_views()), toured(validation_views()));
    let views = [&set, &validation];
    let curve = |spec: &TrainingSpec| {
        let folder = tempfile::tempdir().unwrap();
        trained(views, spec, folder.path(), None, |_| false).unwrap();
        Model::load(folder.path()).unwrap();
        std::fs::read_to_string(folder.path().join(CURVE_TABLE)).unwrap()
    };
    let spec = asked(tiny_spec());
    let of_dependent = curve(&spec);
    let camera = PredictiveSpec { motion: Motion::Camera, ..PredictiveSpec::default() };
    let others = [predictive(PredictiveSpec::default()), predictive(camera)].map(|spec| curve(&asked(spec)));
    for table in others.iter().chain([&of_dependent]) {
        for (term, most) in [("instance", 0.8), ("azimuth", 0.95)] {
            let place = table.lines().next().unwrap().split(',').position(|name| name == term).unwrap();
            let trunk = table.lines().filter(|line| line.starts_with("trunk"));
            let terms: Vec<f64> =
                trunk.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect();
            let mean = |terms: &[f64]| terms.iter().sum::<f64>() / terms.len() as f64;
            let (first, last) = (mean(&terms[..8]), mean(&terms[terms.len() - 8..]));
            assert!(last < most * first, "{term}: {first} {last}");
        }
    }

    let killed = tempfile::tempdir().unwrap();
    let midway = |told: &Progress| matches!(told, Progress::Step { stage: Stage::Trunk, step: 22, .. });
    trained(views, &spec, killed.path(), None, midway).unwrap_err();
    let told = trained(views, &spec, killed.path(), None, |_| false).unwrap();
    assert_eq!(told[0], Progress::Resumed { stage: Stage::Trunk, step: 15 });
    assert!(of_dependent == std::fs::read_to_string(killed.path().join(CURVE_TABLE)).unwrap());
}

#[test]
fn trainings_that_differ_in_stage_two_share_a_trunk_and_no_result_changes() {
    let (set, validation) = (toured(training_views()), toured(validation_views()));
    let trunks = tempfile::tempdir().unwrap();
    let other = TrainingSpec { instance_weight: 0.0, ..tiny_spec() };
    let run = |spec: &TrainingSpec, trunks: Option<&Path>| {
        let folder = tempfile::tempdir().unwrap();
        let told = trained([&set, &validation], spec, folder.path(), trunks, |_| false).unwrap();
        let of_trunk = |told: &&Progress| matches!(told, Progress::Step { stage: Stage::Trunk, .. });
        let trunk_steps = told.iter().filter(of_trunk).count();
        (trunk_steps, std::fs::read_to_string(folder.path().join(CURVE_TABLE)).unwrap())
    };
    assert_eq!(run(&tiny_spec(), Some(trunks.path())).0, tiny_spec().trunk_steps as usize);
    let (steps, shared) = run(&other, Some(trunks.path()));
    assert_eq!(steps, 0);
    assert!(shared == run(&other, None).1);
    let told = predictive(PredictiveSpec { trunk: TrunkTarget::TrueViewpoints, ..PredictiveSpec::default() });
    assert_eq!(run(&told, Some(trunks.path())).0, 0);
    for of_its_own in [
        TrainingSpec { measurement_dim: 7, ..tiny_spec() },
        TrainingSpec { trunk_instance_weight: 1.0, ..tiny_spec() },
    ] {
        assert_eq!(run(&of_its_own, Some(trunks.path())).0, of_its_own.trunk_steps as usize);
    }
}
