//! The rows of the table of trajectories: the estimators that a scene may name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use vantage_learn::gaussian_process::GaussianProcess;
use vantage_learn::readout::{AzimuthReadout, ClassReadout, Readouts};
use vantage_model::{LastLayer, ObservationModel, PairModel};
use vantage_slam::{
    AzimuthHead, Checked, DecoderAdapted, DecoderChecked, DecoderTaught, DiscreteClass, DomainAdapted,
    Estimator, Geometric, Learner, OdometryOnly, OrientationSettings, PROCESSES, ProcessRefitted, Refitted,
    SeenView, Semantic, SemanticSettings, Settings, Uninformative, ViewpointPairs,
};

/// How much a crop tells the Gaussian process, by what it says itself: the best on validation objects of `sparse_loop`.
const GAUSSIAN_PROCESS_INFORMATION: f64 = 0.25;
/// Thinning of the rivals' views, radians, under which their information was chosen: they have no discrepancy of their own.
const RIVAL_SEPARATION: f64 = 0.1;

/// Settings of a rival whose crops count for this share.
fn rival(settings: &Settings, information: f64) -> Settings {
    let semantics = SemanticSettings {
        information_scale: settings.semantics.information_scale * information,
        minimum_view_separation: RIVAL_SEPARATION,
        azimuth_discrepancy: None,
        unknown_margin: None,
        ..settings.semantics
    };
    Settings { semantics, ..*settings }
}

/// Settings under which the noise of every view is independent and known: each counts, and counts in full.
pub fn of_an_ideal_sensor(settings: &Settings) -> Settings {
    let semantics = SemanticSettings {
        information_scale: 1.0,
        minimum_view_separation: 0.0,
        azimuth_discrepancy: None,
        unknown_margin: None,
        ..settings.semantics
    };
    Settings { semantics, ..*settings }
}

/// What rows read crops by.
#[derive(Clone, Copy)]
pub struct Reader<'m> {
    /// The model.
    pub model: &'m dyn ObservationModel,
    /// The same as one of pairs of views, which is there where a row [reads them](Row::reads_pairs).
    pub pairs: Option<&'m dyn PairModel>,
    /// Its read-outs, which are there where a row [reads one](Row::reads_out).
    pub readouts: Option<&'m Readouts>,
    /// An ideal sensor in place of a model, which is there where a row [reads it](Row::reads_truth).
    pub ideal: Option<&'m dyn ObservationModel>,
    /// The model with a process per object beside it, which is there where a row [has one](Row::has_process).
    pub process: Option<&'m dyn ObservationModel>,
    /// The model with each of the processes beside it that a row [tries](Row::tries_processes), which are there where one does.
    pub processes: Option<[&'m dyn ObservationModel; PROCESSES]>,
    /// The last layer of its decoder, which is there where a row [learns it](Row::learns_layer).
    pub layer: Option<&'m dyn LastLayer>,
    /// What is seen in the episode's crops by the truth, which is there where a row [is taught by it](Row::is_taught).
    pub seen: Option<&'m [SeenView]>,
}

impl<'m> Reader<'m> {
    fn readouts(&self) -> &'m Readouts {
        self.readouts.expect("they are fitted where a row reads one")
    }

    fn pairs(&self) -> &'m dyn PairModel {
        self.pairs.expect("other models are refused where a row reads pairs")
    }

    fn process(&self) -> &'m dyn ObservationModel {
        self.process.expect("it is fitted where a row has one")
    }

    fn processes(&self) -> [&'m dyn ObservationModel; PROCESSES] {
        self.processes.expect("they are made where a row tries them")
    }

    fn seen(&self) -> &'m [SeenView] {
        self.seen.expect("it is read where a row is taught by the truth")
    }

    fn layer(&self) -> &'m dyn LastLayer {
        self.layer.expect("other models are refused where a row learns it")
    }

    fn ideal(&self) -> &'m dyn ObservationModel {
        self.ideal.expect("it is made where a row reads the truth")
    }
}

