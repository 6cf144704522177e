//! `likelihood.svg`: how well the model knows a viewpoint: mean log-likelihood against the azimuth's offset from truth.

use super::FigureError;
use super::palette::color;
use super::svg::{Area, Drawn, draw_key, svg};
use plotters::prelude::*;

const FIGURE: &str = "likelihood";
const SIZE: (u32, u32) = (800, 500);

/// One curve: its name, and (offset in radians, mean log-likelihood less that at the truth) by rising offset.
pub type Curve<'a> = (&'a str, Vec<(f64, f64)>);

/// Draws the curves over -180 to 180 degrees. An informative model peaks at 0.
pub fn likelihood_svg(title: &str, curves: &[Curve<'_>]) -> Result<String, FigureError> {
    let mut range: Option<(f64, f64)> = None;
    for (name, points) in curves {
        for (offset, value) in points {
            if !(offset.is_finite() && value.is_finite()) {
                return Err(FigureError::NotFinite { figure: FIGURE, of: (*name).to_owned() });
            }
            let (low, high) = range.unwrap_or((*value, *value));
            range = Some((low.min(*value), high.max(*value)));
        }
    }
    let (low, high) = range.ok_or(FigureError::Empty { figure: FIGURE })?;
    let margin = ((high - low) * 0.05).max(1e-6);
    svg(FIGURE, SIZE, |area| draw(title, curves, (low - margin, high + margin), area))
}

fn draw(title: &str, curves: &[Curve<'_>], (low, high): (f64, f64), area: &Area<'_>) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(-180.0..180.0, low..high)?;
    chart
        .configure_mesh()
        .x_desc("azimuth less true azimuth [deg]")
        .y_desc("mean log-likelihood less that at the truth")
        .max_light_lines(1)
        .draw()?;
    for (index, (name, points)) in curves.iter().enumerate() {
        let style = color(index).stroke_width(2);
        let line = points.iter().map(|(offset, value)| (offset.to_degrees(), *value));
        chart
            .draw_series(LineSeries::new(line, style))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    draw_key(&mut chart, SeriesLabelPosition::UpperRight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_drawn_with_their_names() {
        let curve = |scale: f64| -> Vec<(f64, f64)> {
            (-30..=30).map(|i| f64::from(i) / 10.0).map(|x| (x, scale * (x.cos() - 1.0))).collect()
        };
        let svg = likelihood_svg("unseen instances", &[("mug", curve(4.0)), ("book", curve(1.0))]).unwrap();
        let lines = svg.lines().filter(|l| l.starts_with("<polyline") && l.matches(',').count() == 61);
        assert_eq!(lines.count(), 2);
        assert!(svg.contains("mug") && svg.contains("book") && svg.contains("unseen instances"));
    }

    #[test]
    fn a_flat_curve_is_drawn_and_nothing_or_nan_is_not() {
        assert!(likelihood_svg("", &[("flat", vec![(-1.0, 0.0), (1.0, 0.0)])]).is_ok());
        assert!(matches!(likelihood_svg("", &[]), Err(FigureError::Empty { .. })));
        let nan = [("mug", vec![(0.0, f64::NAN)])];
        assert!(matches!(likelihood_svg("", &nan), Err(FigureError::NotFinite { .. })));
    }
}
