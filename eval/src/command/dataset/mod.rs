//! `bench dataset SCENE --out DIR`: episodes as files, one image at a time in memory.

mod avd;
#[cfg(feature = "formats")]
mod bigbird;
mod claim;
mod crops;
mod episodes;
pub mod error;
mod images;
mod index;
mod trajectories;

use super::placed;
use crate::code::SIMULATED;
use crate::command::cli::{DatasetArgs, DatasetFormat};
use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::pipeline::concerns_one_seed;
use crate::progress::Progress;
use crate::result::output_folder::OutputFolder;
use crate::scene_file::{self, SceneFile};
use avd::Avd;
#[cfg(feature = "formats")]
use bigbird::BigBird;
use crops::Crops;
use episodes::Episodes;
use error::DatasetError;
use images::Images;
use index::Index;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use trajectories::Trajectories;
use vantage_dataset::store::Provenance;
use vantage_dataset::{Capture, Episode, Seed, Split};
use vantage_formats::{BopLayout, CropLayout, Opened};
use vantage_sim::capture::capture;
use vantage_sim::checked::CheckedScene;
use vantage_sim::episode::{OnLook, observe};
use vantage_sim::error::Progress as Looked;
use vantage_sim::observer::{Look, Observer};
use vantage_sim::render::Renderer;
use vantage_sim::render::choice::open;
use vantage_sim::rollout::{Rollout, roll_out};

/// The most images in a shard of BOP's WebDataset, which allows a thousand.
const IMAGES_PER_SHARD: u64 = 500;

/// An episode of so many images has a progress of its own: it may take minutes.
const MANY_IMAGES: u64 = 500;

/// What a format needs of a seed, each including the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Need {
    /// It has it already.
    Nothing,
    /// The drive.
    Rollout,
    /// What the robot observes.
    Episode,
    /// Whole images with silhouettes.
    Captures,
}

/// A format under way.
trait Format {
    /// What it needs of a seed.
    fn need(&mut self, seed: Seed, index: &Index) -> Result<Need, BenchError>;

    /// Whether it needs that still, now that the objects are known.
    fn wants(&mut self, _rollout: &Rollout) -> bool {
        true
    }

    /// Takes the drive of a seed that it needs something of, before the rest.
    fn begin(&mut self, _rollout: &Rollout) -> Result<(), BenchError> {
        Ok(())
    }

    /// Takes an image of the seed that was begun.
    fn image(&mut self, _step: usize, _capture: &Capture) -> Result<(), BenchError> {
        Ok(())
    }

    /// Takes the episode of the seed that was begun.
    fn episode(&mut self, _episode: &Episode) -> Result<(), BenchError> {
        Ok(())
    }

    /// There are no more seeds.
    fn finish(self: Box<Self>) -> Result<(), BenchError> {
        Ok(())
    }
}

/// What begins a format that can hold the scene.
type Begin<'a> = Box<dyn FnOnce() -> Result<Box<dyn Format + 'a>, BenchError> + 'a>;

/// What a dataset of all seeds is made of.
struct Source<'a> {
    name: &'a str,
    scene: &'a CheckedScene,
    seeds: &'a [Seed],
    split: Split,
    provenance: Provenance,
    progress: &'a Progress,
}

impl Source<'_> {
    /// Refuses seeds that a format has no numbers for.
    fn require_seeds_below(&self, limit: u64, format: &'static str) -> Result<(), BenchError> {
        match self.seeds.iter().find(|seed| seed.0 >= limit) {
            None => Ok(()),
            Some(seed) => Err(DatasetError::Unsuitable {
                format,
                reason: format!("it numbers scenes below {limit}, and seed {} is none of them", seed.0),
            }
            .into()),
        }
    }
}

/// The writer and how many samples it has already; none where all was finished before.
fn taken_up<W>(opened: Opened<W>, progress: &Progress) -> (Option<W>, u64) {
    match opened {
        Opened::Finished(_) => (None, 0),
        Opened::Unfinished { writer, skip, damage } => {
            if let Some(damage) = damage {
                progress.note(&format!("warning: {}; it is written anew", damage.finding()));
            }
            (Some(writer), skip)
        }
    }
}

/// Tells of folders that were written anew.
fn tell(progress: &Progress, set_aside: &[PathBuf]) {
    for folder in set_aside {
        let what = "warning: what was written anew held files that are not of the dataset: it is now";
        progress.note(&format!("{what} {}", folder.display()));
    }
}

