//! `bench SCENE`: the whole line, from a scene file to tables and pictures.

use super::entry::Entry;
use super::{pictures, tables};
use crate::cli::{RunArgs, StageArgs};
use crate::error::BenchError;
use crate::exit::Exit;
use crate::manifest::{Manifest, Renderer};
use crate::output::OutputFolder;
use crate::pipeline::{
    Answer, EpisodeFolder, PANICKED, Pipeline, Subject, Unseen, caveat, episodes, estimates, model,
    test_views, unseen,
};
use crate::progress::Progress;
use crate::render::{self, Style};
use crate::report;
use crate::result_folder::{Of, ResultFolder};
use crate::results::Results;
use crate::scene_file::{self, SceneFile};
use crate::score::viewpoint::{ViewpointTrial, summarize, summarize_by_family};
use crate::table::{Outcome, Run, Table};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use vantage_dataset::store::read_truth;
use vantage_dataset::{Seed, Split};

/// All that the line gave for one scene.
pub struct Scored {
    /// The tables.
    pub results: Results,
    /// Their origin.
    pub manifest: Manifest,
    /// The episodes by seed, or why there is none; empty where no robot drives.
    pub episodes: Vec<(Seed, Result<EpisodeFolder, String>)>,
    /// The estimators' answers by seed.
    pub answers: Vec<(Seed, Vec<Answer>)>,
    /// Estimators of others.
    pub entries: Vec<Entry>,
    /// Scores on unseen instances, one a seed.
    pub unseen: Vec<Unseen>,
    /// Detections of objects in all episodes.
    pub detections: usize,
    /// Name of the semantic row.
    pub semantic_row: &'static str,
}

/// The seeds that are asked for.
pub(super) fn seeds(file: &SceneFile, stages: &StageArgs) -> Vec<Seed> {
    match stages.seeds {
        Some(count) => (0..count).map(Seed).collect(),
        None => file.evaluation.seeds.as_slice().to_vec(),
    }
}

/// Runs the line on a scene.
pub fn score(scene: &Path, stages: &StageArgs) -> Result<Scored, BenchError> {
    let pipeline = Pipeline::open(scene, &stages.cache, stages.renderer)?;
    let seeds = seeds(&pipeline.file, stages);
    if let (Some(folder), true) = (stages.trajectories.first(), pipeline.file.robot.path.stations()) {
        return Err(Entry::undriven(folder));
    }
    let entries = Entry::open(&stages.trajectories, &tables::taken_names(), &seeds, &pipeline.progress)?;
    let mut manifest = Manifest::new(&pipeline.scene_hash, &seeds);
    manifest.renderer = renderer(&pipeline);
    manifest.options = serde_json::to_value(stages)?;
    let mut clock = Clock { manifest: &mut manifest, start: Instant::now() };

    let chosen = chosen_model(&pipeline, stages.train, stages.model.as_deref())?;
    let tests = test_views(&pipeline, &seeds)?;
    clock.stage("test views");
    let loaded = model(&pipeline, chosen.as_deref())?;
    tests.iter().try_for_each(|scored| loaded.check_set(&scored.set))?;
    clock.stage("model");
    let (episodes, answers) = if pipeline.file.robot.path.stations() {
        let told = "note: no robot drives in this scene: single views are scored, and no trajectory";
        pipeline.progress.note(told);
        (Vec::new(), Vec::new())
    } else {
        let episodes = episodes(&pipeline, &seeds, Split::Test)?;
        clock.stage("episodes");
        for episode in episodes.iter().filter_map(|(_, episode)| episode.as_ref().ok()) {
            loaded.check_unseen(read_truth(&episode.folder)?.objects.iter().map(|object| object.instance))?;
        }
        let answers = estimates(&pipeline, &episodes, &loaded)?;
        clock.stage("estimates");
        (episodes, answers)
    };
    let viewing = loaded.model.viewing();
    let unseen = unseen(&pipeline, &tests, Subject::Viewing(&*viewing), &loaded.hash)?;
    clock.stage("unseen instances");
    let scored = tables::tables(
        &pipeline.file.estimator.rows,
        &entries,
        &seeds,
        &episodes,
        &answers,
        &unseen,
        &loaded,
    )?;

    manifest.model_hash = Some(loaded.hash.clone());
    manifest.trajectories.extend(entries.iter().map(|entry| (entry.name.clone(), entry.hash.clone())));
    manifest.caveat = caveat(&pipeline, loaded.model.inner())?.map(|what| format!("The model {what}."));
    let made = episodes.iter().map(|(_, episode)| episode.as_ref().map_or("none", |episode| &episode.seal));
    let views = tests.iter().map(|views| views.seal.as_str()).filter(|_| episodes.is_empty());
    manifest.dataset_hash = Some(dataset_hash(seeds.iter().zip(made.chain(views))));
    Ok(Scored {
        results: Results::new(&pipeline.file.name, &pipeline.scene_hash, scored.tables),
        detections: scored.detections,
        semantic_row: tables::semantic_row(loaded.model.inner().manifest()),
        manifest,
        episodes,
        answers,
        entries,
        unseen,
    })
}

/// Notes how long each stage took.
struct Clock<'a> {
    manifest: &'a mut Manifest,
    start: Instant,
}

impl Clock<'_> {
    fn stage(&mut self, name: &str) {
        self.manifest.took(name, self.start.elapsed());
        self.start = Instant::now();
    }
}

