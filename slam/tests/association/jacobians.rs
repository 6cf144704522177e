//! Derivatives of the factors of the plane against differences.

use nalgebra::{DVector, Matrix2, Matrix3, Vector2};
use vantage_dataset::Seed;
use vantage_slam::Key;
use vantage_slam::association::planar::{Motion, PlanarBetween, PlanarPoint, PlanarPrior, RangeBearing};
use vantage_slam::factor::Factor;
use vantage_slam::variable::{Value, Values};

#[test]
fn derivatives_are_those_of_the_residuals() {
    let mut stream = Seed(8).stream("planar", 0);
    let mut draw = || stream.uniform(-3.0, 3.0);
    for _ in 0..20 {
        let (a, b) = (Motion::new(draw(), draw(), draw()), Motion::new(draw(), draw(), draw()));
        let point = Vector2::new(draw() + 9.0, draw());
        let near = |motion: Motion| Motion::new(motion.x + 0.1, motion.y - 0.2, motion.heading + 0.3);
        let w3 = Matrix3::new(2.0, 0.3, 0.1, 0.0, 1.5, -0.2, 0.0, 0.0, 4.0);
        let w2 = Matrix2::new(2.0, 0.3, 0.0, 1.5);
        let mut values = Values::default();
        values.insert(Key::Robot(0), a.to_value());
        values.insert(Key::Robot(1), b.to_value());
        values.insert(Key::Landmark(0), Value::Vector(DVector::from_column_slice(point.as_slice())));
        let (robot, landmark) = (Key::Robot(0), Key::Landmark(0));
        let factors: [Box<dyn Factor>; 4] = [
            Box::new(PlanarBetween::new(robot, Key::Robot(1), near(a.to(b)), w3)),
            Box::new(PlanarPoint::new(robot, landmark, a.seen(point) + Vector2::new(0.3, -0.2), w2)),
            Box::new(RangeBearing::new(robot, landmark, 7.0, 0.4, w2)),
            Box::new(PlanarPrior::new(robot, near(a), w3)),
        ];
        for factor in &factors {
            let linear = factor.linearize(&values).unwrap();
            for (key, jacobian) in factor.keys().iter().zip(&linear.jacobians) {
                for column in 0..jacobian.ncols() {
                    let h = 1e-6;
                    let at = |h: f64| {
                        let mut moved = values.clone();
                        let mut step = vec![0.0; jacobian.ncols()];
                        step[column] = h;
                        moved.retract(*key, &step);
                        factor.residual(&moved).unwrap()
                    };
                    let slope = (at(h) - at(-h)) / (2.0 * h);
                    let off = (slope - jacobian.column(column)).amax();
                    assert!(off < 1e-6, "{key}, {column}: {off}");
                }
            }
        }
    }
}

#[test]
fn residuals_are_zero_where_a_measurement_is_met_and_headings_are_wrapped() {
    let (a, b) = (Motion::new(1.0, 2.0, 3.0), Motion::new(0.5, -1.0, -3.1));
    let mut values = Values::default();
    values.insert(Key::Robot(0), a.to_value());
    values.insert(Key::Robot(1), Motion::new(b.x, b.y, b.heading + 4.0 * std::f64::consts::PI).to_value());
    let factor = PlanarBetween::new(Key::Robot(0), Key::Robot(1), a.to(b), Matrix3::identity());
    assert!(factor.residual(&values).unwrap().amax() < 1e-12);
    values.insert(Key::Landmark(0), Value::Vector(DVector::from_column_slice(&[1.0, 2.0])));
    let at_zero = RangeBearing::new(Key::Robot(0), Key::Landmark(0), 1.0, 0.0, Matrix2::identity());
    assert!(at_zero.residual(&values).is_none(), "a bearing at range 0 is undefined");
}
