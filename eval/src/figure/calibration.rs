//! `calibration.svg`: whether residuals are as large as the model claims, together and number by number.

use super::FigureError;
use super::palette::color;
use super::svg::{Area, Drawn, draw_key, svg};
use crate::score::calibration::{Calibration, REGIONS};
use plotters::prelude::*;

const FIGURE: &str = "calibration";
const SIZE: (u32, u32) = (1100, 480);
/// Points of a curve.
const POINTS: usize = 200;

/// Draws what was found beside what was promised: residuals as claimed lie on the lines.
pub fn calibration_svg(found: &Calibration) -> Result<String, FigureError> {
    svg(FIGURE, SIZE, |area| {
        let (left, right) = area.split_horizontally(SIZE.0 / 2);
        together(&left, found)?;
        number_by_number(&right, found)
    })
}

/// The share of residuals inside the region that should hold each share.
fn together(area: &Area<'_>, found: &Calibration) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .caption(
            format!("Squared whitened residuals of {} held-out views", found.residuals),
            ("sans-serif", 18),
        )
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
    chart
        .configure_mesh()
        .x_desc("share that the region should hold")
        .y_desc("share of residuals inside")
        .max_light_lines(1)
        .draw()?;
    chart.draw_series(LineSeries::new([(0.0, 0.0), (1.0, 1.0)], BLACK.mix(0.5)))?;
    let claimed = ("Student t, as the model claims", Some(&found.probabilities));
    let gaussian = ("Gaussian of the same covariance (chi-square)", found.gaussian_probabilities.as_ref());
    for (index, (name, probabilities)) in [claimed, gaussian].into_iter().enumerate() {
        let Some(probabilities) = probabilities else { continue };
        let inside = |promised: f64| {
            probabilities.partition_point(|&p| p <= promised) as f64 / probabilities.len() as f64
        };
        let curve =
            (0..=POINTS).map(|i| i as f64 / POINTS as f64).map(|promised| (promised, inside(promised)));
        let style = color(index).stroke_width(2);
        chart
            .draw_series(LineSeries::new(curve, style))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    draw_key(&mut chart, SeriesLabelPosition::LowerRight)
}

/// The share of each whitened number inside its intervals.
fn number_by_number(area: &Area<'_>, found: &Calibration) -> Drawn {
    let numbers = found.number_inside.len() as f64;
    let mut chart = ChartBuilder::on(area)
        .caption("Each whitened number", ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..numbers + 1.0, 0.0..1.0)?;
    chart
        .configure_mesh()
        .x_desc("number of the reduced measurement")
        .y_desc("share inside its interval")
        .x_label_formatter(&|number| format!("{number:.0}"))
        .disable_x_mesh()
        .max_light_lines(1)
        .draw()?;
    for (index, region) in REGIONS.into_iter().enumerate() {
        let style = color(index);
        chart.draw_series(LineSeries::new([(0.0, region), (numbers + 1.0, region)], style.mix(0.6)))?;
        let shares = (1..).zip(&found.number_inside);
        let dots =
            shares.map(|(number, shares)| Circle::new((f64::from(number), shares[index]), 3, style.filled()));
        chart
            .draw_series(dots)?
            .label(format!("{:.0}%", 100.0 * region))
            .legend(move |(x, y)| Circle::new((x + 10, y), 3, style.filled()));
    }
    draw_key(&mut chart, SeriesLabelPosition::LowerRight)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(gaussian: bool) -> Calibration {
        let probabilities: Vec<f64> = (0..100).map(|i| f64::from(i) / 100.0).collect();
        Calibration {
            residuals: 100,
            inside: REGIONS,
            gaussian_inside: gaussian.then_some(REGIONS),
            number_inside: vec![[0.4, 0.7, 0.9], [0.5, 0.8, 0.95]],
            gaussian_probabilities: gaussian.then(|| probabilities.clone()),
            probabilities,
            squared_norm_variance: None,
        }
    }

    #[test]
    fn every_number_has_a_dot_for_each_region_and_every_law_a_curve() {
        let curves = |svg: &str| {
            svg.lines().filter(|l| l.starts_with("<polyline") && l.matches(',').count() > POINTS).count()
        };
        let svg = calibration_svg(&found(true)).unwrap();
        let legend = REGIONS.len();
        assert_eq!(svg.matches("<circle").count(), 2 * REGIONS.len() + legend);
        assert_eq!(curves(&svg), 2);
        assert_eq!(curves(&calibration_svg(&found(false)).unwrap()), 1);
    }

    /// Points of the polylines of a figure, longest last.
    fn polylines(svg: &str) -> Vec<Vec<(f64, f64)>> {
        let points = |line: &str| {
            let points = line.split('"').max_by_key(|part| part.matches(',').count()).unwrap();
            let pairs = points.split_whitespace().filter_map(|point| point.split_once(','));
            pairs.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).collect()
        };
        let mut found: Vec<Vec<(f64, f64)>> =
            svg.lines().filter(|line| line.starts_with("<polyline")).map(points).collect();
        found.sort_by_key(Vec::len);
        found
    }

    #[test]
    fn a_curve_is_as_far_from_the_diagonal_as_its_residuals_are_from_the_law() {
        let largest = |found: &Calibration| {
            let lines = polylines(&calibration_svg(found).unwrap());
            let curve = &lines[lines.len() - 1];
            let diagonal = lines
                .iter()
                .find(|line| line.len() == 2 && line[0].0 < line[1].0 && line[0].1 > line[1].1)
                .unwrap();
            let (from, to) = (diagonal[0], diagonal[1]);
            let side = to.0 - from.0;
            curve.iter().fold(0.0f64, |most, (x, y)| {
                let share = (from.1 - y) / (from.1 - to.1);
                most.max((share - (x - from.0) / side).abs())
            })
        };
        let claimed = found(false);
        assert!(largest(&claimed) < 0.02);
        let squared = claimed.probabilities.iter().map(|p| p * p).collect();
        let away = largest(&Calibration { probabilities: squared, ..claimed });
        assert!((away - 0.25).abs() < 0.02, "sqrt(p) - p is 1/4 at most, not {away}");
    }
}
