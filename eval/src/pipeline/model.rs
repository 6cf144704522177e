//! Stage `model`: the scene's committed model, one that the user names, or one trained here.

use super::object_process::object_process;
use super::readouts::readouts;
#[cfg(feature = "train")]
use super::training::trained;
use super::{ModelRefusal, Pipeline, StageError, VIEW_CONDITIONS};
use crate::scene_file::row::{Reader, Row};
use crate::scene_file::row_name::{folder_name, kind_name, reserved_names};
use crate::scene_file::{self, SceneFile};
use crate::supplied;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{StoreError, read_regular};
use vantage_dataset::{InstanceId, ViewSet};
use vantage_learn::readout::Readouts;
use vantage_learn::residual_process::ResidualHyperparameters;
use vantage_learn::{
    DecoderLastLayer, Frames, Kind, LARGEST_FILE, MANIFEST, Model, Objective, Role, Viewing,
};

/// A model ready for the estimator.
pub struct LoadedModel {
    /// The model, one of looks from viewpoints.
    pub model: Model,
    /// The name of its rows.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Its read-outs, where a row of the scene reads one, and what identifies the views that they are fitted on.
    pub readouts: Option<(Readouts, String)>,
    /// How far it is off, where a row of the scene has a process beside it, and what identifies the views that this is fitted on.
    pub process: Option<(ResidualHyperparameters, String)>,
}

impl LoadedModel {
    /// The model as the estimator takes it.
    pub fn viewing(&self) -> &dyn Viewing {
        self.model.viewing().expect("`load` refuses other models")
    }

    /// What rows read crops by.
    pub fn reader(&self) -> Reader<'_> {
        Reader {
            model: self.viewing(),
            pairs: self.model.pairs(),
            readouts: self.readouts.as_ref().map(|(readouts, _)| readouts),
            ideal: None,
            process: None,
            processes: None,
            layer: None,
            seen: None,
        }
    }

    /// Whether the yaws that it tells are in the frames of truth: those of a family's front, which training told it.
    pub fn shares_frames(&self) -> bool {
        let manifest = self.model.manifest();
        let trained = manifest.training.details.as_ref();
        manifest.kind == Kind::ViewpointDependent
            && trained.is_none_or(|details| details.spec.frames == Frames::Canonical)
    }

    /// Refuses to score instances that the model has seen.
    pub fn check_unseen(&self, scored: impl IntoIterator<Item = InstanceId>) -> Result<(), StageError> {
        check_unseen(self.model.training_instances(), &self.folder, scored)
    }

    /// Likewise, all instances of a view set.
    pub fn check_set(&self, set: &ViewSet) -> Result<(), StageError> {
        self.check_unseen(set.instances.iter().map(|instance| instance.id))
    }
}

/// Refuses to score instances that a model has `seen`.
pub fn check_unseen(
    seen: &BTreeSet<InstanceId>,
    folder: &Path,
    scored: impl IntoIterator<Item = InstanceId>,
) -> Result<(), StageError> {
    match scored.into_iter().find(|instance| seen.contains(instance)) {
        Some(instance) => Err(ModelRefusal::Leak { instance, folder: folder.to_owned() }.into()),
        None => Ok(()),
    }
}

/// The folder of the model that a scene names: relative to the scene or, where there is none, the model of that name that comes with
/// the program. `None` where the scene names none.
pub fn reference_model(file: &SceneFile, scene: &Path, cache: &Path) -> Result<Option<PathBuf>, StoreError> {
    file.training.reference.as_ref().map(|path| beside_or_supplied(scene, path, cache)).transpose()
}

/// The folder of a model that a file names: relative to the file or, where there is none, the model of that name that comes with the program.
pub fn beside_or_supplied(file: &Path, folder: &Path, cache: &Path) -> Result<PathBuf, StoreError> {
    let beside = file.parent().unwrap_or(Path::new("")).join(folder);
    let supplied = folder.file_name().and_then(|name| name.to_str()).filter(|_| !beside.is_dir());
    match supplied {
        Some(name) => Ok(supplied::model(name, cache)?.unwrap_or(beside)),
        None => Ok(beside),
    }
}

