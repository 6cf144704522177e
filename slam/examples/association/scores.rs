//! Scores of one run, and their summary.

/// Of one run.
pub struct Scores {
    /// Root mean square error of the track, metres, in the frame of the first pose.
    pub ate: f64,
    pub objects: f64,
    /// Of pairs of detections taken as of one object.
    pub precision: f64,
    pub recall: f64,
    /// Most at a time.
    pub hypotheses: f64,
    /// Share of mass that was dropped.
    pub dropped: f64,
    pub cpu: f64,
}

impl Scores {
    fn f1(&self) -> f64 {
        2.0 * self.precision * self.recall / (self.precision + self.recall).max(f64::MIN_POSITIVE)
    }

    /// Means and deviations.
    pub fn summary(all: &[Scores]) -> String {
        let of = |number: fn(&Scores) -> f64, digits: usize| {
            let n = all.len() as f64;
            let mean = all.iter().map(number).sum::<f64>() / n;
            let squares: f64 = all.iter().map(|scores| (number(scores) - mean).powi(2)).sum();
            format!("{mean:.digits$} +- {:.digits$}", (squares / (n - 1.0).max(1.0)).sqrt())
        };
        [
            of(|s| s.ate, 3),
            of(|s| s.objects, 1),
            of(Scores::f1, 4),
            of(|s| s.precision, 4),
            of(|s| s.recall, 4),
            of(|s| s.hypotheses, 0),
            of(|s| s.dropped, 4),
            of(|s| s.cpu, 2),
        ]
        .join(" | ")
    }
}

/// Precision and recall of pairs of detections in one object; a false detection is in none.
pub fn pairwise(truth: &[usize], labels: &[usize], clutter: usize) -> (f64, f64) {
    let (mut both, mut told, mut real) = (0.0, 0.0, 0.0);
    for i in 0..truth.len() {
        for j in 0..i {
            let is_told = labels[i] == labels[j] && labels[i] != clutter;
            let is_real = truth[i] == truth[j] && truth[i] != clutter;
            told += f64::from(is_told);
            real += f64::from(is_real);
            both += f64::from(is_told && is_real);
        }
    }
    (both / f64::max(told, 1.0), both / f64::max(real, 1.0))
}
