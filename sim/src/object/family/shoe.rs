//! Shoes.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Palette, Region, mix};
use crate::object::solid::loft;
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

const UPPER: Region = Region::new(0, 0, 128, 96);
const SOLE: Region = Region::new(0, 96, 128, 32);

/// From heel to toe: share of the length, half width, height of the upper, both in shares of their largest.
const STATIONS: [[f64; 3]; 9] = [
    [0.0, 0.5, 0.8],
    [0.04, 0.66, 0.97],
    [0.18, 0.76, 1.0],
    [0.34, 0.74, 0.96],
    [0.5, 0.82, 0.74],
    [0.66, 0.96, 0.56],
    [0.82, 1.0, 0.44],
    [0.94, 0.76, 0.36],
    [1.0, 0.4, 0.22],
];
const SIDES: usize = 16;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let length = shape.uniform(0.17, 0.25);
    let half_width = length * shape.uniform(0.16, 0.21);
    let height = length * shape.uniform(0.28, 0.45);
    let sole = length * shape.uniform(0.05, 0.1);

    let palette = Palette::draw(look);
    let ground = Ground::draw(look);
    let emblem = Emblem::draw(look);
    let grain = look.uniform(0.08, 0.2);
    let mut canvas = Canvas::new(palette.body);
    canvas.wrap(UPPER, [3.0 * half_width, length], |patch| {
        ground.cover(patch, [palette.body, mix(palette.body, palette.shade, 0.7)], grain, look);
        // Around: 0 is the lower left edge, 1/4 the ridge, 1/2 the lower right edge; along: 0 is the toe.
        let toe = look.uniform(0.2, 0.3);
        patch.rect(Area::band(0.0, toe), palette.accent);
        let heel = look.uniform(0.1, 0.16);
        patch.rect(Area::band(1.0 - heel, 1.0), palette.trim);
        let tongue = look.uniform(0.055, 0.08);
        patch.rect(Area::new(0.25 - tongue, toe, 0.25 + tongue, 0.6), palette.shade);
        for lace in 0..4 {
            let t = toe + 0.06 + 0.075 * f64::from(lace);
            patch.rect(Area::new(0.25 - tongue, t, 0.25 + tongue, t + 0.035), palette.panel);
        }
        patch.disc(Area::new(0.14, 0.6, 0.36, 0.96), palette.trim);
        patch.disc(Area::new(0.155, 0.62, 0.345, 0.94), [0.1, 0.09, 0.1]);
        let t = look.uniform(0.56, 0.64);
        patch.emblem(Area::around([0.08, t], [0.065, 0.12]), emblem, palette.over(palette.body));
        for stripe in 0..3 {
            let top = 0.5 + 0.08 * f64::from(stripe);
            patch.rect(Area::new(0.36, top, 0.5, top + 0.045), palette.over(palette.body));
        }
    });
    canvas.wrap(SOLE, [2.0 * half_width, length], |patch| {
        let rubber = if look.chance(0.6) { [0.93, 0.92, 0.9] } else { palette.ink };
        patch.fill(rubber);
        if look.chance(0.5) {
            patch.rect(Area::new(0.02, 0.0, 0.06, 1.0), palette.accent);
            patch.rect(Area::new(0.44, 0.0, 0.48, 1.0), palette.accent);
        }
    });

    let high_top = shape.uniform(0.85, 1.15);
    let ring = |[along, width, rise]: [f64; 3], swell: f64, base: f64, top: f64, domed: bool| {
        let collar = if along < 0.4 { high_top } else { 1.0 };
        (0..SIDES)
            .map(|k| {
                let angle = 2.0 * PI * k as f64 / SIDES as f64;
                let (cos, sin) = (libm::cos(angle), libm::sin(angle));
                let narrow = if domed { 1.0 - 0.4 * (sin.max(0.0) * rise) } else { 1.0 };
                let lift =
                    if domed { sin.max(0.0) * rise * collar } else { f64::from(u8::from(sin >= -1e-9)) };
                let x = length * (along - 0.5) * if domed { 0.97 } else { 1.0 };
                Vector3::new(x, swell * half_width * width * narrow * cos, base + (top - base) * lift)
            })
            .collect::<Vec<_>>()
    };
    let upper: Vec<_> = STATIONS.iter().map(|&s| ring(s, 0.94, 0.9 * sole, sole + height, true)).collect();
    let bottom: Vec<_> = STATIONS.iter().map(|&s| ring(s, 1.04, 0.0, sole, false)).collect();
    Draft { solid: loft(&upper, UPPER).join(loft(&bottom, SOLE)), canvas, density: 300.0 }
}
