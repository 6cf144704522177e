//! `bench study FILE`: models trained in several ways on the same views, compared on the same instances.

mod scores;
mod worst;

use super::figures::latents;
use super::study_pages::{STUDY_FILE, known_views_table, study_pages};
use crate::command::cli::StudyArgs;
use crate::command::error::BenchError;
use crate::command::folder::is_there;
use crate::command::places::places;
use crate::command::report::{REPORT, page_of};
use crate::command::sweep::Part;
use crate::command::view_split::check_split;
use crate::exit::Exit;
use crate::pipeline::{
    ImportedViews, Pipeline, StudyViews, Teller, VariantModels, beside_or_supplied, finished_model,
    imported_views, study_views, test_views, variant_models, variant_scores,
};
use crate::progress::Progress;
use crate::result::folder::ResultFolder;
use crate::result::grid::Style;
use crate::result::kind::ResultKind;
use crate::result::manifest::{Manifest, Renderer};
use crate::result::output_folder::OutputFolder;
use crate::result::report;
use crate::result::results_file::{FILE_NAME, Results};
use crate::result::table_text;
use crate::scene_file;
use crate::scene_file::row_name::{GAUSSIAN_PROCESS, with_process};
use crate::scene_file::study::{Scored, StudyFile, VariantError};
use crate::score::known_views::known_view_scores;
use crate::score::unseen_table::OF_LATENTS;
use scores::StudyScores;
use std::collections::BTreeMap;
use std::io::Write;
use std::iter;
use std::path::{Path, PathBuf};
use std::time::Instant;
use vantage_dataset::{Seed, Split};
use vantage_learn::Objective;
use worst::{WORST, worst_png};

/// Folder of the cache that holds trained trunks.
const TRUNKS: &str = "trunks";
/// Name of the file that tells what each variant is.
const VARIANTS: &str = "variants.md";

/// Trains and scores every variant, prints the table and writes it below `args.out`.
pub fn study(args: &StudyArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let study: StudyFile = scene_file::read(&args.study)?;
    let made = make(args, study)?;
    write(&out, made, stdout)
}

/// Trains and scores some of the variants, and leaves them in the cache.
pub fn part(args: &StudyArgs, part: Part) -> Result<(), BenchError> {
    let mut study: StudyFile = scene_file::read(&args.study)?;
    study.variants = part.of(study.variants);
    if study.variants.is_empty() { Ok(()) } else { make(args, study).map(drop) }
}

/// A study with its scores.
struct Made {
    study: StudyFile,
    results: Results,
    manifest: Manifest,
    drawn: Drawn,
    any: bool,
}

fn make(args: &StudyArgs, study: StudyFile) -> Result<Made, BenchError> {
    let beside = args.study.parent().unwrap_or(Path::new(""));
    let pipeline =
        Pipeline::open(&beside.join(&study.scene), &args.making.cache, args.making.renderer.into())?;
    let seeds: Vec<Seed> = (1..=study.seeds).map(Seed).collect();
    let imported = |setting: &str, folder: &Option<PathBuf>, expected: Option<Split>| {
        let Some(folder) = folder.as_ref().map(|folder| beside.join(folder)) else { return Ok(None) };
        let named_by = format!("`{setting}` of {}", args.study.display());
        let views = imported_views(&folder, &named_by)?;
        expected.map_or(Ok(()), |split| check_split(&folder, &named_by, split))?;
        Ok::<_, BenchError>(Some(views))
    };
    let in_place = ImportedViews {
        training: imported("training_views", &study.training_views, Some(Split::Train))?,
        validation: imported("validation_views", &study.validation_views, Some(Split::Validation))?,
    };
    let finished = finished(&pipeline, &study, &in_place, (&args.study, &args.making.cache), &seeds)?;
    let other = study
        .scored_scene
        .as_ref()
        .map(|scene| Pipeline::open(&beside.join(scene), &args.making.cache, args.making.renderer.into()));
    let other = other.transpose()?;
    let scenes = [Some(&pipeline), other.as_ref()];
    let hashes_of_scenes = scenes.into_iter().flatten().map(|scene| scene.scene_hash.as_str());
    let hash = study.hash(&hashes_of_scenes.collect::<Vec<_>>().join(" "))?;
    let mut manifest = Manifest {
        renderer: Renderer::from(&pipeline.renderer_info),
        options: serde_json::to_value(args)?,
        model_hashes: hashes(&finished),
        ..Manifest::new(&hash, &seeds)
    };

    let started = Instant::now();
    let elsewhere = match (imported("views", &study.views, None)?, &other) {
        (Some(views), _) => Some(vec![views]),
        (None, Some(other)) => Some(test_views(other, other.file.evaluation.seeds.as_slice())?),
        (None, None) => None,
    };
    let views = study_views(&pipeline, &study, in_place, elsewhere)?;
    manifest.took("views", started.elapsed());
    manifest.dataset_hash = Some(views.hash());
    finished.values().try_for_each(|models| views.check_finished(models))?;
    let trunks = args.making.cache.join(TRUNKS);
    let (scores, drawn) = scored(&pipeline, &study, &views, finished, &trunks, &mut manifest)?;
    let any = scores.any();
    let results = Results::new(&study.name, &hash, scores.tables(&study, &seeds)?);
    Ok(Made { study, results, manifest, drawn, any })
}

