//! Why real data is not imported.

use crate::exit::Ends;
use std::path::PathBuf;
use thiserror::Error;

/// Why real data is not imported.
#[derive(Debug, Error)]
pub enum ImportRefusal {
    /// A folder to import from lacks an object that was asked for.
    #[error("{} holds no object {name}: look what --objects names (of BigBIRD, a folder with a calibration.h5; of BOP, such as obj_000001; of photographs, what stands before `__`)", folder.display())]
    NoObject {
        name: String,
        /// Where it was looked for.
        folder: PathBuf,
    },
    /// A folder to import from holds no object.
    #[error(
        "{} holds no object, that is, no folder with a calibration.h5: name the folder of the objects' folders",
        folder.display()
    )]
    NoObjects { folder: PathBuf },
    /// A folder to import from is that of an object, in place of that of all.
    #[error("{} holds the files of one object: name the folder above it", folder.display())]
    OneObject { folder: PathBuf },
    /// A scene to be like is of no use to a view set of photographs.
    #[error("--like is for `avd` and `bop`, whose odometry is made of true motions")]
    NoMotion,
    /// Objects or a split are chosen of an episode, which has all objects and no split.
    #[error("{option} is for a view set: add --views")]
    ForViewSets { option: &'static str },
    /// A view set is asked for of a layout that gives nothing else.
    #[error(
        "--views is for `avd` and `bop`, which give episodes without it: leave it out, a view set is written anyway"
    )]
    ViewsAnyway,
    /// A camera is described to a layout that has its own.
    #[error("{option} is for `folder`, whose files do not say it: leave it out")]
    ForPhotographs { option: &'static str },
}

impl Ends for ImportRefusal {}
