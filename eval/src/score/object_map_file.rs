//! A map of objects as a CSV file: a line an object.
//!
//! | column | holds |
//! |---|---|
//! | `x`, `y`, `z` | the centre, metres |
//! | `length`, `width`, `height` | the sides of the box along x, y and z, metres; all or none |
//! | `label`, `confidence` | the class, and its probability, 1 without that column |
//! | `p_CLASS` | the probability of a class, in place of `label` |
//! | `e0`, `e1`, ... | the latent |

use super::object_map::Proposal;
use crate::exit::Ends;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::store::read_regular;

/// Largest file, bytes.
const LARGEST_FILE: u64 = 16 << 20;
/// Most objects of a map: the matching takes their number to the third power.
const MOST: usize = 2000;
/// By how much probabilities may sum to more than 1.
const ROUNDING: f64 = 1e-6;

/// A map of objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectMap {
    /// Its objects.
    pub proposals: Vec<Proposal>,
    /// Their latents; empty where the map has none.
    pub latents: Vec<Vec<f32>>,
}

/// A file that is no map.
#[derive(Debug, Error)]
#[error("{}: {reason}", path.display())]
pub struct ObjectMapError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, and where.
    pub reason: String,
}

impl Ends for ObjectMapError {}

impl ObjectMap {
    /// Reads a regular file; `None` where there is none.
    pub fn read(path: &Path) -> Result<Option<Self>, ObjectMapError> {
        let wrong = |reason: String| ObjectMapError { path: path.to_owned(), reason };
        match read_regular(path, LARGEST_FILE) {
            Ok(bytes) => Self::parse(&bytes).map(Some).map_err(wrong),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(wrong(error.to_string())),
        }
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new().from_reader(bytes);
        let head: Vec<String> =
            reader.headers().map_err(|error| error.to_string())?.iter().map(str::to_owned).collect();
        let columns = Columns::of(&head)?;
        let mut map = Self::default();
        for record in reader.records() {
            let record = record.map_err(|error| told(&error))?;
            let line = record.position().map_or(0, csv::Position::line);
            if map.proposals.len() == MOST {
                return Err(format!("line {line}: more than {MOST} objects"));
            }
            let row = Row { record: &record, head: &head, line };
            map.proposals.push(columns.proposal(&row)?);
            if !columns.latent.is_empty() {
                let latent = columns.latent.iter().map(|&i| Ok(row.number(i)? as f32));
                map.latents.push(latent.collect::<Result<_, String>>()?);
            }
        }
        Ok(map)
    }
}

fn told(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos: Some(pos), expected_len, len } => {
            format!("line {}: {len} columns, expected {expected_len}", pos.line())
        }
        _ => error.to_string(),
    }
}

/// Where in a line what stands.
struct Columns {
    center: [usize; 3],
    sides: Option<[usize; 3]>,
    label: Option<usize>,
    confidence: Option<usize>,
    /// Classes with their columns.
    probabilities: Vec<(String, usize)>,
    latent: Vec<usize>,
}

impl Columns {
    fn of(head: &[String]) -> Result<Self, String> {
        if let Some(twice) =
            head.iter().enumerate().find_map(|(i, name)| head[..i].contains(name).then_some(name))
        {
            return Err(format!("line 1: two columns {twice:?}"));
        }
        let find = |name: &str| head.iter().position(|column| column == name);
        let three = |names: [&str; 3]| {
            let found = names.map(find);
            match found {
                [Some(a), Some(b), Some(c)] => Ok(Some([a, b, c])),
                [None, None, None] => Ok(None),
                _ => Err(format!("line 1: expected all of {} or none", names.join(", "))),
            }
        };
        let center =
            three(["x", "y", "z"])?.ok_or("line 1: no columns x, y, z; the first line names the columns")?;
        let (label, confidence) = (find("label"), find("confidence"));
        let named = |(i, name): (usize, &String)| Some((name.strip_prefix("p_")?.to_owned(), i));
        let probabilities: Vec<(String, usize)> = head.iter().enumerate().filter_map(named).collect();
        if label.is_some() && !probabilities.is_empty() {
            return Err("line 1: both label and columns p_CLASS; expected one of them".to_owned());
        }
        if confidence.is_some() && label.is_none() {
            return Err("line 1: confidence without label".to_owned());
        }
        let latent: Vec<usize> = (0..).map_while(|i| find(&format!("e{i}"))).collect();
        let sides = three(["length", "width", "height"])?;
        let columns = Self { center, sides, label, confidence, probabilities, latent };
        match (0..head.len()).find(|i| !columns.knows(*i)) {
            Some(unknown) => Err(format!(
                "line 1: unknown column {:?}; expected x, y, z, length, width, height, label, confidence, p_CLASS, e0, e1 and so on",
                head[unknown]
            )),
            None => Ok(columns),
        }
    }

    fn knows(&self, column: usize) -> bool {
        let single = [self.label, self.confidence];
        let several = self.center.iter().chain(self.sides.iter().flatten()).chain(&self.latent);
        several.chain(single.iter().flatten()).any(|&known| known == column)
            || self.probabilities.iter().any(|(_, known)| *known == column)
    }

