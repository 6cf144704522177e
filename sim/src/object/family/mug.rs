//! Mugs.

use super::{Draft, SPOTS, WRAP};
use crate::object::paint::{Area, Canvas, Emblem, Ground, Label, Palette, mix};
use crate::object::solid::{Skin, arc, tube, turned};
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let radius = shape.uniform(0.034, 0.047);
    let height = radius * shape.uniform(1.9, 2.7);
    let foot = radius * shape.uniform(0.72, 1.0);
    let [inner, floor] = [0.9 * radius, 0.1 * radius];

    let palette = Palette::draw(look);
    let ground = Ground::draw(look);
    let emblem = Emblem::draw(look);
    let grain = look.uniform(0.1, 0.3);
    let mut canvas = Canvas::new(palette.body);
    canvas.wrap(WRAP, [2.0 * PI * radius, height], |patch| {
        ground.cover(patch, [palette.body, mix(palette.body, palette.shade, 0.7)], grain, look);
        let band = look.uniform(0.05, 0.12);
        patch.rect(Area::band(0.0, band), palette.trim);
        let mut at = |azimuth: f64, width: [f64; 2], height: [f64; 2]| {
            let s = Label::share(azimuth + look.uniform(-8.0, 8.0));
            let half = [look.uniform(width[0], width[1]) / 360.0, look.uniform(height[0], height[1])];
            Area::around([s, 0.54], half)
        };
        let [front, back, side] = [
            at(0.0, [40.0, 52.0], [0.3, 0.38]),
            at(180.0, [36.0, 48.0], [0.14, 0.2]),
            at(-92.0, [13.0, 18.0], [0.42, 0.45]),
        ];
        patch.disc(front, palette.panel);
        patch.emblem(front.part(0.14, 0.1, 0.86, 0.9), emblem, palette.logo);
        patch.rect(side, palette.accent);
        patch.writing(back, 2, palette.panel, look);
    });
    canvas.plain(SPOTS[0], palette.trim);
    let inside = if look.chance(0.5) { palette.panel } else { mix(palette.body, [1.0; 3], 0.35) };
    canvas.paint(SPOTS[1], [2.0, 1.0], |patch| patch.fade(Area::ALL, inside, mix(inside, [0.0; 3], 0.4)));
    canvas.plain(SPOTS[2], mix(inside, [0.0; 3], 0.45));

    let cup = turned(
        &[
            (&[[0.0, 0.0], [0.95 * foot, 0.0]], Skin::Disc(SPOTS[3])),
            (&[[0.95 * foot, 0.0], [foot, 0.05 * radius]], Skin::Wrap(SPOTS[3])),
            (
                &[
                    [foot, 0.05 * radius],
                    [0.5 * (foot + radius) + 0.02 * radius, 0.4 * height],
                    [radius, height],
                ],
                Skin::Wrap(WRAP),
            ),
            (&[[radius, height], [inner, height]], Skin::Wrap(SPOTS[0])),
            (&[[inner, height], [0.9 * foot, floor]], Skin::Wrap(SPOTS[1])),
            (&[[0.9 * foot, floor], [0.0, floor]], Skin::Disc(SPOTS[2])),
        ],
        20,
    );
    let reach = radius * shape.uniform(0.62, 0.95);
    let thickness = radius * shape.uniform(0.13, 0.2);
    let path = arc(
        Vector3::new(0.0, 0.9 * radius, height * shape.uniform(0.48, 0.56)),
        Vector3::y() * reach,
        Vector3::z() * (height * shape.uniform(0.28, 0.36)),
        [-0.5 * PI, 0.5 * PI],
        10,
    );
    let handle = tube(&path, |_| [0.75 * thickness, 1.1 * thickness], Vector3::x(), 8, SPOTS[0]);
    Draft { solid: cup.join(handle), canvas, density: 2300.0 }
}
