//! COCO's run lengths of masks: column by column, the first run counting zeros.

use serde::{Deserialize, Serialize};

/// Bits of a run in one letter of the compressed form.
const GROUP_BITS: u32 = 5;
/// The sign of a group of bits, where it is the last.
const SIGN: u8 = 0x10;
/// Another group follows.
const MORE: u8 = 0x20;
const FIRST_LETTER: u8 = b'0';

/// A mask as run lengths.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rle {
    /// Lengths of the runs, of zeros and of ones by turns, from the top down and then column by column. The
    /// first is of zeros, and is 0 where the first pixel is set.
    pub counts: Vec<u32>,
    /// Height and width.
    pub size: [u32; 2],
}

impl Rle {
    /// The runs of a row-major mask of `width` columns. The mask's length is a multiple of `width`.
    pub fn encode(mask: &[bool], width: usize) -> Self {
        let height = mask.len().checked_div(width).unwrap_or(0);
        let mut counts = Vec::new();
        let (mut value, mut run) = (false, 0);
        for column in 0..width {
            for row in 0..height {
                if mask[row * width + column] != value {
                    counts.push(run);
                    (value, run) = (!value, 0);
                }
                run += 1;
            }
        }
        counts.push(run);
        Self { counts, size: [height as u32, width as u32] }
    }

    /// The row-major mask, or `None` where the runs do not fill the image.
    pub fn decode(&self) -> Option<Vec<bool>> {
        let [height, width] = self.size.map(|side| side as usize);
        let pixels = height.checked_mul(width)?;
        let runs: u64 = self.counts.iter().map(|&run| u64::from(run)).sum();
        if runs != pixels as u64 {
            return None;
        }
        let mut mask = vec![false; pixels];
        let mut place = 0;
        for (i, &run) in self.counts.iter().enumerate() {
            let end = place + run as usize;
            if i % 2 == 1 {
                (place..end).for_each(|p| mask[p % height * width + p / height] = true);
            }
            place = end;
        }
        Some(mask)
    }

    /// The runs as the text that pycocotools calls compressed: from the fourth on each run less the last but one,
    /// in groups of five bits from the lowest, each as a letter.
    pub fn compressed(&self) -> String {
        let mut text = String::new();
        for (i, &run) in self.counts.iter().enumerate() {
            let before = if i > 2 { i64::from(self.counts[i - 2]) } else { 0 };
            let mut rest = i64::from(run) - before;
            loop {
                let group = (rest & 0x1f) as u8;
                rest >>= GROUP_BITS;
                let sign = if group & SIGN == 0 { 0 } else { -1 };
                let more = if rest == sign { 0 } else { MORE };
                text.push(char::from(FIRST_LETTER + (group | more)));
                if more == 0 {
                    break;
                }
            }
        }
        text
    }

    /// The inverse of [`Rle::compressed`] for a mask of height and width `size`; `None` where the text is no such
    /// runs.
    pub fn from_compressed(text: &str, size: [u32; 2]) -> Option<Self> {
        let mut counts: Vec<u32> = Vec::new();
        let (mut value, mut shift) = (0i64, 0);
        for letter in text.bytes() {
            let group = letter.checked_sub(FIRST_LETTER).filter(|&group| group < 1 << (GROUP_BITS + 1))?;
            if shift > i64::from(u32::BITS) {
                return None;
            }
            value |= i64::from(group & (MORE - 1)) << shift;
            shift += i64::from(GROUP_BITS);
            if group & MORE == 0 {
                let sign = if group & SIGN == 0 { 0 } else { -1 << shift };
                let before = if counts.len() > 2 { i64::from(counts[counts.len() - 2]) } else { 0 };
                counts.push(u32::try_from((value | sign) + before).ok()?);
                (value, shift) = (0, 0);
            }
        }
        (shift == 0).then_some(Self { counts, size })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::Value;
    use std::path::PathBuf;

    fn shared(path: &str) -> Option<PathBuf> {
        let root = std::env::var_os("VANTAGE_SHARED")
            .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
        Some(root.join(path)).filter(|path| path.exists())
    }

    #[test]
    fn runs_are_those_of_pycocotools() {
        let Some(path) = shared("data/clustering/coco_rle.json") else {
            eprintln!("SKIPPED: data/clustering/coco_rle.json is not there");
            return;
        };
        let file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        let cases = file["cases"].as_array().unwrap();
        assert!(cases.len() >= 8);
        for case in cases {
            let mask: Vec<bool> =
                case["mask_row_major"].as_str().unwrap().bytes().map(|b| b == b'1').collect();
            let counts: Vec<u32> = serde_json::from_value(case["counts_uncompressed"].clone()).unwrap();
            let size: [u32; 2] = serde_json::from_value(case["size"].clone()).unwrap();
            let expected = Rle { counts, size };
            assert_eq!(Rle::encode(&mask, size[1] as usize), expected, "{}", case["name"]);
            assert_eq!(expected.decode().unwrap(), mask, "{}", case["name"]);
            let text = case["counts_compressed"].as_str().unwrap();
            assert_eq!(expected.compressed(), text, "{}", case["name"]);
            assert_eq!(Rle::from_compressed(text, size).unwrap(), expected, "{}", case["name"]);
        }
    }

    #[test]
    fn runs_go_down_the_columns() {
        let rle = Rle::encode(&[true, false, true, true, false, false], 2);
        assert_eq!(rle, Rle { counts: vec![0, 2, 2, 1, 1], size: [3, 2] });
    }

    #[test]
    fn runs_that_do_not_fill_the_image_are_refused() {
        let decode = |counts: &[u32], size| Rle { counts: counts.to_vec(), size }.decode();
        assert_eq!(decode(&[3], [2, 2]), None);
        assert_eq!(decode(&[3, 2], [2, 2]), None);
        assert_eq!(decode(&[u32::MAX, u32::MAX], [2, 2]), None);
        assert_eq!(decode(&[], [u32::MAX, u32::MAX]), None);
        for text in ["P", "PPPPPPPPPPPPP1", "\u{7f}", " ", "O"] {
            assert_eq!(Rle::from_compressed(text, [2, 2]), None, "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn decoding_undoes_encoding(mask in prop::collection::vec(any::<bool>(), 0..300), width in 1usize..20) {
            let mask = &mask[..mask.len() / width * width];
            let rle = Rle::encode(mask, width);
            prop_assert_eq!(rle.decode().unwrap(), mask);
            prop_assert_eq!(Rle::from_compressed(&rle.compressed(), rle.size).unwrap(), rle);
        }
    }
}
