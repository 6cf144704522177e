use super::*;
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::{Crop, Seed};
use vantage_model::{
    AzimuthSensor, ClassModel, LatentGaussian, Linearization, MeasurementNoise, ObservationModel,
};

/// A model of which only the measurement is used: numbers that a crop's bytes hold.
struct Numbers(MeasurementNoise);

const M: usize = 6;

fn numbers() -> Numbers {
    Numbers(MeasurementNoise::new(DMatrix::identity(M, M), 4.0).unwrap())
}

impl ObservationModel for Numbers {
    fn latent_dim(&self) -> usize {
        1
    }
    fn noise(&self) -> &MeasurementNoise {
        &self.0
    }
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        let of = |i: usize| f64::from_le_bytes(crop.0[8 * i..8 * i + 8].try_into().unwrap());
        Ok(DVector::from_fn(M, |i, _| of(i)))
    }
    fn encode(&self, _: &Crop, _: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        Err(AnswerError::NonFinite { what: "what is not used" })
    }
    fn predict(&self, _: &DVector<f64>, _: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Err(AnswerError::NonFinite { what: "what is not used" })
    }
    fn linearize(&self, _: &DVector<f64>, _: &Viewpoint) -> Result<Linearization, AnswerError> {
        Err(AnswerError::NonFinite { what: "what is not used" })
    }
}

fn crop(numbers: &DVector<f64>) -> Crop {
    let mut crop = Crop::black();
    for (i, x) in numbers.iter().enumerate() {
        crop.0[8 * i..8 * i + 8].copy_from_slice(&x.to_le_bytes());
    }
    crop
}

/// Three classes of smooth looks with noise of `sigma`.
fn look(class: usize, azimuth: f64, sigma: f64, stream: &mut vantage_dataset::Stream) -> DVector<f64> {
    let shift = class as f64;
    DVector::from_fn(M, |i, _| {
        let harmonic = (1 + i / 2) as f64;
        let phase = if i % 2 == 0 { 0.0 } else { PI / 2.0 };
        2.0 * (harmonic * azimuth + phase + 0.3 * shift * harmonic).cos()
            + 0.8 * shift
            + sigma * stream.normal()
    })
}

fn views(instances: usize, sigma: f64) -> Vec<LabelledView> {
    let mut stream = Seed(3).stream("views", 0);
    let mut views = Vec::new();
    for instance in 0..instances {
        for _ in 0..16 {
            let azimuth = stream.uniform(-PI, PI);
            let direction = Vector3::new(azimuth.cos(), azimuth.sin(), 0.3).normalize();
            let viewpoint = Viewpoint { direction, roll: 0.0, log_distance: 1.0 };
            // Class 1 has odd instances alone.
            let class = instance % 4 % 3;
            let measurement = look(class, azimuth, sigma, &mut stream);
            views.push(LabelledView { measurement, viewpoint, instance, class });
        }
    }
    views
}

#[test]
fn azimuths_are_read_and_their_errors_foretold() {
    let (model, shown) = (numbers(), views(60, 0.3));
    let of_one_class: Vec<_> = shown.into_iter().filter(|view| view.class == 0).collect();
    let weights = AzimuthWeights::fit(&of_one_class).unwrap();
    let sensor = AzimuthReadout::new(&model, &weights);
    let mut stream = Seed(4).stream("test", 0);
    let (mut inside, mut errors) = (0, Vec::new());
    for _ in 0..400 {
        let azimuth = stream.uniform(-PI, PI);
        let read = sensor.read(&crop(&look(0, azimuth, 0.3, &mut stream))).unwrap();
        let error = (read.azimuth - azimuth).sin().atan2((read.azimuth - azimuth).cos());
        errors.push(error.abs());
        inside += usize::from(error.abs() < 1.96 * read.sigma);
    }
    errors.sort_by(f64::total_cmp);
    assert!(errors[200] < 8f64.to_radians(), "{}", errors[200].to_degrees());
    assert!((350..=395).contains(&inside), "{inside} of 400 within 1.96 sigma");
}

#[test]
fn classes_are_told_apart_and_predict_what_they_have_not_seen() {
    let (model, shown) = (numbers(), views(60, 0.1));
    let weights = ClassWeights::fit(&["a", "b", "c"], &shown).unwrap();
    assert_eq!(weights.names(), ["a", "b", "c"]);
    let classes = ClassReadout::new(&model, &weights);
    let mut stream = Seed(5).stream("test", 0);
    for view in views(6, 0.0) {
        let measured = look(view.class, view.viewpoint.azimuth(), 0.0, &mut stream);
        let miss = |class: usize| (classes.linearize(class, &view.viewpoint).0 - &measured).norm();
        assert!(miss(view.class) < 0.15, "{}", miss(view.class));
        assert!((0..3).filter(|&other| other != view.class).all(|other| miss(other) > 0.5));
    }
    for class in 0..classes.classes() {
        let sigma = classes.noise(class).sqrt_information().diagonal().mean().recip();
        assert!((sigma - 0.1).abs() < 0.03, "{sigma}");
    }
}

#[test]
fn derivatives_of_classes_are_those_of_steps() {
    let (model, shown) = (numbers(), views(60, 0.1));
    let weights = ClassWeights::fit(&["a", "b", "c"], &shown).unwrap();
    let classes = ClassReadout::new(&model, &weights);
    let (at, step) = (&shown[7].viewpoint, 1e-6);
    let analytic = classes.linearize(1, at).1.by_azimuth(at);
    let of = |angle: f64| classes.linearize(1, &at.turned(angle)).0;
    assert!(((of(step) - of(-step)) / (2.0 * step) - analytic).amax() < 1e-7);
}

#[test]
fn too_few_views_have_no_noise() {
    assert!(AzimuthWeights::fit(&[]).is_none());
    assert!(ClassWeights::fit(&["a", "b", "c"], &[]).is_none());
    assert!(ClassWeights::fit(&["a"], &views(1, 0.1)[..3]).is_none());
}

#[test]
fn read_outs_come_back_from_json_to_the_bit() {
    let shown = views(30, 0.1);
    let azimuth = AzimuthWeights::fit(&shown).unwrap();
    let classes = ClassWeights::fit(&["a", "b", "c"], &shown).unwrap();
    let readouts = Readouts { azimuth, classes };
    let text = serde_json::to_string(&readouts).unwrap();
    assert_eq!(serde_json::from_str::<Readouts>(&text).unwrap(), readouts);
}
