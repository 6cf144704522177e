//! All compared scores, in words.

use super::comparison::{Comparison, Movement, Shift};
use crate::result::grid::{Style, draw};
use crate::result::metric::Metric;
use crate::result::statistics::Mean;
use serde::Serialize;

const HEAD: [&str; 8] =
    ["Table", "Method", "Score", "Baseline", "Now", "Paired difference", "Seeds that differ", "Verdict"];

/// All compared scores.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// By table, method, metric.
    pub comparisons: Vec<Comparison>,
}

impl Verdict {
    /// Whether nothing moved.
    pub fn passed(&self) -> bool {
        self.comparisons.iter().all(|c| c.movement == Movement::Still)
    }

    /// How many scores moved so.
    pub fn count(&self, movement: Movement) -> usize {
        self.comparisons.iter().filter(|c| c.movement == movement).count()
    }

    /// Two lines, and a table of what moved where something did, worst first.
    pub fn report(&self, style: Style) -> String {
        let of = |movement| self.count(movement);
        let line = format!(
            "of the means over seeds {} regressed, {} improved, {} moved either way, {} new, {} within tolerance\n{}\n",
            of(Movement::Regressed),
            of(Movement::Improved),
            of(Movement::Unclear),
            of(Movement::New),
            of(Movement::Still),
            self.differing()
        );
        if self.passed() {
            return line;
        }
        let mut moved: Vec<&Comparison> =
            self.comparisons.iter().filter(|c| c.movement != Movement::Still).collect();
        moved.sort_by_key(|c| match c.movement {
            Movement::Regressed => 0,
            Movement::Unclear => 1,
            Movement::Improved => 2,
            Movement::New | Movement::Still => 3,
        });
        let rows = moved.into_iter().map(|comparison| comparison.cells().to_vec()).collect();
        let remedy = if of(Movement::Regressed) + of(Movement::Unclear) > 0 {
            "Find out why before going on.\n"
        } else {
            "Better or more than the baseline: run `bench baseline SCENE --why TEXT`, and commit what it writes; in this repository say why in the CHANGELOG, too.\n"
        };
        format!("{line}\n{}\n\n{remedy}", draw(style, &HEAD.map(str::to_owned), rows))
    }

    /// How many scores of single runs are not the baseline's, and which the least.
    fn differing(&self) -> String {
        let shifts = || self.comparisons.iter().filter_map(|c| Some((c, c.shift.as_ref()?)));
        let all: usize = shifts().map(|(_, shift)| shift.mean.n).sum();
        let differing: usize = shifts().map(|(_, shift)| shift.differing).sum();
        let share = |(c, shift): &(&Comparison, &Shift)| {
            let (_, old, new) = shift.most;
            (new - old).abs() / c.tolerance()
        };
        match shifts().max_by(|a, b| share(a).total_cmp(&share(b))) {
            Some((c, shift)) if differing > 0 => {
                let (seed, old, new) = shift.most;
                let (there, now) = (c.metric.display(old), c.metric.display(new));
                let values = match there == now {
                    true => {
                        format!("{there} there and now, {:.0e} apart", c.metric.in_table(new - old).abs())
                    }
                    false => format!("{there} there, {now} now"),
                };
                format!(
                    "{differing} of {all} scores of single seeds differ from the baseline, most the {} of {} on seed {}: {values}.",
                    c.metric.heading(),
                    c.method,
                    seed.0,
                )
            }
            _ if all == 0 => "No score of a single seed is in both.".to_owned(),
            _ => format!(
                "All {all} scores of single seeds that both have are those of the baseline to the last bit."
            ),
        }
    }
}

impl Comparison {
    /// Its row, under [`HEAD`].
    pub(super) fn cells(&self) -> [String; 8] {
        let metric = self.metric;
        let mean = |mean: Option<Mean>| {
            mean.map_or_else(
                || "-".to_owned(),
                |mean| format!("{} (n={})", metric.display(mean.mean), mean.n),
            )
        };
        let shift = self.shift.as_ref();
        let verdict = match self.movement {
            Movement::Still => "still",
            Movement::Improved => "improved: baseline out of date",
            Movement::Regressed if self.fresh.is_none() => "REGRESSED: no run has it any more",
            Movement::Regressed => "REGRESSED",
            Movement::Unclear if shift.is_some_and(|shift| shift.mean.n == 1) => "MOVED, on one seed alone",
            Movement::Unclear => "MOVED, too unlike by seed to say which way",
            Movement::New => "new: not in the baseline",
        };
        [
            self.table.clone(),
            self.method.clone(),
            metric.heading(),
            mean(self.baseline),
            mean(self.fresh),
            shift.map_or_else(|| "-".to_owned(), |shift| with_interval(metric, shift.mean)),
            shift.map_or_else(
                || "-".to_owned(),
                |shift| format!("{} of {}, most on seed {}", shift.differing, shift.mean.n, shift.most.0.0),
            ),
            verdict.to_owned(),
        ]
    }
}

fn with_interval(metric: Metric, mean: Mean) -> String {
    let center = metric.display(mean.mean);
    mean.half_width.map_or_else(|| center.clone(), |half| format!("{center} +- {}", metric.display(half)))
}
