//! Crops in labelled rows: what was seen beside what was predicted.

use super::FigureError;
use super::canvas::Canvas;
use vantage_dataset::Crop;
use vantage_dataset::crop::CROP_SIDE;

const FIGURE: &str = "crop table";
const SCALE: u32 = 2;
const CELL: u32 = CROP_SIDE as u32 * SCALE + 4;
/// Width of the labels, pixels.
const LABEL: u32 = 148;
/// Height of a line of text, pixels.
const TEXT: u32 = 20;
/// Between blocks, pixels.
const GAP: u32 = 14;
/// Width of a letter, pixels.
const LETTER: u32 = 7;

/// Rows that belong together, such as those of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Over the labels.
    pub name: String,
    /// Over each column.
    pub captions: Vec<String>,
    /// Label and crops of each row.
    pub rows: Vec<(String, Vec<Crop>)>,
}

/// A PNG of all blocks, one below another, crops at twice their size. A wider gap follows the first column.
pub fn crop_table_png(blocks: &[Block]) -> Result<Vec<u8>, FigureError> {
    let columns = blocks.iter().flat_map(|block| block.rows.iter().map(|(_, crops)| crops.len())).max();
    let columns = columns.filter(|&columns| columns > 0).ok_or(FigureError::Empty { figure: FIGURE })?;
    let height = |block: &Block| TEXT + block.rows.len() as u32 * CELL + GAP;
    let mut canvas = Canvas::new(left(columns as u32), GAP / 2 + blocks.iter().map(height).sum::<u32>());
    let mut top = GAP / 2;
    for block in blocks {
        canvas.text(&block.name, (4, top as i32));
        for (column, caption) in block.captions.iter().enumerate() {
            let middle = left(column as u32) + (CELL - 4) / 2;
            let half = LETTER * caption.chars().count() as u32 / 2;
            canvas.text(caption, (middle as i32 - half as i32, top as i32));
        }
        for (row, (label, crops)) in block.rows.iter().enumerate() {
            let top = top + TEXT + row as u32 * CELL;
            canvas.text(label, (4, (top + (CELL - TEXT) / 2) as i32));
            for (column, crop) in crops.iter().enumerate() {
                canvas.crop(crop, left(column as u32), top, SCALE);
            }
        }
        top += height(block);
    }
    canvas.png()
}

fn left(column: u32) -> u32 {
    LABEL + column * CELL + if column > 0 { GAP } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_stand_in_their_rows() {
        let mut grey = Crop::black();
        grey.0.fill(100);
        let block = |rows: usize| Block {
            name: "mug".into(),
            captions: vec!["input".into(), "+30".into()],
            rows: (0..rows).map(|i| (format!("row {i}"), vec![grey.clone(), Crop::black()])).collect(),
        };
        let png = crop_table_png(&[block(1), block(2)]).unwrap();
        let sheet = image::load_from_memory(&png).unwrap().to_rgb8();
        let first = GAP / 2 + TEXT;
        let second = first + CELL + GAP + TEXT;
        for top in [first, second, second + CELL] {
            assert_eq!(sheet.get_pixel(LABEL, top).0, [100; 3]);
            assert_eq!(sheet.get_pixel(left(1) + 63, top + 63).0, [0; 3]);
            assert_eq!(sheet.get_pixel(LABEL + 65, top).0, [255; 3]);
        }
        let empty = Block { rows: vec![("none".into(), vec![])], ..block(0) };
        assert_eq!(crop_table_png(&[empty]), Err(FigureError::Empty { figure: FIGURE }));
    }
}
