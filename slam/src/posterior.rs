//! A posterior at its maximum, and the estimate that is read off it.

use crate::covariance::Marginals;
use crate::estimate::{
    Dropped, Estimate, LandmarkEstimate, ObjectEstimate, Orientation, Unresolved, UnresolvedLandmark,
};
use crate::graph::Graph;
use crate::lesson::DomainBelief;
use crate::linear::Structure;
use crate::settings::SolverSettings;
use crate::sighting::Sighting;
use crate::solve::{Outcome, Solution, solve};
use crate::variable::{Key, Value, Values};
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3};
use std::collections::BTreeMap;
use vantage_dataset::Observations;
use vantage_model::LatentGaussian;

/// A graph with its maximum, and what of the detections is in it.
pub struct Posterior<'m> {
    /// The factors.
    pub graph: Graph<'m>,
    /// The maximum.
    pub solution: Solution,
    /// The first variable, in the order of keys, that nothing ties to the world.
    pub unanchored: Option<Key>,
    /// Sightings of the objects that were placed, by track.
    pub sightings: BTreeMap<usize, Vec<Sighting>>,
    /// Tracks that were seen and yet not placed, in order.
    pub unresolved: Vec<Unresolved>,
    /// Sightings used of the landmarks that were placed, by landmark.
    pub landmarks: BTreeMap<usize, usize>,
    /// Landmarks that were seen and yet not placed, in order.
    pub unresolved_landmarks: Vec<UnresolvedLandmark>,
    /// Detections and sightings that were not used, or not fully.
    pub dropped: Dropped,
}

/// What is known of an object beside its variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its diameter, metres.
    pub size: Option<f64>,
    /// By how much the second mode of its orientation is worse, nats; `None` of an object without orientation and
    /// latent.
    pub margin: Option<f64>,
    /// Semantic measurements used.
    pub semantic_views: usize,
}

impl<'m> Posterior<'m> {
    /// The maximum of a graph over all variables, from `start`.
    pub fn maximum(
        graph: Graph<'m>,
        start: Values,
        sightings: BTreeMap<usize, Vec<Sighting>>,
        solver: &SolverSettings,
    ) -> Self {
        let unanchored = graph.first_unanchored(&start);
        let solution = solve(&graph, start, |_| true, solver.limits());
        Self {
            graph,
            solution,
            unanchored,
            sightings,
            unresolved: Vec::new(),
            landmarks: BTreeMap::new(),
            unresolved_landmarks: Vec::new(),
            dropped: Dropped::default(),
        }
    }

    /// The marginal of the domain; `None` where there is none, or the normal equations are singular
    /// even when damped.
    pub(crate) fn domain(&self) -> Option<DomainBelief> {
        let values = &self.solution.values;
        let mean = values.vector(Key::Domain)?.clone();
        let structure = Structure::new(&self.graph, values, |_| true)?;
        let system = structure.linearize(&self.graph, values)?;
        let covariance = Marginals::new(&system)?.covariances(&[Key::Domain]).pop()??;
        covariance.iter().all(|x| x.is_finite()).then_some(DomainBelief { mean, covariance })
    }

