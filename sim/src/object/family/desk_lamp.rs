//! Desk lamps.

use super::{Draft, SPOTS, SQUARE, WRAP};
use crate::object::paint::{Area, Canvas, Ground, Label, Palette, mix};
use crate::object::solid::{Skin, tube, turned};
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let height = shape.uniform(0.15, 0.21);
    let base = height * shape.uniform(0.24, 0.3);
    let plinth = height * shape.uniform(0.08, 0.14);
    let shade_radius = height * shape.uniform(0.2, 0.27);
    let shade_length = height * shape.uniform(0.34, 0.44);
    let crown = shade_radius * shape.uniform(0.35, 0.6);
    let tilt = shape.uniform(0.6, 0.95);

    let palette = Palette::draw(look);
    let ground = Ground::draw(look);
    let grain = look.uniform(0.16, 0.35);
    let mut canvas = Canvas::new(palette.trim);
    canvas.wrap(WRAP, [1.6 * PI * shade_radius, shade_length], |patch| {
        ground.cover(patch, [palette.body, palette.shade], grain, look);
        let edge = look.uniform(0.1, 0.2);
        patch.rect(Area::band(1.0 - edge, 1.0), palette.accent);
        let half = look.uniform(22.0, 32.0) / 360.0;
        patch.rect(Area::around([Label::share(90.0), 0.5], [half, 0.5]), palette.panel);
        patch.disc(Area::around([Label::share(-90.0), 0.45], [half, 0.3]), palette.accent);
    });
    canvas.paint(SQUARE, [1.0, 1.0], |patch| {
        patch.fill(palette.body);
        patch.rect(Area::new(0.0, 0.0, 0.5, 1.0), palette.shade);
        patch.disc(Area::around([0.5, 0.8], [0.16, 0.13]), palette.accent);
        patch.disc(Area::around([0.5, 0.8], [0.08, 0.07]), palette.panel);
    });
    canvas.wrap(SPOTS[0], [2.0 * PI * base, plinth], |patch| {
        patch.fill(palette.body);
        patch.rect(Area::around([0.5, 0.5], [0.07, 0.5]), palette.accent);
        patch.rect(Area::around([Label::share(-90.0), 0.5], [0.06, 0.5]), palette.panel);
    });
    canvas.paint(SPOTS[1], [1.0, 1.0], |patch| {
        patch.fill([0.98, 0.9, 0.55]);
        patch.disc(Area::around([0.5, 0.5], [0.26, 0.26]), [1.0, 0.99, 0.9]);
    });
    canvas.plain(SPOTS[3], mix(palette.body, [0.0; 3], 0.4));

    let stand = turned(
        &[
            (&[[0.0, 0.0], [base, 0.0]], Skin::Disc(SPOTS[3])),
            (&[[base, 0.0], [0.92 * base, plinth]], Skin::Wrap(SPOTS[0])),
            (&[[0.92 * base, plinth], [0.0, plinth]], Skin::Disc(SQUARE)),
        ],
        20,
    );
    let shade = turned(
        &[
            (&[[0.0, 0.0], [shade_radius, 0.0]], Skin::Disc(SPOTS[1])),
            (&[[shade_radius, 0.0], [crown, shade_length]], Skin::Wrap(WRAP)),
            (&[[crown, shade_length], [0.0, shade_length]], Skin::Disc(SPOTS[2])),
        ],
        20,
    );
    // Tilted so that the bulb, at the shade's lower end, looks forwards and down.
    let tilted = shade.moved(0.0, 0.0, -shade_length).turned(Vector3::y_axis(), -tilt);
    let foot = Vector3::new(-0.45 * base, 0.0, 0.8 * plinth);
    let joint = Vector3::new(0.0, 0.0, height);
    let elbow = Vector3::new(-base * shape.uniform(1.0, 1.5), 0.0, height * shape.uniform(0.6, 0.75));
    let path: Vec<Vector3<f64>> = (0..9)
        .map(|i| {
            let u = f64::from(i) / 8.0;
            foot * ((1.0 - u) * (1.0 - u)) + elbow * (2.0 * u * (1.0 - u)) + joint * (u * u)
        })
        .collect();
    let thickness = height * shape.uniform(0.025, 0.04);
    let arm = tube(&path, |_| [thickness; 2], Vector3::y(), 7, SPOTS[2]);
    Draft { solid: stand.join(arm).join(tilted.moved(0.02 * height, 0.0, height)), canvas, density: 500.0 }
}
