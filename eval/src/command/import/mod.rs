//! `bench import LAYOUT DIR --out DIR`: real data in our own layout.

#[cfg(feature = "formats")]
mod bigbird;
mod bop;
pub mod error;
mod like;

use crate::command::cli::{ImportArgs, ImportLayout, SplitChoice};
use crate::command::error::BenchError;
use crate::command::folder::{FolderError, is_there};
use crate::exit::Exit;
use crate::pipeline::TRUE_MOTION;
use crate::progress::Progress;
use crate::result::output_folder::OutputFolder;
use error::ImportRefusal;
use like::Like;
use std::collections::BTreeMap;
use std::io::Write;
use vantage_dataset::store::{Provenance, write_episode, write_views};
use vantage_dataset::views::InstanceRecord;
use vantage_dataset::{Episode, ObjectTruth, Seed, Split, Symmetry, ViewSet};
use vantage_formats::avd::read_scan;
use vantage_formats::{ImportReport, Turntable, read_turned_photos};

/// Elevation of a camera that nobody named, degrees.
const ELEVATION_DEG: f64 = 25.0;
/// Distance of a camera that nobody named, in sizes of the object.
const DISTANCE: f64 = 5.0;
/// Skipped files that are told one by one.
const TOLD: usize = 10;

/// Reads, writes, and tells what was left out.
pub fn import(args: &ImportArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    is_there(&args.source)?;
    refuse_idle(args)?;
    let like = args.like.as_deref().map(Like::read).transpose()?;
    if args.out.is_file() {
        return Err(FolderError::NotOurs { folder: args.out.clone() }.into());
    }
    let progress = Progress::detect();
    let out = OutputFolder::probe(&args.out)?;
    let _lock = out.lock(&progress)?;
    if !out.is_empty()? {
        return Err(FolderError::NotOurs { folder: args.out.clone() }.into());
    }
    let source = args.source.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let provenance = Provenance::from([("imported".to_owned(), source.into())]);
    let (data, report) = match args.layout {
        #[cfg(feature = "formats")]
        ImportLayout::Bigbird => bigbird::bigbird(args)?,
        #[cfg(not(feature = "formats"))]
        ImportLayout::Bigbird => return Err(crate::left_out::LeftOut::Formats.into()),
        ImportLayout::Avd => avd(args, like.as_ref())?,
        ImportLayout::Bop => bop::bop(args, like.as_ref(), &progress)?,
        ImportLayout::Folder => folder(args, &progress)?,
    };
    tell(&report, &progress);
    let is_none = matches!(&data, Imported::Episodes(episodes) if episodes.is_empty());
    if report.views == 0 || is_none {
        let (folder, wanted) = (args.source.display(), wanted(args.layout));
        writeln!(stdout, "nothing to import in {folder}: nothing was written; looked for {wanted}")?;
        return Ok(Exit::NothingEvaluated);
    }
    let what = match &data {
        Imported::Views(set) => {
            write_views(out.path(), set, provenance)?;
            format!("views of {} objects", set.instances.len())
        }
        Imported::Episode(episode) => {
            write_episode(out.path(), episode, provenance)?;
            format!("detections in {} images", episode.observations.steps())
        }
        Imported::Episodes(episodes) => {
            for (name, episode) in episodes {
                let mut provenance = provenance.clone();
                provenance.insert("part".to_owned(), name.clone().into());
                let odometry = args.like.as_ref().map_or(TRUE_MOTION, |_| "drawn");
                provenance.insert("odometry".to_owned(), odometry.into());
                write_episode(&out.path().join(episode.seed.0.to_string()), episode, provenance)?;
            }
            format!(
                "detections in {} episodes, seeds 0 to {},",
                episodes.len(),
                episodes.len().saturating_sub(1)
            )
        }
    };
    writeln!(stdout, "{} {what} written to {}", report.views, args.out.display())?;
    Ok(Exit::Success)
}

/// Refuses options that the layout leaves without effect.
fn refuse_idle(args: &ImportArgs) -> Result<(), ImportRefusal> {
    let has_motion = matches!(args.layout, ImportLayout::Avd | ImportLayout::Bop);
    let of_view_sets = [("--objects", !args.objects.is_empty()), ("--split", args.split.is_some())];
    if let Some(option) = given(&of_view_sets).filter(|_| has_motion && !args.views) {
        return Err(ImportRefusal::ForViewSets { option });
    }
    if args.views && !has_motion {
        return Err(ImportRefusal::ViewsAnyway);
    }
    let of_photographs = [
        ("--elevation-deg", args.elevation_deg.is_some()),
        ("--distance", args.distance.is_some()),
        ("--clockwise", args.clockwise),
    ];
    if let Some(option) = given(&of_photographs).filter(|_| args.layout != ImportLayout::Folder) {
        return Err(ImportRefusal::ForPhotographs { option });
    }
    if !has_motion && args.like.is_some() {
        return Err(ImportRefusal::NoMotion);
    }
    Ok(())
}

