//! The likelihood of a crop over the sphere of viewpoints: azimuth by elevation, the truth marked.

use super::FigureError;
use super::canvas::Canvas;
use super::palette::viridis;
use plotters::coord::Shift;
use plotters::prelude::*;
use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_SIDE;

const FIGURE: &str = "viewpoint map";
/// Size of a panel, pixels.
const PANEL: (u32, u32) = (600, 210);
const COLUMNS: usize = 2;
/// Pixels of the picture a pixel of a panel's crop.
const SCALE: u32 = 3;
/// Height of the scale of colours below all panels, pixels.
const FOOT: u32 = 56;
/// Nats below the best viewpoint at which colours end.
const FLOOR: f64 = 30.0;

/// The likelihood of one crop.
#[derive(Clone, Debug)]
pub struct ViewpointPanel {
    /// What the crop is of.
    pub title: String,
    /// The crop.
    pub crop: Crop,
    /// Log-likelihood, nats, `[elevation][azimuth]`: azimuths spread evenly over a turn from -180 degrees, elevations from
    /// least to greatest; a value is that of its cell's middle.
    pub log_likelihood: Vec<Vec<f64>>,
    /// Least and greatest elevation, degrees.
    pub elevations: (f64, f64),
    /// True azimuth and elevation, degrees.
    pub truth: (f64, f64),
}

/// A PNG of all panels, two a row.
pub fn viewpoint_map_png(panels: &[ViewpointPanel]) -> Result<Vec<u8>, FigureError> {
    if panels.is_empty() || panels.iter().any(|p| p.log_likelihood.iter().all(Vec::is_empty)) {
        return Err(FigureError::Empty { figure: FIGURE });
    }
    if let Some(panel) = panels.iter().find(|p| p.log_likelihood.iter().flatten().any(|v| !v.is_finite())) {
        return Err(FigureError::NotFinite { figure: FIGURE, of: panel.title.clone() });
    }
    let rows = panels.len().div_ceil(COLUMNS) as u32;
    let width = PANEL.0 * COLUMNS.min(panels.len()) as u32;
    let mut canvas = Canvas::new(width, PANEL.1 * rows + FOOT);
    let corner = |index: usize| (PANEL.0 * (index % COLUMNS) as u32, PANEL.1 * (index / COLUMNS) as u32);
    let area = (&mut canvas).into_drawing_area();
    for (index, panel) in panels.iter().enumerate() {
        draw(panel, &area.clone().shrink(corner(index), PANEL)).map_err(refused)?;
    }
    scale(&area.clone().shrink((0, PANEL.1 * rows), (width, FOOT))).map_err(refused)?;
    drop(area);
    for (index, panel) in panels.iter().enumerate() {
        let (left, top) = corner(index);
        canvas.crop(&panel.crop, left + 8, top + 44, SCALE);
    }
    canvas.png()
}

type Drawn = Result<(), Box<dyn std::error::Error>>;

fn draw(panel: &ViewpointPanel, area: &DrawingArea<&mut Canvas, Shift>) -> Drawn {
    let (low, high) = panel.elevations;
    let rows = panel.log_likelihood.len();
    let thumbnail = CROP_SIDE as u32 * SCALE;
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 16))
        .margin_left(thumbnail + 16)
        .margin_right(24)
        .margin_top(4)
        .x_label_area_size(46)
        .y_label_area_size(56)
        .build_cartesian_2d(-180.0..180.0, low..high)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("azimuth [deg]")
        .y_desc("elevation [deg]")
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 14))
        .x_labels(9)
        .y_labels(6)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .draw()?;
    let best = panel.log_likelihood.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut peak = (0.0, 0.0);
    for (row, values) in panel.log_likelihood.iter().enumerate() {
        let at = |row: usize| low + (high - low) * row as f64 / rows as f64;
        for (column, value) in values.iter().enumerate() {
            let along = |column: usize| -180.0 + 360.0 * column as f64 / values.len() as f64;
            let cell = [(along(column), at(row)), (along(column + 1), at(row + 1))];
            let color = viridis(1.0 - (best - value) / FLOOR);
            chart.draw_series([Rectangle::new(cell, color.filled())])?;
            if *value == best {
                peak = ((cell[0].0 + cell[1].0) / 2.0, (cell[0].1 + cell[1].1) / 2.0);
            }
        }
    }
    chart.draw_series([Circle::new(panel.truth, 8, BLACK.stroke_width(4))])?;
    chart.draw_series([Circle::new(panel.truth, 8, WHITE.stroke_width(2))])?;
    chart.draw_series([Cross::new(peak, 4, RED.stroke_width(2))])?;
    Ok(())
}

/// What colours and marks mean.
fn scale(area: &DrawingArea<&mut Canvas, Shift>) -> Drawn {
    const STEPS: i32 = 240;
    let text = ("sans-serif", 14).into_font().color(&BLACK);
    let (left, top) = (20, 8);
    for step in 0..STEPS {
        let color = viridis(f64::from(step) / f64::from(STEPS - 1));
        let bar = [(left + step, top), (left + step + 1, top + 14)];
        area.draw(&Rectangle::new(bar, color.filled()))?;
    }
    let marks = format!("-{FLOOR:.0}");
    area.draw_text(&marks, &text, (left, top + 18))?;
    area.draw_text("0", &text, (left + STEPS - 8, top + 18))?;
    let nats = "log-likelihood less that of the best viewpoint [nats]";
    area.draw_text(nats, &text, (left + STEPS + 14, top))?;
    let line = top + 26;
    let (truth, best) = (left + STEPS + 22, left + STEPS + 142);
    area.draw(&Circle::new((truth, line + 8), 8, BLACK.stroke_width(4)))?;
    area.draw(&Circle::new((truth, line + 8), 8, WHITE.stroke_width(2)))?;
    area.draw_text("truth", &text, (truth + 16, line))?;
    area.draw(&Cross::new((best, line + 8), 4, RED.stroke_width(2)))?;
    area.draw_text("best", &text, (best + 16, line))?;
    Ok(())
}

fn refused(error: impl std::fmt::Display) -> FigureError {
    FigureError::Draw { figure: FIGURE, reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel() -> ViewpointPanel {
        let value =
            |row: usize, column: usize| -((row as f64 - 3.0).powi(2) + (column as f64 - 20.0).powi(2));
        ViewpointPanel {
            title: "mug".into(),
            crop: Crop::black(),
            log_likelihood: (0..8).map(|row| (0..36).map(|column| value(row, column)).collect()).collect(),
            elevations: (0.0, 80.0),
            truth: (25.0, 35.0),
        }
    }

    #[test]
    fn likely_places_are_light_and_the_same_input_gives_the_same_bytes() {
        let png = viewpoint_map_png(&[panel(), panel(), panel()]).unwrap();
        assert_eq!(png, viewpoint_map_png(&[panel(), panel(), panel()]).unwrap());
        let picture = image::load_from_memory(&png).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (2 * PANEL.0, 2 * PANEL.1 + FOOT));
        let count = |color: RGBColor| picture.pixels().filter(|p| p.0 == [color.0, color.1, color.2]).count();
        assert!(count(viridis(0.0)) > 10_000 && count(viridis(1.0)) > 10);
    }

    #[test]
    fn nothing_and_nan_are_refused() {
        assert!(matches!(viewpoint_map_png(&[]), Err(FigureError::Empty { .. })));
        let mut broken = panel();
        broken.log_likelihood[2][3] = f64::NAN;
        assert!(matches!(viewpoint_map_png(&[broken]), Err(FigureError::NotFinite { .. })));
    }
}
