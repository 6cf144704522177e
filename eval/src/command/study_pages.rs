//! What is made of a study's raw scores beside its tables: the law of composites, where its variants differ in them.

use crate::figure::FigureError;
use crate::figure::law::{Law, Line, Panel, law_png, law_svg};
use crate::result::metric::Metric;
use crate::result::results_file::Results;
use crate::result::table::Table;
use crate::scene_file::row_name::{GAUSSIAN_PROCESS, with_process};
use crate::scene_file::study::{StudyFile, Variant};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The study as it was run, beside its scores: what its figures are made by.
pub const STUDY_FILE: &str = "study.json";

/// More families than there are.
const ALL: usize = usize::MAX;

/// Name of the table of azimuths from `known` views.
pub fn known_views_table(known: usize) -> String {
    format!("known_views_{known}")
}

/// The name and the bytes of each figure; none of a study whose variants do not differ in composites, or that tells no azimuths from known
/// views.
pub fn study_pages(
    study: &StudyFile,
    results: &Results,
) -> Result<Vec<(&'static str, Vec<u8>)>, FigureError> {
    let Some(law) = law(study, results) else { return Ok(Vec::new()) };
    Ok(vec![("law.svg", law_svg(&law)?.into_bytes()), ("law.png", law_png(&law)?)])
}

/// Of the most known views: a line for each number of families of which there are models with several numbers of composites, and that
/// differ in nothing else. Where lines differ in settings of the model, there is a panel for each combination.
fn law(study: &StudyFile, results: &Results) -> Option<Law> {
    let known = study.known_views.iter().max()?;
    let table = results.table(&known_views_table(*known))?;
    let mut by_families: BTreeMap<(usize, String), Vec<(usize, &Variant)>> = BTreeMap::new();
    for variant in &study.variants {
        if let Some(composites) = variant.composites {
            let trained_alike = (variant.families.unwrap_or(ALL), format!("{:?}", variant.model));
            by_families.entry(trained_alike).or_default().push((composites, variant));
        }
    }
    by_families.retain(|_, variants| {
        variants.sort_by_key(|(composites, _)| *composites);
        variants.first().zip(variants.last()).is_some_and(|(first, last)| first.0 < last.0)
    });
    let composites: BTreeSet<usize> =
        by_families.values().flatten().map(|(composites, _)| *composites).collect();
    let composites: Vec<usize> = composites.into_iter().collect();
    let models: Vec<_> = by_families.values().flatten().map(|(_, variant)| &variant.model).collect();
    let keys: BTreeSet<&String> = models.iter().flat_map(|model| model.keys()).collect();
    let differ: Vec<&String> = keys
        .into_iter()
        .filter(|&key| models.windows(2).any(|two| two[0].get(key) != two[1].get(key)))
        .collect();
    let mut panels: Vec<Panel> = Vec::new();
    // Those of most families first.
    for ((families, _), variants) in by_families.iter().rev() {
        let of = |row: &dyn Fn(&str) -> String| -> Vec<(usize, f64)> {
            let point = |(count, variant): &(usize, &Variant)| {
                let place = composites.binary_search(count).ok()?;
                Some((place, degrees(table, &row(&variant.name))?))
            };
            variants.iter().filter_map(point).collect()
        };
        let name = match *families {
            0 => "composites alone".to_owned(),
            1 => "1 family".to_owned(),
            ALL => "all families".to_owned(),
            families => format!("{families} families"),
        };
        let own =
            differ.iter().map(|&key| match variants.first().and_then(|(_, first)| first.model.get(key)) {
                Some(Value::String(word)) => format!("{key} {word}"),
                Some(value) => format!("{key} {value}"),
                None => format!("{key} of the scene"),
            });
        let own = own.collect::<Vec<_>>().join(", ");
        let lines = [(false, of(&|name| name.to_owned())), (true, of(&|name| with_process(name)))]
            .into_iter()
            .filter(|(_, points)| !points.is_empty())
            .map(|(is_process, points)| Line { name: name.clone(), is_process, points });
        match panels.iter_mut().find(|panel| panel.name == own) {
            Some(panel) => panel.lines.extend(lines),
            None => panels.push(Panel { name: own, lines: lines.collect() }),
        }
    }
    panels.retain(|panel| !panel.lines.is_empty());
    let floor =
        degrees(table, GAUSSIAN_PROCESS).map(|error| ("Gaussian process on pixels".to_owned(), error));
    let views = if *known == 1 { "view" } else { "views" };
    let title = format!("{}: azimuths from {known} known {views}", study.name);
    (!panels.is_empty()).then_some(Law { title, composites, panels, floor })
}

