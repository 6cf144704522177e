//! A scene at a glance: images side by side, with boxes and paths drawn into them, and captions.

use super::FigureError;
use super::canvas::Canvas;
use image::{Rgb, RgbImage, imageops};
use vantage_dataset::BoundingBox;

const FIGURE: &str = "scene sheet";
/// Of a detection's box.
pub const BOX: Rgb<u8> = Rgb([255, 255, 0]);
/// Of the box of a detection of nothing.
pub const BOX_OF_NOTHING: Rgb<u8> = Rgb([0, 255, 255]);
const PATH: Rgb<u8> = Rgb([255, 0, 0]);
/// Half the width of a path, pixels.
const PEN: i64 = 1;

/// An sRGB image, row-major, 3 bytes a pixel, that can be drawn into.
#[derive(Clone, Debug)]
pub struct Panel {
    image: RgbImage,
}

impl Panel {
    /// From `width * height` pixels.
    pub fn new(width: u32, height: u32, rgb: Vec<u8>) -> Result<Self, FigureError> {
        let bytes = rgb.len();
        let image = RgbImage::from_raw(width, height, rgb).ok_or_else(|| FigureError::Draw {
            figure: FIGURE,
            reason: format!("got {bytes} bytes for {width} x {height} pixels"),
        })?;
        Ok(Self { image })
    }

    /// Draws the outline of a box, pixels; what lies outside is left out.
    pub fn outline(&mut self, bounds: &BoundingBox, hue: Rgb<u8>) {
        let (left, top) = (bounds.min.x as i64, bounds.min.y as i64);
        let (right, bottom) = (bounds.max.x as i64 - 1, bounds.max.y as i64 - 1);
        for x in left..=right {
            self.dot(x, top, hue);
            self.dot(x, bottom, hue);
        }
        for y in top..=bottom {
            self.dot(left, y, hue);
            self.dot(right, y, hue);
        }
    }

    /// Draws straight lines between consecutive points, pixels.
    pub fn path(&mut self, points: &[[f64; 2]]) {
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).ceil().clamp(1.0, 10_000.0);
            for step in 0..=steps as u32 {
                let along = f64::from(step) / steps;
                let at = |axis: usize| (from[axis] + along * (to[axis] - from[axis])) as i64;
                self.spot(at(0), at(1));
            }
        }
    }

    /// Draws points, pixels.
    pub fn points(&mut self, points: &[[f64; 2]]) {
        points.iter().for_each(|at| self.spot(at[0] as i64, at[1] as i64));
    }

    fn spot(&mut self, x: i64, y: i64) {
        for (across, down) in (-PEN..=PEN).flat_map(|x| (-PEN..=PEN).map(move |y| (x, y))) {
            self.dot(x + across, y + down, PATH);
        }
    }

    fn dot(&mut self, x: i64, y: i64, color: Rgb<u8>) {
        if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
            && let Some(pixel) = self.image.get_pixel_mut_checked(x, y)
        {
            *pixel = color;
        }
    }

    /// Puts it on a sheet with its corner at (`left`, `top`), at `side` pixels along its longer side.
    pub fn place_on(&self, sheet: &mut Canvas, left: u32, top: u32, side: u32) {
        let longer = self.image.width().max(self.image.height());
        let scaled = |length: u32| (length * side / longer).max(1);
        let (width, height) = (scaled(self.image.width()), scaled(self.image.height()));
        let filter =
            if side < longer { imageops::FilterType::Triangle } else { imageops::FilterType::Nearest };
        sheet.image(&imageops::resize(&self.image, width, height, filter), left, top);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    const WHITE: Rgb<u8> = Rgb([255; 3]);

    fn black(width: u32, height: u32) -> Panel {
        Panel::new(width, height, vec![0; (width * height * 3) as usize]).unwrap()
    }

    #[test]
    fn boxes_and_paths_are_drawn_as_far_as_they_are_inside() {
        let mut panel = black(8, 8);
        panel.outline(&BoundingBox { min: Vector2::new(2.0, 3.0), max: Vector2::new(20.0, 6.0) }, BOX);
        assert_eq!(panel.image.get_pixel(2, 3), &BOX);
        assert_eq!(panel.image.get_pixel(7, 5), &BOX);
        assert_eq!(panel.image.get_pixel(4, 4), &Rgb([0, 0, 0]));
        panel.outline(
            &BoundingBox { min: Vector2::new(0.0, 0.0), max: Vector2::new(2.0, 2.0) },
            BOX_OF_NOTHING,
        );
        assert_eq!(panel.image.get_pixel(1, 1), &BOX_OF_NOTHING);
        panel.path(&[[-5.0, 7.0], [5.0, 7.0]]);
        assert_eq!(panel.image.get_pixel(0, 7), &PATH);
        assert_eq!(panel.image.get_pixel(7, 7), &Rgb([0, 0, 0]));
    }

    #[test]
    fn panels_stand_where_they_are_put() {
        let mut sheet = Canvas::new(20, 10);
        black(4, 2).place_on(&mut sheet, 10, 0, 8);
        let sheet = image::load_from_memory(&sheet.png().unwrap()).unwrap().to_rgb8();
        assert_eq!(sheet.get_pixel(9, 0), &WHITE);
        assert_eq!(sheet.get_pixel(10, 0), &Rgb([0, 0, 0]));
        assert_eq!(sheet.get_pixel(17, 3), &Rgb([0, 0, 0]));
        assert_eq!(sheet.get_pixel(17, 4), &WHITE);
        assert!(Panel::new(2, 2, vec![0; 3]).is_err());
    }
}
