//! Which meshes a path stands for.

use super::{MeshFault, MeshFileError};
use std::fs;
use std::path::{Path, PathBuf};

/// Where known collections keep the mesh of a model, relative to the model's folder: YCB, Google Scanned Objects.
const LAYOUTS: [&str; 5] =
    ["textured.obj", "google_16k/textured.obj", "tsdf/textured.obj", "meshes/model.obj", "model.obj"];
/// Where Google Scanned Objects keep textures.
const TEXTURES: &str = "materials/textures";
const ENDINGS: [&str; 3] = ["obj", "gltf", "glb"];
/// Most meshes that one path may stand for.
pub(crate) const MAX_MESHES: usize = 10_000;

/// One mesh on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Source {
    /// The model's name: that of its folder in a known layout or alone in its folder, else that of the file.
    pub name: String,
    pub file: PathBuf,
    /// The folder that everything the mesh names has to lie in.
    pub root: PathBuf,
    /// Where else textures may lie.
    pub textures: Option<PathBuf>,
    /// A licence file in the model's folder or in that of the collection.
    pub licence: Option<PathBuf>,
}

impl Source {
    pub fn error(&self, fault: MeshFault) -> MeshFileError {
        MeshFileError { path: self.file.clone(), fault }
    }
}

/// The meshes of a file, of a model's folder, or of a folder of such, by name.
pub(crate) fn find(path: &Path) -> Result<Vec<Source>, MeshFileError> {
    let unreadable = |error| MeshFileError { path: path.to_owned(), fault: MeshFault::Unreadable(error) };
    if fs::metadata(path).map_err(unreadable)?.is_file() {
        if !is_mesh(path) {
            return Err(MeshFileError { path: path.to_owned(), fault: MeshFault::UnknownFormat });
        }
        return Ok(vec![named_file(path)]);
    }
    let mut found = model_folder(path)?;
    if found.is_empty() {
        for folder in entries(path)?.into_iter().filter(|entry| entry.is_dir()) {
            let models = model_folder(&folder)?;
            if models.is_empty() {
                return Err(MeshFileError { path: folder, fault: MeshFault::NoMeshInFolder });
            }
            found.extend(models);
            if found.len() > MAX_MESHES {
                let fault =
                    MeshFault::TooMany { what: "meshes or more", got: found.len(), limit: MAX_MESHES };
                return Err(MeshFileError { path: path.to_owned(), fault });
            }
        }
    }
    if found.is_empty() {
        return Err(MeshFileError { path: path.to_owned(), fault: MeshFault::NoMeshInFolder });
    }
    let common = licence(path);
    found.iter_mut().for_each(|source| source.licence = source.licence.take().or_else(|| common.clone()));
    Ok(found)
}

/// A file that was named itself; its model is the folder if the layout is known.
fn named_file(file: &Path) -> Source {
    let layout = LAYOUTS.into_iter().find(|layout| file.ends_with(layout) && layout.contains('/'));
    let layout = layout.or_else(|| LAYOUTS.into_iter().find(|layout| file.ends_with(layout)));
    let parent = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match layout {
        Some(layout) => {
            let root = if layout.contains('/') { parent.join("..") } else { parent.to_owned() };
            let folder = fs::canonicalize(&root).unwrap_or_default();
            in_layout(&root, file.to_owned(), file_name(&folder))
        }
        None => alone(parent, file.to_owned()),
    }
}

/// The meshes of a model's folder: the one of a known layout, or else every mesh file; none if there is none.
fn model_folder(folder: &Path) -> Result<Vec<Source>, MeshFileError> {
    let canonical = fs::canonicalize(folder)
        .map_err(|error| MeshFileError { path: folder.to_owned(), fault: MeshFault::Unreadable(error) })?;
    let name = file_name(&canonical);
    for layout in LAYOUTS {
        let file = folder.join(layout);
        if file.is_file() {
            return Ok(vec![in_layout(folder, file, name)]);
        }
    }
    let files: Vec<PathBuf> =
        entries(folder)?.into_iter().filter(|entry| is_mesh(entry) && entry.is_file()).collect();
    let mut found: Vec<Source> = files.into_iter().map(|file| alone(folder, file)).collect();
    if let [only] = found.as_mut_slice() {
        only.name = name;
    }
    Ok(found)
}

fn in_layout(root: &Path, file: PathBuf, name: String) -> Source {
    let textures = Some(root.join(TEXTURES)).filter(|folder| folder.is_dir());
    Source { name, file, root: root.to_owned(), textures, licence: licence(root) }
}

fn alone(folder: &Path, file: PathBuf) -> Source {
    // `barrel.gltf.glb` is a barrel.
    let name = file_name(&file).split('.').next().unwrap_or_default().to_owned();
    Source { name, file, root: folder.to_owned(), textures: None, licence: licence(folder) }
}

/// What lies in a folder, by name, without what is hidden or begins with an underscore.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, MeshFileError> {
    let list = || -> std::io::Result<Vec<PathBuf>> {
        fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect()
    };
    let mut entries = list()
        .map_err(|error| MeshFileError { path: folder.to_owned(), fault: MeshFault::Unreadable(error) })?;
    entries.retain(|entry| !file_name(entry).starts_with(['.', '_']));
    entries.sort();
    Ok(entries)
}

fn is_mesh(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    ENDINGS.contains(&ending.as_str())
}

fn licence(folder: &Path) -> Option<PathBuf> {
    let files = entries(folder).ok()?.into_iter();
    files.filter(|file| file.is_file()).find(|file| {
        let name = file_name(file).to_ascii_uppercase();
        ["LICENCE", "LICENSE", "COPYING"].iter().any(|known| name.starts_with(known))
    })
}

/// The last part of a path, for messages.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