/// Writes every format of every seed below `args.out`. What is there, whole and of this scene, is kept, and what a killed run
/// left is gone on with. A seed without a world is told of and left out; if none has one, that is the error.
pub fn dataset(args: &DatasetArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let file: SceneFile = scene_file::read(&args.scene)?;
    file.check_simulated(&args.scene)?;
    let progress = Progress::detect();
    let scene = file.checked(&args.scene, &args.making.cache, &progress)?;
    let _lock = out.lock(&progress)?;
    let opened = open(args.making.renderer.into())?;
    if let Some(notice) = &opened.notice {
        progress.note(notice);
    }
    let split: Split = args.split.into();
    let seeds = match args.seeds {
        Some(count) => (0..count).map(Seed).collect(),
        None => file.evaluation.seeds.as_slice().to_vec(),
    };
    let mut provenance: Provenance = BTreeMap::from([
        ("scene".to_owned(), file.name.clone().into()),
        ("scene_hash".to_owned(), scene_file::hash(&(scene.world(), scene.robot(), scene.sensors()))?.into()),
        ("split".to_owned(), split.name().into()),
        ("renderer".to_owned(), serde_json::to_value(opened.renderer.info())?),
        ("code".to_owned(), SIMULATED.into()),
    ]);
    if !scene.meshes().is_empty() {
        provenance.insert("meshes".to_owned(), serde_json::to_value(scene.meshes())?);
    }
    if !scene.fixtures().is_empty() {
        provenance.insert("fixtures".to_owned(), serde_json::to_value(scene.fixtures())?);
    }
    let mut of_all = provenance.clone();
    of_all.insert("seeds".to_owned(), serde_json::to_value(&seeds)?);
    let source = Source {
        name: &file.name,
        scene: &scene,
        seeds: &seeds,
        split,
        provenance: of_all,
        progress: &progress,
    };

    let asked = args.format.iter().enumerate().filter(|(i, format)| !args.format[..*i].contains(format));
    let checked: Vec<Begin<'_>> = asked
        .map(|(_, &format)| check(format, &out, &provenance, &source))
        .collect::<Result<_, BenchError>>()?;
    let mut formats: Vec<Box<dyn Format + '_>> =
        checked.into_iter().map(|begin| begin()).collect::<Result<_, BenchError>>()?;
    let mut index = Index::read(&out, provenance.clone());
    let mut maker = Maker { out: &out, scene: &scene, progress: &progress, split, renderer: opened.renderer };
    let stage = progress.stage("episodes", seeds.len() as u64);
    let (mut written, mut kept, mut failure) = (0, 0, None);
    for &seed in &seeds {
        match maker.make(seed, &mut formats, &mut index) {
            Ok(true) => written += 1,
            Ok(false) => kept += 1,
            Err(BenchError::Sim(error)) if concerns_one_seed(&error) => {
                progress.note(&format!("seed {} is left out: {error}", seed.0));
                failure = Some(error);
            }
            Err(error) => return Err(error),
        }
        stage.advance(1);
    }
    if written + kept > 0 {
        formats.into_iter().try_for_each(Format::finish)?;
    }
    drop(stage);
    let left_out = match seeds.len() - written - kept {
        0 => String::new(),
        count => format!(", {count} of {} seeds left out for want of a world", seeds.len()),
    };
    writeln!(
        stdout,
        "{written} episodes written to {}, {kept} already there{left_out}",
        out.path().display()
    )?;
    match failure {
        Some(error) if written + kept == 0 => Err(placed(error, &args.scene)),
        _ if index.is_without_crops() => {
            progress.note(
                "warning: no detection of an object in any image; look at the scene with `bench look`, and lower \
                 sensors.detector.min_mask_pixels or min_visible_fraction",
            );
            Ok(Exit::NothingEvaluated)
        }
        _ => Ok(Exit::Success),
    }
}

