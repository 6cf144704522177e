//! `trajectory.svg`: the world from above, with the true path, every estimate, and the objects.

use super::FigureError;
use super::palette::color;
use plotters::prelude::*;
use vantage_dataset::Pose;

const FIGURE: &str = "trajectory";
const SIDE: u32 = 800;
/// Pixels that legend, labels and margins take from the plot.
const FRAME: u32 = 70;

/// What the figure shows, all in the true world frame.
#[derive(Clone, Debug, Default)]
pub struct TopView<'a> {
    /// Title.
    pub title: &'a str,
    /// The true robot poses.
    pub truth: &'a [Pose],
    /// Estimated robot poses by method, aligned as the scores align them.
    pub estimates: &'a [(&'a str, Vec<Pose>)],
    /// The method whose path is dashed, because it may lie on another's.
    pub dashed: &'a str,
    /// True objects: name, x and y of the centre, radius, metres.
    pub objects: &'a [(&'a str, [f64; 2], f64)],
}

/// Draws the figure; metres, x to the right and y up, at equal scale.
pub fn trajectory_svg(view: &TopView<'_>) -> Result<String, FigureError> {
    let bounds = bounds(view)?;
    let mut svg = String::new();
    draw(view, bounds, &mut svg)
        .map_err(|error| FigureError::Draw { figure: FIGURE, reason: error.to_string() })?;
    Ok(svg)
}

fn xy(pose: &Pose) -> (f64, f64) {
    (pose.translation.x, pose.translation.y)
}

/// The square that holds everything: x from, x to, y from, y to.
fn bounds(view: &TopView<'_>) -> Result<[f64; 4], FigureError> {
    let truth = view.truth.iter().map(|pose| ("truth", xy(pose)));
    let estimates =
        view.estimates.iter().flat_map(|(name, poses)| poses.iter().map(|pose| (*name, xy(pose))));
    let objects = view.objects.iter().flat_map(|(name, [x, y], radius)| {
        [(*name, (x - radius, y - radius)), (*name, (x + radius, y + radius))]
    });
    let mut limits: Option<[f64; 4]> = None;
    for (name, (x, y)) in truth.chain(estimates).chain(objects) {
        if !(x.is_finite() && y.is_finite()) {
            return Err(FigureError::NotFinite { figure: FIGURE, of: name.to_owned() });
        }
        let [x0, x1, y0, y1] = limits.unwrap_or([x, x, y, y]);
        limits = Some([x0.min(x), x1.max(x), y0.min(y), y1.max(y)]);
    }
    let [x0, x1, y0, y1] = limits.ok_or(FigureError::Empty { figure: FIGURE })?;
    let half = ((x1 - x0).max(y1 - y0) * 0.55).max(0.1);
    let (x, y) = ((x0 + x1) / 2.0, (y0 + y1) / 2.0);
    Ok([x - half, x + half, y - half, y + half])
}

fn draw(
    view: &TopView<'_>,
    [x0, x1, y0, y1]: [f64; 4],
    svg: &mut String,
) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, (SIDE, SIDE)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(view.title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(FRAME / 2)
        .y_label_area_size(FRAME)
        .build_cartesian_2d(x0..x1, y0..y1)?;
    chart.configure_mesh().x_desc("x [m]").y_desc("y [m]").max_light_lines(1).draw()?;
    let gray = RGBColor(120, 120, 120);
    for (name, [x, y], radius) in view.objects {
        let outline = (0..=32).map(|i| {
            let angle = f64::from(i) / 32.0 * 2.0 * std::f64::consts::PI;
            (x + radius * libm::cos(angle), y + radius * libm::sin(angle))
        });
        chart.draw_series(std::iter::once(PathElement::new(outline.collect::<Vec<_>>(), gray)))?;
        chart.draw_series(std::iter::once(Text::new(
            (*name).to_owned(),
            (x + radius, y + radius),
            ("sans-serif", 12).into_font().color(&gray),
        )))?;
    }
    for (index, (name, poses)) in view.estimates.iter().enumerate() {
        let style = color(index).stroke_width(2);
        let path = poses.iter().map(xy);
        let drawn = if *name == view.dashed {
            chart.draw_series(DashedLineSeries::new(path, 8, 8, style))?
        } else {
            chart.draw_series(LineSeries::new(path, style))?
        };
        drawn.label(*name).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    if !view.truth.is_empty() {
        chart
            .draw_series(LineSeries::new(view.truth.iter().map(xy), BLACK.stroke_width(2)))?
            .label("truth")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], BLACK.stroke_width(2)));
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.8))
            .border_style(gray)
            .draw()?;
    }
    area.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(scale: f64) -> Vec<Pose> {
        (0..20).map(|i| Pose::translation(scale * f64::from(i), f64::from(i % 3), 0.0)).collect()
    }

    #[test]
    fn every_path_object_and_name_is_drawn_and_escaped() {
        let truth = path(1.0);
        let estimates = [("odometry", path(1.2)), ("a<b", path(0.9))];
        let objects = [("mug & bowl", [1.0, 1.0], 0.3)];
        let (title, dashed) = ("tabletop", "a<b");
        let view = TopView { title, truth: &truth, estimates: &estimates, dashed, objects: &objects };
        let svg = trajectory_svg(&view).unwrap();
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
        for text in ["tabletop", "odometry", "a&lt;b", "mug &amp; bowl", "truth", "x [m]"] {
            assert!(svg.contains(text), "{text} is missing");
        }
        let long_lines = svg.lines().filter(|l| l.starts_with("<polyline") && l.matches(',').count() == 20);
        assert_eq!(long_lines.count(), 2, "odometry and truth; the other estimate is dashed");
        let lines = |svg: &str| svg.lines().filter(|line| line.starts_with("<polyline")).count();
        let solid = trajectory_svg(&TopView { dashed: "", ..view.clone() }).unwrap();
        assert!(lines(&svg) > lines(&solid) + 10, "{} {}", lines(&svg), lines(&solid));
        assert_eq!(svg, trajectory_svg(&view).unwrap());
    }

    #[test]
    fn a_single_pose_has_a_figure_and_nothing_or_nan_has_none() {
        let one = [Pose::identity()];
        assert!(trajectory_svg(&TopView { truth: &one, ..TopView::default() }).is_ok());
        assert!(matches!(trajectory_svg(&TopView::default()), Err(FigureError::Empty { .. })));
        let nan = [("odometry", vec![Pose::translation(f64::NAN, 0.0, 0.0)])];
        let view = TopView { truth: &one, estimates: &nan, ..TopView::default() };
        assert!(matches!(trajectory_svg(&view), Err(FigureError::NotFinite { of, .. }) if of == "odometry"));
    }
}
