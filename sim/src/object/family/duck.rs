//! Bath ducks.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Palette, Region, hsl, mix};
use crate::object::solid::{Skin, ellipsoid, turned};
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

const BODY: Region = Region::new(0, 0, 128, 56);
const HEAD: Region = Region::new(0, 56, 128, 40);
const BEAK: Region = Region::new(0, 96, 32, 32);
const LEFT_WING: Region = Region::new(32, 96, 32, 32);
const RIGHT_WING: Region = Region::new(64, 96, 32, 32);
const HAT: Region = Region::new(96, 96, 32, 32);

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let half_length = shape.uniform(0.04, 0.062);
    let half_width = half_length * shape.uniform(0.66, 0.82);
    let half_height = half_length * shape.uniform(0.55, 0.72);
    let head = half_length * shape.uniform(0.46, 0.58);
    let neck = Vector3::new(half_length * shape.uniform(0.34, 0.48), 0.0, half_height + 0.62 * head);

    let palette = Palette::draw(look);
    let ground = Ground::draw(look);
    let grain = look.uniform(0.16, 0.35);
    let mut canvas = Canvas::new(palette.body);
    canvas.wrap(BODY, [PI * (half_length + half_width), PI * half_height], |patch| {
        ground.cover(patch, [palette.body, mix(palette.body, palette.shade, 0.7)], grain, look);
        let bib = look.uniform(36.0, 50.0) / 360.0;
        patch.disc(Area::new(0.5 - bib, 0.05, 0.5 + bib, 0.85), palette.panel);
        let tail = look.uniform(22.0, 32.0) / 360.0;
        patch.rect(Area::new(1.0 - tail, 0.0, 1.0 + tail, 1.0), palette.accent);
    });
    canvas.wrap(HEAD, [2.0 * PI * head, PI * head], |patch| {
        patch.fill(palette.body);
        patch.rect(Area::band(0.0, look.uniform(0.15, 0.28)), palette.shade);
        patch.rect(Area::band(look.uniform(0.82, 0.88), 1.0), palette.trim);
        let gap = look.uniform(38.0, 50.0) / 360.0;
        let size = look.uniform(0.07, 0.1);
        for s in [0.5 - gap, 0.5 + gap] {
            patch.disc(patch.square([s, 0.44], 1.8 * size), [0.98, 0.98, 0.98]);
            patch.disc(patch.square([s, 0.45], size), [0.06, 0.06, 0.08]);
        }
    });
    let bill = hsl(look.uniform(0.02, 0.12), 0.95, look.uniform(0.42, 0.55));
    canvas.plain(BEAK, if look.chance(0.7) { bill } else { palette.accent });
    let emblem = Emblem::draw(look);
    canvas.paint(LEFT_WING, [1.0, 1.0], |patch| {
        patch.fill(palette.shade);
        patch.emblem(Area::new(0.2, 0.2, 0.8, 0.8), emblem, palette.panel);
    });
    canvas.plain(RIGHT_WING, palette.accent);
    canvas.plain(HAT, palette.trim);

    let flat = -0.62 * half_height;
    let body = ellipsoid([half_length, half_width, half_height], 20, 10, BODY).bent(|mut p| {
        p.z = p.z.max(flat);
        let rear = (-p.x / half_length - 0.35).max(0.0);
        p.z += 1.8 * half_height * rear * rear * (0.3 + 0.7 * p.z / half_height).max(0.0);
        p
    });
    let bill_length = head * shape.uniform(0.55, 0.8);
    let beak = turned(
        &[
            (&[[0.0, 0.0], [0.5 * head, 0.0]], Skin::Disc(BEAK)),
            (&[[0.5 * head, 0.0], [0.42 * head, 0.5 * bill_length], [0.0, bill_length]], Skin::Wrap(BEAK)),
        ],
        10,
    )
    .turned(Vector3::y_axis(), 0.5 * PI)
    .scaled(1.0, 1.0, 0.45);
    let wing = |side: f64, region: Region| {
        ellipsoid([0.5 * half_length, 0.16 * half_width, 0.45 * half_height], 10, 6, region)
            .turned(Vector3::z_axis(), side * 0.25)
            .moved(-0.18 * half_length, side * 0.93 * half_width, 0.12 * half_height)
    };
    let mut solid = body
        .join(ellipsoid([head; 3], 16, 8, HEAD).moved(neck.x, 0.0, neck.z))
        .join(beak.moved(neck.x + 0.8 * head, 0.0, neck.z - 0.1 * head))
        .join(wing(1.0, LEFT_WING))
        .join(wing(-1.0, RIGHT_WING));
    if shape.chance(0.4) {
        let top = 0.7 * head;
        let hat = turned(
            &[
                (&[[0.0, 0.0], [top, 0.0]], Skin::Disc(HAT)),
                (&[[top, 0.0], [0.6 * top, 0.5 * top], [0.0, 0.7 * top]], Skin::Wrap(HAT)),
            ],
            12,
        );
        solid = solid.join(hat.moved(neck.x - 0.1 * head, 0.0, neck.z + 0.7 * head));
    }
    Draft { solid, canvas, density: 300.0 }
}
