//! The sizes of the networks: what a change of architecture edits.

use crate::latent::LatentLayout;
use crate::role::{Convention, Kind};
use crate::spec::{Loss, TrainingSpec, Traits};
use serde::{Deserialize, Serialize};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};

/// Numbers of the conditioning that do not turn with the azimuth: sine of the elevation, cosine and sine of
/// the roll, log distance.
pub const UPRIGHT: usize = CONDITIONING - 2 * HARMONICS;

/// The networks of a model, by their sizes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Architecture {
    /// What the networks are told of viewpoints, if anything.
    #[serde(default = "viewpoints")]
    pub convention: Option<Convention>,
    /// Output channels of the trunk's convolutions: 4x4, stride 2, padding 1, each followed by a ReLU.
    pub trunk: Vec<usize>,
    /// Numbers of the trunk's features `t(z)`: a linear layer and a ReLU on the last convolution.
    pub features: usize,
    /// `d_m`, numbers of the reduced measurement `m(z)` of IV-C: a linear layer on `t(z)`, then whitening.
    pub measurement: usize,
    /// Hidden layers of the encoder `q(e | z, x_rel)`, from `t(z)`, the crop's principal components and, where the
    /// convention is that of viewpoints, the upright conditioning, with ReLUs.
    pub encoder: Vec<usize>,
    /// The latent `e`.
    pub latent: LatentLayout,
    /// Whether the latent stands for a discrete class (Eq. 8): what the decoder sees of it is
    /// `softmax(CLASS_SHARPNESS e)`, and each view's factor is the logarithm of the class's likelihood.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub latent_is_class: bool,
    /// Hidden layers of the decoder `p(z | e, x_rel)`, from the latent in the camera's yaw frame and the
    /// conditioning, with SiLUs: the estimator's second-order steps need a prediction that is smooth in the latent.
    pub decoder: Vec<usize>,
    /// Whether the decoder is fed the absolute azimuth beside the latent it has turned. If not, a turn of the
    /// viewpoint and of the latent cancel exactly.
    pub decoder_sees_azimuth: bool,
    /// Whether the decoder is fed the reduced measurement of the first view (Eq. 15), zeros where there is none.
    #[serde(default)]
    pub decoder_sees_source: bool,
    /// Principal components of a crop that the encoder sees and the image head predicts.
    pub components: usize,
}

impl Architecture {
    /// The networks that a training asks for; `None` where its latent is too small.
    pub fn new(spec: &TrainingSpec) -> Option<Self> {
        let Traits { convention, loss, .. } = spec.traits();
        let turns = convention.is_some_and(Convention::turns);
        let latent = LatentLayout::new(spec.latent_dim, spec.turning_pairs())?;
        Some(Self {
            convention,
            trunk: vec![24, 48, 96],
            features: spec.features_dim,
            measurement: spec.measurement_dim,
            encoder: vec![256, 256],
            latent,
            latent_is_class: loss == Loss::Class,
            decoder: vec![spec.decoder_width; 2],
            decoder_sees_azimuth: convention == Some(Convention::AzimuthHarmonics)
                || (turns && latent.pairs() == 0),
            decoder_sees_source: spec.reads_odometry() && spec.predictive.source > 0.0,
            components: 96,
        })
    }

    /// What such a model is.
    pub fn kind(&self) -> Kind {
        match self.convention {
            Some(Convention::AzimuthHarmonics) => Kind::ViewpointDependent,
            Some(Convention::ObjectCentredChange | Convention::CameraMotion) => Kind::ViewpointPredictive,
            None => Kind::Embedding,
        }
    }

    /// Numbers of the conditioning.
    pub fn conditioning(&self) -> usize {
        self.convention.map_or(0, Convention::numbers)
    }

    /// Numbers of the conditioning that the encoder sees.
    pub fn encoder_conditioning(&self) -> usize {
        if self.kind() == Kind::ViewpointDependent { UPRIGHT } else { 0 }
    }

    /// Numbers at the end of the conditioning that the decoder sees beside the latent.
    pub fn decoder_conditioning(&self) -> usize {
        let turns = self.convention.is_some_and(Convention::turns);
        self.conditioning() - if turns && !self.decoder_sees_azimuth { 2 * HARMONICS } else { 0 }
    }

    /// Numbers the decoder sees.
    pub fn decoder_inputs(&self) -> usize {
        let source = if self.decoder_sees_source { self.measurement } else { 0 };
        self.latent.dimension() + self.decoder_conditioning() + source
    }
}

fn viewpoints() -> Option<Convention> {
    Some(Convention::AzimuthHarmonics)
}
