//! The cells of a map, with the scene and the model of all that runs in each.

use crate::pipeline::Pass;
use crate::scene_file::SceneFile;
use crate::scene_file::hypothesis::Hypothesis;
use crate::scene_file::map::MapFile;
use crate::scene_file::panel::{Estimates, Panel};
use crate::scene_file::row::Row;
use crate::scene_file::row_name::kind_names;
use crate::scene_file::vary::{VaryError, told, varied};
use std::path::Path;

/// A cell before it is made.
#[derive(Debug)]
pub struct Planned {
    /// Its name.
    pub name: String,
    /// Which drive of lives it is.
    pub drive: Option<u64>,
    /// What runs in it.
    pub passes: Vec<Pass>,
}

/// All cells, panel by panel, in sequences: each goes on from the one before in its sequence. Refuses what no scene can have before
/// anything runs.
pub fn sequences(map: &MapFile, path: &Path, base: &SceneFile) -> Result<Vec<Vec<Planned>>, VaryError> {
    rows_fit(map, path)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let mut sequences: Vec<Vec<Planned>> = Vec::new();
    for panel in &map.panels {
        for (at_value, value) in map.across.over.iter().enumerate() {
            let at = || format!("panel {}, {} {}", panel.name, map.across.field, told(value));
            let refused = |reason| VaryError { path: path.to_owned(), what: at(), reason };
            let drive = map.across.is_of_drives().then(|| value.as_u64()).flatten();
            let mut fields = panel.set.clone();
            match drive {
                Some(drive) => fields.extend(panel.world_of(drive)),
                None => fields.extend(map.across.at(value)),
            }
            let scene = varied(base, &fields).map_err(refused)?;
            let pass = |estimates: &Estimates| {
                let mut scene = varied(&scene, &estimates.set).map_err(refused)?;
                scene.estimator.rows.clone_from(&estimates.rows);
                let model = estimates.model.as_ref().map(|model| beside.join(model));
                Ok(Pass { scene, model, association: estimates.association })
            };
            let passes = map.estimates_of(panel).iter().map(pass).collect::<Result<_, _>>()?;
            let planned = Planned { name: map.cell_name(panel, value), drive, passes };
            match sequences.last_mut().filter(|_| drive.is_some() && !panel.alone && at_value > 0) {
                Some(sequence) => sequence.push(planned),
                None => sequences.push(vec![planned]),
            }
        }
    }
    Ok(sequences)
}

/// In each panel every row runs once but those of models, and `geometric` is among them; what hypotheses and the summary name runs.
fn rows_fit(map: &MapFile, path: &Path) -> Result<(), VaryError> {
    let refused =
        |what: String, reason: &str| VaryError { path: path.to_owned(), what, reason: reason.to_owned() };
    for panel in &map.panels {
        let rows = rows_of(map, panel);
        let of = || format!("panel {}", panel.name);
        if !rows.contains(&Row::Geometric) {
            return Err(refused(
                of(),
                "geometric is not among its rows, and gains are over it: add it to `estimates`",
            ));
        }
        if rows.iter().enumerate().any(|(i, row)| !row.is_of_model() && rows[..i].contains(row)) {
            let reason =
                "a row that is not of a model runs twice: leave it out of all but one of `estimates`";
            return Err(refused(of(), reason));
        }
        let asked = map.estimates_of(panel).iter().filter(|estimates| estimates.association.is_some());
        if let Some(row) = asked.flat_map(|of| &of.rows).find(|row| row.reads_truth() || row.is_taught()) {
            let reason = format!(
                "{row} reads the truth, by the objects that the episode tells: run it without an `association`"
            );
            return Err(refused(of(), &reason));
        }
    }
    for (i, hypothesis) in map.hypotheses.iter().enumerate() {
        let Hypothesis { panel, than_in, row, than, .. } = hypothesis;
        for (panel, row) in [(panel, row), (than_in.as_ref().unwrap_or(panel), than)] {
            if !runs(map, panel, row) {
                return Err(refused(
                    format!("hypotheses[{i}]"),
                    &format!("no row {row:?} runs in panel {panel}"),
                ));
            }
        }
    }
    if let Some(summary) = &map.summary {
        for row in &summary.rows {
            if !summary.panels.iter().any(|panel| runs(map, panel, row)) {
                return Err(refused("summary".to_owned(), &format!("no row {row:?} runs in its panels")));
            }
        }
    }
    Ok(())
}

