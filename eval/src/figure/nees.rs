//! `nees.svg`: whether poses are as far off as their covariances say, step by step.

use super::FigureError;
use super::palette::color;
use super::svg::{Area, Drawn, draw_key, svg};
use crate::result::distribution::chi_squared_quantile;
use crate::score::consistency::POSE;
use plotters::prelude::*;

const FIGURE: &str = "nees";
const SIZE: (u32, u32) = (900, 500);
/// By how much the scale goes on above the lines, for the key.
const ROOM: f64 = 2.0;

/// A row's NEES / dof of the whole pose: of each seed, by step from the second on.
pub type Curve<'a> = (&'a str, Vec<Vec<f64>>);

/// Draws the mean over the seeds of each row on a logarithmic scale, with the band that holds that of a consistent estimator in 95%: the
/// chi-square law of all numbers of a pose on all seeds, over how many they are. A row ends where its shortest seed does.
pub fn nees_svg(title: &str, rows: &[Curve<'_>]) -> Result<String, FigureError> {
    let seeds = rows.iter().map(|(_, seeds)| seeds.len()).max().unwrap_or(0);
    let means: Vec<(&str, Vec<f64>)> = rows.iter().map(|(name, seeds)| (*name, mean(seeds))).collect();
    let steps = means.iter().map(|(_, mean)| mean.len()).max().filter(|steps| *steps > 0);
    let steps = steps.ok_or(FigureError::Empty { figure: FIGURE })? as f64;
    let numbers = (seeds * POSE) as f64;
    let band = [0.025, 0.975].map(|probability| chi_squared_quantile(probability, numbers) / numbers);
    let (mut low, mut high) = (band[0], band[1]);
    for (name, mean) in &means {
        if mean.iter().any(|nees| !nees.is_finite()) {
            return Err(FigureError::NotFinite { figure: FIGURE, of: (*name).to_owned() });
        }
        // A logarithm has no place for an estimate without error.
        low = mean.iter().copied().filter(|nees| *nees > 0.0).fold(low, f64::min);
        high = mean.iter().copied().fold(high, f64::max);
    }
    svg(FIGURE, SIZE, |area| draw(title, &means, (seeds, band), steps, (low / 1.3, high * ROOM), area))
}

/// By step, over seeds.
fn mean(seeds: &[Vec<f64>]) -> Vec<f64> {
    let steps = seeds.iter().map(Vec::len).min().unwrap_or(0);
    (0..steps).map(|i| seeds.iter().map(|nees| nees[i]).sum::<f64>() / seeds.len() as f64).collect()
}

fn draw(
    title: &str,
    rows: &[(&str, Vec<f64>)],
    (seeds, band): (usize, [f64; 2]),
    steps: f64,
    (low, high): (f64, f64),
    area: &Area<'_>,
) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..steps, (low..high).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("step")
        .y_desc("NEES of the pose / 6, mean over seeds")
        .x_label_formatter(&|step| format!("{step:.0}"))
        .y_label_formatter(&|nees| format!("{nees}"))
        .disable_x_mesh()
        .draw()?;
    let gray = BLACK.mix(0.15).filled();
    let plural = if seeds == 1 { "" } else { "s" };
    chart
        .draw_series([Rectangle::new([(0.0, band[0]), (steps, band[1])], gray)])?
        .label(format!("consistent: 95% of {seeds} seed{plural}"))
        .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 20, y + 5)], gray));
    chart.draw_series(LineSeries::new([(0.0, 1.0), (steps, 1.0)], BLACK.mix(0.6)))?;
    for (index, (name, mean)) in rows.iter().enumerate() {
        let style = color(index).stroke_width(2);
        let line = (1..).zip(mean).map(|(step, nees)| (f64::from(step), nees.max(low)));
        chart
            .draw_series(LineSeries::new(line, style))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    draw_key(&mut chart, SeriesLabelPosition::UpperLeft)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(svg: &str, points: usize) -> usize {
        svg.lines().filter(|l| l.starts_with("<polyline") && l.matches(',').count() == points).count()
    }

    #[test]
    fn each_row_has_a_line_of_the_steps_that_all_its_seeds_have() {
        let rows = [("odometry", vec![vec![1.0; 30], vec![2.0; 20]]), ("a<b", vec![vec![0.5; 25]])];
        let svg = nees_svg("s", &rows).unwrap();
        assert_eq!((lines(&svg, 20), lines(&svg, 25), lines(&svg, 30)), (1, 1, 0), "{svg}");
        for text in ["odometry", "a&lt;b", "consistent: 95% of 2 seeds", "step"] {
            assert!(svg.contains(text), "{text} is missing: {svg}");
        }
        assert_eq!(svg, nees_svg("s", &rows).unwrap());
    }

    #[test]
    fn an_exact_row_is_drawn_and_nothing_or_nan_is_not() {
        assert!(nees_svg("s", &[("exact", vec![vec![0.0; 9]])]).is_ok());
        for rows in [&[][..], &[("none", vec![])][..], &[("none", vec![vec![]])][..]] {
            assert!(matches!(nees_svg("s", rows), Err(FigureError::Empty { .. })));
        }
        let nan = [("mine", vec![vec![1.0, f64::NAN]])];
        assert!(matches!(nees_svg("s", &nan), Err(FigureError::NotFinite { .. })));
    }
}
