//! The scene, the study or the map that a command is given: a file, or the name of one that comes with the program.

pub(super) mod error;

use super::cli::Cli;
use crate::command::error::BenchError;
use crate::scene_file::FileKind;
use crate::supplied;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser};
use error::{Meant, SourceError};
use std::fs;
use std::path::{Path, PathBuf};

/// The command line of this process, which ends with help, or with 2 and what is wrong.
pub fn command_line() -> Cli {
    Cli::try_parse().unwrap_or_else(|error| {
        let first = std::env::args().nth(1).filter(|_| error.use_stderr());
        unknown_word(first.as_deref()).or_else(|| second_word(&error)).unwrap_or(error).exit()
    })
}

/// Puts the file to read in the place of what the command line gives, and folders in that of the names of models: what comes with the
/// program is laid out in the cache.
pub fn find(cli: &mut Cli) -> Result<(), BenchError> {
    let bare = cli.command.is_none();
    if let Some(source) = cli.source() {
        *source.path = file(source.path, source.kind, source.cache, bare)?;
    }
    if let Some((models, cache)) = cli.models() {
        for model in models {
            let name = model.to_str().filter(|_| !model.exists());
            if let Some(folder) = name.map(|name| supplied::model(name, cache)).transpose()?.flatten() {
                *model = folder;
            }
        }
    }
    Ok(())
}

fn file(given: &Path, kind: FileKind, cache: &Path, bare: bool) -> Result<PathBuf, BenchError> {
    let name = given.to_str().filter(|_| is_name(given));
    match fs::metadata(given) {
        Ok(there) if !there.is_dir() => return of_kind(given, FileKind::of_file(given), kind),
        Ok(_) if name.is_none_or(|name| named(name, kind, true).is_none()) => {
            let files = files_in(given, Some(kind)).collect();
            return Err(SourceError::Folder { folder: given.to_owned(), kind, files }.into());
        }
        _ => {}
    }
    let Some(name) = name else {
        return Err(SourceError::NoFile { path: given.to_owned(), meant: near_path(given, kind) }.into());
    };
    if let Some(found) = named(name, kind, bare) {
        of_kind(given, Some(found.kind), kind)?;
        return Ok(supplied::lay_out(cache)?.join(found.path));
    }
    let name = name.to_owned();
    Err(if bare {
        SourceError::NoCommand { meant: near_word(&name), word: name }
    } else {
        SourceError::NoName { kind, meant: Meant::nearest(&name, names(kind, false)), name }
    }
    .into())
}

fn of_kind(given: &Path, found: Option<FileKind>, expected: FileKind) -> Result<PathBuf, BenchError> {
    match found {
        Some(found) if found != expected => {
            Err(SourceError::Other { given: given.to_owned(), found, expected }.into())
        }
        _ => Ok(given.to_owned()),
    }
}

/// Whether it is one word without an extension, which no file of ours is.
fn is_name(given: &Path) -> bool {
    given.extension().is_none() && given.components().count() == 1 && !given.to_string_lossy().ends_with('/')
}

/// What has that name: of the kind that is looked for, else of another. Scenes of studies have names after a command alone.
fn named(name: &str, kind: FileKind, bare: bool) -> Option<supplied::Supplied> {
    let of = |kind: FileKind| {
        supplied::of_kind(kind).chain(of_studies(kind, bare)).find(|file| file.name() == name)
    };
    of(kind).or_else(|| [FileKind::Scene, FileKind::Study, FileKind::Map].into_iter().find_map(of))
}

fn of_studies(kind: FileKind, bare: bool) -> impl Iterator<Item = supplied::Supplied> {
    let asked = kind == FileKind::Scene && !bare;
    asked.then(supplied::scenes_for_studies).into_iter().flatten()
}

