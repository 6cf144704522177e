//! `bench map FILE`: one scene in many cells, every estimator in each, on the same seeds.
//!
//! A scene that varies fields of its own is a map, too: `bench SCENE` comes here.

mod expand;
mod pages;
mod text;

use super::cli::{MakingArgs, MapArgs, RunArgs};
use super::scene::error::RunError;
use crate::command::error::BenchError;
use crate::command::places::places;
use crate::command::sweep::Part;
use crate::exit::Exit;
use crate::pipeline::{Cell, Lessons, PANICKED, Pass, cell, row_names};
use crate::progress::Progress;
use crate::result::folder::ResultFolder;
use crate::result::kind::ResultKind;
use crate::result::manifest::{Manifest, Renderer};
use crate::result::output_folder::OutputFolder;
use crate::result::report::TABLES;
use crate::result::results_file::{FILE_NAME, Results};
use crate::result::standing::Standing;
use crate::result::table::Table;
use crate::scene_file::life::what_is_wrong;
use crate::scene_file::map::MapFile;
use crate::scene_file::row::Row;
use crate::scene_file::vary::VaryError;
use crate::scene_file::{self, SceneFile};
use expand::{Planned, sequences};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use text::map_markdown;
use vantage_dataset::Seed;

pub use pages::{MAP_FILE, map_pages};

/// A map with all that it reads.
struct Source {
    map: MapFile,
    /// The map's file, or that of the scene which varies.
    path: PathBuf,
    scene: SceneFile,
    scene_path: PathBuf,
}

/// Makes the map, prints its tables and writes it below `args.out`.
pub fn map(args: &MapArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let source = Source::read(args)?;
    let options = serde_json::to_value(args)?;
    make(&source, (&args.out, &args.making, args.seeds, args.replace), options, stdout)
}

/// Makes some of the cells, and leaves them in the cache.
pub fn part(args: &MapArgs, part: Part) -> Result<(), BenchError> {
    make_part(&Source::read(args)?, &args.making, args.seeds, part)
}

/// Likewise, of a scene that varies some of its fields.
pub fn part_of_varied(args: &RunArgs, scene: SceneFile, path: &Path, part: Part) -> Result<(), BenchError> {
    make_part(&Source::of_varied(args, scene, path)?, &args.stages.making, args.stages.seeds, part)
}

impl Source {
    fn read(args: &MapArgs) -> Result<Self, BenchError> {
        let map: MapFile = scene_file::read(&args.map)?;
        let scene_path = args.map.parent().unwrap_or(Path::new("")).join(&map.scene);
        if !scene_path.is_file() {
            let reason =
                format!("there is no file {}; the path is relative to the map", scene_path.display());
            return Err(VaryError { path: args.map.clone(), what: "scene".to_owned(), reason }.into());
        }
        let scene = scene_file::read(&scene_path)?;
        Ok(Self { map, path: args.map.clone(), scene, scene_path })
    }

    fn seeds(&self, asked: Option<u64>) -> Vec<Seed> {
        match asked {
            Some(count) => (0..count).map(Seed).collect(),
            None => self.map.seeds.as_ref().unwrap_or(&self.scene.evaluation.seeds).as_slice().to_vec(),
        }
    }

    /// All cells, in their sequences.
    fn sequences(&self, seeds: &[Seed]) -> Result<Vec<Vec<Planned>>, VaryError> {
        let refused =
            |reason: String| VaryError { path: self.path.clone(), what: self.map.name.clone(), reason };
        if let Some(reason) = what_is_wrong(&self.map, seeds) {
            return Err(refused(reason));
        }
        let sequences = sequences(&self.map, &self.path, &self.scene)?;
        let SceneFile { world, robot, sensors, .. } = &self.scene;
        let mut passes = sequences.iter().flatten().flat_map(|cell| &cell.passes);
        let is_simulated = |Pass { scene, .. }: &Pass| {
            (&scene.world, &scene.robot, &scene.sensors) != (world, robot, sensors)
        };
        if self.scene.evaluation.episodes.is_some() && passes.any(is_simulated) {
            let reason = "the scene's episodes were recorded, so that world, robot and sensors change nothing: \
                          vary the estimator alone";
            return Err(refused(reason.to_owned()));
        }
        Ok(sequences)
    }

