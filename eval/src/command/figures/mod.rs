//! `bench figures SCENE --out DIR`: what a model makes of objects it has not seen, as pictures.

pub mod latents;
pub mod looks;

use crate::command::cli::FiguresArgs;
use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::pipeline::{Pipeline, any_model, check_unseen, chosen_model, imported_views, views};
use crate::result::output_folder::OutputFolder;
use crate::score::instance_posterior::KnownInstances;
use looks::Looks;
use std::io::Write;
use vantage_dataset::{Seed, Split, ViewSet};

/// File of what is predicted beside what is seen.
pub const PREDICTIONS: &str = "predictions.png";
/// Of the likelihood of viewpoints.
pub const VIEWPOINTS: &str = "viewpoints.png";

/// Draws the test instances of the scene's first seed, or those of an imported view set: their latents as t-SNE and, of models that
/// know looks from viewpoints, predictions, likelihoods over viewpoints, and the calibration of their noise.
pub fn figures(args: &FiguresArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let pipeline = Pipeline::open(&args.scene, &args.making.cache, args.making.renderer.into())?;
    let chosen = chosen_model(&pipeline, false, args.model.as_deref())?;
    let (model, folder) = any_model(&pipeline, chosen.as_deref())?;
    let seed = pipeline.file.evaluation.seeds.as_slice().first().copied().unwrap_or(Seed(0));
    let set = match &args.views {
        Some(folder) => imported_views(folder, "--views")?.set,
        None => views(&pipeline, Split::Test, seed, &mut |_| ())?.0,
    };
    check_unseen(model.training_instances(), &folder, set.instances.iter().map(|instance| instance.id))?;

    let embeddings = latents::embeddings(&model, &set)?;
    let mut drawn = Vec::new();
    match latents::map(&set, &embeddings)? {
        Some((svg, png)) => {
            drawn.extend([(latents::LATENTS_DOTS, svg.into_bytes()), (latents::LATENTS, png)])
        }
        None => pipeline.progress.note(&format!(
            "note: no {} and {}: {} views are too few for t-SNE",
            latents::LATENTS,
            latents::LATENTS_DOTS,
            set.views.len()
        )),
    }
    drawn.extend(posteriors(&set, &embeddings)?.map(|csv| ("posterior.csv", csv)));
    match model.viewing() {
        Some(viewing) => {
            let looks = Looks::new(&set, viewing)?;
            if looks.any() {
                match looks.predictions()? {
                    Some(png) => drawn.push((PREDICTIONS, png)),
                    None => pipeline.progress.note("note: no predictions.png: the model has no graph image"),
                }
                drawn.extend(looks.viewpoints()?.map(|png| (VIEWPOINTS, png)));
                drawn.extend(looks.calibration()?.map(|svg| ("calibration.svg", svg)));
            } else {
                pipeline.progress.note(
                    "note: no predictions.png, viewpoints.png and calibration.svg: no object has views of two sessions (views.sessions)",
                );
            }
        }
        None => pipeline.progress.note(
            "note: no predictions.png, viewpoints.png and calibration.svg: the model does not know looks from viewpoints",
        ),
    }
    if drawn.is_empty() {
        return Ok(Exit::NothingEvaluated);
    }
    for (name, bytes) in drawn {
        out.write(name, &bytes)?;
        writeln!(stdout, "{}", out.path().join(name).display())?;
    }
    Ok(Exit::Success)
}

/// Which of the instances that even sessions show made each view of the odd ones, `P(beta | z)`, with its probability; `None` where
/// an instance has no view of an even session.
fn posteriors(set: &ViewSet, embeddings: &[Vec<f32>]) -> Result<Option<Vec<u8>>, BenchError> {
    let of = |odd: usize| {
        set.views.iter().zip(embeddings).enumerate().filter(move |(_, (v, _))| v.session % 2 == odd)
    };
    let (known, instances): (Vec<Vec<f32>>, Vec<usize>) =
        of(0).map(|(_, (view, embedding))| (embedding.clone(), view.instance)).unzip();
    let Some(known) = KnownInstances::fit(&known, &instances, set.instances.len()) else { return Ok(None) };
    let names = latents::names(set);
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["view", "instance", "most_likely", "probability", "probability_of_instance"])?;
    for (index, (view, embedding)) in of(1) {
        let posterior = known.posterior(embedding);
        let (found, most) =
            posterior.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        let (own, right) = (&names[view.instance], posterior[view.instance]);
        writer.write_record([
            &index.to_string(),
            own,
            &names[found],
            &most.to_string(),
            &right.to_string(),
        ])?;
    }
    Ok(Some(writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?))
}
