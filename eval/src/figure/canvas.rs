//! A PNG to draw on: crops, text, and all that plotters draws.

use super::FigureError;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, Rgb, RgbImage, imageops};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use std::convert::Infallible;
use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_SIDE;

const INK: BackendColor = BackendColor { alpha: 1.0, rgb: (0, 0, 0) };

/// A picture of fixed size, white where nothing is drawn. What lies outside is left out.
///
/// Text is drawn in the two sizes of its font, 16 and 20 pixels high, the same on every machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Canvas {
    image: RgbImage,
}

impl Canvas {
    /// An empty picture, pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { image: RgbImage::from_pixel(width, height, Rgb([255; 3])) }
    }

    /// Puts a crop with its corner at (`left`, `top`), each of its pixels `scale` wide.
    pub fn crop(&mut self, crop: &Crop, left: u32, top: u32, scale: u32) {
        let side = CROP_SIDE as u32;
        let pixels = RgbImage::from_fn(side * scale, side * scale, |x, y| {
            let start = ((y / scale * side + x / scale) * 3) as usize;
            Rgb([crop.0[start], crop.0[start + 1], crop.0[start + 2]])
        });
        self.image(&pixels, left, top);
    }

    /// Puts an image with its corner at (`left`, `top`).
    pub fn image(&mut self, image: &RgbImage, left: u32, top: u32) {
        imageops::replace(&mut self.image, image, i64::from(left), i64::from(top));
    }

    /// Puts another picture with its corner at (`left`, `top`).
    pub fn place(&mut self, other: &Canvas, left: u32, top: u32) {
        self.image(&other.image, left, top);
    }

    /// Writes black text, 16 pixels high, its upper left corner at `at`.
    pub fn text(&mut self, text: &str, at: (i32, i32)) {
        self.glyphs(text, at, RasterHeight::Size16, INK, |x, y| (x, y));
    }

    /// The picture as a PNG.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(&self.image, self.image.width(), self.image.height(), ExtendedColorType::Rgb8)
            .map_err(|error| FigureError::Draw { figure: "picture", reason: error.to_string() })?;
        Ok(png)
    }

    /// Draws text along `turned` axes: from pixels right and down of `at` to those of the picture.
    fn glyphs(
        &mut self,
        text: &str,
        at: BackendCoord,
        size: RasterHeight,
        color: BackendColor,
        turned: impl Fn(i32, i32) -> (i32, i32),
    ) {
        let mut left = 0;
        for letter in text.chars() {
            let glyph = get_raster(letter, FontWeight::Regular, size)
                .or_else(|| get_raster('?', FontWeight::Regular, size));
            for (y, row) in glyph.iter().flat_map(|glyph| glyph.rows()).enumerate() {
                for (x, &intensity) in row.iter().enumerate() {
                    let (x, y) = turned(left + x as i32, y as i32);
                    self.blend((at.0 + x, at.1 + y), color, f64::from(intensity) / 255.0);
                }
            }
            left += get_raster_width(FontWeight::Regular, size) as i32;
        }
    }

    fn blend(&mut self, (x, y): BackendCoord, color: BackendColor, share: f64) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        let Some(pixel) = self.image.get_pixel_mut_checked(x, y) else { return };
        let share = (color.alpha * share).clamp(0.0, 1.0);
        let (r, g, b) = color.rgb;
        for (below, above) in pixel.0.iter_mut().zip([r, g, b]) {
            *below = (f64::from(*below) * (1.0 - share) + f64::from(above) * share).round() as u8;
        }
    }
}

/// Sizes of 18 and more are large.
fn raster(size: f64) -> RasterHeight {
    if size < 18.0 { RasterHeight::Size16 } else { RasterHeight::Size20 }
}

fn extent(text: &str, size: RasterHeight) -> (i32, i32) {
    let width = get_raster_width(FontWeight::Regular, size) * text.chars().count();
    (width as i32, size.val() as i32)
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for &mut Canvas {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.image.dimensions()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn {
        self.blend(point, color, 1.0);
        Ok(())
    }

    /// Antialiased, where plotters' own circles have steps.
    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let (reach, outer) = (radius as i32 + 1, f64::from(radius) + 0.5);
        let inner = if fill { f64::NEG_INFINITY } else { outer - f64::from(style.stroke_width().max(1)) };
        for (x, y) in (-reach..=reach).flat_map(|x| (-reach..=reach).map(move |y| (x, y))) {
            let distance = libm::hypot(f64::from(x), f64::from(y));
            let share = (outer - distance).min(distance - inner).clamp(0.0, 1.0);
            self.blend((center.0 + x, center.1 + y), style.color(), share);
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let size = raster(style.size());
        let (width, height) = extent(text, size);
        let across = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let down = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        let transform = style.transform();
        self.glyphs(text, at, size, style.color(), |x, y| transform.transform(x + across, y + down));
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let (width, height) = extent(text, raster(style.size()));
        Ok((width.unsigned_abs(), height.unsigned_abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plotters::prelude::*;

    fn dark(canvas: &Canvas, x: std::ops::Range<u32>, y: std::ops::Range<u32>) -> usize {
        let pixels = x.flat_map(|x| y.clone().map(move |y| (x, y)));
        pixels.filter(|&(x, y)| canvas.image.get_pixel(x, y).0[0] < 128).count()
    }

    #[test]
    fn crops_and_pictures_stand_where_they_are_put_and_are_cut_at_the_border() {
        let mut canvas = Canvas::new(100, 80);
        canvas.crop(&Crop::black(), 10, 20, 1);
        assert_eq!(dark(&canvas, 0..100, 0..80), CROP_SIDE * CROP_SIDE);
        assert_eq!(dark(&canvas, 10..42, 20..52), CROP_SIDE * CROP_SIDE);
        let mut outer = Canvas::new(60, 60);
        outer.place(&canvas, 30, 40);
        assert_eq!(dark(&outer, 40..60, 60..60), 0);
        canvas.crop(&Crop::black(), 90, 70, 2);
        assert_eq!(dark(&canvas, 90..100, 70..80), 100);
    }

    #[test]
    fn text_is_drawn_from_its_anchor_in_any_direction() {
        let mut canvas = Canvas::new(200, 200);
        canvas.text("WWWW", (100, 100));
        let right = dark(&canvas, 100..200, 100..116);
        assert!(right > 60 && dark(&canvas, 0..200, 0..200) == right);
        let mut turned = Canvas::new(200, 200);
        let style = ("sans-serif", 14).into_font().transform(FontTransform::Rotate270).color(&BLACK);
        (&mut turned).into_drawing_area().draw_text("WWWW", &style, (100, 100)).unwrap();
        assert_eq!(dark(&turned, 100..116, 0..101), right);
    }

    #[test]
    fn circles_are_round_and_outside_is_nowhere() {
        let mut canvas = Canvas::new(60, 60);
        let area = (&mut canvas).into_drawing_area();
        area.draw(&Circle::new((30, 30), 10, BLACK.filled())).unwrap();
        area.draw(&Circle::new((0, 59), 3, BLACK.filled())).unwrap();
        drop(area);
        let ink: f64 = canvas.image.pixels().map(|p| 1.0 - f64::from(p.0[0]) / 255.0).sum();
        // A whole disk, and of the one about the corner pixel's middle the quarter inside, with half a pixel beyond its axes.
        let expected = std::f64::consts::PI * (10f64.powi(2) + 3f64.powi(2) / 4.0) + 3.0 + 0.25;
        assert!((ink - expected).abs() < 2.0, "{ink} {expected}");
    }
}
