//! `map.svg` and `map.png`: what each row changes of the reference's error, panel by panel along one field.

use super::FigureError;
use super::canvas::Canvas;
use super::palette::color;
use super::svg::svg;
use crate::result::bootstrap::bca_interval;
use crate::result::metric::Metric;
use crate::result::results_file::Results;
use crate::result::table::Table;
use crate::scene_file::map::MapFile;
use crate::scene_file::row::Row;
use crate::scene_file::vary::told;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const FIGURE: &str = "map";
/// Size of a panel, and height of a line of the key above all.
const PANEL: (u32, u32) = (420, 300);
const KEY_LINE: u32 = 24;
/// Most panels in a line.
const ABREAST: usize = 4;
/// Where scales begin, percent.
const FROM: f64 = -100.0;
/// Where they may end: the first that no mean is above. What lies beyond is drawn at the edge.
const TO: [f64; 4] = [50.0, 100.0, 200.0, 400.0];
/// Width of a row's place in the key.
const KEY_WIDTH: usize = 205;

type Drawn = Result<(), Box<dyn std::error::Error>>;

/// What a row changes at one value: the mean in percent of the reference's mean ATE, and its interval of 95%.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    at: f64,
    change: f64,
    interval: (f64, f64),
}

/// A panel as it is drawn.
struct Drawing {
    name: String,
    title: String,
    /// Each row's points, by its place in the key.
    rows: Vec<(usize, Vec<Point>)>,
}

/// All panels of a map, as an SVG.
pub fn map_svg(map: &MapFile, results: &Results) -> Result<String, FigureError> {
    Figure::of(map, results)?.svg()
}

/// The same as [`map_svg`], as a PNG.
pub fn map_png(map: &MapFile, results: &Results) -> Result<Vec<u8>, FigureError> {
    Figure::of(map, results)?.png()
}

/// The panels and rows of the map's summary, as an SVG; `None` where it has none.
pub fn map_summary_svg(map: &MapFile, results: &Results) -> Result<Option<String>, FigureError> {
    Figure::of_summary(map, results)?.map(|figure| figure.svg()).transpose()
}

/// The same as [`map_summary_svg`], as a PNG.
pub fn map_summary_png(map: &MapFile, results: &Results) -> Result<Option<Vec<u8>>, FigureError> {
    Figure::of_summary(map, results)?.map(|figure| figure.png()).transpose()
}

/// Panels with the key above them.
struct Figure<'a> {
    map: &'a MapFile,
    /// The rows that are shown, each with its place among all, which decides its colour.
    key: Vec<(usize, String)>,
    drawings: Vec<Drawing>,
}

impl<'a> Figure<'a> {
    /// Where the scale of all panels ends, percent.
    fn to(&self) -> f64 {
        let rows = self.drawings.iter().flat_map(|drawing| &drawing.rows);
        let most = rows.flat_map(|(_, points)| points).map(|point| point.change).fold(0.0, f64::max);
        TO.into_iter().find(|to| most <= *to).unwrap_or(TO[TO.len() - 1])
    }

    fn of(map: &'a MapFile, results: &Results) -> Result<Self, FigureError> {
        let (names, drawings) = drawings(map, results)?;
        Ok(Self { map, key: names.into_iter().enumerate().collect(), drawings })
    }

    fn of_summary(map: &'a MapFile, results: &Results) -> Result<Option<Self>, FigureError> {
        let Some(summary) = &map.summary else { return Ok(None) };
        let mut figure = Self::of(map, results)?;
        figure.key.retain(|(_, name)| summary.rows.contains(name));
        figure.drawings.retain(|drawing| summary.panels.contains(&drawing.name));
        for drawing in &mut figure.drawings {
            drawing.rows.retain(|(place, _)| figure.key.iter().any(|(shown, _)| shown == place));
        }
        Ok(Some(figure))
    }

    fn size(&self) -> (u32, u32) {
        let width = PANEL.0 * self.drawings.len().min(ABREAST) as u32;
        let height = PANEL.1 * self.drawings.len().div_ceil(ABREAST) as u32;
        (width, key_height(width, self.key.len()) + height)
    }

    fn svg(&self) -> Result<String, FigureError> {
        svg(FIGURE, self.size(), |area| draw(self, area))
    }

    fn png(&self) -> Result<Vec<u8>, FigureError> {
        let (width, height) = self.size();
        let mut canvas = Canvas::new(width, height);
        let drawn = draw(self, &(&mut canvas).into_drawing_area());
        drawn.map_err(|error| FigureError::Draw { figure: FIGURE, reason: error.to_string() })?;
        canvas.png()
    }
}

fn abreast(width: u32) -> usize {
    (width as usize / KEY_WIDTH).max(1)
}

fn key_height(width: u32, rows: usize) -> u32 {
    KEY_LINE * rows.div_ceil(abreast(width)) as u32 + 12
}

