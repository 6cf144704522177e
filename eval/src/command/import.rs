//! `bench import LAYOUT DIR --out DIR`: real data in our own layout.

use crate::cli::{ImportArgs, ImportLayout};
use crate::exit::{BenchError, Exit};
use crate::output::OutputFolder;
use crate::progress::Progress;
use std::collections::BTreeMap;
use std::io::Write;
use vantage_dataset::layout::avd::read_scan;
use vantage_dataset::layout::bigbird::{object_folders, read_objects};
use vantage_dataset::store::{write_episode, write_views};

/// Skipped files that are told one by one.
const TOLD: usize = 10;

/// Reads, writes, and tells what was left out.
pub fn import(args: &ImportArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    if args.out.is_file() {
        return Err(BenchError::NotOurs { folder: args.out.clone() });
    }
    let progress = Progress::detect();
    let out = OutputFolder::probe(&args.out)?;
    let _lock = out.lock(&progress)?;
    if !out.is_empty()? {
        return Err(BenchError::NotOurs { folder: args.out.clone() });
    }
    let source = args.source.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let provenance = BTreeMap::from([("imported".to_owned(), source.into())]);
    let (report, what) = match args.layout {
        ImportLayout::Bigbird => {
            let mut folders = object_folders(&args.source)?;
            if folders.is_empty() {
                return Err(BenchError::NoObject {
                    name: "of any object".to_owned(),
                    folder: args.source.clone(),
                });
            }
            let missing =
                args.objects.iter().find(|name| !folders.iter().any(|folder| folder.ends_with(name)));
            if let Some(name) = missing {
                return Err(BenchError::NoObject { name: name.clone(), folder: args.source.clone() });
            }
            folders.retain(|folder| {
                args.objects.is_empty() || args.objects.iter().any(|name| folder.ends_with(name))
            });
            let (set, report) = read_objects(&folders, args.split.into(), &|_| true)?;
            write_views(out.path(), &set, provenance)?;
            (report, format!("views of {} objects", set.instances.len()))
        }
        ImportLayout::Avd => {
            let scan = read_scan(&args.source)?;
            write_episode(out.path(), &scan.episode, provenance)?;
            let steps = scan.episode.observations.steps();
            (scan.report, format!("detections in {steps} images"))
        }
    };
    for skipped in report.skipped.iter().take(TOLD) {
        progress.note(&format!("left out: {skipped}"));
    }
    if report.skipped.len() > TOLD {
        progress.note(&format!("left out: {} more", report.skipped.len() - TOLD));
    }
    writeln!(stdout, "{} {what} written to {}", report.views, args.out.display())?;
    Ok(if report.views == 0 { Exit::NothingEvaluated } else { Exit::Success })
}
