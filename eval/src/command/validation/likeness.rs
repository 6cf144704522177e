//! What crops tell of pairs of tracklets, of one object or of two: what fits the exponents of likenesses, and how far one may trust them.

use super::Trial;
use crate::scene_file::associator::Told;
use crate::scene_file::row::Reader;
use rayon::prelude::*;
use vantage_dataset::InstanceId;
use vantage_learn::readout::{ClassReadout, EmbeddingReadout};
use vantage_model::AnswerError;
use vantage_slam::associator::{
    Classed, ClassedSettings, Embedded, EmbeddedSettings, Encoded, EncodedSettings, Heading, Likeness,
};
use vantage_slam::problem::Problem;
use vantage_slam::sighting::Sighting;
use vantage_slam::variable::{Key, Value, Values};
use vantage_slam::{Estimate, GeometrySettings};

/// Exponents of latents and sides that are tried.
const EXPONENTS: [[f64; 2]; 7] =
    [[0.05, 0.2], [0.1, 0.2], [0.2, 0.2], [0.4, 0.2], [0.1, 0.0], [0.1, 0.1], [0.1, 0.4]];
/// Exponents of classes that are tried.
const CLASS_EXPONENTS: [f64; 4] = [0.1, 0.2, 0.4, 1.0];
/// Exponents of an embedding that are tried.
const EMBEDDING_EXPONENTS: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];
/// Bounds of the probabilities that are told together.
const BOUNDS: [f64; 7] = [0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0];

/// A tracklet where an estimate has its object.
struct Shown {
    trial: usize,
    instance: InstanceId,
    family: String,
    sightings: Vec<Sighting>,
    values: Values,
}

/// Log-ratios of pairs of tracklets.
struct Pairs {
    /// Of one object.
    same: Vec<f64>,
    /// Of two objects of one family.
    kin: Vec<f64>,
    /// Of objects of two families.
    other: Vec<f64>,
}

/// Rows of log losses by exponents, and of how often pairs are of one object by what is promised of them.
pub fn likeness_rows(
    trials: &[Trial],
    estimates: &[(Estimate, f64)],
    geometry: &GeometrySettings,
    reader: &Reader<'_>,
    embedding: Option<EmbeddingReadout<'_>>,
) -> Result<[Vec<Vec<String>>; 2], AnswerError> {
    let shown: Vec<Shown> = (trials.iter().zip(estimates).enumerate())
        .flat_map(|(number, (trial, (estimate, _)))| tracklets(number, trial, estimate))
        .collect();
    let (mut losses, mut kept) = (Vec::new(), None);
    let default = EncodedSettings::default();
    for [latent_exponent, side_exponent] in EXPONENTS {
        let encoded =
            Encoded::new(reader.model, EncodedSettings { latent_exponent, side_exponent, ..default });
        let pairs = Pairs::of(&shown, trials, geometry, &encoded)?;
        losses.push(pairs.losses(format!("latents {latent_exponent}, sides {side_exponent}")));
        if [latent_exponent, side_exponent] == [default.latent_exponent, default.side_exponent] {
            kept = Some(pairs);
        }
    }
    for exponent in CLASS_EXPONENTS {
        let Some(readouts) = reader.readouts else { break };
        let classes = ClassReadout::new(reader.model, &readouts.classes);
        let classed = Classed::new(classes, ClassedSettings { exponent, ..ClassedSettings::default() });
        losses.push(Pairs::of(&shown, trials, geometry, &classed)?.losses(format!("class {exponent}")));
    }
    for exponent in EMBEDDING_EXPONENTS {
        let Some(embedding) = embedding else { break };
        let embedded = Embedded::new(embedding, EmbeddedSettings { exponent, ..EmbeddedSettings::default() });
        let pairs = Pairs::of(&shown, trials, geometry, &embedded)?;
        losses.push(pairs.losses(format!("embedding {exponent}")));
    }
    Ok([losses, kept.map_or_else(Vec::new, |pairs| pairs.reliability())])
}

/// The tracklets of objects that an estimate places.
fn tracklets(number: usize, trial: &Trial, estimate: &Estimate) -> Vec<Shown> {
    let Trial { observations, truth } = trial;
    let (tracklets, order) = Told::Tracklets.of(observations);
    let mut sightings: Vec<Vec<Sighting>> = vec![Vec::new(); tracklets.count()];
    let mut tracks = vec![None; tracklets.count()];
    for (detection, &given) in tracklets.observations().detections.iter().zip(&order) {
        let original = &observations.detections[given];
        if truth.shown(given, original).is_some() {
            tracks[detection.track] = Some(original.track);
            sightings[detection.track].extend(Sighting::new(&observations.camera, given, original));
        }
    }
    let shown = |(track, sightings): (Option<usize>, Vec<Sighting>)| {
        let track = track?;
        let object = truth.objects.get(track)?;
        let placed = estimate.objects.get(track)?.as_ref()?;
        let mut values = Values::default();
        values.insert(Key::Object(0), Value::Point(placed.position));
        for sighting in &sightings {
            values.insert(Key::Robot(sighting.step), Value::Pose(estimate.world_from_robot[sighting.step]));
        }
        let (instance, family) = (object.instance, object.family.clone());
        (sightings.len() > 1).then_some(Shown { trial: number, instance, family, sightings, values })
    };
    tracks.into_iter().zip(sightings).filter_map(shown).collect()
}

