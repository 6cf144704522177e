//! The manifest beside the results: from what, on what, and how fast they were made.
//!
//! Kept apart from [`crate::result::results_file`], which equal inputs reproduce byte for byte. `bench check` tells whether processor
//! and renderer are those here.

use super::kind::ResultKind;
use crate::code;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::Duration;
use vantage_dataset::store::read_regular;
use vantage_sim::render::RendererInfo;

/// Name of the file.
pub const FILE_NAME: &str = "manifest.json";

/// More bytes no manifest has.
pub const LARGEST_FILE: u64 = 16 << 20;

/// The lock file this program was built with.
const LOCK_FILE: &[u8] = include_bytes!("../../../Cargo.lock");

/// Everything that made a result.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// Version of this program.
    pub version: &'static str,
    /// The commit; `None` where the program does not run in the repository it was built from.
    pub commit: Option<Commit>,
    /// Hash of the lock file it was built with.
    pub lock_hash: String,
    /// Hash of the scene as read.
    pub scene_hash: String,
    /// Hash of the dataset; `None` where none was made.
    pub dataset_hash: Option<String>,
    /// Hash of the model; `None` where none was used.
    pub model_hash: Option<String>,
    /// Of a study, the hash of the model of each variant that names a folder, by the variant.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub model_hashes: BTreeMap<String, String>,
    /// Hashes of other estimators' trajectories, by the name of their row.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub trajectories: BTreeMap<String, String>,
    /// Hashes of other associators' answers, by the name of their row.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub associations: BTreeMap<String, String>,
    /// What a reader of the scores has to know of the model; written above the tables, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub caveat: Option<String>,
    /// All seeds used.
    pub seeds: Vec<u64>,
    /// What rendered.
    pub renderer: Renderer,
    /// What computed.
    pub host: Host,
    /// The command line, without the program's folder.
    pub command: Vec<String>,
    /// What the results are of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<ResultKind>,
    /// The other files of these results.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    /// Options after defaults, by name.
    pub options: serde_json::Value,
    /// Seconds each stage took, in order.
    pub seconds: Vec<(String, f64)>,
}

/// The state of the repository.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Commit {
    /// Full hash of the commit.
    pub hash: String,
    /// Whether tracked files differ from it, or its sources from those that the program was built from.
    pub modified: bool,
}

/// The renderer that ran.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Renderer {
    /// `wgpu` or `reference`.
    pub name: String,
    /// Name of the adapter; `None` for the reference renderer.
    pub adapter: Option<String>,
    /// Driver and its version; `None` for the reference renderer.
    pub driver: Option<String>,
}

impl From<&RendererInfo> for Renderer {
    fn from(info: &RendererInfo) -> Self {
        let is_wgpu = !info.driver.is_empty();
        Self {
            name: info.renderer.clone(),
            adapter: is_wgpu.then(|| info.adapter.clone()),
            driver: is_wgpu.then(|| info.driver.clone()),
        }
    }
}

/// The machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Host {
    /// Model of the processor, as the system names it.
    pub cpu: Option<String>,
    /// Threads that may run at once.
    pub threads: usize,
    /// Architecture the program was built for.
    pub arch: String,
    /// System the program was built for.
    pub os: String,
}

impl Manifest {
    /// A manifest of this program, machine and repository, for a scene; the rest is filled in as it is known.
    pub fn new(scene_hash: &str, seeds: &[vantage_dataset::Seed]) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            commit: Commit::of(Path::new(".")),
            lock_hash: blake3::hash(LOCK_FILE).to_hex().to_string(),
            scene_hash: scene_hash.to_owned(),
            dataset_hash: None,
            model_hash: None,
            model_hashes: BTreeMap::new(),
            trajectories: BTreeMap::new(),
            associations: BTreeMap::new(),
            caveat: None,
            seeds: seeds.iter().map(|seed| seed.0).collect(),
            renderer: Renderer::default(),
            host: Host::this(),
            command: command_line(),
            of: None,
            files: Vec::new(),
            options: serde_json::Value::Null,
            seconds: Vec::new(),
        }
    }

    /// Notes how long a stage took.
    pub fn took(&mut self, stage: &str, duration: Duration) {
        self.seconds.push((stage.to_owned(), duration.as_secs_f64()));
    }

    /// The file's text.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// Where the program lies differs from machine to machine, and may tell a user's name.
