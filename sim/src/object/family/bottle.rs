//! Bottles.

use super::{Draft, SPOTS, WRAP};
use crate::object::paint::{Canvas, Label, Palette, mix};
use crate::object::solid::{Faces, Skin, cuboid, turned};
use std::f64::consts::PI;
use vantage_dataset::Stream;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let radius = shape.uniform(0.035, 0.05);
    let height = radius * shape.uniform(3.3, 4.5);
    let flatness = shape.uniform(0.62, 0.85);
    let wall = height * shape.uniform(0.5, 0.64);
    let shoulder = height * shape.uniform(0.76, 0.82);
    let [neck, cap] = [radius * shape.uniform(0.32, 0.5), radius * shape.uniform(0.52, 0.68)];
    let cap_low = height * 0.86;

    let palette = Palette::draw(look);
    let label = Label::draw(palette, look);
    let mut canvas = Canvas::new(palette.trim);
    canvas.wrap(WRAP, [1.7 * PI * radius, wall], |patch| label.wrap(patch, look));
    let liquid = mix(palette.body, [1.0; 3], look.uniform(0.0, 0.25));
    canvas.plain(SPOTS[0], liquid);
    canvas.plain(SPOTS[1], mix(palette.trim, [0.0; 3], 0.35));

    let between = |a: f64, b: f64, share: f64| a + (b - a) * (0.5 - 0.5 * libm::cos(PI * share));
    let slope: Vec<[f64; 2]> = (0..=5)
        .map(|i| {
            let share = f64::from(i) / 5.0;
            [between(radius, neck, share), wall + (shoulder - wall) * share]
        })
        .chain([[neck, cap_low]])
        .collect();
    let body = turned(
        &[
            (&[[0.0, 0.0], [0.92 * radius, 0.0]], Skin::Disc(SPOTS[0])),
            (&[[0.92 * radius, 0.0], [radius, 0.08 * radius]], Skin::Wrap(SPOTS[0])),
            (&[[radius, 0.08 * radius], [radius, wall]], Skin::Wrap(WRAP)),
            (&slope, Skin::Wrap(SPOTS[0])),
            (&[[neck, cap_low], [cap, cap_low]], Skin::Wrap(SPOTS[2])),
            (&[[cap, cap_low], [cap, height]], Skin::Wrap(SPOTS[2])),
            (&[[cap, height], [0.0, height]], Skin::Disc(SPOTS[2])),
        ],
        20,
    )
    .scaled(flatness, 1.0, 1.0);
    let tab = cuboid([0.42 * cap, 0.5 * cap, 0.2 * (height - cap_low)], 0.0, &Faces::all(SPOTS[1]));
    let reach = cap * flatness + shape.uniform(0.2, 0.34) * cap;
    Draft { solid: body.join(tab.moved(reach, 0.0, 0.25 * cap_low + 0.75 * height)), canvas, density: 900.0 }
}
