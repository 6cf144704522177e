//! `bench score SEALED SUBMISSION`: somebody's answers to a task.

mod files;

use crate::command::cli::ScoreArgs;
use crate::command::error::BenchError;
use crate::command::score::error::ScoreError;
use crate::command::score::labels;
use crate::command::task::error::TaskError;
use crate::command::task::sealed::{Sealed, Task, published};
use crate::exit::Exit;
use crate::progress::Progress;
use crate::result::grid::Style;
use crate::result::metric::Metric;
use crate::result::results_file::Results;
use crate::result::run::{Outcome, Run};
use crate::result::table::Table;
use crate::result::table_text;
use crate::score::association::{self, ASSOCIATION, TrueTracklets};
use crate::score::embedding::Scores;
use crate::score::object_map::{
    self, OBJECT_MAP, TrueObject, nearest_pairs, object_map_scores, sides_around,
};
use crate::score::object_map_file::ObjectMap;
use crate::score::pairs::Pairs;
use crate::score::semantics::{self, Belief, SEMANTICS, semantic_scores};
use crate::score::trajectory_scores::{TRAJECTORIES, TRAJECTORY, pose_scores};
use files::{About, Division, Submission};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use vantage_dataset::store::{read_episode, read_manifest};
use vantage_dataset::{Detection, Episode, Extents, ObjectTruth, Observations, Pose, Seed};

/// The row of dead reckoning, to which trajectories are compared.
const ODOMETRY: &str = "odometry";
/// What an episode left of objects, or why it left nothing.
type Believed = (Seed, Result<Vec<Belief>, String>);

/// Scores it, and prints tables.
pub fn score(args: &ScoreArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let (sealed, hash) = Sealed::read(&args.truth)?;
    if let Some(option) = args.of_trajectories() {
        return Err(ScoreError::Option { option, of: "a submission" }.into());
    }
    let mut classes = None;
    if let Some(task) = &args.task {
        let Task { truth: expected, classes: of_task, .. } = Task::read(task)?;
        if expected != hash {
            let (truth, task) = (args.truth.clone(), task.clone());
            return Err(TaskError::OtherTruth { truth, task, found: hash, expected }.into());
        }
        classes = Some(of_task.into_iter().collect());
    }
    let submission = Submission::read(&args.estimate, &sealed, &hash)?;
    if let Some(classes) = &classes {
        labels::check(submission.proposals(), classes)?;
    }
    let (tables, true_classes) = submission.tables(&sealed, &args.truth)?;
    if classes.is_none() {
        labels::tell(submission.proposals(), &true_classes, "the truth", &Progress::detect());
    }
    let results = Results::new(&sealed.scene, &sealed.scene_hash, tables);
    if args.json {
        stdout.write_all(results.to_json()?.as_bytes())?;
    } else {
        let About { name, division, .. } = &submission.about;
        let division = match division {
            Division::Closed => "closed",
            Division::Open => "open",
        };
        writeln!(stdout, "{name}, {division} division, {} episodes; truth {hash}\n", sealed.episodes.len())?;
        for table in &results.tables {
            writeln!(stdout, "{}", table_text::tables(table, Style::terminal()))?;
        }
    }
    let answered = |run: &Run| run.method == submission.about.name && run.failure().is_none();
    let any = results.tables.iter().flat_map(Table::runs).any(answered);
    Ok(if any { Exit::Success } else { Exit::NothingEvaluated })
}

impl Submission {
    /// The tables, and the classes of all true objects.
    fn tables(&self, sealed: &Sealed, truth: &Path) -> Result<(Vec<Table>, BTreeSet<String>), BenchError> {
        let mut classes = BTreeSet::new();
        let numbers = sealed.numbers();
        let (mut driven, mut associated, mut mapped, mut believed) = (vec![], vec![], vec![], vec![]);
        for (&number, episode) in numbers.iter().zip(&sealed.episodes) {
            let folder = truth.join(number.0.to_string());
            if read_manifest(&folder)?.seal != episode.seal {
                return Err(TaskError::OtherEpisode { path: folder }.into());
            }
            let whole = read_episode(&folder)?;
            classes.extend(whole.truth.objects.iter().map(|object| object.family.clone()));
            let (seen, order) = published(&whole.observations, sealed.association);
            if order != episode.order {
                return Err(TaskError::OtherEpisode { path: folder }.into());
            }
            let answered = self.trajectories.as_ref().map(|entry| entry.run(number, &seen.timestamps));
            if let Some(answered) = &answered {
                let own = answered.as_ref().map_err(Clone::clone);
                let own = own.and_then(|poses| posed(&whole.truth.world_from_robot, poses));
                driven.push(self.run(number, own));
                let alone = dead_reckoning(&seen);
                let scores = posed(&whole.truth.world_from_robot, &alone);
                driven.push(Run { method: ODOMETRY.to_owned(), ..self.run(number, scores) });
            }
            if let Some(entry) = &self.associations {
                entry.fits(number, order.len())?;
                let told = entry.run(number, order.len());
                associated.push(self.run(number, told.map(|told| told_scores(&whole, &seen, &order, &told))));
            }
            if let Some(map) = self.maps.get(number.0 as usize) {
                let frame = answered.unwrap_or_else(|| Ok(vec![Pose::identity()]));
                let scored = match (map, frame) {
                    (_, Err(reason)) => {
                        Err(format!("its trajectory, whose frame it is in, failed: {reason}"))
                    }
                    (None, Ok(_)) => Err(format!("there is no {}.csv", number.0)),
                    (Some(map), Ok(poses)) => {
                        Ok(of_map(&whole, map, &poses.first().copied().unwrap_or_default()))
                    }
                };
                believed.push((number, scored.clone().map(|(_, beliefs)| beliefs)));
                let scored = scored.map(|(scores, _)| scores);
                mapped.push(self.run(number, scored));
            }
        }
        let name = &*self.about.name;
        let mut tables = Vec::new();
        if !driven.is_empty() {
            let columns = &TRAJECTORY[..5];
            tables.push(Table::new(
                TRAJECTORIES,
                &[ODOMETRY, name],
                Some(ODOMETRY),
                columns,
                &numbers,
                driven,
            )?);
        }
        if !associated.is_empty() {
            let columns = &association::OF_OTHERS;
            tables.push(Table::new(ASSOCIATION, &[name], None, columns, &numbers, associated)?);
        }
        if !mapped.is_empty() {
            tables.push(Table::new(OBJECT_MAP, &[name], None, &object_map::COLUMNS, &numbers, mapped)?);
        }
        if believed.iter().any(|(_, beliefs)| beliefs.as_ref().is_ok_and(|beliefs| !beliefs.is_empty())) {
            let runs = self.recalled(&believed);
            tables.push(Table::new(SEMANTICS, &[name], None, &semantics::COLUMNS, &numbers, runs)?);
        }
        Ok((tables, classes))
    }