/// Refuses a format that cannot hold the scene, before another has begun; what begins it otherwise.
fn check<'a>(
    format: DatasetFormat,
    out: &'a OutputFolder,
    of_each: &'a Provenance,
    source: &'a Source<'a>,
) -> Result<Begin<'a>, BenchError> {
    let at = move |name: &str| out.path().join(name);
    let begin: Begin<'a> = match format {
        DatasetFormat::Vantage => {
            Box::new(move || Ok(Box::new(Episodes::new(out, of_each.clone(), source.progress))))
        }
        DatasetFormat::Tum => Box::new(move || Ok(Box::new(Trajectories::tum(out, source)?))),
        DatasetFormat::G2o => Box::new(move || Ok(Box::new(Trajectories::g2o(out, source)?))),
        DatasetFormat::Webdataset => {
            Box::new(move || Ok(Box::new(Crops::open(&at("webdataset"), CropLayout::WebDataset, source)?)))
        }
        #[cfg(feature = "formats")]
        DatasetFormat::Parquet => {
            Box::new(move || Ok(Box::new(Crops::open(&at("parquet"), CropLayout::Parquet, source)?)))
        }
        DatasetFormat::Bop => {
            Images::check(source)?;
            Box::new(move || Ok(Box::new(Images::open(&at("bop"), BopLayout::Scenes, source)?)))
        }
        DatasetFormat::BopWebdataset => {
            Images::check(source)?;
            let layout = BopLayout::WebDataset { images_per_shard: IMAGES_PER_SHARD };
            Box::new(move || Ok(Box::new(Images::open(&at("bop-webdataset"), layout, source)?)))
        }
        #[cfg(feature = "formats")]
        DatasetFormat::Bigbird => {
            BigBird::degrees(source)?;
            Box::new(move || Ok(Box::new(BigBird::open(&at("bigbird"), source)?)))
        }
        DatasetFormat::Avd => {
            Avd::check(source)?;
            Box::new(move || Ok(Box::new(Avd::open(&at("avd"), source)?)))
        }
        #[cfg(not(feature = "formats"))]
        DatasetFormat::Parquet | DatasetFormat::Bigbird => {
            return Err(crate::left_out::LeftOut::Formats.into());
        }
    };
    Ok(begin)
}

struct Maker<'a> {
    out: &'a OutputFolder,
    scene: &'a CheckedScene,
    progress: &'a Progress,
    split: Split,
    renderer: Box<dyn Renderer>,
}

impl Maker<'_> {
    /// Makes what the formats need of a seed; whether they needed anything.
    fn make(
        &mut self,
        seed: Seed,
        formats: &mut [Box<dyn Format + '_>],
        index: &mut Index,
    ) -> Result<bool, BenchError> {
        let mut active: Vec<(Need, &mut Box<dyn Format + '_>)> = Vec::new();
        for format in formats {
            match format.need(seed, index)? {
                Need::Nothing => {}
                need => active.push((need, format)),
            }
        }
        if active.is_empty() {
            return Ok(false);
        }
        let rollout = roll_out(self.scene, seed, self.split, &mut |_| {})?;
        active.retain_mut(|(_, format)| format.wants(&rollout));
        let Some(most) = active.iter().map(|(need, _)| *need).max() else { return Ok(false) };
        for (_, format) in &mut active {
            format.begin(&rollout)?;
        }
        if most < Need::Episode {
            return Ok(true);
        }
        let mut on_look = |observer: &Observer<'_>,
                           step: usize,
                           look: &Look,
                           renderer: &mut dyn Renderer|
         -> Result<(), BenchError> {
            let image = capture(observer, look, rollout.drive.timestamps[step], renderer)?;
            let mut taking = active.iter_mut().filter(|(need, _)| *need == Need::Captures);
            taking.try_for_each(|(_, format)| format.image(step, &image))
        };
        let each: Option<&mut OnLook<'_, BenchError>> =
            if most == Need::Captures { Some(&mut on_look) } else { None };
        let (steps, name) = (rollout.steps() as u64, format!("images of seed {}", seed.0));
        let images = (steps >= MANY_IMAGES).then(|| self.progress.stage(&name, steps));
        let mut done = 0;
        let mut looked = |progress: Looked| {
            if let Some(images) = &images {
                images.advance(progress.done.saturating_sub(done));
                done = progress.done;
            }
        };
        let episode = observe(self.scene, &rollout, self.renderer.as_mut(), &mut looked, each)?;
        drop(images);
        // Before the formats: a kill in between leaves a count of what is not there yet, and not the other way round.
        index.count(&episode);
        index.write(self.out)?;
        for (_, format) in active.iter_mut().filter(|(need, _)| *need >= Need::Episode) {
            format.episode(&episode)?;
        }
        Ok(true)
    }
}
