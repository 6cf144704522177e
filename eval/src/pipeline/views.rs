//! Stage `views`: single objects from known viewpoints.

use super::{Pipeline, StageError, code};
use serde::Serialize;
use std::collections::BTreeMap;
use vantage_dataset::store::{Key, read_manifest, read_views, write_views};
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_sim::checked::ViewConditions;
use vantage_sim::render::RendererInfo;
use vantage_sim::views::training_views;

/// What a model's manifest calls the hash of the conditions its views were made under.
pub const VIEW_CONDITIONS: &str = "view_conditions";

#[derive(Serialize)]
struct Inputs<'a> {
    code: &'static str,
    conditions: &'a ViewConditions,
    split: Split,
    instances: usize,
    seed: Seed,
    renderer: &'a RendererInfo,
}

/// The views of a split under a seed, and the seal that identifies them. `made` is told of instances as they are
/// rendered, where the cache has none.
pub fn views(
    pipeline: &Pipeline,
    split: Split,
    seed: Seed,
    made: &mut dyn FnMut(u64),
) -> Result<(ViewSet, String), StageError> {
    let conditions = pipeline.scene.view_conditions();
    let instances = conditions.views.instances(split);
    let inputs = Inputs {
        code: code::SIMULATED,
        conditions: &conditions,
        split,
        instances,
        seed,
        renderer: &pipeline.renderer_info,
    };
    let entry = pipeline.cache.entry(&Key::new("views", &inputs)?, |folder| {
        let mut done = 0;
        let set = training_views(
            &conditions,
            split,
            instances,
            seed,
            pipeline.renderer.borrow_mut().as_mut(),
            &mut |progress| {
                made(progress.done - done);
                done = progress.done;
            },
        )?;
        let provenance = BTreeMap::from([("seed".to_owned(), seed.0.into())]);
        write_views(folder, &set, provenance)?;
        Ok(())
    })?;
    Ok((read_views(&entry.folder)?, read_manifest(&entry.folder)?.seal))
}
