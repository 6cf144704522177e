//! The simulation of Mu et al. (IROS 2016): a robot among objects of a few classes, as a MAT-file.

use crate::import::{FETCH_AGAIN, ImportError};
use crate::mat5::{self, Value};
use std::collections::BTreeMap;
use std::path::Path;

/// Most poses, objects or detections.
const MOST: usize = 1 << 20;

/// A track through a plane of objects, without noise.
#[derive(Clone, Debug, PartialEq)]
pub struct MuSimulation {
    /// Poses `[x, y, heading]` in the world, metres and radians counter-clockwise.
    pub poses: Vec<[f64; 3]>,
    /// Objects `[x, y]` in the world, with their classes.
    pub objects: Vec<([f64; 2], usize)>,
    /// What was seen: pose and object, both from 0, in the order of the file.
    pub detections: Vec<[usize; 2]>,
    /// How far an object is seen, metres.
    pub range: f64,
}

/// Reads `simulation.mat`. Its own noisy measurements are left: they turn positions by the heading the other way round.
///
/// # Errors
/// A file that is no MAT-file of version 5 to 7, or lacks a field.
pub fn read(path: &Path) -> Result<MuSimulation, ImportError> {
    decode(&mat5::read(path)?, path)
}

/// [`read`] of the variables of a file; `path` is for messages alone.
///
/// # Errors
/// A variable that is missing or of another shape.
pub fn decode(variables: &BTreeMap<String, Value>, path: &Path) -> Result<MuSimulation, ImportError> {
    let file = Variables { variables, path };
    let poses = file.rows::<3>("truth_traj")?;
    let objects = file.rows::<3>("truth_objects")?;
    let classed =
        objects.iter().map(|[x, y, class]| Ok(([*x, *y], file.whole("truth_objects", *class, MOST)?)));
    let objects: Vec<([f64; 2], usize)> = classed.collect::<Result<_, ImportError>>()?;
    let (seers, seen) = (file.field("lm_edge", "id1")?, file.field("lm_edge", "id2")?);
    if seers.len() != seen.len() {
        return Err(file.fault(
            "lm_edge.id2",
            format!("{} numbers", seen.len()),
            format!("{}, as id1 has", seers.len()),
        ));
    }
    let number = |field: &str, id: f64, most: usize| file.whole(field, id - 1.0, most - 1);
    let detections = seers.iter().zip(seen).map(|(&pose, &object)| {
        Ok([number("lm_edge.id1", pose, poses.len())?, number("lm_edge.id2", object, objects.len())?])
    });
    let detections = detections.collect::<Result<_, ImportError>>()?;
    let range = match file.numbers("FOV")? {
        [range] if *range > 0.0 => *range,
        other => return Err(file.fault("FOV", format!("{other:?}"), "one positive number")),
    };
    Ok(MuSimulation { poses, objects, detections, range })
}

struct Variables<'a> {
    variables: &'a BTreeMap<String, Value>,
    path: &'a Path,
}

impl<'a> Variables<'a> {
    fn fault(&self, field: &str, got: impl std::fmt::Display, expected: impl Into<String>) -> ImportError {
        ImportError::invalid(self.path, field, got, expected, FETCH_AGAIN)
    }