fn command_line() -> Vec<String> {
    let mut arguments: Vec<_> = std::env::args_os().collect();
    if let Some(program) = arguments.first_mut()
        && let Some(name) = Path::new(program).file_name()
    {
        *program = name.to_owned();
    }
    arguments.into_iter().map(|argument| argument.to_string_lossy().into_owned()).collect()
}

impl Commit {
    /// The commit of the repository that holds `folder`, if this program was built from that repository: its lock
    /// file has to be the one compiled in.
    fn of(folder: &Path) -> Option<Self> {
        let git = |arguments: &[&str]| {
            let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
            let text = String::from_utf8(output.stdout).ok()?;
            output.status.success().then(|| text.trim().to_owned())
        };
        let root = git(&["rev-parse", "--show-toplevel"])?;
        if read_regular(&Path::new(&root).join("Cargo.lock"), LARGEST_FILE).ok()? != LOCK_FILE {
            return None;
        }
        let hash = git(&["rev-parse", "HEAD"])?;
        let changes =
            git(&["status", "--porcelain", "--untracked-files=no", "--", ":/", ":(exclude,top)results"])?;
        let modified = !changes.is_empty() || !code::is_of(Path::new(&root));
        Some(Self { hash, modified })
    }
}

impl Host {
    /// The machine this runs on.
    pub fn this() -> Self {
        let cpu_info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu_info.lines().find_map(|line| line.strip_prefix("model name"));
        Self {
            cpu: model.map(|text| text.trim_start_matches([' ', '\t', ':']).to_owned()),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            arch: std::env::consts::ARCH.to_owned(),
            os: std::env::consts::OS.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::Seed;

    #[test]
    fn the_manifest_holds_what_made_the_result() {
        let mut manifest = Manifest::new("abc", &[Seed(0), Seed(7)]);
        manifest.took("simulate", Duration::from_millis(1500));
        let json: serde_json::Value = serde_json::from_str(&manifest.to_json().unwrap()).unwrap();
        assert_eq!(json["scene_hash"], "abc");
        assert!(json.get("model_hashes").is_none(), "manifests without such variants are as they were");
        assert_eq!(json["seeds"], serde_json::json!([0, 7]));
        assert_eq!(json["seconds"], serde_json::json!([["simulate", 1.5]]));
        assert_eq!(json["lock_hash"].as_str().unwrap().len(), 64);
        assert!(json["host"]["threads"].as_u64().unwrap() >= 1);
        let program = json["command"][0].as_str().unwrap();
        assert!(!program.is_empty() && !program.contains(std::path::MAIN_SEPARATOR), "{program}");
    }

    #[test]
    fn a_folder_that_is_no_repository_of_ours_has_no_commit() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Commit::of(folder.path()), None);
    }

    #[test]
    fn the_commit_and_its_modifications_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let git = |arguments: &[&str]| {
            let identity = ["-c", "user.name=t", "-c", "user.email=t@t", "-c", "commit.gpgsign=false"];
            Command::new("git").arg("-C").arg(folder.path()).args(identity).args(arguments).output()
        };
        if git(&["init", "-q"]).is_err() {
            use std::io::Write as _;
            writeln!(std::io::stderr(), "SKIPPED: git is not installed").unwrap();
            return;
        }
        std::fs::write(folder.path().join("Cargo.lock"), LOCK_FILE).unwrap();
        git(&["add", "Cargo.lock"]).unwrap();
        git(&["commit", "-q", "-m", "lock"]).unwrap();
        // Without our sources.
        let other = Commit::of(folder.path()).unwrap();
        assert_eq!((other.hash.len(), other.modified), (40, true));
        assert!(code::is_of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..")));
        std::fs::write(folder.path().join("Cargo.lock"), "other").unwrap();
        assert_eq!(Commit::of(folder.path()), None);
    }
}
