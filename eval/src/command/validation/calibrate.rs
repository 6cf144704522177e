//! `bench calibrate SCENE [N]`: the estimator's settings, fitted on validation objects.
//!
//! First what boxes say, over those that the border does not cut. For `estimator.bearing_noise`, the root mean square of
//! the offset of the box centre from the object's centre, whole and in box sides; for `estimator.size_over_box_side`,
//! the median of the object's size over the box side at the object's distance. Then the fit by maximum marginal likelihood of
//! `estimator.bearing_noise` alone, and with `estimator.bearing_offset`; and, for the latter, by how much objects' boxes are off alike from all sides.
//! What each, each `estimator.bearing_kernel`, and no `estimator.odometry_bias`, makes of `geometric`.
//!
//! Then what crops tell of pairs of tracklets, which `--associate` weighs: log losses by the exponents of likenesses, and what comes of what they
//! promise.
//!
//! Then how much more probable validation crops at their true viewpoints are where the model's azimuths are off; that with the covariance of the
//! object's harmonics fitted by expectation maximization, alone and beside one of each visit to it; and, with it, where noise is
//! multiplied by one factor for all objects, or by one of each object's own.
//!
//! Then how much a crop is worth once its neighbours have been counted, by `estimator.semantic_information_scale`, and by a discrepancy of the azimuth in
//! its place, without the objects that the model does not know by an `estimator.unknown_margin`. Likewise of the rows beside a model's that the scene
//! names: `gaussian_process`, whose hyper-parameters of most marginal likelihood are told, `azimuth_head`, `discrete_class` and `viewpoint_pairs`; the last
//! with the discrepancy, too.
//!
//! Then what pairings do, where the model is viewpoint-predictive: how much more probable crops at their true viewpoints are than by the latent alone,
//! and a row of `viewpoint_pairs` by each.
//!
//! Each row has the mean ATE, its paired difference to `geometric`, and the mean normalised estimation error squared over its dimensions (NEES, 1
//! where consistent) of all poses and of the last one; of the centres of objects; and the share of poses inside their region of 95%.

use super::boxes::Boxes;
use super::hyperparameters::hyperparameters;
use super::likeness::likeness_rows;
use super::offset_fit::{OffsetFit, described};
use super::told_evidence::{fitted_discrepancy, print_pairings};
use super::{Trial, columns, estimated, evidence, open, print, trials};
use crate::command::cli::CalibrateArgs;
use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::pipeline::{StageError, chosen_model, embedding, model};
use crate::result::metric::Metric;
use crate::result::statistics::Mean;
use crate::scene_file::row::Row;
use crate::score::consistency::{ObjectGaussian, object_scores, pose_scores};
use crate::score::pairs::{Pairs, PairsError};
use nalgebra::Point3;
use std::io::Write;
use vantage_learn::gaussian_process::Hyperparameters;
use vantage_slam::discrepancy::Discrepant;
use vantage_slam::noise::Kernel;
use vantage_slam::{
    Estimate, EstimateError, Estimator, Geometric, GeometrySettings, ObjectEstimate, OdometryOnly,
    OdometrySettings, Semantic, SemanticSettings, Settings, ViewpointPairs,
};

const SCALES: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.05];
/// `estimator.bearing_kernel`, with names.
const KERNELS: [(&str, Kernel); 5] = [
    ("Huber, 2", Kernel::Huber { threshold: 2.0 }),
    ("Student t, 8", Kernel::StudentT { degrees_of_freedom: 8.0 }),
    ("Student t, 4", Kernel::StudentT { degrees_of_freedom: 4.0 }),
    ("Student t, 2", Kernel::StudentT { degrees_of_freedom: 2.0 }),
    ("Student t, 1", Kernel::StudentT { degrees_of_freedom: 1.0 }),
];
/// `estimator.unknown_margin`, nats.
const MARGINS: [f64; 4] = [100.0, 50.0, 20.0, 0.0];

