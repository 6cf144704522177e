//! `bench SCENE`: the whole line, from a scene file to tables and pictures.

mod association;
mod dump;
pub mod error;
pub mod line;
mod online;
mod pictures;
mod record;
mod said;

use super::cli::{RunArgs, StageArgs};
use crate::command::error::BenchError;
use crate::command::map::{part_of_varied, sweep};
use crate::command::report::{REPORT, page_of};
use crate::command::sweep::Part;
use crate::exit::Exit;
use crate::pipeline::{Naming, PANICKED, StageError, concerns_one_seed, model_hash, reference_model};
use crate::progress::Progress;
use crate::result::folder::ResultFolder;
use crate::result::kind::ResultKind;
use crate::result::output_folder::OutputFolder;
use crate::result::report;
use crate::result::run::Run;
use crate::result::standing::Standing;
use crate::result::table::Table;
use crate::scene_file::{self, SceneFile};
use crate::score::association::ASSOCIATION;
use crate::score::trajectory_scores::TRAJECTORIES;
use error::RunError;
use line::{Beside, Scored, line, seeds};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs the line, writes results, trajectories and pictures below `args.out`, and says what came out.
pub fn bench(args: &RunArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    // Required by the command line whenever there is no other command.
    let scene = args.scene.clone().unwrap_or_default();
    let file: SceneFile = scene_file::read(&scene)?;
    if !file.vary.is_empty() {
        return sweep(args, file, &scene, stdout);
    }
    if !args.replace {
        keep_fuller(&ResultKind::Scene.place(out.path(), &file.name), &scene, &file, &args.stages)?;
    }
    let mut scored = line(&scene, &args.stages, Naming::Folder, beside(args, Part::default()))?;
    let progress = Progress::detect();
    let folder = ResultFolder::open(&out, &file.name, ResultKind::Scene, &progress)?;
    let place = folder.path().to_owned();
    // First, so that scores are not lost where a picture cannot be written.
    report::write(&folder, &scored.results, &scored.manifest)?;
    let mut pictures = pictures::write(&folder, &scored)?;
    pictures.extend(online::write(&folder, &scored)?);
    association::write(&folder, &scored)?;
    if args.dump {
        let start = Instant::now();
        dump::write(&folder, &scored)?;
        scored.manifest.took("dump", start.elapsed());
    }
    folder.write(REPORT, page_of(&place, &scored.results, &scored.manifest, &pictures)?.as_bytes())?;
    folder.finish(&scored.manifest)?;
    said::say(args, &scored, &place, &pictures, stdout)?;
    notes(&scored, &progress);
    ended(&scored, scene)
}

/// Does the stages of some of the seeds, and leaves them in the cache.
pub fn part(args: &RunArgs, part: Part) -> Result<(), BenchError> {
    let scene = args.scene.clone().unwrap_or_default();
    let file: SceneFile = scene_file::read(&scene)?;
    if !file.vary.is_empty() {
        return part_of_varied(args, file, &scene, part);
    }
    if part.of(seeds(&file, &args.stages)).is_empty() {
        return Ok(());
    }
    match line(&scene, &args.stages, Naming::Folder, beside(args, part)) {
        // A seed without a world is an answer, which the whole run gives again.
        Err(BenchError::Stage(StageError::Sim(error))) if concerns_one_seed(&error) => Ok(()),
        made => made.map(drop),
    }
}

fn beside(args: &RunArgs, part: Part) -> Beside<'_> {
    Beside { online: args.online, associate: args.associate, associations: &args.associations, part }
}