pub(super) fn renderer(pipeline: &Pipeline) -> Renderer {
    let info = &pipeline.renderer_info;
    let is_wgpu = !info.driver.is_empty();
    Renderer {
        name: info.renderer.clone(),
        adapter: is_wgpu.then(|| info.adapter.clone()),
        driver: is_wgpu.then(|| info.driver.clone()),
    }
}

/// The folder of the model to load, the named one before the scene's own; `None` to train one.
pub(super) fn chosen_model(
    pipeline: &Pipeline,
    train: bool,
    named: Option<&Path>,
) -> Result<Option<PathBuf>, BenchError> {
    let committed = || pipeline.file.training.reference.as_ref().map(|path| pipeline.folder.join(path));
    let chosen = if train { None } else { named.map(Path::to_owned).or_else(committed) };
    match chosen {
        Some(folder) if !folder.is_dir() => Err(BenchError::NoModel { folder }),
        chosen => Ok(chosen),
    }
}

fn dataset_hash<'a>(seals: impl Iterator<Item = (&'a Seed, &'a str)>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (seed, seal) in seals {
        hasher.update(&seed.0.to_le_bytes());
        hasher.update(seal.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// Runs the line, writes results, trajectories and pictures below `args.out`, and prints the tables.
pub fn bench(args: &RunArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    // Required by the command line whenever there is no other command.
    let scene = args.scene.clone().unwrap_or_default();
    let file: SceneFile = scene_file::read(&scene)?;
    ResultFolder::check(&out, &file.name, Of::Scene)?;
    let scored = score(&scene, &args.stages)?;
    let viewpoints = viewpoint_table(&scored.unseen, Style::Markdown);
    let (name, progress) = (&scored.results.scene, Progress::detect());
    let folder = ResultFolder::open(&out, name, Of::Scene, &progress)?;
    let written = format!("written to {}", folder.path().display());
    pictures::write(&folder, &scored)?;
    folder.write("viewpoint.md", format!("# {name}\n\n{viewpoints}").as_bytes())?;
    report::write(folder, &scored.results, &scored.manifest)?;
    progress.note(&written);
    print(&scored, stdout)?;
    told_of_failures(&scored, &progress);
    let panicked = |answer: &Answer| matches!(&answer.outcome, Outcome::Failed(reason) if reason == PANICKED);
    if scored.answers.is_empty() {
        let any = scored.results.tables.iter().flat_map(Table::runs).any(|run| !run.scores.is_empty());
        return if any { Ok(Exit::Success) } else { Err(BenchError::NothingSeen { scene }) };
    }
    if scored.answers.iter().any(|(_, rows)| rows.iter().any(panicked)) {
        return Err(BenchError::Panicked { scene });
    }
    if scored.answers.iter().all(|(_, rows)| rows.iter().all(|answer| answer.world_from_robot.is_empty())) {
        return Err(BenchError::NothingAnswered { scene });
    }
    if scored.detections == 0 {
        return Err(BenchError::NothingSeen { scene });
    }
    Ok(Exit::Success)
}

/// Says how many runs of each other estimator failed, and why the first did.
fn told_of_failures(scored: &Scored, progress: &Progress) {
    let trajectories = scored.results.tables.iter().filter(|table| table.name() == tables::TRAJECTORIES);
    let runs: Vec<&Run> = trajectories.flat_map(Table::runs).collect();
    for entry in &scored.entries {
        let of_entry = || runs.iter().filter(|run| run.method == entry.name);
        let failed = of_entry().filter_map(|run| match &run.outcome {
            Outcome::Failed(reason) => Some((run.seed, reason)),
            _ => None,
        });
        if let Some((seed, reason)) = failed.clone().next() {
            let (failed, all, name) = (failed.count(), of_entry().count(), &entry.name);
            progress.note(&format!(
                "note: {failed} of {all} runs of {name} failed, that of seed {} first: {reason}",
                seed.0
            ));
        }
    }
}

/// Prints every table, and the viewpoint errors by family.
fn print(scored: &Scored, stdout: &mut impl Write) -> Result<(), BenchError> {
    for table in &scored.results.tables {
        writeln!(stdout, "{}", render::tables(table, Style::Terminal))?;
    }
    writeln!(stdout, "{}", viewpoint_table(&scored.unseen, Style::Terminal))?;
    Ok(())
}

fn viewpoint_table(unseen: &[Unseen], style: Style) -> String {
    let trials: Vec<ViewpointTrial> =
        unseen.iter().flat_map(|seed| seed.trials.iter().cloned().map(ViewpointTrial::from)).collect();
    render::viewpoint_table(&summarize_by_family(&trials), &summarize(&trials), style)
}

impl Scored {
    /// The model's likelihood against the azimuth's offset, mean over the seeds that have one; empty without any.
    pub fn likelihood(&self) -> Vec<(f64, f64)> {
        let curves: Vec<_> = self.unseen.iter().filter(|seed| !seed.likelihood.is_empty()).collect();
        let Some(first) = curves.first() else { return Vec::new() };
        let mean =
            |i: usize| curves.iter().map(|seed| seed.likelihood[i].1).sum::<f64>() / curves.len() as f64;
        first.likelihood.iter().enumerate().map(|(i, (offset, _))| (*offset, mean(i))).collect()
    }
}
