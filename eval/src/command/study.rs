//! `bench study FILE`: models trained in several ways on the same views, compared on the same instances.

use super::figures::latents;
use crate::command::cli::StudyArgs;
use crate::command::error::BenchError;
use crate::command::folder::is_there;
use crate::command::places::places;
use crate::exit::Exit;
use crate::pipeline::{Pipeline, VariantModels, finished_model, study_views, variant_models, variant_scores};
use crate::progress::Progress;
use crate::result::folder::ResultFolder;
use crate::result::grid::Style;
use crate::result::kind::ResultKind;
use crate::result::manifest::{Manifest, Renderer};
use crate::result::metric::Metric;
use crate::result::output_folder::OutputFolder;
use crate::result::report;
use crate::result::results_file::{FILE_NAME, Results};
use crate::result::run::{Outcome, Run};
use crate::result::table::Table;
use crate::result::table_text;
use crate::scene_file;
use crate::scene_file::study::{Scored, StudyFile, VariantError};
use crate::score::embedding::Scores;
use crate::score::unseen_table::{OF_LATENTS, TABLES, UnseenTable};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::time::Instant;
use vantage_dataset::{Seed, Split};
use vantage_learn::Objective;

/// Folder of the cache that holds trained trunks.
const TRUNKS: &str = "trunks";

