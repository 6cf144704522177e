//! Vases: surfaces of revolution, painted with rings only.

use super::{Draft, SPOTS, WRAP};
use crate::object::paint::{Area, Canvas, Palette, mix};
use crate::object::solid::{Skin, turned};
use std::f64::consts::PI;
use vantage_dataset::Stream;

const KNOTS: usize = 4;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let height = shape.uniform(0.1, 0.22);
    let scale = height * shape.uniform(0.22, 0.34);
    let radii: [f64; KNOTS] = [0.6, 1.0, 0.75, 0.6].map(|r| scale * (r + shape.uniform(-0.22, 0.25)));
    let outline: Vec<[f64; 2]> = (0..=9)
        .map(|i| {
            let at = f64::from(i) / 9.0 * (KNOTS - 1) as f64;
            let knot = (libm::floor(at) as usize).min(KNOTS - 2);
            let share = 0.5 - 0.5 * libm::cos(PI * (at - knot as f64));
            [radii[knot] + (radii[knot + 1] - radii[knot]) * share, height * f64::from(i) / 9.0]
        })
        .collect();

    let palette = Palette::draw(look);
    let tones = [palette.body, palette.shade, palette.accent, palette.panel, palette.trim];
    let mut canvas = Canvas::new(palette.body);
    canvas.paint(WRAP, [2.0 * PI * scale, height], |patch| {
        patch.fade(Area::ALL, palette.body, if look.chance(0.5) { palette.shade } else { palette.body });
        for _ in 0..2 + look.below(4) {
            let (center, half) = (look.uniform(0.05, 0.95), look.uniform(0.02, 0.12));
            patch.rect(Area::band(center - half, center + half), tones[look.below(tones.len())]);
        }
        if look.chance(0.6) {
            let (start, pitch) = (look.uniform(0.1, 0.6), look.uniform(0.04, 0.08));
            let tone = tones[2 + look.below(3)];
            for ring in 0..2 + look.below(4) {
                let top = start + f64::from(ring as u32) * pitch;
                patch.rect(Area::band(top, top + 0.5 * pitch), tone);
            }
        }
    });
    canvas.plain(SPOTS[0], palette.trim);
    canvas.plain(SPOTS[1], mix(palette.body, [0.0; 3], 0.7));

    let [foot, mouth] = [radii[0], radii[KNOTS - 1]];
    let solid = turned(
        &[
            (&[[0.0, 0.0], [foot, 0.0]], Skin::Disc(SPOTS[1])),
            (&outline, Skin::Wrap(WRAP)),
            (&[[mouth, height], [0.84 * mouth, height]], Skin::Wrap(SPOTS[0])),
            (&[[0.84 * mouth, height], [0.7 * mouth, 0.8 * height]], Skin::Wrap(SPOTS[1])),
            (&[[0.7 * mouth, 0.8 * height], [0.0, 0.8 * height]], Skin::Disc(SPOTS[1])),
        ],
        24,
    );
    Draft { solid, canvas, density: 900.0 }
}