    fn run(&self, seed: Seed, scored: Result<Scores, String>) -> Run {
        let (outcome, scores) = match scored {
            Ok(scores) => (Outcome::Done, scores),
            Err(reason) => (Outcome::Failed(reason), Scores::new()),
        };
        Run { method: self.about.name.clone(), seed, outcome, scores }
    }

    /// Each episode's latents against those of all earlier ones.
    fn recalled(&self, believed: &[Believed]) -> Vec<Run> {
        let of = |(i, (number, own)): (usize, &Believed)| {
            let earlier = believed[..i].iter().filter_map(|(_, beliefs)| beliefs.as_ref().ok()).flatten();
            let earlier: Vec<Belief> = earlier.cloned().collect();
            let scores = |own: &Vec<Belief>| semantic_scores(own, &earlier, *number);
            self.run(*number, own.as_ref().map(scores).map_err(Clone::clone))
        };
        believed.iter().enumerate().map(of).collect()
    }
}

fn posed(truth: &[Pose], poses: &[Pose]) -> Result<Scores, String> {
    Pairs::by_step(truth, poses).map(|pairs| pose_scores(&pairs)).map_err(|error| error.to_string())
}

/// The poses of odometry alone.
fn dead_reckoning(seen: &Observations) -> Vec<Pose> {
    let mut poses = vec![Pose::identity()];
    for measured in &seen.odometry {
        poses.push(poses[measured.from] * measured.robot_from_robot);
    }
    poses
}

/// The scores of the object told for each published detection.
fn told_scores(whole: &Episode, seen: &Observations, order: &[usize], told: &[Option<usize>]) -> Scores {
    let given = &whole.observations.detections;
    let shown = |&number: &usize| whole.truth.shown(number, &given[number]).map(|_| given[number].track);
    let is_whole = |detection: &Detection| !detection.bounding_box.is_truncated(&seen.camera);
    let truth = TrueTracklets {
        tracklets: (0..order.len()).collect(),
        shown: order.iter().map(shown).collect(),
        is_whole: seen.detections.iter().map(is_whole).collect(),
    };
    let mut scores = truth.scores(told);
    scores.extend(truth.adjusted_information(told).map(|ami| (Metric::Ami, ami)));
    scores
}

/// The scores of a map, and what its latents say of the objects that are near; in the axes of the robot's first pose. Objects that no detection
/// shows are left out.
fn of_map(whole: &Episode, map: &ObjectMap, world_from_first: &Pose) -> (Scores, Vec<Belief>) {
    let truth = &whole.truth;
    let first_from_world = truth.world_from_robot.first().map(Pose::inverse).unwrap_or_default();
    let numbered = whole.observations.detections.iter().enumerate();
    let shown: BTreeSet<usize> =
        numbered.filter_map(|(i, seen)| truth.shown(i, seen).map(|_| seen.track)).collect();
    let object = |object: &ObjectTruth| {
        let first_from_object = first_from_world * object.world_from_object;
        let sides = |extents: Extents| sides_around(&first_from_object.rotation, &(2.0 * extents.half_sides));
        TrueObject {
            center: first_from_object.translation.vector.into(),
            sides: object.extents.map(sides),
            class: object.family.clone(),
        }
    };
    let objects: Vec<TrueObject> =
        shown.iter().filter_map(|&track| truth.objects.get(track)).map(object).collect();
    let first_from_map = world_from_first.inverse();
    let proposals: Vec<_> =
        map.proposals.iter().map(|proposal| proposal.moved(&first_from_map, 1.0)).collect();
    let belief = |(i, j): (usize, usize)| {
        let latent = map.latents.get(j)?.clone();
        Some(Belief { class: objects[i].class.clone(), latent: Some(latent), named: None })
    };
    let beliefs = nearest_pairs(&objects, &proposals).into_iter().filter_map(belief).collect();
    (object_map_scores(&objects, &proposals), beliefs)
}
