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
/// Height of the captions, two lines.
const HEAD: u32 = 2 * TEXT;
/// Between blocks, pixels.
const GAP: u32 = 14;
/// Width of a letter, pixels.
const LETTER: u32 = 7;

/// Rows that belong together, such as those of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Over the labels.
    pub name: String,
    /// Over each column, up to two lines of nine letters.
    pub captions: Vec<String>,
    /// Label and crops of each row.
    pub rows: Vec<(String, Vec<Crop>)>,
}

/// A PNG of all blocks, one below another, crops at twice their size. A wider gap follows the first column.
pub fn crop_table_png(blocks: &[Block]) -> Result<Vec<u8>, FigureError> {
    let columns = blocks.iter().flat_map(|block| block.rows.iter().map(|(_, crops)| crops.len())).max();
    let columns = columns.filter(|&columns| columns > 0).ok_or(FigureError::Empty { figure: FIGURE })?;
    let height = |block: &Block| HEAD + block.rows.len() as u32 * CELL + GAP;
    let mut canvas = Canvas::new(left(columns as u32), GAP / 2 + blocks.iter().map(height).sum::<u32>());
    let mut top = GAP / 2;
    for block in blocks {
        let first = top + HEAD;
        canvas.text(&block.name, (4, (first - TEXT) as i32));
        for (column, caption) in block.captions.iter().enumerate() {
            let middle = left(column as u32) + (CELL - 4) / 2;
            for (above, line) in (1..=2).zip(caption.lines().rev()) {
                let half = LETTER * line.chars().count() as u32 / 2;
                canvas.text(line, (middle as i32 - half as i32, (first - above * TEXT) as i32));
            }
        }
        for (row, (label, crops)) in block.rows.iter().enumerate() {
            let top = first + row as u32 * CELL;
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
            captions: vec!["input".into(), "azimuth\n-180 deg".into()],
            rows: (0..rows).map(|i| (format!("row {i}"), vec![grey.clone(), Crop::black()])).collect(),
        };
        let png = crop_table_png(&[block(1), block(2)]).unwrap();
        let sheet = image::load_from_memory(&png).unwrap().to_rgb8();
        let first = GAP / 2 + HEAD;
        let second = first + CELL + GAP + HEAD;
        for top in [first, second, second + CELL] {
            assert_eq!(sheet.get_pixel(LABEL, top).0, [100; 3]);
            assert_eq!(sheet.get_pixel(left(1) + 63, top + 63).0, [0; 3]);
            assert_eq!(sheet.get_pixel(LABEL + 65, top).0, [255; 3]);
        }
        let inked = |line: u32| {
            let dark = |x: &u32| (0..TEXT).any(|y| sheet.get_pixel(*x, GAP / 2 + line * TEXT + y).0[0] < 128);
            (LABEL..sheet.width()).filter(dark).collect::<Vec<_>>()
        };
        let [upper, lower] = [inked(0), inked(1)];
        assert!(upper.iter().all(|&x| x >= left(1)), "one line stands next to the crops");
        assert!(upper.len() > 20 && lower.iter().any(|&x| x < left(1)) && lower.iter().any(|&x| x > left(1)));
        let empty = Block { rows: vec![("none".into(), vec![])], ..block(0) };
        assert_eq!(crop_table_png(&[empty]), Err(FigureError::Empty { figure: FIGURE }));
    }
}