/// The folder of the model to load, the named one before the scene's own; `None` to train one.
pub fn chosen_model(
    pipeline: &Pipeline,
    train: bool,
    named: Option<&Path>,
) -> Result<Option<PathBuf>, StageError> {
    let own = || pipeline.reference.clone();
    let chosen = if train { None } else { named.map(Path::to_owned).or_else(own) };
    match chosen {
        Some(folder) if !folder.is_dir() => Err(match named {
            Some(_) => ModelRefusal::NotThere { folder },
            None => ModelRefusal::NoReference { folder },
        }
        .into()),
        #[cfg(not(feature = "train"))]
        None => trained(pipeline).map(Some),
        chosen => Ok(chosen),
    }
}

/// What identifies the model in a folder, without loading it; `None` where there is none.
pub fn model_hash(folder: &Path) -> Option<String> {
    Some(blake3::hash(&read_regular(&folder.join(MANIFEST), LARGEST_FILE).ok()?).to_hex().to_string())
}

/// What the rows of models that the user names are called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Naming {
    /// After their folders.
    Folder,
    /// After their kinds, as those of a scene's own model: to be compared with them.
    Kind,
}

/// Likewise, of the models that the user `named`, the scene's own where there is none.
pub fn chosen_models(
    pipeline: &Pipeline,
    train: bool,
    named: &[PathBuf],
) -> Result<Vec<Option<PathBuf>>, StageError> {
    match named {
        [] => Ok(vec![chosen_model(pipeline, train, None)?]),
        named => named.iter().map(|folder| chosen_model(pipeline, train, Some(folder))).collect(),
    }
}

/// Loads the models that were `chosen`, or trains one. Their rows' names differ from each other, from those of the scene's other rows,
/// and from `others`.
pub fn models(
    pipeline: &Pipeline,
    chosen: &[Option<PathBuf>],
    naming: Naming,
    others: &[&str],
) -> Result<Vec<LoadedModel>, StageError> {
    let mut taken = reserved_names();
    taken.extend(others.iter().map(|&name| name.to_owned()));
    let load = |(index, chosen): (usize, &Option<PathBuf>)| {
        let loaded = match chosen {
            // Rows that there is one of, not one for each model, are of the first.
            Some(folder) if index > 0 => load(pipeline, folder, |row| row.is_of_model())?,
            chosen => model(pipeline, chosen.as_deref())?,
        };
        let folder = || loaded.folder.clone();
        let name = match naming {
            Naming::Kind => loaded.name.clone(),
            Naming::Folder => {
                folder_name(&loaded.folder).ok_or_else(|| ModelRefusal::Unnamed { folder: folder() })?
            }
        };
        if taken.contains(&name) {
            return Err(ModelRefusal::Named { folder: folder(), name }.into());
        }
        taken.push(name.clone());
        Ok(LoadedModel { name, ..loaded })
    };
    chosen.iter().enumerate().map(load).collect()
}

/// Loads the model in `folder`, or trains one where that is `None`.
pub fn model(pipeline: &Pipeline, folder: Option<&Path>) -> Result<LoadedModel, StageError> {
    if folder.is_none() && !pipeline.file.training.model.is_viewing() {
        return Err(ModelRefusal::ObjectiveNotViewing { scene: pipeline.file.name.clone() }.into());
    }
    let objective = pipeline.file.training.model.objective;
    let reads_pairs = pipeline.file.estimator.rows.iter().any(|row| row.reads_pairs());
    if folder.is_none() && reads_pairs && objective != Objective::ViewpointPredictive {
        return Err(ModelRefusal::ObjectiveNotOfPairs { scene: pipeline.file.name.clone() }.into());
    }
    load(pipeline, &named_or_trained(pipeline, folder)?, |_| true)
}

