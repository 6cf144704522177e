//! Planar measurements with several modes or candidates, as the text of MH-iSAM2 (Hsiao & Kaess, ICRA 2019).
//!
//! `KIND from n to_1 .. to_n detachable m z_1 .. z_m`: a measurement from pose `from` to one of `n` poses or landmarks, one of `m` values, or, where
//! `detachable` is 1, a false one. A value is `x y heading` of an `ODOMETRY` or `EDGE2`, and `x y` of a `LANDMARK`, in the frame of `from`.
//!
//! Files list what is true first, so the reader shuffles: what takes the first is right by chance alone.

use crate::import::{ImportError, read_file};
use std::path::Path;
use vantage_dataset::Seed;

/// Largest file, bytes.
const LARGEST: u64 = 64 << 20;
/// Most poses, landmarks, and candidates of a line.
const MOST: usize = 1 << 20;
const MOST_CANDIDATES: usize = 1 << 10;
const REMEDY: &str = "correct the line or fetch the file again";

/// A measurement from a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct MhMeasurement {
    /// The line, from 1.
    pub line: usize,
    /// The pose that measures.
    pub from: usize,
    /// What is measured.
    pub target: MhTarget,
    /// Whether it may be false.
    pub is_detachable: bool,
    /// Where the alternative now stands that the file lists first, among candidates and among values.
    pub first: [usize; 2],
}

/// What a measurement is of.
#[derive(Clone, Debug, PartialEq)]
pub enum MhTarget {
    /// One of some poses, at one of some motions `[x, y, heading]`, metres and radians.
    Pose {
        /// Poses.
        candidates: Vec<usize>,
        /// Motions.
        modes: Vec<[f64; 3]>,
    },
    /// One of some landmarks, at one of some places `[x, y]`, metres.
    Landmark {
        /// Landmarks.
        candidates: Vec<usize>,
        /// Places in the frame of the pose.
        modes: Vec<[f64; 2]>,
    },
}

impl MhMeasurement {
    /// Ways to take it: each candidate with each value, and, if it may be, that it is false.
    pub fn alternatives(&self) -> usize {
        let (candidates, modes) = match &self.target {
            MhTarget::Pose { candidates, modes } => (candidates.len(), modes.len()),
            MhTarget::Landmark { candidates, modes } => (candidates.len(), modes.len()),
        };
        candidates * modes + usize::from(self.is_detachable)
    }
}

/// Reads a file, with candidates and values of each line shuffled by a seed.
///
/// # Errors
/// A file that cannot be read or is over 64 MiB, and a line that is not as the format says.
pub fn read(path: &Path, seed: Seed) -> Result<Vec<MhMeasurement>, ImportError> {
    decode(&String::from_utf8_lossy(&read_file(path, LARGEST)?), path, seed)
}

/// [`read`] of the text of a file; `path` is for messages alone.
///
/// # Errors
/// A line that is not as the format says.
pub fn decode(text: &str, path: &Path, seed: Seed) -> Result<Vec<MhMeasurement>, ImportError> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(i, line)| Line { path, number: i + 1, words: line.split_whitespace() }.measurement(seed))
        .collect()
}

struct Line<'a> {
    path: &'a Path,
    number: usize,
    words: std::str::SplitWhitespace<'a>,
}

impl Line<'_> {
    fn fault(&self, field: &str, got: impl std::fmt::Display, expected: impl Into<String>) -> ImportError {
        ImportError::invalid(self.path, format!("line {}, {field}", self.number), got, expected, REMEDY)
    }

    fn word(&mut self, field: &str, expected: &str) -> Result<&str, ImportError> {
        let missing = self.fault(field, "the end of the line", expected);
        self.words.next().ok_or(missing)
    }

    fn count(&mut self, field: &str, range: std::ops::RangeInclusive<usize>) -> Result<usize, ImportError> {
        let expected = format!("a whole number of {} to {}", range.start(), range.end());
        let word = self.word(field, &expected)?.to_owned();
        match word.parse() {
            Ok(count) if range.contains(&count) => Ok(count),
            _ => Err(self.fault(field, word, expected)),
        }
    }

    fn values<const N: usize>(&mut self, modes: usize) -> Result<Vec<[f64; N]>, ImportError> {
        let mut values = Vec::new();
        for _ in 0..modes {
            let mut value = [0.0; N];
            for number in &mut value {
                let expected = "a finite number";
                let word = self.word("value", expected)?.to_owned();
                *number = match word.parse::<f64>() {
                    Ok(parsed) if parsed.is_finite() => parsed,
                    _ => return Err(self.fault("value", word, expected)),
                };
            }
            values.push(value);
        }
        Ok(values)
    }

    fn measurement(mut self, seed: Seed) -> Result<MhMeasurement, ImportError> {
        let kinds = "ODOMETRY, EDGE2 or LANDMARK";
        let kind = self.word("kind", kinds)?.to_owned();
        let is_landmark = match kind.as_str() {
            "LANDMARK" => true,
            "ODOMETRY" | "EDGE2" => false,
            _ => return Err(self.fault("kind", kind, kinds)),
        };
        let from = self.count("pose", 0..=MOST)?;
        let count = self.count("number of candidates", 1..=MOST_CANDIDATES)?;
        let mut candidates = Vec::new();
        for _ in 0..count {
            let candidate = self.count("candidate", 0..=MOST)?;
            if candidates.contains(&candidate) {
                return Err(self.fault("candidate", candidate, "each candidate once"));
            }
            candidates.push(candidate);
        }
        if let (false, Some(_)) = (is_landmark, candidates.iter().find(|candidate| **candidate == from)) {
            return Err(self.fault("candidate", from, "another pose than that which measures"));
        }
        let is_detachable = self.count("detachable", 0..=1)? == 1;
        let modes = self.count("number of values", 1..=MOST_CANDIDATES)?;
        let mut stream = seed.stream("mh", self.number as u64);
        let first = [stream.below(count), stream.below(modes)];
        let target = if is_landmark {
            let mut modes = self.values(modes)?;
            shuffle(&mut candidates, first[0], &mut stream);
            shuffle(&mut modes, first[1], &mut stream);
            MhTarget::Landmark { candidates, modes }
        } else {
            let mut modes = self.values(modes)?;
            shuffle(&mut candidates, first[0], &mut stream);
            shuffle(&mut modes, first[1], &mut stream);
            MhTarget::Pose { candidates, modes }
        };
        if let Some(word) = self.words.next() {
            return Err(self.fault("end", word, "no more words"));
        }
        Ok(MhMeasurement { line: self.number, from, target, is_detachable, first })
    }
}