/// Declares [`Row`]: what each is, and what makes its estimator of the settings and a reader.
macro_rules! rows {
    ($($(#[$what:meta])* $row:ident => $make:expr;)*) => {
        /// A row of the score table: which factors the estimator uses.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum Row {
            $($(#[$what])* $row,)*
        }

        impl Row {
            /// All rows, in the order of the table.
            pub const ALL: &[Row] = &[$(Row::$row),*];

            /// What runs.
            pub fn estimator<'m>(
                self,
                settings: &Settings,
                reader: Reader<'m>,
            ) -> Box<dyn Estimator + 'm> {
                match self {
                    $(Row::$row => Box::new($make(settings, reader)),)*
                }
            }
        }
    };
}

rows! {
    /// Dead reckoning.
    Odometry => |settings, _| OdometryOnly::new(settings);
    /// Odometry and bearings to object centres.
    Geometric => |settings, _| Geometric::new(settings);
    /// Geometric, with the viewpoint-dependent semantic factors of III-A.
    ViewpointDependent => |settings, reader: Reader<'m>| Semantic::new(settings, reader.model);
    /// The variables and factors of `viewpoint_dependent`, its semantic factors with zero information: a
    /// control that must equal `geometric`.
    Uninformative => |settings, reader: Reader<'m>| Uninformative::new(settings, reader.model);
    /// Geometric, with an untrained Gaussian process per object over the azimuth in place of a model; runs where a scene
    /// names it.
    GaussianProcess => |settings: &Settings, _| {
        // Its prior is the same for every yaw: the first one tried is the object's frame, and is held as well as its tilt.
        let orientation = OrientationSettings { yaw_candidates: 1, ..settings.orientation };
        let rival = rival(settings, GAUSSIAN_PROCESS_INFORMATION);
        let semantics = SemanticSettings { yaw_sigma: rival.semantics.tilt_sigma, ..rival.semantics };
        Semantic::new(&Settings { orientation, semantics, ..rival }, GaussianProcess::fitted())
    };
    /// Geometric, with the azimuth that a read-out of the model's measurement tells of each crop, without a latent; runs where a
    /// scene names it.
    AzimuthHead => |settings, reader: Reader<'m>| {
        AzimuthHead::new(&rival(settings, 1.0), AzimuthReadout::new(reader.model, &reader.readouts().azimuth))
    };
    /// Geometric, with the semantic factors of Eq. 8: a discrete class in place of the latent; runs where a scene names it.
    DiscreteClass => |settings, reader: Reader<'m>| {
        DiscreteClass::new(&rival(settings, 1.0), ClassReadout::new(reader.model, &reader.readouts().classes))
    };
    /// Geometric, with the factors of two views of Eq. 15, by a viewpoint-predictive model; runs where a scene names it.
    ViewpointPairs => |settings, reader: Reader<'m>| ViewpointPairs::new(settings, reader.pairs());
    /// `viewpoint_dependent`, the noise of crops and the discrepancy refitted on the episode; runs where a scene names it.
    NoiseRefitted => |settings, reader: Reader<'m>| Refitted::new(settings, reader.model);
    /// `viewpoint_dependent`, with a Gaussian process per object over the azimuth that corrects the model's predictions by the object's own
    /// views, in place of the discrepancy; runs where a scene names it.
    ObjectProcess => |settings: &Settings, reader: Reader<'m>| {
        let semantics = SemanticSettings { azimuth_discrepancy: None, ..settings.semantics };
        Semantic::new(&Settings { semantics, ..*settings }, reader.process())
    };
    /// `noise_refitted`, with a process per object beside the model, fitted on nothing before: its size is refitted on the episode, too; runs
    /// where a scene names it.
    ProcessRefitted => |settings: &Settings, reader: Reader<'m>| {
        ProcessRefitted::new(settings, reader.model, reader.processes())
    };
    /// `viewpoint_dependent`, with an affine change of the model's predictions that is learnt on the episode (Eq. 25-26); runs where a scene
    /// names it.
    DomainAdapted => |settings, reader: Reader<'m>| DomainAdapted::new(settings, reader.model);
    /// `viewpoint_dependent`, the last layer of the model's decoder learnt on the episode by expectation maximization (Eq. 25-26); runs where
    /// a scene names it.
    DecoderAdapted => |settings, reader: Reader<'m>| DecoderAdapted::new(settings, reader.layer());
    /// `decoder_adapted`, each round of it kept only where it predicts crops that it did not see; runs where a scene names it.
    DecoderChecked => |settings, reader: Reader<'m>| DecoderChecked::new(settings, reader.layer());
    /// A control: `decoder_adapted`, taught after each drive of a life by the truth, and not on it. On a first drive it is the model as it was
    /// trained; runs where a scene names it.
    DecoderTaught => |settings, reader: Reader<'m>| DecoderTaught::new(settings, reader.layer(), reader.seen());
    /// `viewpoint_dependent`, with the noise refitted and a domain learnt on the episode, each kept only where it predicts crops that it did
    /// not see; runs where a scene names it.
    LearningChecked => |settings: &Settings, reader: Reader<'m>| Checked::new(settings, reader.model, &settings.domain);
    /// Geometric, with an ideal sensor of azimuths in place of a model: what could be had at best. It reads the truth with noise of two
    /// degrees; runs where a scene names it.
    IdealAzimuth => |settings, reader: Reader<'m>| Semantic::new(&of_an_ideal_sensor(settings), reader.ideal());
}