/// What has a name of a kind: what comes with the program and, by their paths, files where they usually lie.
fn names(kind: FileKind, bare: bool) -> impl Iterator<Item = (String, String)> {
    let folder = kind.folder();
    let supplied = supplied::of_kind(kind).chain(of_studies(kind, bare)).map(|file| file.name().to_owned());
    let there = ["", folder].into_iter().flat_map(move |folder| files_in(Path::new(folder), None));
    let there = there.filter_map(|path| Some((path.file_stem()?.to_str()?.to_owned(), path)));
    supplied
        .map(|name| (name.clone(), format!("`{name}`")))
        .chain(there.map(|(stem, path)| (stem, path.display().to_string())))
}

/// What a misspelt word before anything else may be: a command or a scene.
fn near_word(word: &str) -> Meant {
    let commands = commands().into_iter().map(|name| (name.clone(), format!("the command `{name}`")));
    Meant::nearest(word, commands.chain(names(FileKind::Scene, true)))
}

fn commands() -> Vec<String> {
    let mut bench = Cli::command();
    bench.build();
    bench.get_subcommands().map(|command| command.get_name().to_owned()).collect()
}

/// What to say where the first word is a misspelt command, which clap takes for a scene, and blames what follows it.
fn unknown_word(first: Option<&str>) -> Option<clap::Error> {
    let word = first.filter(|word| !word.is_empty() && !word.starts_with('-'))?;
    let nothing =
        is_name(Path::new(word)) && !Path::new(word).exists() && named(word, FileKind::Scene, true).is_none();
    if !nothing || commands().iter().any(|command| command == word) {
        return None;
    }
    let unknown = SourceError::NoCommand { word: word.to_owned(), meant: near_word(word) };
    Some(Cli::command().error(ErrorKind::InvalidSubcommand, unknown))
}

/// What to say of a word after a scene, which clap takes for a command.
fn second_word(error: &clap::Error) -> Option<clap::Error> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    let told = match commands().contains(word) {
        true => format!("a command comes before the scene: `bench {word} SCENE`"),
        false => format!("one scene at a time: `{word}` is one word too many"),
    };
    (error.kind() == ErrorKind::ArgumentConflict).then(|| Cli::command().error(error.kind(), told))
}

/// A file beside the one that is not there, or one of its name that comes with the program.
fn near_path(path: &Path, kind: FileKind) -> Meant {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = files_in(path.parent().unwrap_or(Path::new("")), None).map(|file| {
        (file.file_name().unwrap_or_default().to_string_lossy().into_owned(), file.display().to_string())
    });
    let supplied = supplied::of_kind(kind).flat_map(|file| {
        let told = format!("`{}`, which comes with the program", file.name());
        [(file.name().to_owned(), told.clone()), (format!("{}.yaml", file.name()), told)]
    });
    match Meant::nearest(&name, beside) {
        Meant(None) => Meant::nearest(&name, supplied),
        meant => meant,
    }
}