/// Prints what boxes say, and the ATE by the scale of a crop's information.
pub fn calibrate(args: &CalibrateArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let CalibrateArgs { validation: args, model: named } = args;
    let pipeline = open(args)?;
    let loaded = model(&pipeline, chosen_model(&pipeline, false, named.as_deref())?.as_deref())?;
    let trials = trials(&pipeline, args)?;
    let instances =
        |trial: &Trial| trial.truth.objects.iter().map(|object| object.instance).collect::<Vec<_>>();
    loaded.check_unseen(trials.iter().flat_map(instances))?;

    let mut settings = pipeline.file.estimator.settings();
    settings.solver.covariances = true;
    settings.semantics.azimuth_discrepancy = None;
    settings.semantics.unknown_margin = None;
    let of = |estimator: &dyn Estimator| {
        estimated(&pipeline, &trials, |trial| estimator.estimate(&trial.observations))
    };
    let geometric = of(&Geometric::new(&settings))?;
    let row = |name: &str, answers: &[(Estimate, f64)]| -> Result<Vec<String>, PairsError> {
        let Promised { nees, inside } = promised(answers, &trials)?;
        let ate = columns(&errors(answers), &errors(&geometric));
        let nees = nees.map(|nees| format!("{nees:.2}"));
        let inside = format!("{inside:.3}");
        Ok(std::iter::once(name.to_owned()).chain(ate).chain(nees).chain([inside]).collect())
    };

    let boxes = Boxes::of(&trials);
    let (offset, in_sides) = (boxes.offset(), boxes.offset_in_sides());
    writeln!(stdout, "box centre off by {offset:.5} of the focal length, {in_sides:.4} box sides")?;
    writeln!(stdout, "size over box side: {:.3}", boxes.size_over_side)?;
    let fits = [OffsetFit::white(&boxes.by_object), OffsetFit::smooth(&boxes.by_object)];
    for fit in &fits {
        writeln!(stdout, "{fit}")?;
    }
    let alike = boxes.constant_offset();
    writeln!(stdout, "alike from all sides: {}", described(&alike))?;
    let (fitted, likelihood) = hyperparameters(&trials);
    let Hyperparameters { kappa, signal, noise, degrees_of_freedom } = fitted;
    writeln!(stdout, "gaussian process: log marginal likelihood {likelihood:.0}, kappa {kappa:.4}")?;
    writeln!(stdout, "noise of {degrees_of_freedom} degrees of freedom; standard deviations by component")?;
    let of_component = |(i, (signal, noise)): (usize, (&f64, &f64))| {
        vec![(i + 1).to_string(), format!("{signal:.4}"), format!("{noise:.4}")]
    };
    let of_components = signal.iter().zip(&noise).enumerate().map(of_component).collect();
    print(stdout, &["Component", "Signal", "Noise"], of_components)?;
    writeln!(stdout)?;
    let mut rows = vec![row("odometry", &of(&OdometryOnly::new(&settings))?)?, row("geometric", &geometric)?];
    let geometries = ["noise fitted", "offset fitted"].into_iter().zip(&fits).map(|(name, fit)| {
        (name, GeometrySettings { bearing_noise: fit.noise, bearing_offset: fit.offset, ..settings.geometry })
    });
    let constant = GeometrySettings { bearing_offset: Some(alike), ..settings.geometry };
    let kernels = KERNELS
        .map(|(name, bearing_kernel)| (name, GeometrySettings { bearing_kernel, ..settings.geometry }));
    for (name, geometry) in geometries.chain([("offset constant", constant)]).chain(kernels) {
        rows.push(row(name, &of(&Geometric::new(&Settings { geometry, ..settings }))?)?);
    }
    let odometry = OdometrySettings { bias: None };
    rows.push(row("no bias", &of(&Geometric::new(&Settings { odometry, ..settings }))?)?);
    print(stdout, &head("Row"), rows)?;

    let embedding = embedding(&pipeline)?;
    let (reader, readout) = (loaded.reader(), embedding.readout());
    let [losses, reliability] = likeness_rows(&trials, &geometric, &settings.geometry, &reader, readout)
        .map_err(|error| StageError::from(EstimateError::Model(error)))?;
    writeln!(stdout, "\npairs of tracklets: log loss at even odds, nats")?;
    print(stdout, &["Exponents", "Of one object", "Of one family", "Of two families"], losses)?;
    writeln!(stdout, "\npairs of tracklets, by the default exponents and at the odds that pairs have")?;
    print(stdout, &["Probability of one object", "Pairs", "Promised", "Of one object"], reliability)?;
    writeln!(stdout)?;

    let mut rows = vec![row("geometric", &geometric)?];
    for scale in SCALES {
        settings.semantics.information_scale = scale;
        rows.push(row(&scale.to_string(), &of(&Semantic::new(&settings, loaded.viewing()))?)?);
    }
    let of_crops = |row: &&Row| !Row::DEFAULT.contains(row) && row.is_by_model_alone();
    let rivals = || pipeline.file.estimator.rows.iter().filter(of_crops);
    for &rival in rivals() {
        for scale in SCALES {
            settings.semantics.information_scale = scale;
            let answers = of(&*rival.estimator(&settings, loaded.reader()))?;
            rows.push(row(&format!("{rival} {scale}"), &answers)?);
        }
    }
    settings.semantics =
        SemanticSettings { information_scale: 1.0, minimum_view_separation: 0.0, ..settings.semantics };
    rows.push(row("1, every view", &of(&Semantic::new(&settings, loaded.viewing()))?)?);
    let objects = evidence::TrueViews::of(&trials, loaded.viewing());
    if let Some(fitted) = fitted_discrepancy(&objects, loaded.viewing(), stdout)? {
        settings.semantics.azimuth_discrepancy = Some(fitted);
        rows.push(row("1, with a discrepancy", &of(&Semantic::new(&settings, loaded.viewing()))?)?);
        for margin in MARGINS {
            settings.semantics.unknown_margin = Some(margin);
            let answers = of(&Semantic::new(&settings, loaded.viewing()))?;
            let placed = || answers.iter().flat_map(|(answer, _)| answer.objects.iter().flatten());
            let known = placed().filter(|object| object.orientation.is_some()).count();
            let all = placed().count();
            let name = format!("{margin} nats: {} of {all} unknown", all - known);
            rows.push(row(&name, &answers)?);
        }
        settings.semantics.unknown_margin = None;
        if let Some(pairs) = loaded.reader().pairs {
            print_pairings(&objects, &Discrepant::new(pairs, &fitted), stdout)?;
            for (name, pairing) in evidence::PAIRINGS {
                let answers = of(&ViewpointPairs::new(&settings, pairs).paired(pairing))?;
                rows.push(row(&format!("pairs, {name}"), &answers)?);
            }
        }
    }
    print(stdout, &head("Scale"), rows)?;
    Ok(Exit::Success)
}

