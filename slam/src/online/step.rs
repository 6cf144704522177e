//! An episode step by step.

use vantage_dataset::{Detection, LandmarkSighting, Observations, Odometry};

/// What is observed at one step.
#[derive(Clone, Debug)]
pub struct StepObservations {
    /// Seconds since the start.
    pub timestamp: f64,
    /// Motion from earlier steps to this one.
    pub odometry: Vec<Odometry>,
    /// Objects seen.
    pub detections: Vec<Detection>,
    /// Landmarks seen.
    pub landmarks: Vec<LandmarkSighting>,
}

impl StepObservations {
    /// An episode step by step, as it came.
    pub fn of(observations: &Observations) -> Vec<Self> {
        let mut steps: Vec<Self> = observations
            .timestamps
            .iter()
            .map(|&timestamp| Self {
                timestamp,
                odometry: Vec::new(),
                detections: Vec::new(),
                landmarks: Vec::new(),
            })
            .collect();
        for odometry in &observations.odometry {
            if let Some(step) = steps.get_mut(odometry.from.max(odometry.to)) {
                step.odometry.push(odometry.clone());
            }
        }
        for detection in &observations.detections {
            if let Some(step) = steps.get_mut(detection.step) {
                step.detections.push(detection.clone());
            }
        }
        for landmark in &observations.landmarks {
            if let Some(step) = steps.get_mut(landmark.step) {
                step.landmarks.push(*landmark);
            }
        }
        steps
    }
}