/// The YAML files in a folder, those of a kind where one is asked for.
fn files_in(folder: &Path, kind: Option<FileKind>) -> impl Iterator<Item = PathBuf> {
    let read = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(read).into_iter().flatten();
    let mut files: Vec<PathBuf> =
        entries.filter_map(|entry| Some(folder.join(entry.ok()?.file_name()))).collect();
    files.retain(|path| {
        path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml")
            && path.is_file()
            && kind.is_none_or(|kind| FileKind::of_file(path) == Some(kind))
    });
    files.sort();
    files.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(given: &Path, kind: FileKind, bare: bool) -> String {
        file(given, kind, Path::new("never"), bare).unwrap_err().to_string()
    }

    #[test]
    fn a_word_that_nothing_has_is_told_with_what_is_near() {
        assert!(
            told(Path::new("chekc"), FileKind::Scene, true).contains("did you mean the command `check`?")
        );
        assert!(told(Path::new("tabeltop"), FileKind::Scene, true).contains("did you mean `tabletop`?"));
        assert!(told(Path::new("hlep"), FileKind::Scene, true).contains("did you mean the command `help`?"));
        let far = told(Path::new("zzzzzzzz"), FileKind::Scene, true);
        assert!(far.contains("`zzzzzzzz` (`bench --help`") && !far.contains("did you mean"), "{far}");
        assert!(
            told(Path::new("model"), FileKind::Study, false)
                .contains("no study `model`; did you mean `models`?")
        );
    }

    #[test]
    fn a_file_that_is_not_there_is_told_with_the_one_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine.yaml");
        fs::write(&mine, "world: 1\n").unwrap();
        let missing = told(&folder.path().join("mine.yml"), FileKind::Scene, true);
        assert!(missing.contains(&format!("did you mean {}?", mine.display())), "{missing}");
        for name in ["tabletop.yaml", "tabletop", "tabletop/"] {
            let elsewhere = told(&folder.path().join(name), FileKind::Scene, true);
            assert!(
                elsewhere.contains("did you mean `tabletop`, which comes with the program?"),
                "{elsewhere}"
            );
        }
    }

    #[test]
    fn a_folder_is_told_with_the_files_of_the_kind_in_it() {
        let folder = tempfile::tempdir().unwrap();
        assert!(told(folder.path(), FileKind::Scene, true).contains("it holds no scene"));
        fs::write(folder.path().join("a.yaml"), "world: 1\n").unwrap();
        fs::write(folder.path().join("b.yaml"), "variants: []\n").unwrap();
        let scenes = told(folder.path(), FileKind::Scene, true);
        assert!(scenes.contains("a.yaml") && !scenes.contains("b.yaml"), "{scenes}");
        let studies = told(folder.path(), FileKind::Study, false);
        assert!(studies.contains("b.yaml") && !studies.contains("a.yaml"), "{studies}");
    }

    #[test]
    fn one_kind_in_place_of_the_other_is_told_with_the_command_that_runs_it() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, study] = ["s.yaml", "t.yaml"].map(|name| folder.path().join(name));
        fs::write(&scene, "world: 1\n").unwrap();
        fs::write(&study, "variants: []\n").unwrap();
        let wrong = told(&study, FileKind::Scene, true);
        assert!(
            wrong.contains(&format!("is a study, expected a scene: `bench study {}`", study.display())),
            "{wrong}"
        );
        let wrong = told(&scene, FileKind::Study, false);
        assert!(
            wrong.contains(&format!("is a scene, expected a study: `bench {}`", scene.display())),
            "{wrong}"
        );
        for (name, command) in [("sizes", "`bench study sizes`"), ("any_loop", "`bench map any_loop`")] {
            assert!(told(Path::new(name), FileKind::Scene, true).contains(command));
        }
        assert_eq!(file(&scene, FileKind::Scene, Path::new("never"), true).unwrap(), scene);
    }

    #[test]
    fn a_name_that_several_kinds_have_is_that_of_the_kind_that_is_looked_for() {
        let path = |name, kind, bare| named(name, kind, bare).map(|found| found.path);
        assert_eq!(path("any", FileKind::Map, false), Some("maps/any.yaml"));
        for name in ["any", "any_dependent", "embedding"] {
            let cache = tempfile::tempdir().unwrap();
            let found = file(Path::new(name), FileKind::Scene, cache.path(), false).unwrap();
            assert!(found.ends_with(format!("studies/views/{name}.yaml")) && found.is_file(), "{found:?}");
        }
        assert_eq!(path("tabletop", FileKind::Scene, false), Some("scenes/tabletop.yaml"));
        assert_eq!(path("embedding", FileKind::Study, false), Some("studies/views/embedding.yaml"));
        assert!(told(Path::new("embeding"), FileKind::Scene, false).contains("did you mean `embedding`?"));
        assert!(told(Path::new("any"), FileKind::Scene, true).contains("`bench map any`"));
        for unknown in [path("embedding", FileKind::Scene, true), path("lmo", FileKind::Scene, false)] {
            assert_eq!(unknown, None);
        }
    }
}