fn write(out: &OutputFolder, made: Made, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let Made { study, results, manifest, drawn, any } = made;
    let progress = Progress::detect();
    let folder = ResultFolder::open(out, &study.name, ResultKind::Study, &progress)?;
    let place = folder.path().to_owned();
    folder.write(VARIANTS, variants(&study).as_bytes())?;
    folder.write(STUDY_FILE, serde_json::to_string_pretty(&study)?.as_bytes())?;
    // Images of others may not be shown: of their views there are dots alone.
    let is_ours =
        [&study.views, &study.training_views, &study.validation_views].into_iter().all(Option::is_none);
    let map = drawn.map.map(|(svg, png)| match is_ours {
        true => (latents::LATENTS, png),
        false => (latents::LATENTS_DOTS, svg.into_bytes()),
    });
    let worst = drawn.worst.filter(|_| is_ours).map(|png| (WORST, png));
    let drawn: Vec<(&str, Vec<u8>)> =
        study_pages(&study, &results)?.into_iter().chain(map).chain(worst).collect();
    let pictures: Vec<&str> = drawn.iter().map(|(name, _)| *name).collect();
    drawn.iter().try_for_each(|(name, bytes)| folder.write(name, bytes))?;
    folder.write(REPORT, page_of(&place, &results, &manifest, &pictures)?.as_bytes())?;
    report::write(&folder, &results, &manifest)?;
    folder.finish(&manifest)?;
    progress.note(&format!("written to {}", place.display()));
    let of_known = study.known_views.iter().map(|&known| known_views_table(known));
    for name in iter::once(OF_LATENTS.name.to_owned()).chain(of_known) {
        if let Some(table) = results.table(&name) {
            writeln!(stdout, "{}", table_text::tables(table, Style::terminal()))?;
        }
    }
    let kinds = [
        ("report", vec![REPORT]),
        ("tables", vec![report::TABLES]),
        ("variants", vec![VARIANTS]),
        ("raw scores", vec![FILE_NAME]),
        ("pictures", pictures),
    ];
    write!(stdout, "{}", places(&place, kinds))?;
    Ok(if any { Exit::Success } else { Exit::NothingEvaluated })
}

/// Refuses variants that cannot be trained, before any is, and loads the models of those that name a folder.
fn finished<'s>(
    pipeline: &Pipeline,
    study: &'s StudyFile,
    imported: &ImportedViews,
    (path, cache): (&Path, &Path),
    seeds: &[Seed],
) -> Result<BTreeMap<&'s str, VariantModels>, BenchError> {
    let (there, known, is_sighted) = imported.numbers(pipeline);
    let known = if study.scored == Scored::Known { known } else { 0 };
    let mut finished = BTreeMap::new();
    for (number, variant) in study.variants.iter().enumerate() {
        let located =
            |error| VariantError { place: Some(scene_file::place_of_variant(number, path)), ..error };
        let spec = variant.training(&pipeline.file.training.model).map_err(located)?;
        variant.fits(there, known).map_err(located)?;
        variant.allowed_under(study.scored).map_err(located)?;
        if let Some(folder) = &variant.folder {
            let folder = beside_or_supplied(path, folder, cache)?;
            is_there(&folder)?;
            finished.insert(variant.name.as_str(), finished_model(pipeline, &folder, seeds)?);
        } else if spec.objective == Objective::ViewpointPredictive && !is_sighted {
            let reason = "the viewpoint-predictive model is trained on odometry: set views.odometry in the scene, or import views that have it";
            return Err(located(variant.refused(reason.to_owned())).into());
        }
    }
    Ok(finished)
}