fn head(first: &str) -> [&str; 8] {
    [first, "ATE [m]", "Diff. [m]", "+- 95%", "NEES", "At end", "Centres", "In 95%"]
}

fn errors(answers: &[(Estimate, f64)]) -> Vec<f64> {
    answers.iter().map(|(_, error)| *error).collect()
}

/// What answers promise, against their errors; not a number where no trial has it.
struct Promised {
    /// Means over trials of NEES / 6 of all poses but the first, which is the world's frame, and of the last; over objects of NEES / 3 of their
    /// centres.
    nees: [f64; 3],
    /// Share of poses inside their region of 95%, mean over trials.
    inside: f64,
}

fn promised(answers: &[(Estimate, f64)], trials: &[Trial]) -> Result<Promised, PairsError> {
    let (mut poses, mut last, mut inside, mut centers) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for ((answer, _), Trial { truth, .. }) in answers.iter().zip(trials) {
        let pairs = Pairs::by_step(&truth.world_from_robot, &answer.world_from_robot)?;
        let scores = pose_scores(&pairs, answer.pose_covariances.as_deref());
        poses.extend(scores.get(&Metric::NeesPose));
        last.extend(scores.get(&Metric::NeesPoseEnd));
        inside.extend(scores.get(&Metric::PoseInside95));
        for (truth, object) in truth.objects.chunks(1).zip(&answer.objects) {
            let scores = object_scores(&pairs, truth, &[object.as_ref().map(gaussian)], false);
            centers.extend(scores.get(&Metric::NeesObjectCenter));
        }
    }
    let [poses, last, centers, inside] =
        [poses, last, centers, inside].map(|values| Mean::of(&values).map_or(f64::NAN, |values| values.mean));
    Ok(Promised { nees: [poses, last, centers], inside })
}

fn gaussian(object: &ObjectEstimate) -> ObjectGaussian {
    ObjectGaussian {
        center_in_world: Point3::from(object.position),
        center_covariance: object.position_covariance,
        rotation: None,
        rotation_covariance: None,
    }
}
