//! The cells of a map, with the scene and the model of all that runs in each.

use crate::pipeline::Pass;
use crate::scene_file::SceneFile;
use crate::scene_file::map::{Estimates, MapFile, Panel};
use crate::scene_file::vary::{VaryError, told, varied};
use std::path::Path;

/// Every cell's name and what runs in it, panel by panel; refuses what no scene can have before anything runs.
pub fn passes(map: &MapFile, path: &Path, base: &SceneFile) -> Result<Vec<(String, Vec<Pass>)>, VaryError> {
    let beside = path.parent().unwrap_or(Path::new(""));
    let mut cells = Vec::new();
    for panel in &map.panels {
        for value in &map.across.over {
            let at = || format!("panel {}, {} {}", panel.name, map.across.field, told(value));
            let refused = |reason| VaryError { path: path.to_owned(), what: at(), reason };
            let mut fields = panel.set.clone();
            fields.extend(map.across.at(value));
            let scene = varied(base, &fields).map_err(refused)?;
            let pass = |estimates: &Estimates| {
                let mut scene = varied(&scene, &estimates.set).map_err(refused)?;
                scene.estimator.rows.clone_from(&estimates.rows);
                let model = estimates.model.as_ref().map(|model| beside.join(model));
                Ok(Pass { scene, model })
            };
            let passes = map.estimates_of(panel).iter().map(pass).collect::<Result<_, _>>()?;
            cells.push((map.cell_name(panel, value), passes));
        }
    }
    rows_differ(map, path)?;
    Ok(cells)
}

/// A row that runs twice in a cell has no name of its own, but for those that are named after their models.
fn rows_differ(map: &MapFile, path: &Path) -> Result<(), VaryError> {
    let twice = |panel: &&Panel| {
        let rows: Vec<_> = map.estimates_of(panel).iter().flat_map(|estimates| &estimates.rows).collect();
        rows.iter().enumerate().any(|(i, row)| !row.is_of_model() && rows[..i].contains(row))
    };
    match map.panels.iter().find(twice) {
        Some(panel) => Err(VaryError {
            path: path.to_owned(),
            what: format!("panel {}", panel.name),
            reason: "a row that is not of a model runs twice: leave it out of all but one of `estimates`"
                .to_owned(),
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::parse;
    use vantage_sim::scene::PathSpec;

    const MAP: &str = "\
version: 1
name: mine
purpose: To show it.
scene: tabletop.yaml
across: { field: robot.path.circle.radius, over: [1.6, 1.7] }
estimates:
  - { rows: [odometry, geometric] }
  - { rows: [viewpoint_dependent], model: m, set: { estimator.semantic_noise_scale: 2 } }
panels:
  - { name: a, title: As it is }
  - { name: b, title: Three, set: { world.objects: 3 } }
";

    fn expanded(map: &str) -> Result<Vec<(String, Vec<Pass>)>, String> {
        let base = parse(include_str!("../../../../scenes/tabletop.yaml"), Path::new("s")).unwrap();
        let map: MapFile = parse(map, Path::new("m")).unwrap();
        passes(&map, Path::new("maps/m.yaml"), &base).map_err(|error| error.to_string())
    }

    #[test]
    fn a_cell_has_the_fields_of_its_panel_and_value_and_the_rows_of_each_model() {
        let cells = expanded(MAP).unwrap();
        assert_eq!(cells.len(), 4);
        let (name, passes) = &cells[3];
        assert_eq!((name.as_str(), passes.len()), ("b, radius 1.7", 2));
        let scene = &passes[1].scene;
        assert_eq!(scene.robot.path, PathSpec::Circle { radius: 1.7 });
        assert_eq!((scene.world.objects, scene.estimator.semantic_noise_scale), (3, 2.0));
        assert_eq!(passes[0].scene.estimator.semantic_noise_scale, 1.0);
        assert_eq!(passes[1].model.as_deref(), Some(Path::new("maps/m")));
        assert_eq!(passes[0].scene.estimator.rows.len(), 2);
    }

    #[test]
    fn what_cannot_be_is_told_with_panel_and_value() {
        for (from, to, said) in [
            ("over: [1.6, 1.7]", "over: [1.6, 0.3]", "maps/m.yaml: panel a, robot.path.circle.radius 0.3: "),
            ("world.objects: 3", "world.objects: none", "panel b, robot.path.circle.radius 1.6: "),
            (
                "rows: [viewpoint_dependent]",
                "rows: [geometric]",
                "panel a: a row that is not of a model runs twice",
            ),
        ] {
            let error = expanded(&MAP.replace(from, to)).unwrap_err();
            assert!(error.contains(said), "{said} not in: {error}");
        }
    }
}
