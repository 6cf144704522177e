//! Stage `readouts`: read-outs of a model's measurement, fitted on the scene's validation views.

use super::{ModelRefusal, Pipeline, StageError, code, views};
use vantage_dataset::Split;
use vantage_dataset::store::Key;
use vantage_learn::Model;
use vantage_learn::readout::Readouts;

const FILE: &str = "readouts.json";

/// The read-outs of a model of looks from viewpoints, and what identifies the views that they are fitted on.
pub fn readouts(pipeline: &Pipeline, model: &Model) -> Result<(Readouts, String), StageError> {
    let viewing = model.viewing().expect("`load` refuses other models");
    let (set, seal) = views(pipeline, Split::Validation, pipeline.file.training.seed, &mut |_| ())?;
    let key = Key::new("readouts", &(code::SCORED, &seal, model.hash()))?;
    let fitted = pipeline.cache.json(&key, FILE, || {
        let too_few =
            || ModelRefusal::NoReadouts { scene: pipeline.file.name.clone(), views: set.views.len() };
        Ok(Readouts::fit(viewing, &set).map_err(ModelRefusal::Answer)?.ok_or_else(too_few)?)
    })?;
    Ok((fitted, seal))
}