/// The first option that is given.
fn given(options: &[(&'static str, bool)]) -> Option<&'static str> {
    options.iter().find(|(_, is_given)| *is_given).map(|(option, _)| *option)
}

/// Says what was left out, each line once.
fn tell(report: &ImportReport, progress: &Progress) {
    let most = if progress.is_verbose() { usize::MAX } else { TOLD };
    for line in lines(report, most) {
        progress.note(&format!("left out: {line}"));
    }
}

/// What was left out in the order of reading, equal lines as one; at most so many, and how many there are more.
fn lines(report: &ImportReport, most: usize) -> Vec<String> {
    let mut times: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for (place, line) in report.skipped.iter().map(ToString::to_string).enumerate() {
        times.entry(line).or_insert((place, 0)).1 += 1;
    }
    let mut in_order: Vec<(usize, String)> = times
        .into_iter()
        .map(|(line, (place, times))| {
            (place, if times > 1 { format!("{line} ({times} times)") } else { line })
        })
        .collect();
    in_order.sort();
    let more = in_order.len().saturating_sub(most);
    let shown = in_order.into_iter().take(most).map(|(_, line)| line);
    shown.chain((more > 0).then(|| format!("{more} more; --verbose tells all"))).collect()
}

/// What a layout's data consist of.
fn wanted(layout: ImportLayout) -> &'static str {
    match layout {
        ImportLayout::Bigbird => "folders of objects with photographs, masks and poses",
        ImportLayout::Avd => "images with boxes of objects and poses of cameras",
        ImportLayout::Bop => "scenes of three images or more, with objects that stand still and are seen",
        ImportLayout::Folder => "photographs named OBJECT__AZIMUTH.png or .jpg, such as cup__30.png",
    }
}

/// What was read, to be written.
enum Imported {
    Views(ViewSet),
    Episode(Box<Episode>),
    /// Each with the name of its part of the data, numbered by its seed.
    Episodes(Vec<(String, Episode)>),
}

fn avd(args: &ImportArgs, like: Option<&Like>) -> Result<(Imported, ImportReport), BenchError> {
    let mut scan = read_scan(&args.source)?;
    if !args.views {
        if let Some(like) = like {
            let name = args.source.file_name().unwrap_or_default().to_string_lossy().into_owned();
            return Ok((Imported::Episodes(like.drawn(&[(name, scan.episode)], args.draws)), scan.report));
        }
        return Ok((Imported::Episode(Box::new(scan.episode)), scan.report));
    }
    if let Some(like) = like {
        scan.episode = like.driven(&scan.episode, Seed(0));
    }
    all_are_there(args, |name| scan.episode.truth.objects.iter().any(|object| object.family == name))?;
    let takes = |object: &ObjectTruth| args.objects.is_empty() || args.objects.contains(&object.family);
    let (set, report) = scan.views(split(args), &takes);
    Ok((Imported::Views(set), report))
}

fn folder(args: &ImportArgs, progress: &Progress) -> Result<(Imported, ImportReport), BenchError> {
    let turntable = Turntable {
        elevation: args.elevation_deg.unwrap_or(ELEVATION_DEG).to_radians(),
        distance: args.distance.unwrap_or(DISTANCE),
        clockwise: args.clockwise,
    };
    let takes = |name: &str| args.objects.is_empty() || args.objects.iter().any(|object| object == name);
    let (set, report) = read_turned_photos(&args.source, split(args), &turntable, &takes)?;
    all_are_there(args, |name| set.instances.iter().any(|instance| instance.family == name))
        .inspect_err(|_| tell(&report, progress))?;
    for InstanceRecord { family, symmetry, .. } in &set.instances {
        match symmetry {
            Symmetry::None => {}
            Symmetry::Cyclic { order } => {
                progress.note(&format!(
                    "{family} looks the same after 1/{order} of a turn: azimuths are scored modulo that"
                ));
            }
            Symmetry::Revolution => {
                progress.note(&format!("{family} looks the same from all round: its azimuths are not asked"))
            }
        }
    }
    Ok((Imported::Views(set), report))
}

fn split(args: &ImportArgs) -> Split {
    args.split.unwrap_or(SplitChoice::Train).into()
}

/// Refuses names of objects that the data do not have.
fn all_are_there(args: &ImportArgs, known: impl Fn(&str) -> bool) -> Result<(), BenchError> {
    match args.objects.iter().find(|name| !known(name)) {
        Some(name) => {
            let (name, folder) = (name.clone(), args.source.clone());
            Err(ImportRefusal::NoObject { name, folder }.into())
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_formats::Skipped;

    #[test]
    fn equal_lines_are_told_once_and_in_the_order_of_reading() {
        let skipped = |reason: &str| Skipped { file: "b".into(), reason: reason.to_owned() };
        let report = ImportReport { views: 0, skipped: ["two", "one", "two", "three"].map(skipped).to_vec() };
        assert_eq!(lines(&report, 3), ["b: two (2 times)", "b: one", "b: three"]);
        assert_eq!(lines(&report, 1), ["b: two (2 times)", "2 more; --verbose tells all"]);
    }
}
