//! COCO's run lengths of masks: column by column, the first run counting zeros.

use serde::{Deserialize, Serialize};

/// A mask as run lengths.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Rle {
    /// Lengths of the runs, of zeros and of ones by turns, from the top down and then column by column. The
    /// first is of zeros, and is 0 where the first pixel is set.
    pub(crate) counts: Vec<u32>,
    /// Height and width.
    pub(crate) size: [u32; 2],
}

impl Rle {
    /// The runs of a row-major mask of `width` columns. The mask's length is a multiple of `width`.
    pub(crate) fn encode(mask: &[bool], width: usize) -> Self {
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

    /// The inverse of [`Rle::encode`], or `None` where the runs do not fill the image.
    #[cfg(test)]
    pub(crate) fn decode(&self) -> Option<Vec<bool>> {
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
            let told = b"SKIPPED: data/clustering/coco_rle.json is absent; set VANTAGE_SHARED\n";
            let _ = std::io::Write::write_all(&mut std::io::stderr(), told);
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
    }

    proptest! {
        #[test]
        fn decoding_undoes_encoding(mask in prop::collection::vec(any::<bool>(), 0..300), width in 1usize..20) {
            let mask = &mask[..mask.len() / width * width];
            let rle = Rle::encode(mask, width);
            prop_assert_eq!(rle.decode().unwrap(), mask);
        }
    }
}