/// Trains and scores every variant, prints the table and writes it below `args.out`.
pub fn study(args: &StudyArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let study: StudyFile = scene_file::read(&args.study)?;
    let beside = args.study.parent().unwrap_or(Path::new(""));
    let scene = beside.join(&study.scene);
    let pipeline = Pipeline::open(&scene, &args.cache, args.renderer.into())?;
    let views = pipeline.scene.view_conditions().views;
    let scored = if study.scored == Scored::Known { views.instances(Split::Test) } else { 0 };
    let seeds: Vec<Seed> = (1..=study.seeds).map(Seed).collect();
    let mut finished: BTreeMap<&str, VariantModels> = BTreeMap::new();
    for (number, variant) in study.variants.iter().enumerate() {
        let located =
            |error| VariantError { place: Some(scene_file::place_of_variant(number, &args.study)), ..error };
        let spec = variant.training(&pipeline.file.training.model).map_err(located)?;
        variant.fits(views.instances(Split::Train), scored).map_err(located)?;
        variant.allowed_under(study.scored).map_err(located)?;
        if let Some(folder) = &variant.folder {
            let folder = beside.join(folder);
            is_there(&folder)?;
            finished.insert(&variant.name, finished_model(&pipeline, &folder, &seeds)?);
            continue;
        }
        if spec.objective == Objective::ViewpointPredictive && views.odometry.is_none() {
            let reason =
                "the viewpoint-predictive model is trained on odometry: set views.odometry in the scene";
            return Err(located(variant.refused(reason.to_owned())).into());
        }
    }
    let hash = study.hash(&pipeline.scene_hash)?;
    let mut manifest = Manifest::new(&hash, &seeds);
    manifest.renderer = Renderer::from(&pipeline.renderer_info);
    manifest.options = serde_json::to_value(args)?;
    for (name, models) in &finished {
        let hash = models.iter().find_map(|(_, model)| Some(model.as_ref().ok()?.model.hash().to_owned()));
        manifest.model_hashes.extend(hash.map(|hash| ((*name).to_owned(), hash)));
    }

    let started = Instant::now();
    let imported = study.views.as_ref().map(|views| beside.join(views));
    let views = study_views(&pipeline, &study, imported.as_deref())?;
    manifest.took("views", started.elapsed());
    manifest.dataset_hash = Some(views.hash());
    finished.values().try_for_each(|models| views.check_finished(models))?;
    let trunks = args.cache.join(TRUNKS);
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); TABLES.len()];
    let mut floors: Vec<BTreeMap<Metric, f64>> = vec![BTreeMap::new(); TABLES.len()];
    let mut map = None;
    for (number, variant) in study.variants.iter().enumerate() {
        let started = Instant::now();
        let models = match finished.remove(variant.name.as_str()) {
            Some(models) => models,
            None => variant_models(&pipeline, &study, variant, &views, &trunks)?,
        };
        if let (0, Some((_, Ok(first))), Some(set)) = (number, models.first(), views.first_scored()) {
            map = latents::map(set, &latents::embeddings(&first.model, set)?)?;
        }
        for (seed, model) in models {
            let scored = match model {
                Ok(model) => variant_scores(&pipeline, &views, &model)?,
                Err(failure) => {
                    let method = variant.name.clone();
                    let failed =
                        Run { method, seed, outcome: Outcome::Failed(failure), scores: BTreeMap::new() };
                    runs.iter_mut().for_each(|runs| runs.push(failed.clone()));
                    continue;
                }
            };
            for ((table, runs), floor) in TABLES.iter().zip(&mut runs).zip(&mut floors) {
                if floor.is_empty() {
                    *floor = mean_scores(table, scored.iter().filter_map(|on| on.floor.get(table.name)));
                }
                let scores = mean_scores(table, scored.iter().filter_map(|on| on.model.get(table.name)));
                runs.push(run(&variant.name, seed, scores));
            }
        }
        manifest.took(&variant.name, started.elapsed());
    }

    let tables = TABLES
        .iter()
        .zip(runs)
        .zip(floors)
        .map(|((table, mut runs), floor)| {
            let of_floor =
                |name| seeds.iter().map(|&seed| run(name, seed, floor.clone())).collect::<Vec<_>>();
            runs.extend(table.floor().into_iter().flat_map(of_floor));
            let variants = study.variants.iter().map(|variant| variant.name.as_str());
            let names: Vec<&str> = variants.chain(table.floor()).collect();
            Table::new(table.name, &names, Some(names[0]), table.metrics(), &seeds, runs)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let notes = study.variants.iter().map(|variant| format!("- `{}`: {}\n", variant.name, variant.note));
    let notes = format!(
        "# {}\n\n{}\n\nScored: {}.\n\n{}",
        study.name,
        study.purpose.trim(),
        study
            .views
            .as_ref()
            .map_or(study.scored.told().to_owned(), |views| format!("the views in {}", views.display())),
        notes.collect::<String>()
    );
    let progress = Progress::detect();
    let folder = ResultFolder::open(&out, &study.name, ResultKind::Study, &progress)?;
    let written = format!("written to {}", folder.path().display());
    folder.write("variants.md", notes.as_bytes())?;
    let place = folder.path().to_owned();
    let mut pictures = Vec::new();
    if let Some((_, png)) = map {
        folder.write(latents::LATENTS, &png)?;
        pictures.push(latents::LATENTS);
    }
    let scored =
        tables.iter().flat_map(Table::runs).any(|run| run.outcome == Outcome::Done && !run.scores.is_empty());
    let results = Results::new(&study.name, &hash, tables);
    report::write(folder, &results, &manifest)?;
    progress.note(&written);
    for table in results.tables.iter().filter(|table| table.name() == OF_LATENTS.name) {
        writeln!(stdout, "{}", table_text::tables(table, Style::terminal()))?;
    }
    let kinds = [
        ("tables", vec![report::TABLES]),
        ("variants", vec!["variants.md"]),
        ("raw scores", vec![FILE_NAME]),
        ("pictures", pictures),
    ];
    write!(stdout, "{}", places(&place, kinds))?;
    Ok(if scored { Exit::Success } else { Exit::NothingEvaluated })
}

fn run(method: &str, seed: Seed, scores: BTreeMap<Metric, f64>) -> Run {
    Run { method: method.to_owned(), seed, outcome: Outcome::Done, scores }
}

/// The mean of each score over the sets of test instances; undefined where it is in any of them.
fn mean_scores<'a>(table: &UnseenTable, sets: impl Iterator<Item = &'a Scores>) -> Scores {
    let sets: Vec<&Scores> = sets.collect();
    let mean = |metric: Metric| {
        let scores: Option<Vec<f64>> = sets.iter().map(|scores| scores.get(&metric).copied()).collect();
        let scores = scores.filter(|scores| !scores.is_empty())?;
        Some((metric, scores.iter().sum::<f64>() / sets.len() as f64))
    };
    table.metrics().iter().copied().filter_map(mean).collect()
}
