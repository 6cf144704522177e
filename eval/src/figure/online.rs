//! `online.svg`: how far off the robot's newest position is after each step.

use super::FigureError;
use super::palette::color;
use super::svg::{Area, Drawn, draw_key, svg};
use crate::result::step_errors::StepErrors;
use plotters::prelude::*;

const FIGURE: &str = "online";
const SIZE: (u32, u32) = (900, 500);
/// Room above the lines, for the key.
const ROOM: f64 = 1.3;

/// Draws a line a row.
pub fn online_svg(title: &str, rows: &[StepErrors<'_>]) -> Result<String, FigureError> {
    let steps = rows.iter().map(|(_, errors)| errors.len()).max().filter(|steps| *steps > 0);
    let steps = steps.ok_or(FigureError::Empty { figure: FIGURE })?;
    let mut highest = 0.0;
    for (name, errors) in rows {
        if errors.iter().any(|error| !error.is_finite()) {
            return Err(FigureError::NotFinite { figure: FIGURE, of: (*name).to_owned() });
        }
        highest = errors.iter().copied().fold(highest, f64::max);
    }
    let top = if highest > 0.0 { highest * ROOM } else { 1.0 };
    svg(FIGURE, SIZE, |area| draw(title, rows, steps as f64, top, area))
}

fn draw(title: &str, rows: &[StepErrors<'_>], steps: f64, top: f64, area: &Area<'_>) -> Drawn {
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
    fn each_row_has_a_line_of_its_steps() {
        let rows = [("odometry", vec![0.1; 20]), ("a<b", vec![0.0; 25])];
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
        let nan = [("mine", vec![0.1, f64::NAN])];
        assert!(matches!(online_svg("s", &nan), Err(FigureError::NotFinite { .. })));
    }
}
