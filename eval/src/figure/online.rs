//! `online.svg`: how far off the robot's newest position is after each step.

use super::FigureError;
use super::palette::color;
use super::svg::{Area, Drawn, draw_key, svg};
use plotters::prelude::*;

const FIGURE: &str = "online";
const SIZE: (u32, u32) = (900, 500);
/// Room above the lines, for the key.
const ROOM: f64 = 1.3;

/// A row's errors, metres: of each seed, by step.
pub type Errors<'a> = (&'a str, Vec<Vec<f64>>);

/// Draws the root mean square over the seeds of each row. A row ends where its shortest seed does.
pub fn online_svg(title: &str, rows: &[Errors<'_>]) -> Result<String, FigureError> {
    let rows: Vec<(&str, Vec<f64>)> = rows.iter().map(|(name, seeds)| (*name, rms(seeds))).collect();
    let steps = rows.iter().map(|(_, rms)| rms.len()).max().filter(|steps| *steps > 0);
    let steps = steps.ok_or(FigureError::Empty { figure: FIGURE })?;
    let mut highest = 0.0;
    for (name, rms) in &rows {
        if rms.iter().any(|error| !error.is_finite()) {
            return Err(FigureError::NotFinite { figure: FIGURE, of: (*name).to_owned() });
        }
        highest = rms.iter().copied().fold(highest, f64::max);
    }
    let top = if highest > 0.0 { highest * ROOM } else { 1.0 };
    svg(FIGURE, SIZE, |area| draw(title, &rows, steps as f64, top, area))
}

/// By step, over seeds.
fn rms(seeds: &[Vec<f64>]) -> Vec<f64> {
    let steps = seeds.iter().map(Vec::len).min().unwrap_or(0);
    let at = |i: usize| seeds.iter().map(|errors| errors[i] * errors[i]).sum::<f64>() / seeds.len() as f64;
    (0..steps).map(|i| at(i).sqrt()).collect()
}

fn draw(title: &str, rows: &[(&str, Vec<f64>)], steps: f64, top: f64, area: &Area<'_>) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..steps, 0.0..top)?;
    chart
        .configure_mesh()
        .x_desc("step")
        .y_desc("error of the newest position [m], RMS over seeds")
        .x_label_formatter(&|step| format!("{step:.0}"))
        .disable_x_mesh()
        .draw()?;
    for (index, (name, errors)) in rows.iter().enumerate() {
        let style = color(index).stroke_width(2);
        let line = (0..).zip(errors).map(|(step, error)| (f64::from(step), *error));
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

    #[test]
    fn each_row_has_a_line_of_the_steps_that_all_its_seeds_have() {
        let rows = [("odometry", vec![vec![0.1; 30], vec![0.2; 20]]), ("a<b", vec![vec![0.0; 25]])];
        let svg = online_svg("s", &rows).unwrap();
        let lines = |points: usize| {
            svg.lines().filter(|l| l.starts_with("<polyline") && l.matches(',').count() == points).count()
        };
        assert_eq!((lines(20), lines(25), lines(30)), (1, 1, 0), "{svg}");
        assert!(svg.contains("a&lt;b") && svg.contains("step"), "{svg}");
    }

    #[test]
    fn nothing_and_nan_are_not_drawn() {
        assert!(matches!(online_svg("s", &[]), Err(FigureError::Empty { .. })));
        let nan = [("mine", vec![vec![0.1, f64::NAN]])];
        assert!(matches!(online_svg("s", &nan), Err(FigureError::NotFinite { .. })));
    }
}
