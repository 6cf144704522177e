//! Colours of figures.

use plotters::style::{Color, HSLColor, RGBColor};

/// Colours that the colour-blind tell apart (Okabe and Ito), without the black that is the truth's.
const METHODS: [RGBColor; 7] = [
    RGBColor(230, 159, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(148, 128, 0),
];

/// Ten colours found to be told apart with any colour vision (Petroff 2021).
const TEN: [RGBColor; 10] = [
    RGBColor(63, 144, 218),
    RGBColor(255, 169, 14),
    RGBColor(189, 31, 1),
    RGBColor(148, 164, 162),
    RGBColor(131, 45, 182),
    RGBColor(169, 107, 89),
    RGBColor(231, 99, 0),
    RGBColor(185, 172, 112),
    RGBColor(113, 117, 129),
    RGBColor(146, 218, 221),
];

/// Stops of viridis, evenly spaced: dark blue to yellow, of evenly rising lightness.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

/// The colour of the `index`th method.
pub(super) fn color(index: usize) -> RGBColor {
    METHODS[index % METHODS.len()]
}

/// `count` colours: up to ten that any colour vision tells apart, more as hues spread evenly, in turn light and dark.
pub fn group_colors(count: usize) -> Vec<RGBColor> {
    if count <= TEN.len() {
        return TEN[..count].to_vec();
    }
    let hue = |i: usize| {
        let lightness = [0.36, 0.52, 0.66][i % 3];
        let (r, g, b) = HSLColor(i as f64 / count as f64, 0.8, lightness).rgb();
        RGBColor(r, g, b)
    };
    (0..count).map(hue).collect()
}

/// The colour of a share in `[0, 1]` on a scale that stays one in grey.
pub fn viridis(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let part = place - below as f64;
    let [r, g, b] = [0, 1, 2].map(|channel| {
        let (a, b) = (VIRIDIS[below][channel], VIRIDIS[below + 1][channel]);
        (a + (b - a) * part).round() as u8
    });
    RGBColor(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn groups_have_colors_of_their_own() {
        for count in [0, 1, 10, 11, 48, 100] {
            let colors: BTreeSet<_> = group_colors(count).iter().map(|c| (c.0, c.1, c.2)).collect();
            assert_eq!(colors.len(), count);
        }
    }

    #[test]
    fn the_scale_gets_lighter_all_the_way() {
        let light = |share: f64| {
            let RGBColor(r, g, b) = viridis(share);
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        assert!((0..100).all(|i| light(f64::from(i + 1) / 100.0) > light(f64::from(i) / 100.0)));
        assert_eq!((viridis(-1.0), viridis(2.0)), (RGBColor(68, 1, 84), RGBColor(253, 231, 37)));
    }
}
