//! Cases of MH-iSAM2.

use crate::Failure;
use crate::clock::{cpu_seconds, peak_bytes};
use nalgebra::Vector2;
use std::path::Path;
use vantage_dataset::Seed;
use vantage_formats::mh::{self, MhMeasurement, MhTarget};
use vantage_slam::association::planar::{
    Motion, MotionMeasurement, PlanarNoise, PlanarSlam, PointMeasurement, pose,
};
use vantage_slam::association::{Limits, Thresholds};

/// Of the file `victoria_park.txt` that GTSAM ships.
const VICTORIA: PlanarNoise = PlanarNoise {
    motion: [0.01, 0.002, 0.002],
    start: [1e-3; 3],
    point: [0.632_455_532; 2],
    reach: 25.0,
    false_share: 0.5,
};
/// Of GTSAM's example `Hybrid_City10000`.
const CITY: PlanarNoise = PlanarNoise {
    motion: [1.0 / 30.0, 1.0 / 30.0, 1.0 / 100.0],
    start: [1e-3; 3],
    point: [1.0; 2],
    reach: 3.0,
    false_share: 0.5,
};

/// Prints the first lines as they come out of the shuffle, each as kind, pose, candidates, whether it may be false, and values, all lists after their
/// lengths; at the end stand the places of what the file lists first.
pub fn shuffled(file: &Path, seed: Seed, lines: usize) -> Result<(), Failure> {
    for MhMeasurement { from, target, is_detachable, first, .. } in mh::read(file, seed)?.iter().take(lines) {
        let (kind, candidates, modes): (&str, &[usize], Vec<&[f64]>) = match target {
            MhTarget::Pose { candidates, modes } => {
                ("POSE", candidates, modes.iter().map(|m| &m[..]).collect())
            }
            MhTarget::Landmark { candidates, modes } => {
                ("LANDMARK", candidates, modes.iter().map(|m| &m[..]).collect())
            }
        };
        print!("{kind} {from} {}", candidates.len());
        candidates.iter().for_each(|candidate| print!(" {candidate}"));
        print!(" {} {}", u8::from(*is_detachable), modes.len());
        modes.iter().copied().flatten().for_each(|number| print!(" {number}"));
        println!(" {} {}", first[0], first[1]);
    }
    Ok(())
}

/// Prints choices, those taken wrong, and times.
pub fn victoria(file: &Path, seed: Seed) -> Result<(), Failure> {
    let measurements = mh::read(file, seed)?;
    let mut run = Run::new(VICTORIA)?;
    let mut rest = measurements.as_slice();
    while let Some(first) = rest.first() {
        let is_same =
            |m: &&MhMeasurement| m.from == first.from && matches!(m.target, MhTarget::Landmark { .. });
        let together = rest.iter().take_while(is_same).count().max(1);
        let (now, later) = rest.split_at(together);
        run.step(now, false)?;
        rest = later;
    }
    run.finish(&measurements, false, |measurement| measurement.first[0])?;
    Ok(())
}

/// Prints choices, those taken wrong, the error of the track, and times. Every loop may be false, or those alone that the file says.
pub fn city(file: &Path, truth: &Path, seed: Seed, lines: usize, loops_open: bool) -> Result<(), Failure> {
    let mut measurements = mh::read(file, seed)?;
    measurements.truncate(lines);
    let text = std::fs::read_to_string(truth)?;
    let truth: Vec<Motion> = text.lines().map(motion).collect::<Result<_, _>>()?;
    let mut run = Run::new(CITY)?;
    for measurement in &measurements {
        run.step(std::slice::from_ref(measurement), loops_open)?;
    }
    let poses = run.finish(&measurements, loops_open, |measurement| label(measurement, &truth))?;
    let squares = poses.iter().zip(&truth).map(|(a, b)| (a.x - b.x).powi(2) + (a.y - b.y).powi(2));
    println!("ate {:.4}", (squares.sum::<f64>() / poses.len() as f64).sqrt());
    Ok(())
}

fn motion(line: &str) -> Result<Motion, Failure> {
    let numbers: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y, heading] => Ok(Motion::new(x, y, heading)),
        _ => Err(format!("{line}: expected x y heading").into()),
    }
}

/// What is true: the mode that stood first, but of a loop that is off by more than 1 m, that it is false.
fn label(measurement: &MhMeasurement, truth: &[Motion]) -> usize {
    let MhTarget::Pose { candidates, modes } = &measurement.target else { return measurement.first[0] };
    let [x, y, _] = modes[measurement.first[1]];
    let ends = (truth.get(measurement.from), truth.get(candidates[0]));
    let is_false = match ends {
        (Some(from), Some(to)) if is_loop(measurement) => {
            let there = from.to(*to);
            libm::hypot(there.x - x, there.y - y) > 1.0
        }
        _ => false,
    };
    if is_false { modes.len() } else { measurement.first[1] }
}