/// The hash of each model that was trained elsewhere, by its variant.
fn hashes(finished: &BTreeMap<&str, VariantModels>) -> BTreeMap<String, String> {
    let hash = |models: &VariantModels| {
        models.iter().find_map(|(_, model)| Some(model.as_ref().ok()?.model.hash().to_owned()))
    };
    finished.iter().filter_map(|(name, models)| Some(((*name).to_owned(), hash(models)?))).collect()
}

/// Pictures of the first variant's first model.
#[derive(Default)]
struct Drawn {
    map: Option<latents::Map>,
    /// Of the most known views.
    worst: Option<Vec<u8>>,
}

/// The scores of all variants, trained where they are not `finished`.
fn scored(
    pipeline: &Pipeline,
    study: &StudyFile,
    views: &StudyViews,
    mut finished: BTreeMap<&str, VariantModels>,
    trunks: &Path,
    manifest: &mut Manifest,
) -> Result<(StudyScores, Drawn), BenchError> {
    let (mut scores, mut drawn) = (StudyScores::default(), Drawn::default());
    for &known in &study.known_views {
        let told = views.known_views(pipeline, known, Teller::Process)?.unwrap_or_default();
        if told.is_empty() {
            pipeline.progress.note(&format!(
                "known_views {known}: no scored object has that many known views. Its table stays empty: ask fewer"
            ));
        }
        for seed in 1..=study.seeds {
            scores.told(known, GAUSSIAN_PROCESS, Seed(seed), known_view_scores(&told));
        }
    }
    for (number, variant) in study.variants.iter().enumerate() {
        let started = Instant::now();
        let models = match finished.remove(variant.name.as_str()) {
            Some(models) => models,
            None => variant_models(pipeline, study, variant, views, trunks)?,
        };
        if let (0, Some((_, Ok(first))), Some(set)) = (number, models.first(), views.first_scored()) {
            drawn.map = latents::map(set, &latents::embeddings(&first.model, set)?)?;
        }
        for (seed, model) in models {
            match model {
                Ok(model) => {
                    scores.scored(&variant.name, seed, &variant_scores(pipeline, views, &model)?);
                    for &known in &study.known_views {
                        let (name, model) = (&variant.name, &*model.model);
                        let rows =
                            [(name.clone(), Teller::Model(model)), (with_process(name), Teller::Both(model))];
                        for (row, teller) in rows {
                            let told = views.known_views(pipeline, known, teller)?.unwrap_or_default();
                            let is_drawn = number == 0
                                && row == *name
                                && seed == Seed(1)
                                && Some(&known) == study.known_views.iter().max();
                            if let (true, Some(set)) = (is_drawn, views.first_asked()) {
                                drawn.worst = worst_png(set, known, &told)?;
                            }
                            scores.told(known, &row, seed, known_view_scores(&told));
                        }
                    }
                }
                Err(failure) => scores.failed(&variant.name, seed, &failure),
            }
        }
        manifest.took(&variant.name, started.elapsed());
    }
    Ok((scores, drawn))
}

/// What the study is about, and each variant, as Markdown.
fn variants(study: &StudyFile) -> String {
    let scored = match &study.views {
        Some(views) => format!("the views in {}", views.display()),
        None => study.scored.told().to_owned(),
    };
    let scored = match &study.scored_scene {
        Some(scene) => format!("{scored}, of {}", scene.display()),
        None => scored,
    };
    let notes = study.variants.iter().map(|variant| format!("- `{}`: {}\n", variant.name, variant.note));
    let (name, purpose, notes) = (&study.name, study.purpose.trim(), notes.collect::<String>());
    format!("# {name}\n\n{purpose}\n\nScored: {scored}.\n\n{notes}")
}
