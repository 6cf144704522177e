//! `law.svg` and `law.png`: how an error falls with the number of composites that models were trained on.

use super::FigureError;
use super::canvas::Canvas;
use super::palette::color;
use super::svg::svg;
use plotters::coord::Shift;
use plotters::coord::ranged1d::SegmentValue;
use plotters::prelude::*;

const FIGURE: &str = "law";
/// Without the key at its right.
const SIZE: (u32, u32) = (660, 500);
/// Room for a letter of the key, and for its lines.
const LETTER: usize = 8;
const KEY: usize = 48;
/// Room above the highest point.
const ROOM: f64 = 1.08;

type Drawn = Result<(), Box<dyn std::error::Error>>;

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// Above all.
    pub title: String,
    /// Numbers of composites, from least to most: the places along the axis.
    pub composites: Vec<usize>,
    /// Lines of models.
    pub lines: Vec<Line>,
    /// An error that no composites lower: its name, and degrees.
    pub floor: Option<(String, f64)>,
}

/// Models that differ in their number of composites alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What else they were trained on.
    pub name: String,
    /// Whether a process stands beside the model: its line is dashed, in the colour of the line before it.
    pub is_process: bool,
    /// The place of each number of composites, and the error, degrees.
    pub points: Vec<(usize, f64)>,
}

/// The law as an SVG.
pub fn law_svg(law: &Law) -> Result<String, FigureError> {
    let top = top(law)?;
    svg(FIGURE, size(law), |area| draw(law, top, area))
}

/// The same as [`law_svg`], as a PNG.
pub fn law_png(law: &Law) -> Result<Vec<u8>, FigureError> {
    let top = top(law)?;
    let (width, height) = size(law);
    let mut canvas = Canvas::new(width, height);
    let drawn = draw(law, top, &(&mut canvas).into_drawing_area());
    drawn.map_err(|error| FigureError::Draw { figure: FIGURE, reason: error.to_string() })?;
    canvas.png()
}

/// With a key that has room for the longest name.
fn size(law: &Law) -> (u32, u32) {
    let names = law.lines.iter().map(key_text).chain(law.floor.iter().map(|(name, _)| name.as_str()));
    let longest = names.map(|name| name.chars().count()).max().unwrap_or(0);
    (SIZE.0 + u32::try_from(KEY + LETTER * longest).unwrap_or(SIZE.0), SIZE.1)
}

/// What the key calls a line.
fn key_text(line: &Line) -> &str {
    if line.is_process { "the same, with a process" } else { &line.name }
}

/// Where the axis of errors ends.
fn top(law: &Law) -> Result<f64, FigureError> {
    if law.composites.is_empty() || law.lines.is_empty() {
        return Err(FigureError::Empty { figure: FIGURE });
    }
    let mut highest = law.floor.as_ref().map_or(0.0, |(_, error)| *error);
    for line in &law.lines {
        for (_, error) in &line.points {
            if !error.is_finite() {
                return Err(FigureError::NotFinite { figure: FIGURE, of: line.name.clone() });
            }
            highest = error.max(highest);
        }
    }
    Ok(highest.max(1.0) * ROOM)
}

fn draw<B>(law: &Law, top: f64, area: &DrawingArea<B, Shift>) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let (drawn, key) = area.split_horizontally(SIZE.0);
    let mut chart = ChartBuilder::on(&drawn)
        .caption(&law.title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(44)
        .y_label_area_size(60)
        .build_cartesian_2d((0..law.composites.len() - 1).into_segmented(), 0.0..top)?;
    let told = |place: &SegmentValue<usize>| match place {
        SegmentValue::CenterOf(place) => {
            law.composites.get(*place).map_or_else(String::new, usize::to_string)
        }
        _ => String::new(),
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .max_light_lines(1)
        .x_labels(law.composites.len())
        .x_label_formatter(&told)
        .x_desc("composites among the objects trained on")
        .y_desc("median error of the azimuth [deg]")
        .y_label_formatter(&|error| format!("{error:.0}"))
        .label_style(("sans-serif", 14))
        .draw()?;
    let mut colored = 0;
    for (index, line) in law.lines.iter().enumerate() {
        colored += usize::from(index > 0 && !line.is_process);
        let style = color(colored).stroke_width(2);
        let points = line.points.iter().map(|(place, error)| (SegmentValue::CenterOf(*place), *error));
        let [begin, end] = key_line(index);
        match line.is_process {
            false => {
                chart.draw_series(LineSeries::new(points.clone(), style))?;
                key.draw(&PathElement::new([begin, end], style))?;
            }
            true => {
                let points: Vec<_> = points.clone().collect();
                chart.draw_series(DashedLineSeries::new(points, 6, 4, style))?;
                for dash in 0..3 {
                    let x = begin.0 + 10 * dash;
                    key.draw(&PathElement::new([(x, begin.1), (x + 6, end.1)], style))?;
                }
            }
        }
        key.draw(&key_name(index, key_text(line)))?;
        chart.draw_series(points.map(|point| Circle::new(point, 3, style.filled())))?;
    }
    if let Some((name, error)) = &law.floor {
        let style = BLACK.mix(0.7).stroke_width(2);
        let ends = [(SegmentValue::Exact(0), *error), (SegmentValue::Last, *error)];
        chart.draw_series(LineSeries::new(ends, style))?;
        key.draw(&PathElement::new(key_line(law.lines.len()), style))?;
        key.draw(&key_name(law.lines.len(), name))?;
    }
    Ok(area.present()?)
}

/// Both ends of the line of that entry of the key, pixels.
fn key_line(entry: usize) -> [(i32, i32); 2] {
    let y = 48 + 20 * i32::try_from(entry).unwrap_or(i32::MAX / 40);
    [(0, y), (26, y)]
}

/// Its name.
fn key_name(entry: usize, name: &str) -> Text<'_, (i32, i32), &str> {
    let [_, (x, y)] = key_line(entry);
    Text::new(name, (x + 8, y - 7), ("sans-serif", 14).into_font())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> Law {
        let line = |name: &str, is_process, points: &[(usize, f64)]| Line {
            name: name.to_owned(),
            is_process,
            points: points.to_vec(),
        };
        Law {
            title: "law".to_owned(),
            composites: vec![0, 250, 4000],
            lines: vec![
                line("families", false, &[(0, 60.0), (1, 50.0), (2, 40.0)]),
                line("with a process", true, &[(0, 50.0), (2, 30.0)]),
                line("alone <b>", false, &[(1, 55.0), (2, 42.0)]),
            ],
            floor: Some(("pixels".to_owned(), 29.0)),
        }
    }

    #[test]
    fn every_line_has_its_points_and_its_name() {
        let svg = law_svg(&law()).unwrap();
        for text in ["law", "250", "4000", "families", "with a process", "alone &lt;b&gt;", "pixels", "[deg]"]
        {
            assert!(svg.contains(text), "{text} is missing: {svg}");
        }
        assert_eq!(svg.matches("<circle").count(), 7);
        assert_eq!(svg, law_svg(&law()).unwrap());
        assert_eq!(law_png(&law()).unwrap(), law_png(&law()).unwrap());
    }

    #[test]
    fn nothing_and_nan_are_not_drawn() {
        let empty = Law { lines: Vec::new(), ..law() };
        assert!(matches!(law_svg(&empty), Err(FigureError::Empty { .. })));
        let mut broken = law();
        broken.lines[0].points[1].1 = f64::NAN;
        assert!(matches!(law_png(&broken), Err(FigureError::NotFinite { .. })));
    }
}