/// Refuses to put a result of fewer seeds, or of another model, in the place of the one that lies there; tells where that is of another
/// scene.
fn keep_fuller(place: &Path, scene: &Path, file: &SceneFile, stages: &StageArgs) -> Result<(), BenchError> {
    let Some(standing) = Standing::read(place) else { return Ok(()) };
    let own = reference_model(file, scene, &stages.making.cache)?;
    let with_a_model = own.is_some();
    let models = match stages.model.as_slice() {
        _ if stages.train => Vec::new(),
        [] => own.into_iter().collect(),
        named => named.to_vec(),
    };
    let same_model = if models.is_empty() {
        standing.is_of_training(with_a_model)
    } else {
        // Of a folder that holds none the line tells.
        let hashes: Option<Vec<String>> = models.iter().map(|model| model_hash(model)).collect();
        hashes.is_none_or(|hashes| standing.is_of(&hashes))
    };
    standing.allows(place, &seeds(file, stages), same_model)?;
    if !standing.is_of_scene(&scene_file::hash(file)?) {
        let place = place.display();
        Progress::detect().note(&format!(
            "note: the result in {place} is of another scene of this name, or of this one as it was; this run replaces it"
        ));
    }
    Ok(())
}

/// How a run ends whose files are written.
fn ended(scored: &Scored, scene: PathBuf) -> Result<Exit, BenchError> {
    if scored.answers.is_empty() {
        let any = scored.results.tables.iter().flat_map(Table::runs).any(|run| !run.scores.is_empty());
        return if any { Ok(Exit::Success) } else { Err(RunError::NothingSeen { scene }.into()) };
    }
    if scored.results.tables.iter().flat_map(Table::runs).any(|run| run.failure() == Some(PANICKED)) {
        return Err(RunError::Panicked { scene }.into());
    }
    if scored.answers.iter().all(|(_, rows)| rows.iter().all(|answer| answer.world_from_robot.is_empty())) {
        return Err(RunError::NothingAnswered { scene }.into());
    }
    if scored.detections == 0 {
        return Err(RunError::NothingSeen { scene }.into());
    }
    let failed = |name: &str, is_counted: &dyn Fn(&String) -> bool| {
        let table = scored.results.table(name)?;
        let none = |method: &&String| table.runs_of(method).iter().all(|run| run.failure().is_some());
        let method = table.methods().iter().filter(|method| is_counted(method)).find(none)?;
        Some((method.clone(), table.runs_of(method).iter().find_map(Run::failure)?.to_owned()))
    };
    let is_entry = |method: &String| scored.associated.iter().any(|entry| entry.name == *method);
    match failed(TRAJECTORIES, &|_| true).or_else(|| failed(ASSOCIATION, &is_entry)) {
        Some((method, reason)) => Err(RunError::NothingOf { method, scene, reason }.into()),
        None => Ok(Exit::Success),
    }
}

/// Says how many runs of each other estimator failed and why the first did or, where more is asked for, of each run of any why it
/// failed, and how long each stage took.
fn notes(scored: &Scored, progress: &Progress) {
    let of = [TRAJECTORIES, ASSOCIATION].into_iter().filter_map(|name| scored.results.table(name));
    let runs: Vec<&Run> = of.flat_map(Table::runs).collect();
    if progress.is_verbose() {
        for (run, reason) in runs.iter().filter_map(|run| Some((run, run.failure()?))) {
            progress.note(&format!("note: {} failed on seed {}: {reason}", run.method, run.seed.0));
        }
        for (stage, seconds) in &scored.manifest.seconds {
            progress.note(&format!("note: {stage} took {seconds:.1} s"));
        }
        return;
    }
    let entries = scored.entries.iter().map(|entry| &entry.name);
    for name in entries.chain(scored.associated.iter().map(|entry| &entry.name)) {
        let of_entry = || runs.iter().filter(|run| run.method == *name);
        let failed = of_entry().filter_map(|run| Some((run.seed, run.failure()?)));
        if let Some((seed, reason)) = failed.clone().next() {
            let (failed, all) = (failed.count(), of_entry().count());
            progress.note(&format!(
                "note: {failed} of {all} runs of {name} failed, that of seed {} first: {reason}",
                seed.0
            ));
        }
    }
}
