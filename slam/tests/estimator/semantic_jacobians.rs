//! The derivatives of semantic factors against central differences: of a model, with its discrepancy, and in a domain.

use crate::jacobians::{check, random_tangent};
use crate::model::TanhModel;
use nalgebra::DVector;
use vantage_dataset::{Pose, Seed, se3};
use vantage_model::ObservationModel;
use vantage_slam::discrepancy::Discrepant;
use vantage_slam::domain::{Domain, DomainPrior};
use vantage_slam::factor::semantic::SemanticScaling;
use vantage_slam::factor::{DomainFactor, Factor, SemanticFactor};
use vantage_slam::variable::{Value, Values};
use vantage_slam::{AzimuthDiscrepancy, Key};

#[test]
fn semantic() {
    semantic_of(&TanhModel::new([7, 6, 16], 0.05, 4.0, Seed(5)));
}

#[test]
fn semantic_with_a_discrepancy() {
    let model = TanhModel::new([7, 6, 16], 0.05, 4.0, Seed(5));
    semantic_of(&Discrepant::new(&model, &AzimuthDiscrepancy { sigma: 0.3, concentration: 2.0 }));
}

fn semantic_of(model: &dyn ObservationModel) {
    semantic_in(model, None);
}

#[test]
fn semantic_in_a_domain() {
    let model = TanhModel::new([7, 6, 16], 0.05, 4.0, Seed(5));
    let domain = Domain::new(model.noise(), &DomainPrior { offset_sigma: 1.5, gain_sigma: 0.4 });
    assert_eq!(domain.dim(), 12);
    semantic_in(&model, Some(&domain));
}

fn semantic_in(model: &dyn ObservationModel, domain: Option<&Domain>) {
    let mut stream = Seed(5).stream("semantic", 0);
    let mut tested = 0;
    while tested < 20 {
        let mut values = Values::default();
        let robot = se3::exp(&random_tangent(&mut stream, 0.5, 1.0));
        let mount = se3::exp(&random_tangent(&mut stream, 0.5, 0.2));
        let ahead = robot * mount * Pose::translation(stream.normal() * 0.3, stream.normal() * 0.3, 2.0);
        let object = ahead * se3::exp(&random_tangent(&mut stream, 1.0, 0.1));
        values.insert(Key::Robot(0), Value::Pose(robot));
        values.insert(Key::Object(0), Value::Pose(object));
        values.insert(
            Key::Latent(0),
            Value::Vector(DVector::from_fn(model.latent_dim(), |_, _| stream.normal())),
        );
        let measurement = DVector::from_fn(6, |_, _| stream.normal());
        let scaling = SemanticScaling { noise: 1.3, information: 0.7 };
        let keys = [Key::Robot(0), Key::Object(0), Key::Latent(0)];
        let factor = SemanticFactor::new(keys, model, measurement, mount, 0.4, scaling);
        if factor.residual(&values).is_none() {
            continue;
        }
        tested += 1;
        match domain {
            None => assert!(check(&factor, &values) > 1.0),
            Some(domain) => {
                let none = DVector::zeros(domain.dim());
                values.insert(Key::Domain, Value::Vector(none));
                let factor_in_domain = DomainFactor::new(factor.clone(), domain);
                let (plain, as_trained) = (factor.residual(&values), factor_in_domain.residual(&values));
                assert!((plain.unwrap() - as_trained.unwrap()).amax() < 1e-12);
                let u = DVector::from_fn(domain.dim(), |_, _| stream.normal());
                values.insert(Key::Domain, Value::Vector(u));
                assert!(check(&factor_in_domain, &values) > 1.0);
            }
        }
    }
}
