//! Latents turned by the azimuth of a viewpoint, pair by pair.

use crate::latent::LatentLayout;
use burn::tensor::Tensor;
use vantage_dataset::viewpoint::HARMONICS;

/// By how much each pair of a latent turns: cosine and sine of `m` times an angle, `[views, pairs]`; nothing for a latent
/// without pairs.
#[derive(Clone, Debug)]
pub(crate) struct Turn(Option<[Tensor<2>; 2]>);

impl Turn {
    /// From conditionings `[views, 2 HARMONICS..]` that begin with the harmonics.
    pub(crate) fn new(layout: LatentLayout, conditioning: &Tensor<2>) -> Self {
        if layout.pairs() == 0 {
            return Self(None);
        }
        let spread = |offset: usize| {
            let of_harmonic = |m: usize| {
                let column = conditioning.clone().narrow(1, 2 * m + offset, 1);
                column.repeat_dim(1, layout.pairs_per_harmonic)
            };
            Tensor::cat((0..HARMONICS).map(of_harmonic).collect(), 1)
        };
        Self(Some([spread(0), spread(1)]))
    }

    /// By the negative angle.
    pub(crate) fn back(&self) -> Self {
        Self(self.0.clone().map(|[cos, sin]| [cos, sin.neg()]))
    }
}

/// A latent with each pair turned: into the object's frame by the azimuth, back by its negative.
pub(crate) fn turned(layout: LatentLayout, latents: Tensor<2>, turn: &Turn) -> Tensor<2> {
    let Turn(Some([cos, sin])) = turn else { return latents };
    let pairs = layout.pairs();
    let invariant = latents.clone().narrow(1, 0, layout.invariant);
    let first = latents.clone().narrow(1, layout.invariant, pairs);
    let second = latents.narrow(1, layout.invariant + pairs, pairs);
    let x = cos.clone() * first.clone() - sin.clone() * second.clone();
    let y = sin.clone() * first + cos.clone() * second;
    Tensor::cat(vec![invariant, x, y], 1)
}

/// Numbers for each of `[invariant | pairs]`, given to both of each pair: `[n, latent]`.
pub(crate) fn for_each_number(layout: LatentLayout, free: Tensor<2>) -> Tensor<2> {
    if layout.pairs() == 0 {
        return free;
    }
    let invariant = free.clone().narrow(1, 0, layout.invariant);
    let pairs = free.narrow(1, layout.invariant, layout.pairs());
    Tensor::cat(vec![invariant, pairs.clone(), pairs], 1)
}
