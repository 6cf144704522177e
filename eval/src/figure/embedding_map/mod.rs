//! Embeddings as points of the plane, coloured by what they are of, and a square of it shown as images: the paper's Fig. 2.

mod image_grid;

use super::FigureError;
use super::canvas::Canvas;
use super::palette::group_colors;
use image_grid::image_grid;
use plotters::coord::Shift;
use plotters::prelude::*;
use vantage_dataset::Crop;

const FIGURE: &str = "embedding";
/// Side of the map and of the images beside it, pixels.
const SIDE: u32 = 896;
const GAP: u32 = 12;
/// Above both, for the titles.
const HEAD: u32 = 40;
/// Below the map, for its legend.
const LEGEND: u32 = 64;
/// Groups that a legend names; more are shown by colour alone.
const NAMED: usize = 10;
const RADIUS: i32 = 5;

/// Points with their colours and images.
#[derive(Clone, Copy, Debug)]
pub struct EmbeddingMap<'a> {
    /// Above the points.
    pub title: &'a str,
    /// The points, in no unit.
    pub points: &'a [[f64; 2]],
    /// The group of each point, an index into `names`.
    pub groups: &'a [usize],
    /// Names of the groups.
    pub names: &'a [String],
    /// The image of each point.
    pub crops: &'a [&'a Crop],
}

/// A square of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Least coordinates.
    pub low: [f64; 2],
    /// Length of its sides.
    pub side: f64,
}

impl Square {
    /// Whether a point is inside.
    pub fn holds(&self, point: &[f64; 2]) -> bool {
        (0..2).all(|axis| (0.0..=self.side).contains(&(point[axis] - self.low[axis])))
    }

    /// The smallest square that holds all points, and a margin of 3%.
    fn around(points: &[[f64; 2]]) -> Option<Self> {
        let extreme = |axis: usize, pick: fn(f64, f64) -> f64| {
            points.iter().map(|point| point[axis]).reduce(pick).filter(|x| x.is_finite())
        };
        let low = [extreme(0, f64::min)?, extreme(1, f64::min)?];
        let high = [extreme(0, f64::max)?, extreme(1, f64::max)?];
        let reach = [0, 1].map(|axis| high[axis] - low[axis]);
        let side = 1.06 * reach[0].max(reach[1]).max(1e-9);
        Some(Self { low: [0, 1].map(|axis| low[axis] - (side - reach[axis]) / 2.0), side })
    }

    /// The square about one of the points, of half this one's sides and within it, that holds most points.
    fn densest(&self, points: &[[f64; 2]]) -> Self {
        let side = self.side / 2.0;
        let about = |point: &[f64; 2]| {
            let low = |axis: usize| {
                (point[axis] - side / 2.0).clamp(self.low[axis], self.low[axis] + self.side - side)
            };
            Square { low: [low(0), low(1)], side }
        };
        let held = |square: &Square| points.iter().filter(|point| square.holds(point)).count();
        let mut best = (0, Square { low: self.low, side });
        for square in points.iter().map(about) {
            if held(&square) > best.0 {
                best = (held(&square), square);
            }
        }
        best.1
    }
}