/// The rows of all panels by their first appearance, and what to draw of each panel.
fn drawings(map: &MapFile, results: &Results) -> Result<(Vec<String>, Vec<Drawing>), FigureError> {
    let mut names: Vec<String> = Vec::new();
    let mut drawings = Vec::new();
    for panel in &map.panels {
        let tables: Vec<&Table> =
            map.across.over.iter().filter_map(|value| results.table(&map.cell_name(panel, value))).collect();
        let Some(reference) = tables.first().and_then(|table| table.reference()) else { continue };
        let mut rows = Vec::new();
        let left_out = [Row::Odometry, Row::Geometric, Row::Uninformative].map(|row| row.to_string());
        for method in tables[0].methods().iter().filter(|method| !left_out.contains(method)) {
            let place = names.iter().position(|name| name == method).unwrap_or_else(|| {
                names.push(method.clone());
                names.len() - 1
            });
            let points = tables.iter().enumerate().filter_map(|(i, table)| point(i, table, method));
            rows.push((place, points.collect()));
        }
        let means: Vec<f64> = tables
            .iter()
            .filter_map(|table| Some(table.cell(reference, Metric::Ate).mean?.mean * 100.0))
            .collect();
        let low = means.iter().copied().fold(f64::INFINITY, f64::min);
        let high = means.iter().copied().fold(0.0, f64::max);
        let range = if means.is_empty() { String::new() } else { format!(" ({low:.0}-{high:.0} cm)") };
        let title = format!("{}{range}", panel.title);
        drawings.push(Drawing { name: panel.name.clone(), title, rows });
    }
    match drawings.is_empty() {
        true => Err(FigureError::Empty { figure: FIGURE }),
        false => Ok((names, drawings)),
    }
}

fn point(index: usize, table: &Table, method: &str) -> Option<Point> {
    let paired = table.paired(method, Metric::Ate)?;
    let reference = paired.reference_mean()?;
    let percent = |value: f64| 100.0 * value / reference;
    let mean = paired.mean()?.mean;
    let differences: Vec<f64> = paired.sorted().iter().map(|(_, difference)| *difference).collect();
    let (low, high) = bca_interval(&differences).unwrap_or((mean, mean));
    let [change, low, high] = [mean, low, high].map(percent);
    change.is_finite().then_some(Point { at: index as f64, change, interval: (low, high) })
}

fn draw<B>(figure: &Figure<'_>, area: &DrawingArea<B, Shift>) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let Figure { map, key, drawings } = figure;
    area.fill(&WHITE)?;
    let (above, panels) = area.split_vertically(key_height(area.dim_in_pixel().0, key.len()));
    draw_key(key, &above)?;
    let lines = drawings.len().div_ceil(ABREAST);
    let places = panels.split_evenly((lines, drawings.len().min(ABREAST)));
    let to = figure.to();
    for (drawing, place) in drawings.iter().zip(&places) {
        draw_panel(map, drawing, (key.len(), to), place)?;
    }
    Ok(area.present()?)
}

fn draw_key<B>(key: &[(usize, String)], area: &DrawingArea<B, Shift>) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let style = ("sans-serif", 15).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let abreast = abreast(area.dim_in_pixel().0);
    for (i, (place, name)) in key.iter().enumerate() {
        let (x, y) =
            (20 + (KEY_WIDTH * (i % abreast)) as i32, 16 + (KEY_LINE as usize * (i / abreast)) as i32);
        area.draw(&PathElement::new([(x, y), (x + 26, y)], color(*place).stroke_width(3)))?;
        area.draw(&Circle::new((x + 13, y), 4, color(*place).filled()))?;
        area.draw(&Text::new(name.clone(), (x + 34, y), style.clone()))?;
    }
    Ok(())
}