    /// The estimate: values, and marginals where the settings ask for them; `seen` tells of each placed object.
    pub fn estimate(
        self,
        observations: &Observations,
        solver: &SolverSettings,
        seen: impl Fn(&Values, usize, &[Sighting]) -> Seen,
    ) -> Estimate {
        let values = &self.solution.values;
        let robots: Vec<Key> = (0..observations.steps()).map(Key::Robot).collect();
        let objects: Vec<Key> = self.sightings.keys().map(|&track| Key::Object(track)).collect();

        let structure = Structure::new(&self.graph, values, |_| true);
        let system = structure.as_ref().and_then(|structure| structure.linearize(&self.graph, values));
        let marginals = system.as_ref().and_then(Marginals::new);
        let wanted = marginals.as_ref().filter(|_| solver.covariances);
        let pose_covariances = wanted.and_then(|marginals| {
            let blocks = marginals.covariances(&robots);
            blocks.into_iter().map(|block| Some(Matrix6::from_column_slice(block?.as_slice()))).collect()
        });
        let object_covariances: Vec<Option<DMatrix<f64>>> =
            wanted.map_or_else(|| vec![None; objects.len()], |marginals| marginals.covariances(&objects));

        let mut estimates: Vec<Option<ObjectEstimate>> = vec![None; observations.tracks()];
        for ((&track, of_track), covariance) in self.sightings.iter().zip(object_covariances) {
            let Some(value) = values.get(Key::Object(track)) else { continue };
            let Some(position) = value.position() else { continue };
            let Seen { size, margin, semantic_views } = seen(values, track, of_track);
            let (position_covariance, rotation_covariance) = split(value, covariance.as_ref());
            let orientation = |margin| {
                let world_from_object = values.pose(Key::Object(track))?.rotation;
                Some(Orientation { world_from_object, covariance: rotation_covariance, margin })
            };
            let latent = |_| {
                let mean = values.vector(Key::Latent(track))?.clone();
                let variance = marginals.as_ref()?.latent_variance(Key::Latent(track))?;
                Some(LatentGaussian { mean, variance })
            };
            estimates[track] = Some(ObjectEstimate {
                position,
                position_covariance,
                size,
                extents: extents(values, track),
                orientation: margin.and_then(orientation),
                latent: margin.and_then(latent),
                classes: None,
                bearings: of_track.len(),
                semantic_views,
            });
        }
        Estimate {
            outcome: self.outcome(observations),
            world_from_robot: robots.iter().filter_map(|&key| values.pose(key).copied()).collect(),
            pose_covariances,
            objects: estimates,
            unresolved: self.unresolved,
            landmarks: estimated_landmarks(&self.landmarks, values, wanted),
            unresolved_landmarks: self.unresolved_landmarks,
            iterations: self.solution.iterations,
            cost: self.solution.cost,
            dropped_detections: self.dropped,
        }
    }

    fn outcome(&self, observations: &Observations) -> Outcome {
        match (self.solution.outcome, self.unanchored) {
            (_, Some(near)) => Outcome::Underconstrained { near },
            (Outcome::Converged, None) if observations.steps() == 0 => Outcome::NothingObserved,
            (outcome, None) => outcome,
        }
    }
}

/// The semi-axes of an object, where they are variables.
fn extents(values: &Values, track: usize) -> Option<Vector3<f64>> {
    let logs = values.vector(Key::Extents(track))?;
    Some(Vector3::from_iterator(logs.iter().map(|log| libm::exp(*log))))
}

/// Places, and covariances where there are marginals, of landmarks with so many sightings each.
fn estimated_landmarks(
    sightings: &BTreeMap<usize, usize>,
    values: &Values,
    marginals: Option<&Marginals<'_>>,
) -> BTreeMap<usize, LandmarkEstimate> {
    let keys: Vec<Key> = sightings.keys().map(|&landmark| Key::Landmark(landmark)).collect();
    let covariances =
        marginals.map_or_else(|| vec![None; keys.len()], |marginals| marginals.covariances(&keys));
    let estimate = |((&landmark, &sightings), covariance): ((&usize, &usize), Option<DMatrix<f64>>)| {
        let position = values.get(Key::Landmark(landmark))?.position()?;
        let covariance = covariance.map(|covariance| Matrix3::from_column_slice(covariance.as_slice()));
        Some((landmark, LandmarkEstimate { position, covariance, sightings }))
    };
    sightings.iter().zip(covariances).filter_map(estimate).collect()
}

/// Covariances of position (world axes) and rotation (right perturbation) from that of a pose or point.
fn split(value: &Value, covariance: Option<&DMatrix<f64>>) -> (Option<Matrix3<f64>>, Option<Matrix3<f64>>) {
    match (value, covariance) {
        (Value::Pose(pose), Some(covariance)) => {
            let world_from_object = pose.rotation.to_rotation_matrix().into_inner();
            let position = Matrix3::from_fn(|i, j| covariance[(3 + i, 3 + j)]);
            let rotation = Matrix3::from_fn(|i, j| covariance[(i, j)]);
            (Some(world_from_object * position * world_from_object.transpose()), Some(rotation))
        }
        (Value::Point(_), Some(covariance)) => {
            (Some(Matrix3::from_column_slice(covariance.as_slice())), None)
        }
        _ => (None, None),
    }
}