    fn of_varied(args: &RunArgs, scene: SceneFile, path: &Path) -> Result<Self, BenchError> {
        let given = [
            (args.online, "`--online`"),
            (args.associate, "`--associate`"),
            (!args.associations.is_empty(), "`--associations`"),
            (args.json, "`--json`"),
            (args.dump, "`--dump`"),
            (args.stages.train, "`--train`"),
            (!args.stages.model.is_empty(), "`--model`"),
            (!args.stages.trajectories.is_empty(), "`--trajectories`"),
        ];
        if let Some((_, what)) = given.into_iter().find(|(given, _)| *given) {
            return Err(RunError::Varies { scene: path.to_owned(), what }.into());
        }
        let map = MapFile::of_scene(&scene).expect("asked of a scene that varies a field alone");
        Ok(Self { map, path: path.to_owned(), scene, scene_path: path.to_owned() })
    }
}

/// Makes the map of a scene that varies some of its fields.
pub fn sweep(
    args: &RunArgs,
    scene: SceneFile,
    path: &Path,
    stdout: &mut impl Write,
) -> Result<Exit, BenchError> {
    let source = Source::of_varied(args, scene, path)?;
    let options = serde_json::to_value(args)?;
    make(&source, (&args.out, &args.stages.making, args.stages.seeds, args.replace), options, stdout)
}

/// Refuses two rows of one name in a cell, before any cell is made.
fn each_row_once<'a>(
    map: &Path,
    cells: impl IntoIterator<Item = &'a Planned>,
    as_cell: impl Fn(&'a [Pass]) -> Cell<'a>,
) -> Result<(), BenchError> {
    // What a pass's rows are called is up to these, and most cells have the same.
    let mut known: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for Planned { name: cell, passes, .. } in cells {
        let mut names: Vec<String> = Vec::new();
        for pass in passes {
            let (training, rows) = (&pass.scene.training, &pass.scene.estimator.rows);
            let key = format!("{:?} {training:?} {rows:?}", pass.model);
            if !known.contains_key(&key) {
                known.insert(key.clone(), row_names(&as_cell(passes), pass)?);
            }
            for name in &known[&key] {
                if names.contains(name) {
                    let reason = format!(
                        "{name} runs twice, by two models, settings or associations, and both rows have this name: put one into another panel"
                    );
                    return Err(VaryError { path: map.to_owned(), what: cell.clone(), reason }.into());
                }
                names.push(name.clone());
            }
        }
    }
    Ok(())
}

fn make_part(source: &Source, making: &MakingArgs, seeds: Option<u64>, part: Part) -> Result<(), BenchError> {
    let seeds = source.seeds(seeds);
    let progress = Progress::notes_once();
    let sequences = source.sequences(&seeds)?;
    // Drives follow each other, and lives do not.
    let (sequences, seeds) = match source.map.across.is_of_drives() {
        true => (sequences, part.of(seeds)),
        false => (part.of(sequences), seeds),
    };
    if seeds.is_empty() {
        return Ok(());
    }
    let stage = Progress::detect().stage("cells", sequences.iter().map(Vec::len).sum::<usize>() as u64);
    let progress = progress.within(&stage);
    for sequence in &sequences {
        let mut before = Lessons::new();
        for Planned { drive, passes, .. } in sequence {
            let (path, cache, renderer) =
                (source.scene_path.as_path(), making.cache.as_path(), making.renderer.into());
            let columns = source.map.columns();
            let of_drive = Cell {
                passes,
                path,
                cache,
                renderer,
                seeds: &seeds,
                drive: *drive,
                columns,
                progress: &progress,
            };
            before = cell(&of_drive, &before)?.lessons;
            stage.advance(1);
        }
    }
    Ok(())
}

