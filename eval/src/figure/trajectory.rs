//! `trajectory.svg`: the world from above, with the true path, every estimate, and the objects.

use super::FigureError;
use super::palette::color;
use super::svg::{Area, Drawn, svg};
use nalgebra::{Matrix2, Matrix6};
use plotters::prelude::*;
use std::f64::consts::PI;
use vantage_dataset::Pose;

const FIGURE: &str = "trajectory";
/// Largest plot, pixels.
const LARGEST: (f64, f64) = (820.0, 760.0);
/// Smallest plot, pixels.
const SMALLEST: (f64, f64) = (520.0, 160.0);
/// Pixels that the labels of the axes take.
const LABELS: (u32, u32) = (60, 45);
const MARGIN: u32 = 15;
/// Left of the axes' labels.
const EDGE: u32 = 10;
/// Height of a line of the title and of the key, pixels.
const LINE: i32 = 22;
/// Width of a letter of the key, pixels.
const LETTER: i32 = 8;

/// What the figure shows, all in the true world frame.
#[derive(Clone, Debug, Default)]
pub struct TopView<'a> {
    /// Title.
    pub title: &'a str,
    /// The true robot poses.
    pub truth: &'a [Pose],
    /// Estimated robot poses by method, aligned as the scores align them.
    pub estimates: &'a [(&'a str, Vec<Pose>)],
    /// 95% regions of estimated positions, closed outlines, metres, each with the number of its estimate.
    pub regions: &'a [(usize, Vec<(f64, f64)>)],
    /// True objects: name, x and y of the centre, radius, metres.
    pub objects: &'a [(&'a str, [f64; 2], f64)],
}

/// Draws the figure; metres, x to the right and y up, at equal scale, with a point where the robot starts and crosses where paths end.
pub fn trajectory_svg(view: &TopView<'_>) -> Result<String, FigureError> {
    let frame = Frame::around(view)?;
    let width = EDGE + LABELS.0 + frame.size.0 as u32 + MARGIN;
    let names: Vec<&str> = view.estimates.iter().map(|(name, _)| *name).collect();
    let key = places(&names, width as i32);
    let head = key.last().map_or(0, |(_, (_, y))| *y) + LINE;
    let height = head as u32 + frame.size.1 as u32 + LABELS.1;
    svg(FIGURE, (width, height), |area| {
        let (above, below) = area.split_vertically(head);
        above.draw(&Text::new(view.title.to_owned(), (MARGIN as i32, 8), ("sans-serif", 18)))?;
        draw_key(&above, &key)?;
        draw(view, &frame, &below)
    })
}

/// Corners of an outline.
const CORNERS: usize = 48;
/// Squared radius of a region of two numbers that holds 95%: the chi-square law's.
const REGION: f64 = 5.991;

/// The outline of the 95% region of a pose's position in the plane, under the covariance of its right perturbation, rotation first; `None`
/// where that is not positive definite.
pub fn region(world_from_robot: &Pose, covariance: &Matrix6<f64>) -> Option<Vec<(f64, f64)>> {
    let turn = world_from_robot.rotation.to_rotation_matrix().into_inner();
    let of_position = turn * covariance.fixed_view::<3, 3>(3, 3) * turn.transpose();
    let root = Matrix2::from(of_position.fixed_view::<2, 2>(0, 0)).cholesky()?.l() * REGION.sqrt();
    let (x, y) = xy(world_from_robot);
    let corner = |i: usize| {
        let (sin, cos) = libm::sincos(2.0 * PI * i as f64 / CORNERS as f64);
        (x + root[(0, 0)] * cos, y + root[(1, 0)] * cos + root[(1, 1)] * sin)
    };
    let outline: Vec<(f64, f64)> = (0..=CORNERS).map(corner).collect();
    outline.iter().all(|(x, y)| x.is_finite() && y.is_finite()).then_some(outline)
}

fn xy(pose: &Pose) -> (f64, f64) {
    (pose.translation.x, pose.translation.y)
}

/// What the plot shows of the world, and how large.
struct Frame {
    /// Pixels a metre.
    scale: f64,
    /// Pixels.
    size: (f64, f64),
    middle: (f64, f64),
}

