//! `bench dataset SCENE --out DIR`: episodes as files, one at a time in memory.

use crate::cli::DatasetArgs;
use crate::exit::{BenchError, Exit};
use crate::output::{OutputError, OutputFolder};
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use vantage_dataset::store::{Provenance, verify, write_episode};
use vantage_dataset::{Seed, Split};
use vantage_sim::render::choice::open;
use vantage_sim::simulate;

/// Writes one episode folder a seed below `args.out`; those that are there, whole and of this scene are kept.
pub fn dataset(args: &DatasetArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let file: SceneFile = scene_file::read(&args.scene)?;
    let scene = file.checked()?;
    let progress = Progress::detect();
    let opened = open(args.renderer.into())?;
    if let Some(notice) = &opened.notice {
        progress.note(notice);
    }
    let mut renderer = opened.renderer;
    let provenance: Provenance = BTreeMap::from([
        ("scene".to_owned(), file.name.clone().into()),
        ("scene_hash".to_owned(), scene_file::hash(&(scene.world(), scene.robot(), scene.sensors()))?.into()),
        ("renderer".to_owned(), serde_json::to_value(renderer.info())?),
    ]);
    let seeds = match args.seeds {
        Some(count) => (0..count).map(Seed).collect(),
        None => file.evaluation.seeds.as_slice().to_vec(),
    };
    let stage = progress.stage("episodes", seeds.len() as u64);
    let (mut written, mut kept) = (0, 0);
    for seed in seeds {
        let folder = out.path().join(seed.0.to_string());
        if is_whole(&folder, &provenance) {
            kept += 1;
        } else {
            let episode = simulate(&scene, seed, Split::Test, renderer.as_mut(), &mut |_| {})?;
            let partial = out.path().join(format!("{}.partial", seed.0));
            let cannot = |source| OutputError { path: folder.clone(), source };
            remove(&partial).map_err(cannot)?;
            write_episode(&partial, &episode, provenance.clone())?;
            remove(&folder).map_err(cannot)?;
            fs::rename(&partial, &folder).map_err(cannot)?;
            written += 1;
        }
        stage.advance(1);
    }
    drop(stage);
    writeln!(stdout, "{written} episodes written to {}, {kept} already there", out.path().display())?;
    Ok(Exit::Success)
}

fn is_whole(folder: &Path, provenance: &Provenance) -> bool {
    verify(folder).is_ok_and(|manifest| manifest.provenance == *provenance)
}

fn remove(folder: &Path) -> std::io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
