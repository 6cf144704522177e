//! A drive of a life: the answer of a row that learns, and what it knows after it.

use super::row_input::RowInput;
use super::{Answer, FILE, Inputs, Method, PANICKED, StageCache, layer_of, processes_of, seen_in_truth};
use crate::pipeline::{StageError, code};
use crate::scene_file::estimator::EstimatorSpec;
use crate::scene_file::row::Reader;
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};
use vantage_dataset::store::Key;
use vantage_model::{LastLayer, ObservationModel};
use vantage_slam::{EstimateError, Learnt, Lesson};

/// An answer, and what is known after it by a row that learns.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    pub answer: Answer,
    pub lesson: Option<Lesson>,
}

/// A drive after those that taught `before`, by several ways to tell who is who: the answer by the likeliest, which comes first, and what
/// all teach.
pub fn driven(
    cache: &StageCache,
    ways: &[(f64, RowInput<'_>)],
    method: (&Method<'_>, &EstimatorSpec),
    before: &Lesson,
) -> Result<Drive, StageError> {
    let mut likeliest = None;
    let mut lessons = Vec::with_capacity(ways.len());
    for (weight, given) in ways {
        let Drive { answer, lesson } = learnt(cache, given, method, before)?;
        lessons.extend(lesson.map(|lesson| (*weight, lesson)));
        likeliest.get_or_insert(answer);
    }
    let answer = likeliest.expect("there is a way at least");
    Ok(Drive { answer, lesson: Some(Lesson::mixed(&lessons)) })
}

/// Likewise, by one, from the cache where that has it.
fn learnt(
    cache: &StageCache,
    given: &RowInput<'_>,
    (method, spec): (&Method<'_>, &EstimatorSpec),
    before: &Lesson,
) -> Result<Drive, StageError> {
    let spec = spec.of_row(method.row);
    let (code, model) = (code::ESTIMATED, method.model.model.hash());
    let (episode, objects) = (&given.episode.seal, given.objects);
    let inputs = Inputs { code, episode, objects, model, readouts: None, process: None, spec: spec.clone() };
    let key = Key::new("drive", &(inputs, before))?;
    cache.json(&key, FILE, || {
        let observations = given.observations()?;
        let layer = layer_of(method)?;
        let processes = processes_of(method)?;
        let processes =
            processes.as_ref().map(|tried| tried.each_ref().map(|of| of as &dyn ObservationModel));
        let views = seen_in_truth(observations, given.episode, method)?;
        let reader = Reader {
            processes,
            layer: layer.as_ref().map(|layer| layer as &dyn LastLayer),
            seen: views.as_deref(),
            ..method.model.reader()
        };
        let learner = method.row.learner(&spec.settings(), reader).expect("the row learns");
        let same = |answer| Ok(Drive { answer, lesson: Some(before.clone()) });
        match catch_unwind(AssertUnwindSafe(|| learner.learn(observations, before))) {
            Ok(Ok(Learnt { estimate, lesson, gain })) => {
                let answer = Answer { gain, ..Answer::new(estimate) };
                Ok(Drive { answer, lesson: Some(lesson) })
            }
            Ok(Err(error @ EstimateError::Model(_))) => same(Answer::failed(error.to_string())),
            Ok(Err(error)) => Err(error.into()),
            Err(_) => same(Answer::failed(PANICKED.to_owned())),
        }
    })
}
