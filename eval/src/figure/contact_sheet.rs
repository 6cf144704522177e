//! `contact_sheet.png`: crops side by side, to see what the model sees.

use super::FigureError;
use image::{ImageEncoder, Rgb, RgbImage};
use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_SIDE;

const FIGURE: &str = "contact sheet";
/// Pixels of the sheet a pixel of a crop.
const SCALE: usize = 2;
/// Pixels between crops.
const GAP: usize = 4;
const BACKGROUND: Rgb<u8> = Rgb([128, 128, 128]);

/// A PNG of rows of crops (for instance one instance a row), each crop at twice its size; rows may differ in length.
pub fn contact_sheet_png(rows: &[Vec<&Crop>]) -> Result<Vec<u8>, FigureError> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    if columns == 0 {
        return Err(FigureError::Empty { figure: FIGURE });
    }
    let refuse = |reason: String| FigureError::Draw { figure: FIGURE, reason };
    let pitch = CROP_SIDE * SCALE + GAP;
    let side = |cells: usize| {
        u32::try_from(cells * pitch + GAP).map_err(|_| refuse(format!("{cells} crops are too many")))
    };
    let mut sheet = RgbImage::from_pixel(side(columns)?, side(rows.len())?, BACKGROUND);
    for (row, crops) in rows.iter().enumerate() {
        for (column, crop) in crops.iter().enumerate() {
            paste(&mut sheet, crop, GAP + column * pitch, GAP + row * pitch);
        }
    }
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new(&mut png)
        .write_image(&sheet, sheet.width(), sheet.height(), image::ExtendedColorType::Rgb8)
        .map_err(|error| refuse(error.to_string()))?;
    Ok(png)
}

fn paste(sheet: &mut RgbImage, crop: &Crop, left: usize, top: usize) {
    for y in 0..CROP_SIDE * SCALE {
        for x in 0..CROP_SIDE * SCALE {
            let source = 3 * (y / SCALE * CROP_SIDE + x / SCALE);
            let pixel = [0, 1, 2].map(|channel| crop.0[source + channel]);
            sheet.put_pixel((left + x) as u32, (top + y) as u32, Rgb(pixel));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_stand_where_they_belong() {
        let mut red = Crop::black();
        red.0.chunks_exact_mut(3).for_each(|pixel| pixel[0] = 200);
        let mut dotted = Crop::black();
        dotted.0[3 * (CROP_SIDE + 2) + 1] = 90;
        let png = contact_sheet_png(&[vec![&dotted], vec![&red, &red]]).unwrap();
        let sheet = image::load_from_memory(&png).unwrap().to_rgb8();
        let pitch = (CROP_SIDE * SCALE + GAP) as u32;
        let gap = GAP as u32;
        assert_eq!(sheet.dimensions(), (2 * pitch + gap, 2 * pitch + gap));
        assert_eq!(sheet.get_pixel(gap + 4, gap + 2), &Rgb([0, 90, 0]));
        assert_eq!(sheet.get_pixel(gap + 5, gap + 3), &Rgb([0, 90, 0]));
        assert_eq!(sheet.get_pixel(gap + 6, gap + 2), &Rgb([0, 0, 0]));
        assert_eq!(sheet.get_pixel(gap + pitch, gap + pitch), &Rgb([200, 0, 0]));
        assert_eq!(sheet.get_pixel(gap + pitch, gap), &BACKGROUND);
    }

    #[test]
    fn no_crop_is_no_sheet() {
        assert_eq!(contact_sheet_png(&[vec![], vec![]]), Err(FigureError::Empty { figure: FIGURE }));
    }
}
