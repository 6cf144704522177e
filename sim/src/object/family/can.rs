//! Cans.

use super::{Draft, SPOTS, SQUARE, WRAP};
use crate::object::paint::{Area, Canvas, Label, Palette, hsl, mix};
use crate::object::solid::{Skin, turned};
use std::f64::consts::PI;
use vantage_dataset::Stream;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let radius = shape.uniform(0.028, 0.045);
    let height = radius * shape.uniform(2.3, 3.7);
    let neck = radius * shape.uniform(0.78, 0.92);
    let [low, high] = [0.07 * radius, height - 0.14 * radius];

    let palette = Palette::draw(look);
    let label = Label::draw(palette, look);
    let metal = hsl(look.unit(), look.uniform(0.0, 0.12), look.uniform(0.6, 0.85));
    let dark = mix(metal, [0.1, 0.1, 0.12], 0.6);
    let mut canvas = Canvas::new(metal);
    canvas.wrap(WRAP, [2.0 * PI * radius, high - low], |patch| label.wrap(patch, look));
    canvas.paint(SQUARE, [1.0, 1.0], |patch| {
        patch.disc(patch.square([0.5, 0.5], 0.47), mix(metal, dark, 0.35));
        patch.disc(patch.square([0.5, 0.5], 0.4), metal);
        patch.disc(Area::around([0.5, 0.76], [0.17, 0.16]), dark);
        patch.disc(Area::around([0.5, 0.46], [0.14, 0.24]), palette.accent);
    });

    let [metal_skin, square] = [Skin::Wrap(SPOTS[0]), Skin::Disc(SQUARE)];
    let rim = height - 0.05 * radius;
    let solid = turned(
        &[
            (&[[0.0, 0.0], [0.9 * radius, 0.0]], Skin::Disc(SPOTS[1])),
            (&[[0.9 * radius, 0.0], [radius, low]], metal_skin),
            (&[[radius, low], [radius, high]], Skin::Wrap(WRAP)),
            (&[[radius, high], [neck, height]], metal_skin),
            (&[[neck, height], [0.95 * neck, rim]], metal_skin),
            (&[[0.95 * neck, rim], [0.0, rim]], square),
        ],
        20,
    );
    Draft { solid, canvas, density: 700.0 }
}
