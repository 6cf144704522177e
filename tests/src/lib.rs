//! What the integration tests share: the `bench` program, and a scene small enough to run often.

mod resume;

pub use resume::assert_resumes;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

/// The `bench` program that was built with the tests.
///
/// # Panics
/// If there is none: `cargo test --workspace` builds it.
pub fn bench() -> Command {
    let test = std::env::current_exe().unwrap_or_default();
    let program = test.ancestors().nth(2).unwrap_or(Path::new(".")).join("bench");
    assert!(program.exists(), "{} is missing: run `cargo test --workspace`", program.display());
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// Every file below a folder, by its path in it.
///
/// # Panics
/// If the folder cannot be read.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("a path below the folder").to_owned();
                found.insert(name, std::fs::read(&path).expect("a file"));
            }
        }
    }
    found
}

/// A folder with a small scene, `scene.yaml`, that takes a second: three objects, two seeds, the committed model.
#[derive(Debug)]
pub struct SmallScene {
    folder: tempfile::TempDir,
}

impl SmallScene {
    /// Writes the scene, with each `(old, new)` replaced in its text.
    ///
    /// # Panics
    /// If the folder cannot be written, or an `old` is not in the scene.
    pub fn new(changes: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut text = include_str!("../cases/small.yaml")
            .replace("MODEL", &root().join("models/objects").to_string_lossy());
        for (old, new) in changes {
            assert!(text.contains(old), "{old:?} is not in the scene");
            text = text.replace(old, new);
        }
        std::fs::write(folder.path().join("scene.yaml"), text).expect("a scene file");
        Self { folder }
    }

    /// A path in the scene's folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `bench`, a command and a file of the folder, with the reference renderer and its cache in the folder.
    pub fn on(&self, command: &[&str], file: &str) -> Command {
        let mut bench = bench();
        bench.args(command).arg(self.path(file)).args(["--renderer", "reference", "--cache"]);
        bench.arg(self.path("cache"));
        bench
    }

    /// `bench scene.yaml` into `out`.
    pub fn command(&self) -> Command {
        let mut command = self.on(&[], "scene.yaml");
        command.arg("--out").arg(self.path("out"));
        command
    }

    /// `bench dataset scene.yaml` into a folder of the scene's.
    pub fn dataset(&self, out: &str, args: &[&str]) -> Command {
        let mut command = self.on(&["dataset"], "scene.yaml");
        command.args(args).arg("--out").arg(self.path(out));
        command
    }

    /// Writes a study, without its name, purpose and scene, and runs it into `out`.
    ///
    /// # Panics
    /// If it cannot be written, or the program not be started.
    pub fn study(&self, name: &str, text: &str) -> Finished {
        let head = format!("version: 1\nname: {name}\npurpose: To see.\nscene: scene.yaml\n");
        std::fs::write(self.path("study.yaml"), head + text).expect("a study file");
        Finished::of(self.on(&["study"], "study.yaml").arg("--out").arg(self.path("out")))
    }

    /// Writes a mesh of a cube, `box.obj`.
    ///
    /// # Panics
    /// If it cannot be written.
    pub fn write_box(&self) {
        let corner = |i: u32| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2);
        let corners: String = (0..8).map(corner).collect();
        let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        std::fs::write(self.path("box.obj"), corners + faces).expect("a mesh");
    }

    /// `bench train scene.yaml` on the view sets `train` and `validation` in the scene's folder, into `model`.
    pub fn train_on_views(&self) -> Command {
        let mut command = self.on(&["train"], "scene.yaml");
        command.arg("--views").arg(self.path("train")).arg("--validation-views").arg(self.path("validation"));
        command.arg("--out").arg(self.path("model"));
        command
    }

    /// Runs [`SmallScene::command`].
    ///
    /// # Panics
    /// If the program cannot be started.
    pub fn run(&self) -> Finished {
        Finished::of(&mut self.command())
    }
}

/// How a program ended.
#[derive(Debug)]
pub struct Finished {
    /// Its exit code; `None` if it was killed.
    pub code: Option<i32>,
    /// What it printed.
    pub stdout: String,
    /// What it complained of.
    pub stderr: String,
}

impl Finished {
    /// Runs a command to its end.
    ///
    /// # Panics
    /// If it cannot be started.
    pub fn of(command: &mut Command) -> Self {
        let Output { status, stdout, stderr } = command.output().expect("the program starts");
        Self {
            code: status.code(),
            stdout: String::from_utf8_lossy(&stdout).into_owned(),
            stderr: String::from_utf8_lossy(&stderr).into_owned(),
        }
    }

    /// # Panics
    /// If the exit code is another, or the complaint lacks one of `words`, or it is a panic's.
    pub fn expect(&self, code: i32, words: &[&str]) -> &Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        for word in words {
            assert!(self.stderr.contains(word), "{word:?} is not in {}", self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }
}