/// Shuffles so that the first comes to stand at `place`.
fn shuffle<T>(items: &mut [T], place: usize, stream: &mut vantage_dataset::Stream) {
    if let Some((_, rest)) = items.split_first_mut() {
        stream.shuffle(rest);
        items.swap(0, place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: &str = "\nODOMETRY 0 1 1 0 1 1.5 -0.25 0.125\nEDGE2 1 1 2 0 2 1 0 0 2 1 0.5\nLANDMARK 2 3 7 8 9 0 1 3.5 4\n\
                          EDGE2 2 1 0 1 1 -1 0 3\n";

    fn decoded(text: &str) -> Result<Vec<MhMeasurement>, ImportError> {
        decode(text, Path::new("sample.txt"), Seed(3))
    }

    #[test]
    fn lines_are_read_and_what_stands_first_is_known_wherever_it_goes() {
        let read = decoded(SAMPLE).unwrap();
        assert_eq!(
            read.iter().map(|m| (m.line, m.from)).collect::<Vec<_>>(),
            [(2, 0), (3, 1), (4, 2), (5, 2)]
        );
        assert_eq!(read.iter().map(MhMeasurement::alternatives).collect::<Vec<_>>(), [1, 2, 3, 2]);
        assert_eq!(read[0].target, MhTarget::Pose { candidates: vec![1], modes: vec![[1.5, -0.25, 0.125]] });
        let MhTarget::Pose { modes, .. } = &read[1].target else { panic!("a pose") };
        assert_eq!(modes[read[1].first[1]], [1.0, 0.0, 0.0]);
        let MhTarget::Landmark { candidates, modes } = &read[2].target else { panic!("a landmark") };
        assert_eq!((candidates[read[2].first[0]], modes.as_slice()), (7, &[[3.5, 4.0]][..]));
        assert!(read[3].is_detachable);
    }

    #[test]
    fn the_first_is_as_often_at_each_place_and_a_seed_says_which() {
        let text = "LANDMARK 0 4 1 2 3 4 0 1 1 1\n".repeat(4000);
        let mut counts = [[0; 4]; 4];
        for measurement in decoded(&text).unwrap() {
            let MhTarget::Landmark { candidates, .. } = measurement.target else { panic!("a landmark") };
            candidates.iter().enumerate().for_each(|(place, id)| counts[place][id - 1] += 1);
        }
        // Binomial, 4000 draws of 1/4: deviation 27.
        assert!(counts.iter().flatten().all(|count| (880..1120).contains(count)), "{counts:?}");
        assert_eq!(decoded(&text).unwrap(), decoded(&text).unwrap());
    }

    #[test]
    fn a_bad_line_is_named_with_what_is_wrong() {
        for (text, field, got) in [
            ("\nVERTEX 0 1", "line 2, kind", "VERTEX"),
            ("EDGE2", "line 1, pose", "the end of the line"),
            ("EDGE2 -1 1 2 0 1 1 1 1", "line 1, pose", "-1"),
            ("EDGE2 0 0 0 1 1 1 1", "line 1, number of candidates", "0"),
            ("LANDMARK 0 2 4 4 0 1 1 1", "line 1, candidate", "4"),
            ("EDGE2 3 1 3 0 1 1 1 1", "line 1, candidate", "3"),
            ("EDGE2 0 1 1 2 1 1 1 1", "line 1, detachable", "2"),
            ("EDGE2 0 1 1 0 99999999999 1 1 1", "line 1, number of values", "99999999999"),
            ("EDGE2 0 1 1 0 1 1 nan 1", "line 1, value", "nan"),
            ("EDGE2 0 1 1 0 2 1 1 1 2", "line 1, value", "the end of the line"),
            ("LANDMARK 0 1 1 0 1 1 1 1", "line 1, end", "1"),
        ] {
            let ImportError::Invalid(problem) = decoded(text).unwrap_err() else { panic!("{text}") };
            assert_eq!((problem.field.as_str(), problem.got.as_str()), (field, got), "{text}");
        }
    }
}