fn rows_of(map: &MapFile, panel: &Panel) -> Vec<Row> {
    map.estimates_of(panel).iter().flat_map(|estimates| estimates.rows.iter().copied()).collect()
}

/// Whether a row of this name may run in a panel: which kind a model is of is seen when it is loaded.
fn runs(map: &MapFile, panel: &str, name: &str) -> bool {
    let named = |row: &Row| {
        if row.is_of_model() { kind_names().iter().any(|kind| kind == name) } else { row.to_string() == name }
    };
    map.panels.iter().any(|other| other.name == panel && rows_of(map, other).iter().any(named))
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

    fn expanded(map: &str) -> Result<Vec<Vec<Planned>>, String> {
        let base = parse(include_str!("../../../../scenes/tabletop.yaml"), Path::new("s")).unwrap();
        let map: MapFile = parse(map, Path::new("m")).unwrap();
        sequences(&map, Path::new("maps/m.yaml"), &base).map_err(|error| error.to_string())
    }

    #[test]
    fn drives_of_a_life_are_a_sequence_of_worlds_and_those_alone_are_none() {
        let map = MAP
            .replace(
                "{ field: robot.path.circle.radius, over: [1.6, 1.7] }",
                "{ field: drive, over: [1, 2, 3] }",
            )
            .replace(
                "title: As it is",
                "title: As it is, life: [{ from: 1 }, { from: 3, set: { world.objects: 4 } }]",
            )
            .replace("title: Three,", "title: Three, alone: true, life: [{ from: 1 }],");
        let sequences = expanded(&map).unwrap();
        let lengths: Vec<usize> = sequences.iter().map(Vec::len).collect();
        assert_eq!(lengths, [3, 1, 1, 1]);
        let objects = |planned: &Planned| planned.passes[0].scene.world.objects;
        let life = &sequences[0];
        assert_eq!((life[0].drive, life[2].drive, life[2].name.as_str()), (Some(1), Some(3), "a, drive 3"));
        assert_eq!((objects(&life[0]), objects(&life[1]), objects(&life[2])), (12, 12, 4));
        assert_eq!(objects(&sequences[1][0]), 3);
    }

    #[test]
    fn a_cell_has_the_fields_of_its_panel_and_value_and_the_rows_of_each_model() {
        let cells = expanded(MAP).unwrap();
        assert_eq!(cells.iter().map(Vec::len).collect::<Vec<_>>(), [1; 4]);
        let Planned { name, drive: None, passes } = &cells[3][0] else { panic!("a drive") };
        assert_eq!((name.as_str(), passes.len()), ("b, radius 1.7", 2));
        let scene = &passes[1].scene;
        assert_eq!(scene.robot.path, PathSpec::Circle { radius: 1.7 });
        assert_eq!((scene.world.objects, scene.estimator.semantic_noise_scale), (3, 2.0));
        assert_eq!(passes[0].scene.estimator.semantic_noise_scale, 1.0);
        assert_eq!(passes[1].model.as_deref(), Some(Path::new("maps/m")));
        assert_eq!(passes[0].scene.estimator.rows.len(), 2);
        assert!(passes.iter().all(|pass| pass.association.is_none()));
        let found =
            MAP.replace("model: m,", "model: m, association: { told: tracklets, by: hypotheses_latents },");
        let passes = expanded(&found).unwrap().remove(0).remove(0).passes;
        assert_eq!(passes[0].association, None);
        assert_eq!(passes[1].association.unwrap().to_string(), "tracklets-hypotheses_latents");
    }

    #[test]
    fn what_cannot_be_is_told_with_panel_and_value() {
        for (from, to, said) in [
            ("over: [1.6, 1.7]", "over: [1.6, 0.3]", "maps/m.yaml: panel a, robot.path.circle.radius 0.3: "),
            ("world.objects: 3", "world.objects: none", "panel b, robot.path.circle.radius 1.6: "),
            (
                "rows: [viewpoint_dependent]",
                "association: { told: tracklets, by: nearest }, rows: [ideal_azimuth]",
                "panel a: ideal_azimuth reads the truth",
            ),
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