struct Run {
    slam: PlanarSlam,
    start: f64,
    times: Vec<f64>,
    poses: usize,
}

impl Run {
    fn new(noise: PlanarNoise) -> Result<Self, Failure> {
        let slam = PlanarSlam::new(noise, Limits::default(), Thresholds::default())?;
        Ok(Self { slam, start: cpu_seconds(), times: Vec::new(), poses: 1 })
    }

    /// Measurements of one moment; with `loops_open`, each loop may be false.
    fn step(&mut self, now: &[MhMeasurement], loops_open: bool) -> Result<(), Failure> {
        let start = cpu_seconds();
        let is_open = now.iter().any(|m| alternatives(m, loops_open) > 1);
        match now {
            [MhMeasurement { target: MhTarget::Pose { candidates, modes }, from, line, .. }] => {
                let [to] = candidates[..] else { return Err(format!("line {line}: several poses").into()) };
                self.poses = self.poses.max(to + 1);
                let modes = modes.iter().map(|[x, y, heading]| Motion::new(*x, *y, *heading)).collect();
                let is_detachable = alternatives(&now[0], loops_open) > 1 && is_loop(&now[0]);
                self.slam.move_by(*line, &MotionMeasurement { from: *from, to, modes, is_detachable })?;
            }
            _ => {
                let seen = now.iter().filter_map(|m| match &m.target {
                    MhTarget::Landmark { candidates, modes } => Some(PointMeasurement {
                        candidates: candidates.clone(),
                        measured: Vector2::from(*modes.first()?),
                    }),
                    MhTarget::Pose { .. } => None,
                });
                let numbers: Vec<usize> = now.iter().map(|m| m.line).collect();
                self.slam.see(now[0].from, &numbers, &seen.collect::<Vec<_>>())?;
            }
        }
        if is_open {
            self.times.push(cpu_seconds() - start);
        }
        Ok(())
    }

    /// Prints what came of it; returns the poses.
    fn finish(
        mut self,
        measurements: &[MhMeasurement],
        loops_open: bool,
        label: impl Fn(&MhMeasurement) -> usize,
    ) -> Result<Vec<Motion>, Failure> {
        self.slam.refine()?;
        let seconds = cpu_seconds() - self.start;
        let hypotheses = self.slam.hypotheses();
        let best = hypotheses.best().ok_or("no hypothesis")?;
        let (mut choices, mut wrong, mut undecided, mut is_false) = (0, 0, 0, 0);
        for measurement in measurements.iter().filter(|m| alternatives(m, loops_open) > 1) {
            let label = label(measurement);
            choices += 1;
            is_false += usize::from(measurement.alternatives() > 1 && is_loop(measurement) && label > 0);
            if best.label(measurement.line) != Some(label) {
                wrong += 1;
                let likely = hypotheses.probability(measurement.line, label);
                undecided += usize::from(likely > 0.05);
                println!("line {} probability of the true one {likely:.6}", measurement.line);
            }
        }
        self.times.sort_by(f64::total_cmp);
        let at = |share: f64| self.times[((self.times.len() - 1) as f64 * share) as usize] * 1e3;
        println!(
            "choices {choices}\nof them false {is_false}\nwrong {wrong}\nof them undecided {undecided}\ncpu {seconds:.3}"
        );
        println!("ms p50 {:.3}\nms p95 {:.3}\nms max {:.3}", at(0.5), at(0.95), at(1.0));
        println!("hypotheses {}\nentropy {:.3}", hypotheses.all().len(), hypotheses.entropy());
        println!("{:?}\n{:?}\npeak MB {:.0}", hypotheses.work(), hypotheses.given_up(), peak_bytes()? / 1e6);
        Ok((0..self.poses).filter_map(|step| pose(best.estimator(), step)).collect())
    }
}

fn is_loop(measurement: &MhMeasurement) -> bool {
    match &measurement.target {
        MhTarget::Pose { candidates, .. } => candidates.iter().all(|to| to.abs_diff(measurement.from) != 1),
        MhTarget::Landmark { .. } => false,
    }
}

fn alternatives(measurement: &MhMeasurement, loops_open: bool) -> usize {
    let is_null_added = loops_open && is_loop(measurement) && !measurement.is_detachable;
    measurement.alternatives() + usize::from(is_null_added)
}