/// Likewise, a model of any kind, and its folder.
pub fn any_model(pipeline: &Pipeline, folder: Option<&Path>) -> Result<(Model, PathBuf), StageError> {
    let folder = named_or_trained(pipeline, folder)?;
    Ok((loaded(pipeline, &folder)?, folder))
}

fn named_or_trained(pipeline: &Pipeline, folder: Option<&Path>) -> Result<PathBuf, StageError> {
    match folder {
        Some(folder) => Ok(folder.to_owned()),
        None => trained(pipeline),
    }
}

#[cfg(not(feature = "train"))]
fn trained(_: &Pipeline) -> Result<PathBuf, StageError> {
    Err(crate::left_out::LeftOut::Training.into())
}

/// Loads the model in a folder, with what those rows of the scene need that are `of_it`.
fn load(pipeline: &Pipeline, folder: &Path, of_it: impl Fn(Row) -> bool) -> Result<LoadedModel, StageError> {
    let rows = || pipeline.file.estimator.rows.iter().copied().filter(|&row| of_it(row));
    let model = loaded(pipeline, folder)?;
    let kind = model.manifest().kind;
    if model.viewing().is_none() {
        return Err(ModelRefusal::NotViewing { folder: folder.to_owned(), kind }.into());
    }
    if rows().any(Row::reads_pairs) && model.pairs().is_none() {
        return Err(ModelRefusal::NotOfPairs { folder: folder.to_owned(), kind }.into());
    }
    let jacobian = match kind {
        Kind::ViewpointPredictive => Role::PredictorJacobian,
        _ => Role::DecoderJacobian,
    };
    if !model.manifest().graphs.contains_key(&jacobian) {
        let what =
            format!("has no graph {jacobian}: derivatives are by central differences, many times slower");
        note(pipeline, folder, &what);
    }
    if rows().any(Row::learns_layer) {
        last_layer(&model, folder)?;
    }
    let readouts = if rows().any(Row::reads_out) { Some(readouts(pipeline, &model)?) } else { None };
    let process = if rows().any(Row::has_process) { Some(object_process(pipeline, &model)?) } else { None };
    Ok(LoadedModel { name: kind_name(model.manifest()), model, folder: folder.to_owned(), readouts, process })
}

/// The last layer of the model in a folder; other models than viewpoint-dependent ones are refused.
pub fn last_layer<'m>(model: &'m Model, folder: &Path) -> Result<DecoderLastLayer<'m>, ModelRefusal> {
    let folder = || folder.to_owned();
    match model {
        Model::ViewpointDependent(of) => DecoderLastLayer::load(of, &folder())
            .map_err(|source| ModelRefusal::NoLastLayer { folder: folder(), source: Box::new(source) }),
        _ => Err(ModelRefusal::NotViewpointDependent { folder: folder(), kind: model.manifest().kind }),
    }
}

/// A model of any kind, with a note where its views were others than the scene's.
fn loaded(pipeline: &Pipeline, folder: &Path) -> Result<Model, StageError> {
    let model = Model::load(folder)?;
    if let Some(what) = caveat(pipeline, &model)? {
        note(pipeline, folder, what);
    }
    Ok(model)
}

/// What a reader of a model's scores in a scene has to know: that its views were others than the scene's.
pub fn caveat(pipeline: &Pipeline, model: &Model) -> Result<Option<&'static str>, StageError> {
    Ok(match model.manifest().training.provenance.get(VIEW_CONDITIONS) {
        None => Some("does not say what views it was trained on"),
        Some(views) if *views != scene_file::hash(&pipeline.scene.view_conditions())? => Some(
            "was trained under other views than this scene's (families, light, camera, noise, detector, viewpoints or their \
             number differ)",
        ),
        Some(_) => None,
    })
}

fn note(pipeline: &Pipeline, folder: &Path, what: &str) {
    let folder = folder.display();
    pipeline.progress.note(&format!("note: the model in {folder} {what}; it is scored as it is"));
}