fn degrees(table: &Table, row: &str) -> Option<f64> {
    let is_there = table.methods().iter().any(|method| method == row);
    is_there.then(|| table.cell(row, Metric::ViewpointMedian).mean)?.map(|mean| mean.mean.to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::run;
    use crate::scene_file::parse;
    use std::path::Path;
    use vantage_dataset::Seed;

    const STUDY: &str = "version: 1\nname: small\npurpose: p\nscene: s\nseeds: 1\nknown_views: [1, 8]\nvariants:\n\
        - { name: f2, note: n, families: 2, composites: 0 }\n\
        - { name: f2_c9, note: n, families: 2, composites: 9 }\n\
        - { name: f2_none, note: n, families: 2, composites: 0, model: { frames: none } }\n\
        - { name: f2_c9_none, note: n, families: 2, composites: 9, model: { frames: none } }\n\
        - { name: f1, note: n, families: 1, composites: 0 }\n\
        - { name: c9, note: n, families: 0, composites: 9 }\n\
        - { name: c5, note: n, families: 0, composites: 5 }\n";

    fn results(rows: &[(&str, f64)]) -> Results {
        let names: Vec<&str> = rows.iter().map(|(name, _)| *name).collect();
        let runs =
            rows.iter().map(|(name, error)| run(name, 1, &[(Metric::ViewpointMedian, error.to_radians())]));
        let metrics = [Metric::ViewpointMedian];
        let table = Table::new("known_views_8", &names, None, &metrics, &[Seed(1)], runs.collect()).unwrap();
        Results::new("small", "hash", vec![table])
    }

    #[test]
    fn models_that_differ_in_composites_alone_are_a_line() {
        let study: StudyFile = parse(STUDY, Path::new("s")).unwrap();
        let rows = [
            ("f2", 60.0),
            ("f2_c9", 50.0),
            ("f2_none", 65.0),
            ("f2_c9_none", 20.0),
            ("f2_c9+process", 40.0),
            ("f1", 70.0),
            ("c9", 45.0),
            ("c5", 55.0),
        ];
        let found = results(&[&rows[..], &[(GAUSSIAN_PROCESS, 30.0)]].concat());
        let law = law(&study, &found).unwrap();
        assert_eq!(law.composites, [0, 5, 9]);
        let told = |(i, error): (usize, f64)| (i, error.round());
        let lines: Vec<_> = law
            .panels
            .iter()
            .flat_map(|panel| panel.lines.iter().map(move |line| (&*panel.name, line)))
            .map(|(panel, line)| {
                let points: Vec<_> = line.points.iter().copied().map(told).collect();
                (panel, &*line.name, line.is_process, points)
            })
            .collect();
        assert_eq!(
            lines,
            [
                ("frames of the scene", "2 families", false, vec![(0, 60.0), (2, 50.0)]),
                ("frames of the scene", "2 families", true, vec![(2, 40.0)]),
                ("frames of the scene", "composites alone", false, vec![(1, 55.0), (2, 45.0)]),
                ("frames none", "2 families", false, vec![(0, 65.0), (2, 20.0)]),
            ]
        );
        assert_eq!(law.floor.clone().map(|(_, error)| error.round()), Some(30.0));
        assert_eq!(study_pages(&study, &found).unwrap().len(), 2);
        let mut without = study.clone();
        without.variants.iter_mut().for_each(|variant| variant.composites = None);
        assert!(study_pages(&without, &found).unwrap().is_empty());
        let unknown = StudyFile { known_views: vec![3], ..study };
        assert!(study_pages(&unknown, &found).unwrap().is_empty());
    }
}