fn make(
    source: &Source,
    (out, making, seeds, replace): (&Path, &MakingArgs, Option<u64>, bool),
    options: serde_json::Value,
    stdout: &mut impl Write,
) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(out)?;
    let Source { map, scene, scene_path, .. } = source;
    let seeds = source.seeds(seeds);
    let place = ResultKind::Map.place(out.path(), &map.name);
    let sequences = source.sequences(&seeds)?;
    if let Some(standing) = Standing::read(&place).filter(|_| !replace) {
        standing.allows(&place, &seeds, true)?;
        let cells = sequences.iter().flatten().map(|cell| cell.name.as_str()).collect();
        Standing::allows_tables(&place, &cells)?;
    }
    let hash = map.hash(&scene_file::hash(scene)?)?;
    let mut manifest = Manifest { options, ..Manifest::new(&hash, &seeds) };

    let progress = Progress::detect();
    let of_cells = Progress::notes_once();
    let as_cell = |passes| Cell {
        passes,
        path: scene_path,
        cache: &making.cache,
        renderer: making.renderer.into(),
        seeds: &seeds,
        drive: None,
        columns: map.columns(),
        progress: &of_cells,
    };
    each_row_once(&source.path, sequences.iter().flatten(), as_cell)?;
    let stage = progress.stage("cells", sequences.iter().map(Vec::len).sum::<usize>() as u64);
    let within = of_cells.within(&stage);
    let (mut tables, mut seals) = (Vec::new(), blake3::Hasher::new());
    for sequence in &sequences {
        let mut before = Lessons::new();
        for Planned { name, drive, passes } in sequence {
            let started = Instant::now();
            let made = cell(&Cell { drive: *drive, progress: &within, ..as_cell(passes) }, &before)?;
            before = made.lessons;
            let methods: Vec<&str> = made.methods.iter().map(String::as_str).collect();
            let reference = Row::Geometric.to_string();
            tables.push(Table::new(name, &methods, Some(&reference), map.columns(), &seeds, made.runs)?);
            for seal in &made.seals {
                seals.update(seal.as_bytes());
            }
            manifest.model_hashes.extend(made.models);
            manifest.renderer = Renderer::from(&made.renderer);
            manifest.took(name, started.elapsed());
            stage.advance(1);
        }
    }
    drop(stage);
    manifest.dataset_hash = Some(seals.finalize().to_hex().to_string());

    let results = Results::new(&map.name, &hash, tables);
    let folder = ResultFolder::open(&out, &map.name, ResultKind::Map, &progress)?;
    let place = folder.path().to_owned();
    folder.write(FILE_NAME, serde_json::to_string(&results)?.as_bytes())?;
    folder.write(MAP_FILE, serde_json::to_string_pretty(map)?.as_bytes())?;
    let pages = map_pages(map, &results)?;
    for (name, bytes) in &pages {
        folder.write(name, bytes)?;
    }
    folder.finish(&manifest)?;
    progress.note(&format!("written to {}", place.display()));
    writeln!(stdout, "{}", map_markdown(map, &results))?;
    let pictures = pages.iter().map(|(name, _)| *name).filter(|name| *name != TABLES).collect();
    let kinds = [("tables", vec![TABLES]), ("raw scores", vec![FILE_NAME]), ("pictures", pictures)];
    write!(stdout, "{}", places(&place, kinds))?;
    let runs = || results.tables.iter().flat_map(Table::runs);
    if runs().any(|run| run.failure() == Some(PANICKED)) {
        return Err(RunError::Panicked { scene: scene_path.clone() }.into());
    }
    match runs().any(|run| !run.scores.is_empty()) {
        true => Ok(Exit::Success),
        false => Err(RunError::NothingAnswered { scene: scene_path.clone() }.into()),
    }
}