impl Frame {
    /// As large as the plot may be with all in it.
    fn around(view: &TopView<'_>) -> Result<Self, FigureError> {
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
        let (width, height) = ((1.1 * (x1 - x0)).max(0.2), (1.1 * (y1 - y0)).max(0.2));
        let scale = (LARGEST.0 / width).min(LARGEST.1 / height);
        let size = ((scale * width).max(SMALLEST.0), (scale * height).max(SMALLEST.1));
        Ok(Self { scale, size, middle: ((x0 + x1) / 2.0, (y0 + y1) / 2.0) })
    }

    /// From and to, metres.
    fn range(&self, middle: f64, size: f64) -> std::ops::Range<f64> {
        let half = size / self.scale / 2.0;
        middle - half..middle + half
    }
}

fn draw(view: &TopView<'_>, frame: &Frame, area: &Area<'_>) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .margin_left(EDGE)
        .margin_right(MARGIN)
        .x_label_area_size(LABELS.1)
        .y_label_area_size(LABELS.0)
        .build_cartesian_2d(
            frame.range(frame.middle.0, frame.size.0),
            frame.range(frame.middle.1, frame.size.1),
        )?;
    chart.configure_mesh().x_desc("x [m]").y_desc("y [m]").max_light_lines(1).draw()?;
    let gray = RGBColor(120, 120, 120);
    for (name, [x, y], radius) in view.objects {
        let pixels = (radius * frame.scale).round().max(1.0) as i32;
        chart.draw_series([Circle::new((*x, *y), pixels, gray)])?;
        let style = ("sans-serif", 12).into_font().color(&gray);
        chart.draw_series([Text::new((*name).to_owned(), (x + radius, y + radius), style)])?;
    }
    let truth = || view.truth.iter().map(xy);
    chart.draw_series(LineSeries::new(truth(), truth_style()))?;
    chart.draw_series(truth().take(1).map(|start| Circle::new(start, 5, BLACK.filled())))?;
    for (index, (_, poses)) in view.estimates.iter().enumerate() {
        let style = color(index).stroke_width(2);
        chart.draw_series(LineSeries::new(poses.iter().map(xy), style))?;
        chart.draw_series(poses.last().map(|end| Cross::new(xy(end), 5, style)))?;
    }
    for (index, outline) in view.regions {
        chart.draw_series(LineSeries::new(outline.iter().copied(), color(*index).stroke_width(1)))?;
    }
    chart.draw_series(truth().next_back().map(|end| Cross::new(end, 5, BLACK.stroke_width(2))))?;
    Ok(())
}

/// Broad and pale: what lies on it is seen.
fn truth_style() -> ShapeStyle {
    BLACK.mix(0.3).stroke_width(6)
}

/// A word of the key.
enum Word<'a> {
    Truth,
    Start,
    End,
    Estimate(usize, &'a str),
}

impl Word<'_> {
    fn text(&self) -> &str {
        match self {
            Self::Truth => "truth",
            Self::Start => "start",
            Self::End => "end",
            Self::Estimate(_, name) => name,
        }
    }
}

/// Where each word of the key stands below the title, in as many lines as they need.
fn places<'a>(names: &[&'a str], width: i32) -> Vec<(Word<'a>, (i32, i32))> {
    let estimates = names.iter().enumerate().map(|(index, name)| Word::Estimate(index, name));
    let (mut x, mut y) = (MARGIN as i32, 8 + LINE);
    let mut placed = Vec::new();
    for word in [Word::Truth].into_iter().chain(estimates).chain([Word::Start, Word::End]) {
        let taken = 40 + LETTER * word.text().chars().count() as i32;
        if x + taken > width && x > MARGIN as i32 {
            (x, y) = (MARGIN as i32, y + LINE);
        }
        placed.push((word, (x, y)));
        x += taken;
    }
    placed
}

