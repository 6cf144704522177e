//! The sizes of the networks: what a change of architecture edits.

use crate::latent::LatentLayout;
use serde::{Deserialize, Serialize};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};

/// Numbers of the conditioning that do not turn with the azimuth: sine of the elevation, cosine and sine of
/// the roll, log distance.
pub const UPRIGHT: usize = CONDITIONING - 2 * HARMONICS;

/// What a pixel in `[0, 1]` is centred by before the trunk.
pub const PIXEL_CENTER: f32 = 0.5;
/// Range of the logarithm of a latent's variance in one view's factor.
pub const LOG_VARIANCE: (f32, f32) = (-8.0, 4.0);

/// The networks of the viewpoint-dependent model, by their sizes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Architecture {
    /// Output channels of the trunk's convolutions: 4x4, stride 2, padding 1, each followed by a ReLU.
    pub trunk: Vec<usize>,
    /// Numbers of the trunk's features `t(z)`: a linear layer and a ReLU on the last convolution.
    pub features: usize,
    /// `d_m`, numbers of the reduced measurement `m(z)` of IV-C: a linear layer on `t(z)`, then whitening.
    pub measurement: usize,
    /// Hidden layers of the encoder `q(e | z, x_rel)`, from `t(z)`, the crop's principal components and the upright
    /// conditioning, with ReLUs.
    pub encoder: Vec<usize>,
    /// The latent `e`.
    pub latent: LatentLayout,
    /// Hidden layers of the decoder `p(z | e, x_rel)`, from the latent in the camera's yaw frame and the
    /// conditioning, with SiLUs: the estimator's second-order steps need a prediction that is smooth in the latent.
    pub decoder: Vec<usize>,
    /// Whether the decoder is fed the absolute azimuth beside the latent it has turned. If not, a turn of the
    /// viewpoint and of the latent cancel exactly.
    pub decoder_sees_azimuth: bool,
    /// Principal components of a crop that the encoder sees and the image head predicts.
    pub components: usize,
}

impl Architecture {
    /// The default networks around a latent and a reduced measurement of the given sizes.
    pub fn new(latent: LatentLayout, measurement: usize) -> Self {
        Self {
            trunk: vec![24, 48, 96],
            features: 256,
            measurement,
            encoder: vec![256, 256],
            latent,
            decoder: vec![256, 256],
            decoder_sees_azimuth: true,
            components: 96,
        }
    }

    /// Numbers the decoder sees beside the latent.
    pub fn decoder_conditioning(&self) -> usize {
        if self.decoder_sees_azimuth { CONDITIONING } else { UPRIGHT }
    }
}