    fn proposal(&self, row: &Row<'_>) -> Result<Proposal, String> {
        let three = |columns: [usize; 3]| -> Result<Vector3<f64>, String> {
            Ok(Vector3::new(row.number(columns[0])?, row.number(columns[1])?, row.number(columns[2])?))
        };
        let sides = self.sides.map(three).transpose()?;
        if let Some(columns) = self.sides.filter(|_| sides.is_some_and(|sides| sides.min() < 0.0)) {
            return Err(format!(
                "line {}: a negative {}",
                row.line,
                columns.map(|i| &*row.head[i]).join(", ")
            ));
        }
        Ok(Proposal { center: Point3::from(three(self.center)?), sides, classes: self.classes(row)? })
    }

    fn classes(&self, row: &Row<'_>) -> Result<Option<BTreeMap<String, f64>>, String> {
        let classes: BTreeMap<String, f64> = match self.label {
            Some(label) => {
                let confidence = self.confidence.map_or(Ok(1.0), |i| row.number(i))?;
                if row.text(label).is_empty() {
                    return Err(format!("line {}, label: nothing", row.line));
                }
                [(row.text(label).to_owned(), confidence)].into()
            }
            None if self.probabilities.is_empty() => return Ok(None),
            None => {
                let probability = |(class, i): &(String, usize)| Ok((class.clone(), row.number(*i)?));
                self.probabilities.iter().map(probability).collect::<Result<_, String>>()?
            }
        };
        let sum: f64 = classes.values().sum();
        if classes.values().any(|p| !(0.0..=1.0).contains(p)) || sum > 1.0 + ROUNDING {
            return Err(format!(
                "line {}: probabilities outside of 0 to 1, or of more than 1 together",
                row.line
            ));
        }
        Ok(Some(classes))
    }
}

/// A line.
struct Row<'a> {
    record: &'a csv::StringRecord,
    head: &'a [String],
    line: u64,
}

impl Row<'_> {
    fn text(&self, column: usize) -> &str {
        // Lines of other lengths than the first are refused before.
        self.record.get(column).unwrap_or_default().trim()
    }

    fn number(&self, column: usize) -> Result<f64, String> {
        let text = self.text(column);
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() && number.abs() < 1e6 => Ok(number),
            _ => Err(format!(
                "line {}, {}: got {text:?}, expected a number below a million",
                self.line, self.head[column]
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<ObjectMap, String> {
        ObjectMap::parse(text.as_bytes())
    }

    #[test]
    fn a_line_is_an_object() {
        let map =
            parse("x,y,z,length,width,height,label,confidence,e0,e1\n1,2,3,.1,.2,.3,mug,0.9,5,-6\n").unwrap();
        let [proposal] = &map.proposals[..] else { panic!("{map:?}") };
        assert_eq!(proposal.center, Point3::new(1.0, 2.0, 3.0));
        assert_eq!(proposal.sides, Some(Vector3::new(0.1, 0.2, 0.3)));
        assert_eq!(proposal.classes, Some(BTreeMap::from([("mug".to_owned(), 0.9)])));
        assert_eq!(map.latents, [vec![5.0, -6.0]]);
        let bare = parse("z,x,y\n3,1,2\n").unwrap();
        assert_eq!(
            bare.proposals[0],
            Proposal { center: Point3::new(1.0, 2.0, 3.0), sides: None, classes: None }
        );
        let several = parse("x,y,z,p_mug,p_book\n0,0,0,0.25,0.75\n").unwrap();
        assert_eq!(several.proposals[0].classes.as_ref().unwrap()["book"], 0.75);
        assert!(parse("x,y,z\n").unwrap().proposals.is_empty());
    }

    #[test]
    fn what_is_no_map_is_told_with_its_line() {
        for (text, words) in [
            ("", "no columns x, y, z"),
            ("0,1,2\n", "no columns x, y, z"),
            ("x,y\n", "all of x, y, z"),
            ("x,y,z,length\n", "length, width, height"),
            ("x,y,z,colour\n", "unknown column \"colour\""),
            ("x,y,z,x\n", "two columns \"x\""),
            ("x,y,z,e1\n", "unknown column \"e1\""),
            ("x,y,z,label,p_mug\n", "both label"),
            ("x,y,z,confidence\n", "confidence without label"),
            ("x,y,z\n1,2,3\n1,nan,3\n", "line 3, y: got \"nan\""),
            ("x,y,z\n1,2,1e9\n", "line 2, z"),
            ("x,y,z\n1,2\n", "line 2"),
            ("x,y,z,length,width,height\n0,0,0,1,-1,1\n", "line 2: a negative"),
            ("x,y,z,label,confidence\n0,0,0,mug,1.5\n", "line 2: probabilities"),
            ("x,y,z,p_a,p_b\n0,0,0,0.7,0.7\n", "line 2: probabilities"),
        ] {
            let told = parse(text).unwrap_err();
            assert!(told.contains(words), "{text:?}: {told}");
        }
        let many = format!("x,y,z\n{}", "0,0,0\n".repeat(MOST + 1));
        assert!(parse(&many).unwrap_err().contains("more than 2000 objects"));
    }

    #[test]
    fn a_folder_in_place_of_a_file_is_told_and_no_file_is_none() {
        let folder = tempfile::tempdir().unwrap();
        assert!(ObjectMap::read(folder.path()).unwrap_err().to_string().contains("not a regular file"));
        assert_eq!(ObjectMap::read(&folder.path().join("none.csv")).unwrap(), None);
    }
}
