//! A verdict as JUnit XML, which continuous integration shows: a test case for each score, a failure for each that moved.

use super::{Comparison, Movement, Verdict};
use quick_xml::Writer;
use quick_xml::events::BytesText;
use std::io;

/// The file, of one scene.
pub fn junit(scene: &str, verdict: &Verdict) -> io::Result<Vec<u8>> {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    let tests = verdict.comparisons.len().to_string();
    let failures = (verdict.comparisons.len() - verdict.count(Movement::Still)).to_string();
    let counts = [("tests", tests.as_str()), ("failures", failures.as_str())];
    let suite = [("name", scene)].into_iter().chain(counts);
    writer.create_element("testsuites").with_attributes(counts).write_inner_content(|writer| {
        writer.create_element("testsuite").with_attributes(suite).write_inner_content(|writer| {
            verdict.comparisons.iter().try_for_each(|comparison| case(writer, scene, comparison))
        })?;
        Ok(())
    })?;
    Ok(writer.into_inner())
}

fn case(writer: &mut Writer<Vec<u8>>, scene: &str, comparison: &Comparison) -> io::Result<()> {
    let (class, name) = (
        format!("{scene}.{}", comparison.table),
        format!("{}, {}", comparison.method, comparison.metric.heading()),
    );
    let element = writer
        .create_element("testcase")
        .with_attributes([("classname", class.as_str()), ("name", name.as_str())]);
    if comparison.movement == Movement::Still {
        element.write_empty()?;
        return Ok(());
    }
    let [_, _, _, baseline, now, difference, differing, verdict] = comparison.cells();
    let told = format!(
        "baseline {baseline}, now {now}, paired difference {difference}, seeds that differ {differing}"
    );
    element.write_inner_content(|writer| {
        let failure = writer.create_element("failure").with_attribute(("message", verdict.as_str()));
        failure.write_text_content(BytesText::new(&told))?;
        Ok(())
    })?;
    Ok(())
}
