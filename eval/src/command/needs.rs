//! What a command reads, what it leaves when it is interrupted, and what renders for it.

use super::cli::{Cli, Command, MakingArgs, RendererChoice};
use crate::scene_file::FileKind;
use std::path::{Path, PathBuf};

/// What a command reads.
pub struct Source<'a> {
    /// The file, or the name of one that comes with the program.
    pub path: &'a mut PathBuf,
    /// What it has to be.
    pub kind: FileKind,
    /// Folder of the command's cache.
    pub cache: &'a Path,
}

impl Cli {
    /// The scene or the study that the command reads, if any.
    pub fn source(&mut self) -> Option<Source<'_>> {
        let kind = match self.command {
            Some(Command::Study(_)) => FileKind::Study,
            Some(Command::Map(_)) => FileKind::Map,
            _ => FileKind::Scene,
        };
        let (path, making) = match &mut self.command {
            None => (self.run.scene.as_mut()?, &self.run.stages.making),
            Some(Command::Baseline(args)) => (&mut args.scene, &args.stages.making),
            Some(Command::Calibrate(args)) => (&mut args.validation.scene, &args.validation.making),
            Some(Command::Headroom(args)) => (&mut args.scene, &args.making),
            Some(Command::Check(args)) => (&mut args.scene, &args.stages.making),
            Some(Command::Dataset(args)) => (&mut args.scene, &args.making),
            Some(Command::Figures(args)) => (&mut args.scene, &args.making),
            Some(Command::Look(args)) => (&mut args.scene, &args.making),
            Some(Command::Task(args)) => (&mut args.scene, &args.making),
            Some(Command::Train(args)) => (&mut args.scene, &args.making),
            Some(Command::Study(args)) => (&mut args.study, &args.making),
            Some(Command::Map(args)) => (&mut args.map, &args.making),
            Some(Command::Import(args)) => {
                let path = args.like.as_mut()?;
                return Some(Source { path, kind, cache: &args.cache });
            }
            Some(_) => return None,
        };
        Some(Source { path, kind, cache: &making.cache })
    }

    /// The models that the command is given, by their folders or names, and the folder of its cache.
    pub fn models(&mut self) -> Option<(Vec<&mut PathBuf>, &Path)> {
        Some(match &mut self.command {
            None => (self.run.stages.model.iter_mut().collect(), &self.run.stages.making.cache),
            Some(Command::Calibrate(args)) => {
                (args.model.iter_mut().collect(), &args.validation.making.cache)
            }
            Some(Command::Check(args)) => (args.stages.model.iter_mut().collect(), &args.stages.making.cache),
            Some(Command::Baseline(args)) => {
                (args.stages.model.iter_mut().collect(), &args.stages.making.cache)
            }
            Some(Command::Figures(args)) => (args.model.iter_mut().collect(), &args.making.cache),
            Some(Command::Models(args)) => (args.folders.iter_mut().collect(), &args.cache),
            Some(_) => return None,
        })
    }

    /// How what the command renders is made; `None` where nothing is rendered.
    fn making(&self) -> Option<&MakingArgs> {
        match &self.command {
            None => Some(&self.run.stages.making),
            Some(Command::Baseline(args)) => Some(&args.stages.making),
            Some(Command::Calibrate(args)) => Some(&args.validation.making),
            Some(Command::Headroom(args)) => Some(&args.making),
            Some(Command::Check(args)) => Some(&args.stages.making),
            Some(Command::Dataset(args)) => Some(&args.making),
            Some(Command::Figures(args)) => Some(&args.making),
            Some(Command::Look(args)) => Some(&args.making),
            Some(Command::Study(args)) => Some(&args.making),
            Some(Command::Map(args)) => Some(&args.making),
            Some(Command::Task(args)) => Some(&args.making),
            Some(Command::Train(args)) => Some(&args.making),
            Some(_) => None,
        }
    }

    /// What a command that is interrupted leaves for the next one, and the folder that holds it.
    pub fn kept(&self) -> Option<(&'static str, &Path)> {
        match &self.command {
            Some(Command::Dataset(args)) => Some(("finished episodes", &args.out)),
            Some(Command::Task(args)) => Some(("finished episodes", &args.truth)),
            Some(Command::Train(args)) => Some(("checkpoints", &args.out)),
            Some(Command::Look(_)) => None,
            _ => Some(("finished stages", &self.making()?.cache)),
        }
    }

    /// Who renders for the command; `None` where nothing is rendered.
    pub fn renderer(&self) -> Option<RendererChoice> {
        Some(self.making()?.renderer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{CommandFactory, Parser};

    #[test]
    fn every_command_that_takes_a_scene_takes_it_by_name_renders_and_says_what_it_keeps() {
        let mut checked = 0;
        for command in Cli::command().get_subcommands() {
            let takes = |id| command.get_arguments().any(|argument| argument.get_id() == id);
            if !takes("scene") && !takes("study") {
                continue;
            }
            let mut line = vec!["bench".to_owned(), command.get_name().to_owned()];
            for argument in command.get_arguments().filter(|argument| argument.is_required_set()) {
                line.extend(argument.get_long().map(|long| format!("--{long}")));
                line.push("tabletop".to_owned());
            }
            let mut cli = Cli::try_parse_from(&line).unwrap();
            assert_eq!(cli.source().unwrap().path.as_path(), Path::new("tabletop"), "{line:?}");
            assert_eq!(cli.renderer(), Some(RendererChoice::Auto), "{line:?}");
            assert!(cli.kept().is_some() || command.get_name() == "look", "{line:?}");
            checked += 1;
        }
        assert!(checked >= 6, "{checked}");
    }
}
