//! Stage `online`: every row's posterior after each step of an episode, as the robot would have had it, and how long it took.

use super::estimates::PANICKED;
use super::{Method, Pipeline, SeedEpisode, StageError};
use nalgebra::Matrix6;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};
use vantage_dataset::store::read_observations;
use vantage_dataset::{Observations, Pose, Seed};
use vantage_slam::{EstimateError, Online, StepObservations};

/// What an iteration promises, nats, that counts as nothing.
const SETTLED: f64 = 1e-6;

/// A method's answers on an episode, step by step.
#[derive(Clone, Debug, Default)]
pub struct OnlineRun {
    /// The robot's newest pose after each step.
    pub newest: Vec<Pose>,
    /// Covariances of their right perturbations, rotation first; `None` where one is not defined.
    pub covariances: Option<Vec<Matrix6<f64>>>,
    /// The poses of all steps after the last.
    pub at_end: Vec<Pose>,
    /// The same at the maximum, or as near to it as so many iterations come.
    pub settled: Vec<Pose>,
    /// How long each step took.
    pub times: Vec<Duration>,
}

/// What a method made of an episode; `None` of an estimator that only takes whole episodes.
pub type OnlineAnswer = Option<Result<OnlineRun, String>>;

/// The answers on a seed, in the order of the methods.
pub type SeedOnline = (Seed, Vec<OnlineAnswer>);

/// All methods on all seeds, one after the other, so that times are of one core that nothing of ours shares.
pub fn online(
    pipeline: &Pipeline,
    episodes: &[SeedEpisode],
    methods: &[Method<'_>],
) -> Result<Vec<SeedOnline>, StageError> {
    let stage = pipeline.progress.stage("online", episodes.len() as u64);
    let mut answers = Vec::with_capacity(episodes.len());
    for (seed, episode) in episodes {
        let of_seed = match episode {
            Ok(episode) => {
                let observations = read_observations(&episode.folder)?;
                methods
                    .iter()
                    .map(|method| answer(pipeline, &observations, method))
                    .collect::<Result<_, _>>()?
            }
            Err(reason) => methods.iter().map(|_| Some(Err(reason.clone()))).collect(),
        };
        answers.push((*seed, of_seed));
        stage.advance(1);
    }
    let has_episode = |index: usize| episodes[index].1.is_ok();
    for row in 0..methods.len() {
        keep_if_asked(&mut answers, row, has_episode);
    }
    Ok(answers)
}

/// Seeds without an episode fail in rows that take single steps alone: those that answer where there is one.
fn keep_if_asked(answers: &mut [SeedOnline], row: usize, has_episode: impl Fn(usize) -> bool) {
    let mut asked = answers.iter().enumerate().filter(|(index, _)| has_episode(*index));
    if asked.all(|(_, (_, of_seed))| of_seed[row].is_none()) {
        answers.iter_mut().for_each(|(_, of_seed)| of_seed[row] = None);
    }
}

/// A method whose model fails on a crop, or that panics, has failed on the seed; the others stand.
fn answer(
    pipeline: &Pipeline,
    observations: &Observations,
    method: &Method<'_>,
) -> Result<OnlineAnswer, StageError> {
    let run = || run(pipeline, observations, method);
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(None) => Ok(None),
        Ok(Some(Ok(run))) => Ok(Some(Ok(run))),
        Ok(Some(Err(
            error @ (EstimateError::Model(_)
            | EstimateError::Indefinite { .. }
            | EstimateError::Unreached { .. }),
        ))) => Ok(Some(Err(error.to_string()))),
        Ok(Some(Err(error))) => Err(error.into()),
        Err(_) => Ok(Some(Err(PANICKED.to_owned()))),
    }
}

fn run(
    pipeline: &Pipeline,
    observations: &Observations,
    method: &Method<'_>,
) -> Option<Result<OnlineRun, EstimateError>> {
    if !method.row.is_by_model_alone() {
        return None;
    }
    let settings = pipeline.file.estimator.settings();
    let estimator = method.row.estimator(&settings, method.model.reader());
    let mut online = match estimator.online(observations.camera, observations.robot_from_camera)? {
        Ok(online) => online,
        Err(error) => return Some(Err(error)),
    };
    let mut run = OnlineRun::default();
    let mut covariances = Vec::new();
    for (step, new) in StepObservations::of(observations).into_iter().enumerate() {
        let start = Instant::now();
        if let Err(error) = online.advance(new) {
            return Some(Err(error));
        }
        run.newest.extend(online.world_from_robot(step));
        covariances.push(online.pose_covariance(step));
        run.times.push(start.elapsed());
    }
    run.covariances = covariances.into_iter().collect();
    let poses = |online: &Online<'_>| {
        (0..observations.steps()).filter_map(|step| online.world_from_robot(step)).collect::<Vec<_>>()
    };
    run.at_end = poses(&online);
    if let Err(error) = online.settle(SETTLED, settings.solver.max_iterations) {
        return Some(Err(error));
    }
    run.settled = poses(&online);
    Some(Ok(run))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_takes_whole_episodes_alone_does_not_fail_for_want_of_one() {
        let failed = || Some(Err("no place".to_owned()));
        let mut answers =
            vec![(Seed(0), vec![None, Some(Ok(OnlineRun::default()))]), (Seed(1), vec![failed(), failed()])];
        for row in 0..2 {
            keep_if_asked(&mut answers, row, |index| index == 0);
        }
        assert!(answers[0].1[0].is_none() && answers[1].1[0].is_none());
        assert!(answers[0].1[1].is_some() && matches!(answers[1].1[1], Some(Err(_))));
    }
}