impl Row {
    /// The rows of a scene that names none.
    pub const DEFAULT: &[Row] = &[Row::Odometry, Row::Geometric, Row::ViewpointDependent, Row::Uninformative];

    /// Whether the frames of its objects are its own, so that neither orientations nor latents are to be scored.
    pub fn frames_are_free(self) -> bool {
        self == Row::GaussianProcess
    }

    /// Whether it reads a model's measurement by a read-out that is fitted on labelled views.
    pub fn reads_out(self) -> bool {
        matches!(self, Row::AzimuthHead | Row::DiscreteClass)
    }

    /// Whether it corrects a model by a process per object that is fitted on views.
    pub fn has_process(self) -> bool {
        self == Row::ObjectProcess
    }

    /// Whether it finds on its drives how large a process per object is that corrects a model.
    pub fn tries_processes(self) -> bool {
        self == Row::ProcessRefitted
    }

    /// Whether it learns the last layer of a model's decoder.
    pub fn learns_layer(self) -> bool {
        matches!(self, Row::DecoderAdapted | Row::DecoderChecked | Row::DecoderTaught)
    }

    /// Whether it learns that layer in rounds.
    pub fn learns_in_rounds(self) -> bool {
        matches!(self, Row::DecoderAdapted | Row::DecoderChecked)
    }

    /// Whether it is taught by the truth after a drive.
    pub fn is_taught(self) -> bool {
        self == Row::DecoderTaught
    }

    /// Whether it reads crops by a model, and nothing else that would have to be made first.
    pub fn is_by_model_alone(self) -> bool {
        !(self.reads_truth() || self.has_process() || self.tries_processes() || self.learns_layer())
    }

    /// Whether it goes on from what drives before taught.
    pub fn learns(self) -> bool {
        matches!(
            self,
            Row::NoiseRefitted
                | Row::ProcessRefitted
                | Row::DomainAdapted
                | Row::DecoderAdapted
                | Row::DecoderChecked
                | Row::DecoderTaught
        )
    }

    /// What goes on from what drives before taught; `None` of a row that learns nothing, or keeps nothing of it.
    pub fn learner<'m>(self, settings: &Settings, reader: Reader<'m>) -> Option<Box<dyn Learner + 'm>> {
        Some(match self {
            Row::NoiseRefitted => Box::new(Refitted::new(settings, reader.model)),
            Row::ProcessRefitted => {
                Box::new(ProcessRefitted::new(settings, reader.model, reader.processes()))
            }
            Row::DomainAdapted => Box::new(DomainAdapted::new(settings, reader.model)),
            Row::DecoderAdapted => Box::new(DecoderAdapted::new(settings, reader.layer())),
            Row::DecoderChecked => Box::new(DecoderChecked::new(settings, reader.layer())),
            Row::DecoderTaught => Box::new(DecoderTaught::new(settings, reader.layer(), reader.seen())),
            _ => return None,
        })
    }

    /// Whether it reads views in pairs, as viewpoint-predictive models alone tell them.
    pub fn reads_pairs(self) -> bool {
        self == Row::ViewpointPairs
    }

    /// Whether it reads an ideal sensor, which is made of the truth.
    pub fn reads_truth(self) -> bool {
        self == Row::IdealAzimuth
    }

    /// Whether there is one for each model, by whose name it is printed.
    pub fn is_of_model(self) -> bool {
        self == Row::ViewpointDependent
    }
}

/// Its name in scene files.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_printed_as_a_scene_names_it() {
        assert_eq!(Row::ViewpointDependent.to_string(), "viewpoint_dependent");
        for &row in Row::ALL {
            assert_eq!(serde_json::to_string(&row).unwrap(), format!("{:?}", row.to_string()));
        }
    }
}
