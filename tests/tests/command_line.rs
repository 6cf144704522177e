//! The command line: scenes by name, what is misspelt, what is listed, and how an interrupt ends.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use vantage_tests::{Finished, SmallScene, bench, files, root};

/// `bench` in a folder that is no checkout.
fn outside(folder: &Path, line: &str) -> Finished {
    Finished::of(bench().current_dir(folder).args(line.split_whitespace()))
}

#[test]
fn a_scene_that_comes_with_the_program_runs_outside_the_repository_as_its_file_does() {
    let folder = tempfile::tempdir().unwrap();
    let options = "--seeds 1 --renderer reference --cache cache --out";
    outside(folder.path(), &format!("tabletop {options} named")).expect(0, &[]);
    let entries = folder.path().join("cache/entries");
    let estimates = |stage: &str| fs::read_dir(entries.join(stage)).unwrap().count();
    assert_eq!((estimates("supplied"), estimates("episode")), (1, 1));
    let file = root().join("scenes/tabletop.yaml");
    outside(folder.path(), &format!("{} {options} by_path", file.display())).expect(0, &[]);
    assert_eq!(estimates("episode"), 1, "the same keys in the cache");
    let [named, by_path] = ["named", "by_path"].map(|out| {
        let mut written = files(&folder.path().join(out));
        written.retain(|name, _| !name.ends_with("manifest.json") && !name.ends_with("report.html"));
        written
    });
    assert!(named.keys().any(|name| name.ends_with("results.json")), "{:?}", named.keys());
    assert!(named == by_path, "{:?} {:?}", named.keys(), by_path.keys());

    let checked = outside(folder.path(), "check tabletop --seeds 1 --renderer reference");
    checked.expect(2, &["results", "tabletop", "--baseline"]);
}

#[test]
fn what_comes_with_the_program_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let listed = outside(folder.path(), "list");
    listed.expect(0, &[]);
    for words in [
        "tabletop",
        "10 seeds, model objects",
        "sparse_loop_predictive",
        "viewpoint_dependent",
        "bench study",
    ] {
        assert!(listed.stdout.contains(words), "{words} not in {}", listed.stdout);
    }
    assert!(fs::read_dir(folder.path()).unwrap().next().is_none(), "it writes nothing");
}

#[test]
fn without_arguments_it_tells_how_it_is_used() {
    let alone = Finished::of(&mut bench());
    alone.expect(2, &["Usage: bench", "Commands:", "bench tabletop", "bench list"]);
    let help = Finished::of(bench().arg("--help"));
    help.expect(0, &[]);
    for words in ["Examples:", "Exit codes:", "130  interrupted", "docs/", "--features"] {
        let all = help.stdout.clone() + &Finished::of(bench().args(["look", "--help"])).stdout;
        assert!(all.contains(words), "{words} not in {all}");
    }
}

#[test]
fn what_is_misspelt_is_told_with_what_may_have_been_meant() {
    let told = |line: &str, words: &[&str]| {
        outside(&root(), line).expect(2, words);
    };
    told(
        "chekc scenes/tabletop.yaml",
        &["no command and no scene `chekc`", "did you mean the command `check`?"],
    );
    told("chekc", &["did you mean the command `check`?", "`bench --help` lists the commands"]);
    told("tabeltop --seeds 2", &["did you mean `tabletop`?"]);
    told("check tabeltop", &["no scene `tabeltop`; did you mean `tabletop`?"]);
    told("scenes/tabletop.yml", &["no file scenes/tabletop.yml; did you mean scenes/tabletop.yaml?"]);
    told("scenes", &["scenes is a folder, expected one scene", "scenes/tabletop.yaml"]);
    told("look scenes/", &["is a folder, expected one scene", "scenes/tabletop.yaml"]);
    told("studies/models.yaml", &["is a study, expected a scene: `bench study studies/models.yaml` runs it"]);
    told(
        "study scenes/tabletop.yaml",
        &["is a scene, expected a study: `bench scenes/tabletop.yaml` runs it"],
    );
    told("study tabletop", &["`bench tabletop` runs it"]);
    told("tabletop --seed 2", &["--seeds"]);
    told("helpp", &["did you mean the command `help`?"]);
    told("./tabletop", &["no file ./tabletop; did you mean `tabletop`, which comes with the program?"]);
    told("tabletop check", &["a command comes before the scene: `bench check SCENE`"]);
    told("tabletop shelves", &["one scene at a time: `shelves` is one word too many"]);
    told("schema extra", &["extra", "Usage"]);
    told("tabletop --model nope", &["model nope: there is no such folder", "`bench list`"]);
    told("datset tabletop --out x", &["did you mean the command `dataset`?"]);
}

#[test]
fn numbers_of_seeds_out_of_range_are_told_the_range() {
    for (number, command) in [("0", "check"), ("-1", "check"), ("-1", "dataset")] {
        let line = format!("{command} tabletop --seeds {number}");
        outside(&root(), &line).expect(2, &[&format!("{number} is not in 1..=")]);
    }
}

#[test]
fn schema_prints_json_and_nothing_else() {
    let printed = Finished::of(bench().arg("schema"));
    printed.expect(0, &[]);
    let schema: serde_json::Value = serde_json::from_str(&printed.stdout).unwrap();
    assert_eq!((schema["title"].as_str(), printed.stderr.as_str()), (Some("SceneFile"), ""));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_ends_with_6() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ended = bench().arg("schema").stdout(full).stderr(Stdio::piped()).output().unwrap();
    assert_eq!(ended.status.code(), Some(6));
    assert!(String::from_utf8_lossy(&ended.stderr).contains("standard output"));
}

