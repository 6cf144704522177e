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
            let (mean, deviation) = moments(all.iter().map(number));
            format!("{mean:.digits$} +- {deviation:.digits$}")
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

/// The error less that of others on the same seeds: the mean, and two standard errors of it.
pub fn paired(all: &[Scores], others: &[Scores]) -> String {
    let (mean, deviation) = moments(all.iter().zip(others).map(|(one, other)| one.ate - other.ate));
    format!("{mean:.3} +- {:.3}", 2.0 * deviation / (all.len() as f64).sqrt())
}

/// Mean and standard deviation.
fn moments(numbers: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = numbers.clone().count() as f64;
    let mean = numbers.clone().sum::<f64>() / n;
    let squares: f64 = numbers.map(|number| (number - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0).max(1.0)).sqrt())
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