impl EmbeddingMap<'_> {
    /// The points alone, as SVG.
    pub fn svg(&self) -> Result<String, FigureError> {
        let (plane, square) = self.checked()?;
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, (SIDE, HEAD + SIDE + LEGEND)).into_drawing_area();
        self.draw(&area, plane, square).map_err(refused)?;
        drop(area);
        Ok(svg)
    }

    /// The points, and beside them the images nearest to a grid over the square that is outlined among them.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let (plane, square) = self.checked()?;
        let mut canvas = Canvas::new(2 * SIDE + GAP, HEAD + SIDE + LEGEND);
        let area = (&mut canvas).into_drawing_area();
        let (map, _) = area.split_horizontally(SIDE);
        self.draw(&map, plane, square).map_err(refused)?;
        let title = ("sans-serif", 20).into_font().color(&BLACK);
        let at = ((SIDE + GAP) as i32 + 4, 8);
        area.draw_text("Images in the outlined square", &title, at).map_err(refused)?;
        drop((area, map));
        let colors = group_colors(self.names.len());
        canvas.place(&image_grid(self, square, &colors, SIDE), SIDE + GAP, HEAD);
        let corners =
            [(SIDE + GAP, HEAD), (2 * SIDE + GAP - 1, HEAD + SIDE - 1)].map(|(x, y)| (x as i32, y as i32));
        let area = (&mut canvas).into_drawing_area();
        area.draw(&Rectangle::new(corners, BLACK.stroke_width(2))).map_err(refused)?;
        drop(area);
        canvas.png()
    }

    fn checked(&self) -> Result<(Square, Square), FigureError> {
        let counts = [self.groups.len(), self.crops.len()];
        if counts.iter().any(|&count| count != self.points.len()) {
            let reason = format!("got {counts:?} groups and images for {} points", self.points.len());
            return Err(FigureError::Draw { figure: FIGURE, reason });
        }
        if let Some(&group) = self.groups.iter().find(|&&group| group >= self.names.len()) {
            let reason = format!("group {group} has no name");
            return Err(FigureError::Draw { figure: FIGURE, reason });
        }
        if self.points.iter().flatten().any(|x| !x.is_finite()) {
            return Err(FigureError::NotFinite { figure: FIGURE, of: "its points".to_owned() });
        }
        let plane = Square::around(self.points).ok_or(FigureError::Empty { figure: FIGURE })?;
        Ok((plane, plane.densest(self.points)))
    }

    fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        plane: Square,
        square: Square,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        B::ErrorType: 'static,
    {
        area.fill(&WHITE)?;
        let title = ("sans-serif", 20).into_font().color(&BLACK);
        area.draw_text(self.title, &title, (4, 8))?;
        let place = |point: [f64; 2]| {
            let across = (point[0] - plane.low[0]) / plane.side * f64::from(SIDE - 1);
            let up = (point[1] - plane.low[1]) / plane.side * f64::from(SIDE - 1);
            (across.round() as i32, (HEAD + SIDE - 1) as i32 - up.round() as i32)
        };
        let corner = |square: Square| {
            [place(square.low), place([square.low[0] + square.side, square.low[1] + square.side])]
        };
        area.draw(&Rectangle::new(corner(plane), BLACK.mix(0.5)))?;
        let colors = group_colors(self.names.len());
        for (&point, &group) in self.points.iter().zip(self.groups) {
            area.draw(&Circle::new(place(point), RADIUS, colors[group].mix(0.85).filled()))?;
        }
        area.draw(&Rectangle::new(corner(square), BLACK.stroke_width(2)))?;
        let text = ("sans-serif", 16).into_font().color(&BLACK);
        let (left, top) = (4, (HEAD + SIDE) as i32 + 10);
        if self.names.len() > NAMED {
            let line = format!("{} points, {} colours", self.points.len(), self.names.len());
            area.draw_text(&line, &text, (left, top))?;
        } else {
            for (index, name) in self.names.iter().enumerate() {
                let across = left + (index % 5) as i32 * (SIDE / 5) as i32;
                let down = top + (index / 5) as i32 * 24;
                area.draw(&Circle::new((across + 6, down + 8), RADIUS + 1, colors[index].filled()))?;
                area.draw_text(name, &text, (across + 18, down))?;
            }
        }
        area.present()?;
        Ok(())
    }
}

fn refused(error: impl std::fmt::Display) -> FigureError {
    FigureError::Draw { figure: FIGURE, reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> Vec<[f64; 2]> {
        vec![[0.0, 0.0], [0.0, 10.0], [10.0, 0.0], [9.9, 9.9], [9.0, 9.5], [8.0, 8.0]]
    }

    #[test]
    fn the_densest_square_is_half_as_wide_and_inside() {
        let plane = Square::around(&corners()).unwrap();
        assert!(corners().iter().all(|point| plane.holds(point)));
        let square = plane.densest(&corners());
        assert_eq!(corners().iter().filter(|point| square.holds(point)).count(), 3);
        assert!((0..2).all(|axis| square.low[axis] + square.side <= plane.low[axis] + plane.side + 1e-9));
        assert_eq!(Square::around(&[]), None);
    }

    #[test]
    fn points_have_their_colors_and_the_same_input_gives_the_same_bytes() {
        let (points, crop) = (corners(), Crop::black());
        let crops = vec![&crop; points.len()];
        let names = ["mug", "duck"].map(str::to_owned);
        let map = EmbeddingMap {
            title: "Latents",
            points: &points,
            groups: &[0, 0, 0, 1, 1, 1],
            names: &names,
            crops: &crops,
        };
        let svg = map.svg().unwrap();
        let fill = |color: RGBColor| format!("#{:02X}{:02X}{:02X}", color.0, color.1, color.2);
        for color in group_colors(2) {
            let circles = svg.lines().filter(|l| l.starts_with("<circle") && l.contains(&fill(color)));
            assert_eq!(circles.count(), 4);
        }
        assert!(svg.contains("mug") && svg.contains("Latents"));
        assert_eq!(map.png().unwrap(), map.png().unwrap());
        assert!(matches!(EmbeddingMap { groups: &[0], ..map }.svg(), Err(FigureError::Draw { .. })));
        assert!(matches!(
            EmbeddingMap { groups: &[0, 0, 0, 1, 1, 2], ..map }.svg(),
            Err(FigureError::Draw { .. })
        ));
        let none = EmbeddingMap { points: &[], groups: &[], crops: &[], ..map };
        assert!(matches!(none.png(), Err(FigureError::Empty { .. })));
    }
}