#[test]
#[cfg(target_os = "linux")]
fn a_standard_error_that_takes_nothing_changes_no_exit_code() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ended = bench().arg("no_such_scene").stderr(full).output().unwrap();
    assert_eq!(ended.status.code(), Some(2));
}

#[test]
fn a_model_that_comes_with_the_program_is_taken_by_its_name() {
    let scene = SmallScene::new(&[]);
    Finished::of(scene.command().args(["--model", "predictive", "--seeds", "1"])).expect(0, &[]);
    assert!(scene.path("out/scenes/small/0/predictive.tum").exists(), "its row has its name");
    let folder = tempfile::tempdir().unwrap();
    let told = outside(folder.path(), "models objects");
    told.expect(0, &[]);
    assert!(told.stdout.contains("viewpoint_dependent"), "{}", told.stdout);
    outside(folder.path(), "models objekts").expect(2, &["no folder objekts"]);
}

#[test]
fn a_model_that_is_not_there_is_found_before_any_work() {
    let scene = SmallScene::new(&[]);
    Finished::of(scene.command().args(["--model", "nope"])).expect(2, &["model nope", "bench train"]);
    assert!(!scene.path("cache/entries/views").exists());
}

#[test]
fn shells_and_man_are_told_of_every_command() {
    for (shell, words) in [("bash", "_bench()"), ("zsh", "#compdef bench"), ("fish", "complete -c bench")] {
        let script = Finished::of(bench().args(["completions", shell]));
        script.expect(0, &[]);
        assert!(script.stdout.contains(words) && script.stdout.contains("figures"), "{shell}");
    }
    Finished::of(bench().args(["completions", "cmd"])).expect(2, &["bash"]);
    let page = Finished::of(bench().arg("man"));
    page.expect(0, &[]);
    assert!(page.stdout.contains(".TH bench 1") && page.stdout.contains("Exit codes"), "{}", page.stdout);
    let page = Finished::of(bench().args(["man", "check"]));
    assert!(page.stdout.contains("baseline"), "{}", page.stdout);
    Finished::of(bench().args(["man", "chekc"])).expect(2, &["expected one of", "check"]);
}

#[test]
#[cfg(unix)]
fn an_interrupt_says_what_is_kept_and_the_same_command_goes_on() {
    let scene = SmallScene::new(&[("seeds: 2", "seeds: 200")]);
    let mut child = scene.command().stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let episodes = scene.path("cache/entries/episode");
    let under_way = || fs::read_dir(&episodes).is_ok_and(|entries| entries.count() >= 2);
    while !under_way() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was interrupted");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let lines: Vec<String> =
        BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{lines:?}");
    let told = lines.last().unwrap();
    assert!(told.starts_with("interrupted: finished stages are kept in "), "{lines:?}");
    let kept = fs::read_dir(&episodes).unwrap().count();
    assert!((2..200).contains(&kept), "{kept}");
    Finished::of(scene.command().args(["--seeds", "2"])).expect(0, &[]);
    assert_eq!(fs::read_dir(&episodes).unwrap().count(), kept, "the first two were there");
}

#[test]
#[cfg(target_os = "linux")]
fn a_vulkan_driver_that_looks_for_a_display_is_not_heard() {
    let scene = SmallScene::new(&[]);
    for set in ["", "relative"] {
        let mut command = bench();
        command.arg("look").arg(scene.path("scene.yaml")).arg("--out").arg(scene.path("look.png"));
        command.env_remove("XDG_RUNTIME_DIR");
        if !set.is_empty() {
            command.env("XDG_RUNTIME_DIR", set);
        }
        let seen = Finished::of(&mut command);
        seen.expect(0, &[]);
        assert!(!seen.stderr.contains("XDG_RUNTIME_DIR"), "{}", seen.stderr);
    }
}

#[test]
#[cfg(unix)]
fn pipes_and_endless_files_are_refused() {
    let scene = SmallScene::new(&[]);
    let mine = scene.path("mine");
    fs::create_dir(&mine).unwrap();
    let pipe = |path: &Path| assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    pipe(&scene.path("pipe.yaml"));
    for command in ["look", "study"] {
        Finished::of(bench().arg(command).arg(scene.path("pipe.yaml")))
            .expect(2, &["pipe.yaml", "not a regular file"]);
    }
    Finished::of(bench().arg("/dev/zero")).expect(2, &["/dev/zero", "not a regular file"]);
    let entered = || Finished::of(scene.command().arg("--trajectories").arg(&mine));
    pipe(&mine.join("0.tum"));
    entered().expect(2, &["0.tum: it is not a regular file"]);
    fs::remove_file(mine.join("0.tum")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", mine.join("0.tum")).unwrap();
    entered().expect(2, &["0.tum: it is not a regular file"]);
    fs::remove_file(mine.join("0.tum")).unwrap();
    let line = |time: f64, x: f64| format!("{time} {x} 0 0 0 0 0 1\n");
    fs::write(mine.join("0.tum"), format!("# mine\n{}{}", line(0.0, 0.0), line(0.0, 0.5))).unwrap();
    entered().expect(2, &["0.tum: line 3: another pose than the one above"]);
    fs::write(mine.join("0.tum"), line(1.0, 0.0) + &line(0.5, 0.5)).unwrap();
    entered().expect(2, &["0.tum: line 2: timestamp 0.5 is before 1"]);
}
