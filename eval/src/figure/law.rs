//! `law.svg` and `law.png`: how an error falls with the number of composites that models were trained on.

use super::FigureError;
use super::canvas::Canvas;
use super::palette::color;
use super::svg::svg;
use plotters::coord::Shift;
use plotters::coord::ranged1d::SegmentValue;
use plotters::prelude::*;

const FIGURE: &str = "law";
/// Of one panel alone, and of each of several.
const WIDTHS: [u32; 2] = [660, 420];
const HEIGHT: u32 = 500;
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
    /// Side by side, with the same scale of errors, and one key for all.
    pub panels: Vec<Panel>,
    /// An error that no composites lower: its name, and degrees.
    pub floor: Option<(String, f64)>,
}

/// Models that a setting has in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The setting; empty where no setting differs.
    pub name: String,
    /// Lines of models.
    pub lines: Vec<Line>,
}

/// Models that differ in their number of composites alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What else they were trained on: lines of one name have one colour.
    pub name: String,
    /// Whether a process stands beside the model: its line is dashed.
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

/// An entry of the key.
enum Entry<'l> {
    Colored(&'l str),
    Process,
    Floor(&'l str),
}

impl<'l> Entry<'l> {
    /// Each name once, in the order of the lines.
    fn all(law: &'l Law) -> Vec<Self> {
        let process = lines(law).any(|line| line.is_process).then_some(Entry::Process);
        let floor = law.floor.iter().map(|(name, _)| Entry::Floor(name));
        names(law).into_iter().map(Entry::Colored).chain(process).chain(floor).collect()
    }

    fn text(&self) -> &'l str {
        match self {
            Entry::Colored(name) | Entry::Floor(name) => name,
            Entry::Process => "with a process",
        }
    }
}

fn lines(law: &Law) -> impl Iterator<Item = &Line> {
    law.panels.iter().flat_map(|panel| &panel.lines)
}

/// Of lines, each once: their place is that of their colour.
fn names(law: &Law) -> Vec<&str> {
    let mut names = Vec::new();
    for line in lines(law) {
        if !names.contains(&&*line.name) {
            names.push(&*line.name);
        }
    }
    names
}

fn panel_width(law: &Law) -> u32 {
    WIDTHS[usize::from(law.panels.len() > 1)]
}

fn panels_width(law: &Law) -> u32 {
    panel_width(law) * u32::try_from(law.panels.len()).unwrap_or(1)
}

/// With a key that has room for the longest name.
fn size(law: &Law) -> (u32, u32) {
    let longest = Entry::all(law).iter().map(|entry| entry.text().chars().count()).max().unwrap_or(0);
    (panels_width(law) + u32::try_from(KEY + LETTER * longest).unwrap_or(0), HEIGHT)
}

/// Where the axis of errors ends.
fn top(law: &Law) -> Result<f64, FigureError> {
    if law.composites.is_empty() || lines(law).next().is_none() {
        return Err(FigureError::Empty { figure: FIGURE });
    }
    let mut highest = law.floor.as_ref().map_or(0.0, |(_, error)| *error);
    for line in lines(law) {
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
    let (drawn, key) = area.split_horizontally(panels_width(law));
    let drawn = drawn.titled(&law.title, ("sans-serif", 18))?;
    for (place, panel) in drawn.split_evenly((1, law.panels.len())).iter().zip(&law.panels) {
        draw_panel(law, panel, top, place)?;
    }
    for (place, entry) in Entry::all(law).iter().enumerate() {
        let [begin, end] = key_line(place);
        match entry {
            Entry::Colored(_) => key.draw(&PathElement::new([begin, end], color(place).stroke_width(2)))?,
            Entry::Process => {
                for x in [0, 10, 20] {
                    let dash = [(begin.0 + x, begin.1), (begin.0 + x + 6, end.1)];
                    key.draw(&PathElement::new(dash, BLACK.stroke_width(2)))?;
                }
            }
            Entry::Floor(_) => key.draw(&PathElement::new([begin, end], floor_style()))?,
        }
        key.draw(&Text::new(entry.text(), (end.0 + 8, end.1 - 7), ("sans-serif", 14).into_font()))?;
    }
    Ok(area.present()?)
}

fn draw_panel<B>(law: &Law, panel: &Panel, top: f64, area: &DrawingArea<B, Shift>) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.name, ("sans-serif", 14))
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
    let names = names(law);
    for line in &panel.lines {
        let colored = names.iter().position(|name| *name == line.name).unwrap_or(0);
        let style = color(colored).stroke_width(2);
        let points: Vec<_> =
            line.points.iter().map(|(place, error)| (SegmentValue::CenterOf(*place), *error)).collect();
        match line.is_process {
            false => chart.draw_series(LineSeries::new(points.clone(), style))?,
            true => chart.draw_series(DashedLineSeries::new(points.clone(), 6, 4, style))?,
        };
        chart.draw_series(points.into_iter().map(|point| Circle::new(point, 3, style.filled())))?;
    }
    if let Some((_, error)) = &law.floor {
        let ends = [(SegmentValue::Exact(0), *error), (SegmentValue::Last, *error)];
        chart.draw_series(LineSeries::new(ends, floor_style()))?;
    }
    Ok(())
}

fn floor_style() -> ShapeStyle {
    BLACK.mix(0.7).stroke_width(2)
}

/// Both ends of the line of that entry of the key, pixels.
fn key_line(entry: usize) -> [(i32, i32); 2] {
    let y = 48 + 20 * i32::try_from(entry).unwrap_or(i32::MAX / 40);
    [(0, y), (26, y)]
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
            panels: vec![
                Panel {
                    name: "frames none".to_owned(),
                    lines: vec![
                        line("families", false, &[(0, 60.0), (1, 50.0), (2, 40.0)]),
                        line("families", true, &[(0, 50.0), (2, 30.0)]),
                    ],
                },
                Panel {
                    name: "frames random".to_owned(),
                    lines: vec![
                        line("alone <b>", false, &[(1, 55.0), (2, 42.0)]),
                        line("families", false, &[(0, 65.0), (1, 64.0)]),
                    ],
                },
            ],
            floor: Some(("pixels".to_owned(), 29.0)),
        }
    }

    #[test]
    fn every_line_has_its_points_and_its_name() {
        let svg = law_svg(&law()).unwrap();
        for text in
            ["law", "250", "4000", "with a process", "alone &lt;b&gt;", "pixels", "[deg]", "frames none"]
        {
            assert!(svg.contains(text), "{text} is missing: {svg}");
        }
        assert_eq!(svg.matches("\nfamilies\n").count(), 1, "once in the key, whatever the panels");
        assert_eq!(svg.matches("<circle").count(), 9);
        let one = Law { panels: law().panels[..1].to_vec(), ..law() };
        assert!(size(&one).0 < size(&law()).0);
        assert_eq!(svg, law_svg(&law()).unwrap());
        assert_eq!(law_png(&law()).unwrap(), law_png(&law()).unwrap());
    }

    #[test]
    fn nothing_and_nan_are_not_drawn() {
        let empty = Law { panels: Vec::new(), ..law() };
        assert!(matches!(law_svg(&empty), Err(FigureError::Empty { .. })));
        let mut broken = law();
        broken.panels[0].lines[0].points[1].1 = f64::NAN;
        assert!(matches!(law_png(&broken), Err(FigureError::NotFinite { .. })));
    }
}