    fn numbers(&self, name: &str) -> Result<&'a [f64], ImportError> {
        let value = self.variables.get(name).ok_or_else(|| self.fault(name, "nothing", "numbers"))?;
        value.as_numbers().ok_or_else(|| self.fault(name, value.describe(), "numbers"))
    }

    fn field(&self, name: &str, field: &str) -> Result<&'a [f64], ImportError> {
        let full = format!("{name}.{field}");
        let found = match self.variables.get(name) {
            Some(Value::Structs(structs)) => {
                structs.field(field).and_then(|at| structs.elements.first()?.get(at)?.as_numbers())
            }
            _ => None,
        };
        found.ok_or_else(|| self.fault(&full, "nothing", "a struct with this field of numbers"))
    }

    /// The rows of a matrix of `N` columns, all finite.
    fn rows<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>, ImportError> {
        let numbers = self.numbers(name)?;
        let rows = numbers.len() / N;
        let dims = match self.variables.get(name) {
            Some(Value::Numbers { dims, .. }) => dims.clone(),
            _ => Vec::new(),
        };
        if dims != [rows, N] || rows == 0 || rows > MOST {
            return Err(self.fault(
                name,
                format!("numbers {dims:?}"),
                format!("1 to {MOST} rows of {N} numbers"),
            ));
        }
        if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(self.fault(name, number, "finite numbers"));
        }
        Ok((0..rows).map(|row| std::array::from_fn(|column| numbers[column * rows + row])).collect())
    }

    fn whole(&self, field: &str, number: f64, most: usize) -> Result<usize, ImportError> {
        let is_whole = number >= 0.0 && number <= most as f64 && number.fract() == 0.0;
        let expected = || self.fault(field, number, format!("a whole number of 0 to {most}, counted from 0"));
        if is_whole { Ok(number as usize) } else { Err(expected()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mat5::StructArray;

    fn variables() -> BTreeMap<String, Value> {
        let seen = StructArray {
            fields: vec!["id1".into(), "id2".into()],
            elements: vec![vec![Value::matrix(1, 2, vec![1.0, 2.0]), Value::matrix(1, 2, vec![2.0, 1.0])]],
        };
        let named = [
            ("truth_traj", Value::matrix(2, 3, vec![0.0, 1.0, 0.5, 0.6, 0.1, 0.2])),
            ("truth_objects", Value::matrix(2, 3, vec![3.0, 4.0, 5.0, 6.0, 0.0, 4.0])),
            ("lm_edge", Value::Structs(seen)),
            ("FOV", Value::scalar(4.0)),
        ];
        named.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    #[test]
    fn what_was_written_is_read() {
        let named = variables();
        let listed: Vec<(&str, &Value)> = named.iter().map(|(name, value)| (name.as_str(), value)).collect();
        let path = Path::new("simulation.mat");
        let read = decode(&mat5::decode(&mat5::encode(&listed), path).unwrap(), path).unwrap();
        assert_eq!(read.poses, [[0.0, 0.5, 0.1], [1.0, 0.6, 0.2]]);
        assert_eq!(read.objects, [([3.0, 5.0], 0), ([4.0, 6.0], 4)]);
        assert_eq!((read.detections, read.range), (vec![[0, 1], [1, 0]], 4.0));
    }

    #[test]
    fn what_is_missing_or_misshapen_is_named() {
        let bad = |name: &str, value: Option<Value>| {
            let mut variables = variables();
            match value {
                Some(value) => variables.insert(name.to_owned(), value),
                None => variables.remove(name),
            };
            match decode(&variables, Path::new("simulation.mat")) {
                Err(ImportError::Invalid(problem)) => problem.field,
                other => panic!("{name}: {other:?}"),
            }
        };
        assert_eq!(bad("truth_traj", None), "truth_traj");
        assert_eq!(bad("truth_traj", Some(Value::matrix(3, 2, vec![0.0; 6]))), "truth_traj");
        assert_eq!(bad("truth_traj", Some(Value::matrix(1, 3, vec![0.0, f64::NAN, 0.0]))), "truth_traj");
        assert_eq!(bad("truth_traj", Some(Value::matrix(1, 3, vec![0.0; 3]))), "lm_edge.id1");
        assert_eq!(bad("truth_objects", Some(Value::matrix(1, 3, vec![0.0, 0.0, 0.5]))), "truth_objects");
        assert_eq!(bad("lm_edge", Some(Value::empty())), "lm_edge.id1");
        assert_eq!(bad("FOV", Some(Value::empty())), "FOV");
    }
}
