//! The rows of the table of trajectories: the estimators that a scene may name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use vantage_learn::gaussian_process::GaussianProcess;
use vantage_model::ObservationModel;
use vantage_slam::{
    Estimator, Geometric, OdometryOnly, OrientationSettings, Semantic, Settings, Uninformative,
};

/// Declares [`Row`]: what each is, and what makes its estimator of the settings and a model.
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
                model: &'m dyn ObservationModel,
            ) -> Box<dyn Estimator + 'm> {
                match self {
                    $(Row::$row => Box::new($make(settings, model)),)*
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
    ViewpointDependent => Semantic::new;
    /// The variables and factors of `viewpoint_dependent`, its semantic factors with zero information: a
    /// control that must equal `geometric`.
    Uninformative => Uninformative::new;
    /// Geometric, with an untrained Gaussian process per object over the azimuth in place of a model; runs where a scene
    /// names it.
    GaussianProcess => |settings: &Settings, _| {
        // Its prior is the same for every yaw: the first one tried is the object's frame.
        let orientation = OrientationSettings { yaw_candidates: 1, ..settings.orientation };
        Semantic::new(&Settings { orientation, ..*settings }, GaussianProcess::fitted())
    };
}

impl Row {
    /// The rows of a scene that names none.
    pub const DEFAULT: &[Row] = &[Row::Odometry, Row::Geometric, Row::ViewpointDependent, Row::Uninformative];

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