impl Pairs {
    fn of<L: Likeness>(
        shown: &[Shown],
        trials: &[Trial],
        geometry: &GeometrySettings,
        likeness: &L,
    ) -> Result<Self, AnswerError>
    where
        L::Reading: Send,
    {
        let read = |shown: &Shown| {
            let problem = Problem { observations: &trials[shown.trial].observations, settings: geometry };
            likeness.read(&problem, &shown.values, &shown.sightings)
        };
        let readings: Vec<L::Reading> = shown.par_iter().map(read).collect::<Result<_, _>>()?;
        let mut pairs = Self { same: Vec::new(), kin: Vec::new(), other: Vec::new() };
        let heading = Heading::default();
        for (i, (a, first)) in shown.iter().zip(&readings).enumerate() {
            for (b, second) in shown[..i].iter().zip(&readings) {
                let ratio = likeness.log_ratio_of(&[(first, heading), (second, heading)]);
                let of_pair = match (a.trial == b.trial && a.instance == b.instance, a.family == b.family) {
                    (true, _) => &mut pairs.same,
                    (_, true) => &mut pairs.kin,
                    _ => &mut pairs.other,
                };
                of_pair.push(ratio);
            }
        }
        Ok(pairs)
    }

    /// Mean log losses at even odds, nats.
    fn losses(&self, name: String) -> Vec<String> {
        let loss = |ratios: &[f64], sign: f64| {
            let sum: f64 = ratios.iter().map(|ratio| softplus(sign * ratio)).sum();
            format!("{:.3}", sum / ratios.len() as f64)
        };
        vec![name, loss(&self.same, -1.0), loss(&self.kin, 1.0), loss(&self.other, 1.0)]
    }

    /// By what is promised at the odds that pairs have: how many there are, and which share of them is of one object.
    fn reliability(&self) -> Vec<Vec<String>> {
        let different = || self.kin.iter().chain(&self.other);
        let log_odds = libm::log(self.same.len() as f64 / different().count() as f64);
        let promised = |ratio: &f64| 1.0 / (1.0 + libm::exp(-(ratio + log_odds)));
        let all: Vec<(f64, bool)> = (self.same.iter().map(|ratio| (promised(ratio), true)))
            .chain(different().map(|ratio| (promised(ratio), false)))
            .collect();
        let row = |bounds: &[f64]| {
            let inside: Vec<&(f64, bool)> =
                all.iter().filter(|(p, _)| *p >= bounds[0] && (*p < bounds[1] || bounds[1] == 1.0)).collect();
            let count = inside.len() as f64;
            let mean = inside.iter().map(|(p, _)| p).sum::<f64>() / count;
            let share = inside.iter().filter(|(_, same)| *same).count() as f64 / count;
            let told = |share: f64| if share.is_nan() { "-".to_owned() } else { format!("{share:.3}") };
            let numbers = [mean, share].map(told);
            let range = format!("{} to {}", bounds[0], bounds[1]);
            [vec![range, inside.len().to_string()], numbers.to_vec()].concat()
        };
        BOUNDS.windows(2).map(row).collect()
    }
}

/// `log(1 + exp x)`.
fn softplus(x: f64) -> f64 {
    x.max(0.0) + libm::log1p(libm::exp(-x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_are_those_of_even_odds_and_promises_of_the_odds_there_are() {
        let pairs = Pairs { same: vec![0.0, 20.0], kin: vec![0.0], other: vec![-20.0, -30.0, -40.0] };
        let half = format!("{:.3}", 2.0_f64.ln() / 2.0);
        assert_eq!(pairs.losses("x".into()), ["x", &half, "0.693", "0.000"]);
        let rows = pairs.reliability();
        // Two of six pairs are of one object: of a ratio of 0 it is one in three.
        assert_eq!(rows[2], ["0.2 to 0.5", "2", "0.333", "0.500"]);
        assert_eq!(rows[5], ["0.95 to 1", "1", "1.000", "1.000"]);
        assert_eq!(rows[1], ["0.05 to 0.2", "0", "-", "-"]);
    }
}
