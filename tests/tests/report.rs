//! Reports: one page of finished results that needs nothing else, and their tables as Markdown and LaTeX.

use std::fs;
use std::path::Path;
use std::process::Command;
use vantage_tests::{Finished, SmallScene, bench, root};

fn report(results: &[&Path], out: &Path, more: &[&str]) -> Finished {
    Finished::of(bench().arg("report").args(results).arg("--out").arg(out).args(more))
}

#[test]
fn a_run_ends_with_its_page() {
    let scene = SmallScene::new(&[]);
    let run = scene.run();
    run.expect(0, &[]);
    let page = fs::read_to_string(scene.path("out/scenes/small/report.html")).unwrap();
    for part in [
        "<caption>trajectory, mean +- 95% interval over 2 seeds",
        "gains.svg",
        "What the decoder predicts from other viewpoints beside what is seen from them",
        "Likelihood of each viewpoint given one crop",
        "scene hash",
        "data:image/svg+xml;base64,",
    ] {
        assert!(page.contains(part), "{part}");
    }
    let images = page.matches("<img ").count();
    assert!(images >= 4 && page.matches("alt=\"").count() == images, "{images} images, each with words");
    assert!(!page.contains("http://") && !page.contains("https://"), "nothing is fetched");

    let both = scene.path("all.html");
    report(&[&scene.path("out"), &root().join("results/studies/known")], &both, &[]).expect(0, &[]);
    let page = fs::read_to_string(&both).unwrap();
    assert!(page.contains("href=\"#result-1\"") && page.contains("<title>2 results"), "{}", &page[..400]);

    let tables = scene.path("tables.tex");
    report(&[&scene.path("out/scenes/small")], &tables, &["--format", "latex"]).expect(0, &[]);
    let text = fs::read_to_string(tables).unwrap();
    assert!(
        text.contains("\\toprule\n{}Method & Runs & ATE [m]") && text.contains("viewpoint\\_dependent &"),
        "{text}"
    );
    let tables = scene.path("again.md");
    report(&[&scene.path("out/scenes/small")], &tables, &["--format", "markdown"]).expect(0, &[]);
    let written = fs::read(scene.path("out/scenes/small/tables.md")).unwrap();
    assert_eq!(fs::read(tables).unwrap(), written);
}

#[test]
fn names_of_others_are_text_and_no_markup() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "<script>alert(1)</script>";
    let from = root().join("results/studies/real_meshes");
    let results = fs::read_to_string(from.join("results.json")).unwrap();
    let manifest = fs::read_to_string(from.join("manifest.json")).unwrap();
    fs::write(folder.path().join("results.json"), results.replace("predictive", hostile)).unwrap();
    let manifest = manifest.replace("x86_64", hostile);
    let manifest = manifest.replace("\"files\": [", "\"files\": [\"\\\"><b>.png\", \"../elsewhere.png\",");
    fs::write(folder.path().join("manifest.json"), manifest).unwrap();
    fs::write(folder.path().join("of_another_run.png"), "no image").unwrap();
    fs::write(folder.path().join("\"><b>.png"), "no image").unwrap();
    let out = folder.path().join("page.html");
    report(&[folder.path()], &out, &[]).expect(0, &[]);
    let page = fs::read_to_string(out).unwrap();
    assert!(!page.contains(hostile) && !page.contains("\"><b>"));
    assert_eq!(page.matches("<img ").count(), 1, "those of the result alone");
    assert!(page.matches("&lt;script&gt;alert(1)").count() >= 2);
}

#[test]
fn what_is_no_result_is_told_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("page.html");
    report(&[folder.path()], &out, &[]).expect(2, &["no results in", "bench SCENE"]);
    report(&[&folder.path().join("nowhere")], &out, &[]).expect(2, &["nowhere"]);
    let from = root().join("results/studies/known");
    report(&[&from], folder.path(), &[]).expect(2, &["is no file name"]);
    fs::copy(from.join("results.json"), folder.path().join("results.json")).unwrap();
    report(&[folder.path()], &out, &[]).expect(5, &["manifest.json", "run again"]);
    fs::write(folder.path().join("manifest.json"), "{").unwrap();
    report(&[folder.path()], &out, &[]).expect(5, &["manifest.json"]);
    let whole = fs::read(from.join("results.json")).unwrap();
    fs::write(folder.path().join("results.json"), &whole[..whole.len() / 2]).unwrap();
    report(&[folder.path()], &out, &[]).expect(5, &["no results file"]);
    assert!(!out.exists());
}

#[test]
fn a_browser_opens_it_without_complaint() {
    if Command::new("chromium").arg("--version").output().is_err() {
        eprintln!("SKIPPED: chromium is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    report(&[&root().join("results/scenes/sparse_loop")], &page, &[]).expect(0, &[]);
    // What the page does with a click on its first column's head, as a reader would.
    let text = fs::read_to_string(&page).unwrap();
    let click = "document.querySelectorAll('thead button')[2].click(); document.title = 'sorted';\n";
    let at = text.rfind("</script>").unwrap();
    fs::write(&page, format!("{}{click}{}", &text[..at], &text[at..])).unwrap();
    let mut browser = Command::new("chromium");
    browser.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]);
    browser.args(["--disable-background-networking", "--disable-component-update", "--disable-sync"]);
    browser.args(["--enable-logging=stderr", "--virtual-time-budget=3000", "--dump-dom"]);
    browser.arg(format!("--user-data-dir={}", folder.path().join("browser").display()));
    let shown = browser.arg(format!("file://{}", page.display())).output().unwrap();
    let said = String::from_utf8_lossy(&shown.stderr);
    assert!(!said.contains("CONSOLE"), "{said}");
    let dom = String::from_utf8_lossy(&shown.stdout);
    assert!(
        dom.contains("<title>sorted") && dom.contains("aria-sort=\"ascending\""),
        "{}",
        &dom[..dom.len().min(500)]
    );
}