fn draw_panel<B>(
    map: &MapFile,
    drawing: &Drawing,
    (rows, to): (usize, f64),
    area: &DrawingArea<B, Shift>,
) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let values = &map.across.over;
    let last = values.len() as f64 - 0.5;
    let mut chart = ChartBuilder::on(area)
        .caption(&drawing.title, ("sans-serif", 16))
        .margin(8)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(-0.5..last, FROM..to)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(0)
        .max_light_lines(1)
        .y_desc("change of the ATE [%]")
        .y_label_formatter(&|percent| format!("{:.0}", percent + 0.0))
        .draw()?;
    let label = ("sans-serif", 14).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Top));
    let (width, height) = chart.plotting_area().dim_in_pixel();
    let origin = chart.plotting_area().get_base_pixel();
    for (i, value) in values.iter().enumerate() {
        let x = origin.0 + (f64::from(width) * (i as f64 + 0.5) / values.len() as f64) as i32
            - area.get_base_pixel().0;
        let y = origin.1 + height as i32 - area.get_base_pixel().1;
        area.draw(&Text::new(told(value), (x, y + 4), label.clone()))?;
        if i == values.len() / 2 {
            area.draw(&Text::new(map.across.label().to_owned(), (x, y + 20), label.clone()))?;
        }
    }
    chart.draw_series(LineSeries::new([(-0.5, 0.0), (last, 0.0)], BLACK.stroke_width(1)))?;
    for (i, (place, points)) in drawing.rows.iter().enumerate() {
        let aside = 0.5 * ((i as f64 + 0.5) / rows as f64 - 0.5);
        let (style, at) = (color(*place), |point: &Point| point.at + aside);
        let shown = |percent: f64| percent.clamp(FROM, to);
        let line = points.iter().map(|point| (at(point), shown(point.change)));
        chart.draw_series(LineSeries::new(line, style.stroke_width(2)))?;
        for point in points {
            let (low, high) = point.interval;
            let bar = [(at(point), shown(low)), (at(point), shown(high))];
            chart.draw_series([PathElement::new(bar, style.stroke_width(1))])?;
            chart.draw_series([Circle::new((at(point), shown(point.change)), 3, style.filled())])?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::table::tests::run;
    use crate::scene_file::parse;
    use std::path::Path;
    use vantage_dataset::Seed;

    fn made() -> (MapFile, Results) {
        let text = "version: 1\nname: m\npurpose: p\nscene: s\nacross: { field: robot.laps, over: [1, 2] }\n\
                    estimates: [{ rows: [geometric] }]\n\
                    panels: [{ name: a, title: a<b }, { name: b, title: Other light }]\n\
                    summary: { panels: [b], rows: [mine] }\n";
        let map: MapFile = parse(text, Path::new("m")).unwrap();
        let seeds: Vec<Seed> = (0..4).map(Seed).collect();
        let mut tables = Vec::new();
        for panel in &map.panels {
            for value in &map.across.over {
                let runs = seeds.iter().flat_map(|seed| {
                    let ate = 0.5 + 0.01 * seed.0 as f64;
                    ["odometry", "geometric", "mine"].map(|row| {
                        run(row, seed.0, &[(Metric::Ate, if row == "mine" { 0.8 * ate } else { ate })])
                    })
                });
                let rows = ["odometry", "geometric", "mine"];
                let name = map.cell_name(panel, value);
                tables.push(
                    Table::new(&name, &rows, Some("geometric"), &[Metric::Ate], &seeds, runs.collect())
                        .unwrap(),
                );
            }
        }
        (map, Results::new("m", "hash", tables))
    }

    #[test]
    fn every_panel_has_its_title_its_values_and_a_line_for_each_row_that_may_gain() {
        let (map, results) = made();
        let svg = map_svg(&map, &results).unwrap();
        for text in ["a&lt;b (52-52 cm)", "Other light", "mine", "laps", "change of the ATE [%]"] {
            assert!(svg.contains(text), "{text} is missing: {svg}");
        }
        assert!(!svg.contains("odometry"), "{svg}");
        // In each panel a point a value; in the key one.
        assert_eq!(svg.matches("<circle").count(), 2 * 2 + 1);
        assert_eq!(svg, map_svg(&map, &results).unwrap());
        let summary = map_summary_svg(&map, &results).unwrap().unwrap();
        assert!(summary.contains("Other light") && !summary.contains("a&lt;b"), "{summary}");
        let small = map_summary_png(&map, &results).unwrap().unwrap();
        assert!(small.len() < map_png(&map, &results).unwrap().len());
        let none = MapFile { summary: None, ..map.clone() };
        assert_eq!(map_summary_png(&none, &results).unwrap(), None);
        assert_eq!(map_summary_svg(&none, &results).unwrap(), None);
        assert_eq!(map_png(&map, &results).unwrap(), map_png(&map, &results).unwrap());
    }

    #[test]
    fn a_change_is_in_percent_of_the_reference() {
        let (map, results) = made();
        let (_, drawings) = drawings(&map, &results).unwrap();
        let (_, points) = &drawings[0].rows[0];
        assert_eq!(points.len(), 2);
        assert!((points[1].change + 20.0).abs() < 1e-9 && points[1].at == 1.0, "{points:?}");
        assert!(points[1].interval.0 <= points[1].change && points[1].change <= points[1].interval.1);
        let none = Results::new("m", "hash", Vec::new());
        assert_eq!(Figure::of(&map, &results).unwrap().to(), 50.0);
        let mut worse = Figure::of(&map, &results).unwrap();
        worse.drawings[1].rows[0].1[0].change = 120.0;
        assert_eq!(worse.to(), 200.0);
        worse.drawings[1].rows[0].1[0].change = 1e4;
        assert_eq!(worse.to(), 400.0);
        assert!(matches!(map_svg(&map, &none), Err(FigureError::Empty { .. })));
    }
}
