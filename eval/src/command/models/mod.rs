//! `bench models DIR...`: what model folders hold.

pub mod error;

use crate::command::cli::ModelsArgs;
use crate::command::error::BenchError;
use crate::command::folder::is_there;
use crate::exit::Exit;
use crate::result::grid::{Style, draw};
use crate::result::statistics::quantile;
use error::Refused;
use std::io::Write;
use std::path::Path;
use std::time::Instant;
use vantage_learn::{GraphRecord, Manifest, Model, Role};

/// Runs of a graph that are timed, after as many that are not; the median is told.
const TIMED: usize = 31;

/// Loads each model with all checks, and prints what it is; the error tells why those are refused that are.
pub fn models(args: &ModelsArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    args.folders.iter().try_for_each(|folder| is_there(folder))?;
    let mut refusals = Vec::new();
    for folder in &args.folders {
        writeln!(stdout, "{}\n", folder.display())?;
        let model = match Model::load(folder) {
            Ok(model) => model,
            Err(error) => {
                writeln!(stdout, "refused: see the error at the end\n")?;
                refusals.push(error);
                continue;
            }
        };
        write!(stdout, "{}", described(&model))?;
        let graphs = &model.manifest().graphs;
        let rows = graphs.iter().map(|(&role, record)| row(&model, folder, role, record));
        let rows = rows.collect::<Result<_, BenchError>>()?;
        let head = ["Graph", "File", "KiB", "Call [ms]", "Inputs", "Outputs"].map(String::from);
        writeln!(stdout, "\n{}\n", draw(Style::terminal(), &head, rows))?;
    }
    if refusals.is_empty() { Ok(Exit::Success) } else { Err(Refused(refusals).into()) }
}

fn described(model: &Model) -> String {
    let Manifest { kind, latent, measurement, conditioning, residual, training, .. } = model.manifest();
    let mut lines = vec![("kind", kind.to_string())];
    lines.push((
        "latent",
        match latent.steerable {
            Some(layout) => format!(
                "{} numbers: {} that do not turn, {} pairs that do",
                latent.dimension,
                layout.invariant,
                layout.pairs()
            ),
            None => format!("{} numbers", latent.dimension),
        },
    ));
    lines.extend(measurement.map(|size| ("measurement", format!("{size} numbers"))));
    lines.extend(conditioning.map(|convention| ("conditioning", convention.to_string())));
    lines.extend(residual.as_ref().map(|residual| {
        let (degrees, count) = (residual.degrees_of_freedom, residual.residuals);
        ("noise", format!("Student t with {degrees:.1} degrees of freedom, fitted to {count} residuals"))
    }));
    lines.push(("origin", training.origin.clone()));
    lines.push(("data", training.data_hash.clone()));
    lines.push(("instances", format!("{} known, none of which is scored", model.training_instances().len())));
    if let Some(details) = &training.details {
        let steps = [details.spec.trunk_steps, details.spec.steps];
        lines.push(("trained on", format!("{} views of {} instances", details.views, details.instances)));
        lines.push(("steps", format!("{} and {}, seed {}", steps[0], steps[1], details.seed.0)));
    }
    lines.extend(training.provenance.iter().map(|(what, value)| (what.as_str(), value.clone())));
    lines.push(("hash", model.hash().to_owned()));
    let width = lines.iter().map(|(what, _)| what.len()).max().unwrap_or(0);
    lines.into_iter().map(|(what, value)| format!("{what:width$}  {value}\n")).collect()
}

fn row(model: &Model, folder: &Path, role: Role, record: &GraphRecord) -> Result<Vec<String>, BenchError> {
    let bytes = std::fs::metadata(folder.join(&record.file)).map_or(0, |file| file.len());
    let shapes = |side: &std::collections::BTreeMap<String, Vec<usize>>| {
        let texts: Vec<_> = side.iter().map(|(name, shape)| format!("{name} {shape:?}")).collect();
        texts.join("\n")
    };
    Ok(vec![
        role.to_string(),
        record.file.clone(),
        (bytes / 1024).to_string(),
        format!("{:.3}", milliseconds(model, role)?),
        shapes(&record.inputs),
        shapes(&record.outputs),
    ])
}

/// Median time of a call.
fn milliseconds(model: &Model, role: Role) -> Result<f64, BenchError> {
    let mut times = Vec::with_capacity(2 * TIMED);
    for _ in 0..2 * TIMED {
        let start = Instant::now();
        model.replay(role)?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let timed = &mut times[TIMED..];
    timed.sort_by(f64::total_cmp);
    Ok(quantile(timed, 0.5).unwrap_or(f64::NAN))
}
