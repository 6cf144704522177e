//! Spray bottles.

use super::{Draft, SPOTS, WRAP};
use crate::object::paint::{Area, Canvas, Label, Palette, mix};
use crate::object::solid::{Faces, Skin, cuboid, tube, turned};
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let radius = shape.uniform(0.034, 0.046);
    let flatness = shape.uniform(0.62, 0.85);
    let wall = radius * shape.uniform(1.8, 2.5);
    let shoulder = wall + radius * shape.uniform(0.6, 1.1);
    let neck = radius * shape.uniform(0.28, 0.36);
    let head_low = shoulder + 0.5 * radius;

    let palette = Palette::draw(look);
    let label = Label::draw(palette, look);
    let mut canvas = Canvas::new(palette.trim);
    canvas.wrap(WRAP, [1.7 * PI * radius, wall], |patch| {
        label.background(patch, look);
        let mut at = |azimuth: f64, half: [f64; 2]| {
            let s = Label::share(azimuth + look.uniform(-8.0, 8.0));
            Area::around([s, look.uniform(0.47, 0.53)], [look.uniform(half[0], half[1]) / 360.0, 0.4])
        };
        let [front, table] = [at(90.0, [42.0, 54.0]), at(-90.0, [26.0, 34.0])];
        label.front(patch, front, look);
        patch.table(table, 5, look);
        patch.rect(Area::around([0.5, 0.5], [look.uniform(10.0, 16.0) / 360.0, 0.5]), palette.accent);
    });
    canvas.plain(SPOTS[0], palette.body);
    canvas.plain(SPOTS[2], palette.accent);
    canvas.plain(SPOTS[3], mix(palette.trim, [0.0; 3], 0.45));

    let slope: Vec<[f64; 2]> = (0..=4)
        .map(|i| {
            let share = f64::from(i) / 4.0;
            let r = neck + (radius - neck) * libm::cos(0.5 * PI * share);
            [r, wall + (shoulder - wall) * libm::sin(0.5 * PI * share)]
        })
        .collect();
    let body = turned(
        &[
            (&[[0.0, 0.0], [radius, 0.0]], Skin::Disc(SPOTS[0])),
            (&[[radius, 0.0], [radius, wall]], Skin::Wrap(WRAP)),
            (&slope, Skin::Wrap(SPOTS[0])),
            (&[[neck, shoulder], [neck, head_low]], Skin::Wrap(SPOTS[3])),
            (&[[neck, head_low], [0.0, head_low]], Skin::Disc(SPOTS[3])),
        ],
        20,
    )
    .scaled(1.0, flatness, 1.0);
    let head = [radius * shape.uniform(0.85, 1.05), 0.42 * radius, radius * shape.uniform(0.3, 0.4)];
    let ahead = radius * shape.uniform(0.35, 0.5);
    let nozzle = cuboid([0.16 * radius, 0.26 * radius, 0.22 * radius], 0.0, &Faces::all(SPOTS[2]));
    let head_z = head_low + 0.8 * head[2];
    let from = Vector3::new(ahead + 0.45 * head[0], 0.0, head_low);
    let reach = radius * shape.uniform(0.15, 0.35);
    let drop = radius * shape.uniform(0.9, 1.2);
    let path = [
        from,
        from + Vector3::new(0.9 * reach, 0.0, -0.35 * drop),
        from + Vector3::new(0.9 * reach, 0.0, -0.7 * drop),
        from + Vector3::new(0.3 * reach, 0.0, -drop),
    ];
    let trigger = tube(&path, |u| [radius * (0.16 - 0.06 * u), 0.2 * radius], Vector3::y(), 6, SPOTS[2]);
    Draft {
        solid: body
            .join(cuboid(head, 0.3 * head[2], &Faces::all(SPOTS[1])).moved(ahead, 0.0, head_z))
            .join(nozzle.moved(ahead + head[0] + 0.1 * radius, 0.0, head_z))
            .join(trigger),
        canvas,
        density: 700.0,
    }
}