fn draw_key(area: &Area<'_>, key: &[(Word<'_>, (i32, i32))]) -> Drawn {
    for (word, (x, y)) in key {
        let (left, middle, right) = ((*x, y + 8), (x + 10, y + 8), (x + 20, y + 8));
        match word {
            Word::Truth => area.draw(&PathElement::new([left, right], truth_style()))?,
            Word::Start => area.draw(&Circle::new(middle, 5, BLACK.filled()))?,
            Word::End => area.draw(&Cross::new(middle, 5, BLACK.stroke_width(2)))?,
            Word::Estimate(index, _) => {
                area.draw(&PathElement::new([left, right], color(*index).stroke_width(2)))?;
            }
        }
        area.draw(&Text::new(word.text().to_owned(), (x + 26, *y), ("sans-serif", 14)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(scale: f64) -> Vec<Pose> {
        (0..20).map(|i| Pose::translation(scale * f64::from(i), f64::from(i % 3), 0.0)).collect()
    }

    fn size(svg: &str) -> (f64, f64) {
        let number = |name: &str| {
            let start = svg.find(name).unwrap() + name.len();
            svg[start..].split('"').next().unwrap().parse().unwrap()
        };
        (number("<svg width=\""), number(" height=\""))
    }

    #[test]
    fn every_path_object_and_name_is_drawn_and_escaped() {
        let truth = path(1.0);
        let estimates = [("odometry", path(1.2)), ("a<b", path(0.9))];
        let objects = [("mug & bowl", [1.0, 1.0], 0.3)];
        let view = TopView {
            title: "tabletop",
            truth: &truth,
            estimates: &estimates,
            regions: &[],
            objects: &objects,
        };
        let svg = trajectory_svg(&view).unwrap();
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
        for text in ["tabletop", "odometry", "a&lt;b", "mug &amp; bowl", "truth", "start", "end", "x [m]"] {
            assert!(svg.contains(text), "{text} is missing");
        }
        let long_lines = svg.lines().filter(|l| l.starts_with("<polyline") && l.matches(',').count() == 20);
        assert_eq!(long_lines.count(), 3, "odometry, the other estimate and truth");
        // The object, and the start in the plot and in the key.
        assert_eq!(svg.matches("<circle").count(), 3, "{svg}");
        assert_eq!(svg, trajectory_svg(&view).unwrap());
    }

    #[test]
    fn a_region_is_turned_with_the_robot_and_holds_two_and_a_half_deviations() {
        let mut covariance = Matrix6::identity() * 1e-6;
        covariance[(3, 3)] = 0.04;
        let turned = Pose::new([1.0, 2.0, 0.0].into(), [0.0, 0.0, PI / 2.0].into());
        let outline = region(&turned, &covariance).unwrap();
        let reach = |of: fn(&(f64, f64)) -> f64| outline.iter().map(of).fold(f64::MIN, f64::max);
        assert!((reach(|p| p.1) - (2.0 + 0.2 * REGION.sqrt())).abs() < 1e-3, "along the robot's x");
        assert!(reach(|p| p.0) < 1.01);
        assert!(region(&turned, &Matrix6::zeros()).is_none());
        let view = TopView { regions: &[(0, outline)], truth: &path(1.0), ..TopView::default() };
        assert_eq!(trajectory_svg(&view).unwrap().matches("<polyline").count(), {
            let bare = TopView { truth: &path(1.0), ..TopView::default() };
            trajectory_svg(&bare).unwrap().matches("<polyline").count() + 1
        });
    }

    #[test]
    fn the_picture_has_the_shape_of_what_it_shows() {
        let along = |x: f64, y: f64| -> Vec<Pose> {
            (0..9).map(|i| Pose::translation(x * f64::from(i), y * f64::from(i), 0.0)).collect()
        };
        let of =
            |path: &[Pose]| size(&trajectory_svg(&TopView { truth: path, ..TopView::default() }).unwrap());
        let (straight, steep, square) = (of(&along(3.0, 0.01)), of(&along(0.01, 3.0)), of(&along(1.0, 1.0)));
        assert!(straight.0 > 3.0 * straight.1, "{straight:?}");
        assert!(steep.1 > 1.3 * steep.0, "{steep:?}");
        assert!((0.8..1.25).contains(&(square.0 / square.1)), "{square:?}");
    }

    #[test]
    fn a_key_that_is_too_long_goes_on_in_the_next_line() {
        let lines = |names: &[&str]| places(names, 400).iter().map(|(_, (_, y))| *y).max();
        let name = "a_long_name_of_an_estimator";
        assert!(lines(&[name; 3]) > lines(&[name]));
        assert!(
            places(&[name; 3], 400)
                .iter()
                .all(|(word, (x, _))| { x + 26 + LETTER * word.text().chars().count() as i32 <= 400 })
        );
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
