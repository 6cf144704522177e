//! Objects of BigBIRD.

use super::error::ImportRefusal;
use super::{Imported, all_are_there, split};
use crate::command::cli::ImportArgs;
use crate::command::error::BenchError;
use vantage_formats::bigbird::{is_object, object_folders, read_objects, uncalibrated_folders};
use vantage_formats::{ImportReport, Skipped};

/// Reads the objects that are asked for, or all.
pub(super) fn bigbird(args: &ImportArgs) -> Result<(Imported, ImportReport), BenchError> {
    let mut folders = object_folders(&args.source)?;
    if folders.is_empty() {
        let folder = args.source.clone();
        let one = is_object(&folder);
        let refusal =
            if one { ImportRefusal::OneObject { folder } } else { ImportRefusal::NoObjects { folder } };
        return Err(refusal.into());
    }
    all_are_there(args, |name| folders.iter().any(|folder| folder.ends_with(name)))?;
    folders
        .retain(|folder| args.objects.is_empty() || args.objects.iter().any(|name| folder.ends_with(name)));
    let (set, mut report) = read_objects(&folders, split(args), &|_| true)?;
    if args.objects.is_empty() {
        let uncalibrated = uncalibrated_folders(&args.source)?.into_iter();
        let told = uncalibrated.map(|file| Skipped { file, reason: "no calibration.h5".to_owned() });
        report.skipped.splice(..0, told);
    }
    Ok((Imported::Views(set), report))
}
