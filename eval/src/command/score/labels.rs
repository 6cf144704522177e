//! Classes that maps tell and the truth does not have.

use super::error::ScoreError;
use crate::progress::Progress;
use crate::score::object_map::Proposal;
use std::collections::BTreeSet;

/// How many classes a message names.
const NAMED: usize = 5;

/// Tells how many objects are of classes that are not `known`, and of which.
pub fn tell<'a>(
    map: impl Iterator<Item = &'a Proposal>,
    known: &BTreeSet<String>,
    whose: &str,
    progress: &Progress,
) {
    let found = Labels::of(map, known);
    if found.wrong > 0 {
        progress.note(&format!(
            "note: {} of {} objects with a label are of classes that {whose} lacks, and count as wrong: {}; it has {}",
            found.wrong,
            found.labelled,
            named(&found.unknown),
            named(known)
        ));
    }
}

/// Likewise, and refuses maps all of whose objects are: their labels score nothing.
pub fn check<'a>(
    map: impl Iterator<Item = &'a Proposal> + Clone,
    known: &BTreeSet<String>,
) -> Result<(), ScoreError> {
    let found = Labels::of(map.clone(), known);
    if found.labelled > 0 && found.wrong == found.labelled {
        let (unknown, known) = (named(&found.unknown), named(known));
        return Err(ScoreError::Labels { objects: found.labelled, unknown, known });
    }
    tell(map, known, "the task", &Progress::detect());
    Ok(())
}

/// What the objects of maps are labelled.
struct Labels<'a> {
    /// Objects with a label.
    labelled: usize,
    /// Those of which no label is known.
    wrong: usize,
    /// The labels of these.
    unknown: BTreeSet<&'a str>,
}

impl<'a> Labels<'a> {
    fn of(map: impl Iterator<Item = &'a Proposal>, known: &BTreeSet<String>) -> Self {
        let mut labels = Self { labelled: 0, wrong: 0, unknown: BTreeSet::new() };
        for classes in map.filter_map(|proposal| proposal.classes.as_ref()) {
            let mut told = classes.iter().filter(|(_, p)| **p > 0.0).map(|(class, _)| class).peekable();
            labels.labelled += usize::from(told.peek().is_some());
            let (right, wrong): (Vec<_>, Vec<_>) = told.partition(|class| known.contains(*class));
            if right.is_empty() && !wrong.is_empty() {
                labels.wrong += 1;
                labels.unknown.extend(wrong.into_iter().map(String::as_str));
            }
        }
        labels
    }
}

/// The first few, and how many others there are.
fn named(labels: &BTreeSet<impl AsRef<str>>) -> String {
    let first: Vec<&str> = labels.iter().take(NAMED).map(AsRef::as_ref).collect();
    match labels.len().saturating_sub(NAMED) {
        0 => first.join(", "),
        others => format!("{} and {others} others", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn object(classes: &[(&str, f64)]) -> Proposal {
        let classes = classes.iter().map(|(class, p)| ((*class).to_owned(), *p)).collect();
        Proposal { center: Point3::origin(), sides: None, classes: Some(classes) }
    }

    #[test]
    fn an_object_is_wrong_where_no_class_that_it_may_be_is_known() {
        let known: BTreeSet<String> = ["book", "mug"].map(String::from).into();
        let bare = Proposal { center: Point3::origin(), sides: None, classes: None };
        let map = [
            object(&[("mug", 1.0)]),
            object(&[("cup", 0.6), ("book", 0.4)]),
            object(&[("tome", 1.0), ("book", 0.0)]),
            object(&[("mug", 0.0)]),
            bare,
        ];
        let found = Labels::of(map.iter(), &known);
        assert_eq!((found.labelled, found.wrong), (3, 1));
        assert_eq!(found.unknown.into_iter().collect::<Vec<_>>(), ["tome"]);
        assert!(check(map.iter(), &known).is_ok() && check(map[4..].iter(), &known).is_ok());
        let told = check(map[2..3].iter(), &known).unwrap_err().to_string();
        assert!(told.contains("tome") && told.contains("book, mug"), "{told}");
    }

    #[test]
    fn many_are_counted() {
        let labels: BTreeSet<String> = (0..7).map(|i| format!("c{i}")).collect();
        assert_eq!(named(&labels), "c0, c1, c2, c3, c4 and 2 others");
    }
}
