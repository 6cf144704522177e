//! Where a model puts views: the latents of single views, laid out by t-SNE, as in the paper's Fig. 2.

use crate::command::error::BenchError;
use crate::figure::embedding_map::EmbeddingMap;
use crate::figure::tsne::tsne;
use vantage_dataset::{Crop, ViewSet};
use vantage_learn::Model;

/// File of the map with images beside it.
pub const LATENTS: &str = "latents.png";
/// Of the map without.
pub const LATENTS_DOTS: &str = "latents.svg";

/// A map as SVG, and with images beside it as PNG.
pub type Map = (String, Vec<u8>);

/// The latent of each view, by its invariant numbers.
pub fn embeddings(model: &Model, set: &ViewSet) -> Result<Vec<Vec<f32>>, BenchError> {
    let narrowed = |numbers: Vec<f64>| numbers.into_iter().map(|number| number as f32).collect();
    set.views.iter().map(|view| Ok(narrowed(model.embed(&view.crop, Some(&view.viewpoint))?))).collect()
}

/// The map of the embeddings of all views as SVG, and with images as PNG; `None` where t-SNE has too few.
pub fn map(set: &ViewSet, embeddings: &[Vec<f32>]) -> Result<Option<Map>, BenchError> {
    let Some(points) = tsne(embeddings) else { return Ok(None) };
    let groups: Vec<usize> = set.views.iter().map(|view| view.instance).collect();
    let names = names(set);
    let crops: Vec<&Crop> = set.views.iter().map(|view| &view.crop).collect();
    let title = format!("t-SNE of latents, one of each view; a colour for each of {} instances", names.len());
    let map = EmbeddingMap { title: &title, points: &points, groups: &groups, names: &names, crops: &crops };
    Ok(Some((map.svg()?, map.png()?)))
}

/// Family and number of each instance, as titles have it.
pub fn names(set: &ViewSet) -> Vec<String> {
    let name = |index: usize| {
        let family = &set.instances[index].family;
        let before = set.instances[..index].iter().filter(|other| other.family == *family).count();
        format!("{family} {}", before + 1)
    };
    (0..set.instances.len()).map(name).collect()
}
