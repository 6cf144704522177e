//! Changes of azimuth between views, told from features that turn with the camera.
//!
//! What a view is told by is a vector `c` whose pairs turn by `m azimuth`, each by its harmonic `m`, as those of a latent do.
//! Turned back by its azimuth it is the same for all views of a session; a change of azimuth is as likely as the vectors of two
//! views agree after it. They have unit length: were they free to vanish, all changes would be equally likely, and stay so,
//! since a gradient by one of them is proportional to the other.

use super::{BINS, soft_labels};
use crate::architecture::UPRIGHT;
use crate::latent::LatentLayout;
use crate::train::network::exponential::log_softmax;
use crate::train::network::rows::table;
use crate::train::network::turn::{Turn, turned};
use burn::tensor::{Device, Tensor};
use std::f64::consts::PI;
use vantage_dataset::viewpoint::HARMONICS;

/// What the head answers of a view: the upright part of its viewpoint, then `c`.
pub(crate) const LAYOUT: LatentLayout = LatentLayout { invariant: UPRIGHT, pairs_per_harmonic: 12 };
/// What agreements are divided by.
const TEMPERATURE: f64 = 0.1;
/// Least square of a length.
const LEAST_SQUARE: f64 = 1e-12;

/// Cross-entropy of the change of azimuth between any two views of a session, over bins: of answers of [`LAYOUT`],
/// `together` of each session one after the other; `views` are their indices.
pub(crate) fn loss(
    answers: Tensor<2>,
    azimuths: impl ExactSizeIterator<Item = f64>,
    views: &[usize],
    together: usize,
    device: &Device,
) -> Tensor<1> {
    let rows = azimuths.len();
    let (sessions, squared) = (rows / together, together * together);
    let harmonics = azimuths.flat_map(|azimuth| {
        (1..=HARMONICS).flat_map(move |m| {
            let (sin, cos) = libm::sincos(m as f64 * azimuth);
            [cos as f32, sin as f32]
        })
    });
    let turn = Turn::new(LAYOUT, &table(harmonics.collect(), rows, device));
    let in_session = turned(LAYOUT, answers, &turn).narrow(1, UPRIGHT, 2 * LAYOUT.pairs());
    let length = (in_session.clone().square().sum_dim(1) + LEAST_SQUARE).sqrt();
    let parts = (in_session / length).reshape([sessions, together, 2 * LAYOUT.pairs()]);

    // Of two views, `sum over pairs of c conj(c')`, by harmonic.
    let (mut real, mut imaginary) = (Vec::new(), Vec::new());
    for m in 0..HARMONICS {
        let of = |offset: usize| {
            let start = offset + m * LAYOUT.pairs_per_harmonic;
            parts.clone().narrow(2, start, LAYOUT.pairs_per_harmonic)
        };
        let (x, y) = (of(0), of(LAYOUT.pairs()));
        let (x_turned, y_turned) = (x.clone().transpose(), y.clone().transpose());
        let column = |tensor: Tensor<3>| tensor.reshape([sessions * squared, 1]);
        real.push(column(x.clone().matmul(x_turned.clone()) + y.clone().matmul(y_turned.clone())));
        imaginary.push(column(y.matmul(x_turned) - x.matmul(y_turned)));
    }
    let wave = |of: fn(f64) -> f64| {
        let value = |m: usize, bin: usize| of((m + 1) as f64 * 2.0 * PI * bin as f64 / BINS as f64) as f32;
        let waves = (0..HARMONICS).flat_map(|m| (0..BINS).map(move |bin| value(m, bin)));
        table(waves.collect(), HARMONICS, device)
    };
    let agreement =
        Tensor::cat(real, 1).matmul(wave(libm::cos)) + Tensor::cat(imaginary, 1).matmul(wave(libm::sin));

    // In the session's frame no change is the right one; the bins of changes are centred where those of angles begin.
    let right = soft_labels([PI / BINS as f64].into_iter(), device);
    let cross_entropy = (log_softmax(agreement / TEMPERATURE) * right).sum_dim(1).neg();
    // A session with fewer views than `together` has some of them more than once.
    let others = views.chunks_exact(together).flat_map(|session| {
        session.iter().flat_map(|a| session.iter().map(move |b| f32::from(u8::from(a != b))))
    });
    let others = table(others.collect(), sessions * squared, device);
    (cross_entropy * others.clone()).sum() / others.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::run::scalar;

    /// Answers whose pairs are those of one vector, turned into cameras at the given azimuths.
    fn answers(azimuths: &[f64]) -> Vec<f32> {
        let at = |azimuth: &f64| {
            let mut row = vec![0.3; UPRIGHT];
            let angle = |pair: usize| 0.7 * pair as f64 - LAYOUT.harmonic(pair) as f64 * azimuth;
            row.extend((0..LAYOUT.pairs()).map(|pair| libm::cos(angle(pair)) as f32));
            row.extend((0..LAYOUT.pairs()).map(|pair| libm::sin(angle(pair)) as f32));
            row
        };
        azimuths.iter().flat_map(at).collect()
    }

    fn cost(seen: &[f64], told: &[f64]) -> f64 {
        let device = Device::flex();
        let views: Vec<usize> = (0..seen.len()).collect();
        scalar(&loss(table(answers(seen), seen.len(), &device), told.iter().copied(), &views, 3, &device))
    }

    #[test]
    fn views_that_agree_after_their_change_cost_least_whatever_the_session_s_heading() {
        let azimuths = [0.2, 1.9, -2.6, 0.7, 0.1, 3.0];
        let right = cost(&azimuths, &azimuths);
        assert!(right < 0.8 * (BINS as f64).ln(), "{right}");
        let headed = azimuths.map(|azimuth| azimuth + 1.3);
        assert!((cost(&azimuths, &headed) - right).abs() < 1e-4);
        let mirrored = azimuths.map(|azimuth| -azimuth);
        assert!(cost(&azimuths, &mirrored) > right + 1.0);
    }
}
