//! Toy cars.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Palette, Patch, Region, Rgb, mix};
use crate::object::solid::{Faces, Skin, cuboid, prism, turned};
use nalgebra::Vector3;
use vantage_dataset::Stream;

const LEFT: Region = Region::new(0, 0, 64, 40);
const RIGHT: Region = Region::new(64, 0, 64, 40);
const FRONT: Region = Region::new(0, 40, 48, 28);
const BACK: Region = Region::new(48, 40, 48, 28);
const HOOD: Region = Region::new(0, 68, 48, 32);
const ROOF: Region = Region::new(48, 68, 48, 32);
const GLASS: Region = Region::new(96, 40, 32, 28);
const WHEEL: Region = Region::new(96, 68, 32, 32);
const TRUNK: Region = Region::new(0, 100, 48, 28);
const TYRE: Region = Region::new(48, 100, 32, 28);
const SPOILER: Region = Region::new(80, 100, 48, 28);

const RUBBER: Rgb = [0.1, 0.1, 0.11];

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let length = shape.uniform(0.11, 0.19);
    let half_width = length * shape.uniform(0.2, 0.26);
    let wheel = length * shape.uniform(0.1, 0.13);
    let floor = 0.6 * wheel;
    let belt = floor + length * shape.uniform(0.13, 0.18);
    let roof = belt + length * shape.uniform(0.13, 0.2);
    let nose = floor + (belt - floor) * shape.uniform(0.6, 0.85);
    let half = 0.5 * length;
    let cowl = length * shape.uniform(0.1, 0.2);
    let roof_front = cowl - length * shape.uniform(0.1, 0.17);
    let roof_back = -length * shape.uniform(0.2, 0.34);
    let deck = (roof_back - length * shape.uniform(0.02, 0.12)).max(0.04 * length - half);
    let corners = [
        [-half, floor],
        [half, floor],
        [half, nose],
        [cowl, belt],
        [roof_front, roof],
        [roof_back, roof],
        [deck, belt],
        [-half, belt],
    ];

    let palette = Palette::draw(look);
    let glass = [0.16, 0.2, 0.26].map(|c: f32| c + look.uniform(0.0, 0.14) as f32);
    let emblem = Emblem::draw(look);
    let stripe = look.uniform(0.12, 0.2);
    let two_tone = look.chance(0.4);
    let mut canvas = Canvas::new(palette.body);
    let belt_share = (roof - belt) / (roof - floor);
    let number = look.uniform(0.16, 0.2);
    let sill = look.uniform(0.12, 0.22);
    let side = |patch: &mut Patch<'_>, ahead: f64| {
        // `ahead` is +1 where the car's front is on the right of the patch.
        let s = |x: f64| 0.5 + 0.5 * ahead * x / half;
        let span = |a: f64, b: f64| (s(a).min(s(b)), s(a).max(s(b)));
        patch.fill(palette.body);
        if two_tone {
            patch.rect(Area::band(0.0, belt_share), palette.trim);
        }
        patch.rect(Area::band(1.0 - sill, 1.0), palette.shade);
        let (left, right) = span(roof_back + 0.02 * length, roof_front + 0.02 * length);
        patch.rect(Area::new(left, 0.18 * belt_share, right, 0.95 * belt_share), glass);
        let pillar = s(0.5 * (roof_back + roof_front));
        patch.rect(Area::new(pillar - 0.02, 0.0, pillar + 0.02, belt_share), palette.body);
        let center = [s(0.5 * (roof_back + roof_front)), 0.5 * (belt_share + 1.0)];
        patch.disc(patch.square(center, number), palette.panel);
        patch.emblem(patch.square(center, 0.7 * number), emblem, palette.ink);
        let (left, right) = span(0.86 * half, half);
        patch.rect(Area::new(left, belt_share + 0.1, right, belt_share + 0.3), [1.0, 0.95, 0.6]);
        let (left, right) = span(-half, -0.88 * half);
        patch.rect(Area::new(left, belt_share + 0.06, right, belt_share + 0.26), [0.85, 0.06, 0.06]);
    };
    let size = [length, roof - floor];
    canvas.paint(LEFT, size, |patch| side(patch, -1.0));
    canvas.paint(RIGHT, size, |patch| side(patch, 1.0));
    canvas.paint(FRONT, [2.0 * half_width, nose - floor], |patch| {
        patch.fill(palette.body);
        patch.rect(Area::new(0.28, 0.35, 0.72, 0.85), RUBBER);
        for s in [0.14, 0.86] {
            patch.disc(Area::around([s, 0.45], [0.12, 0.32]), [1.0, 0.96, 0.7]);
        }
        patch.rect(Area::band(0.88, 1.0), [0.75, 0.76, 0.78]);
    });
    canvas.paint(BACK, [2.0 * half_width, belt - floor], |patch| {
        patch.fill(palette.shade);
        for s in [0.12, 0.88] {
            patch.rect(Area::around([s, 0.4], [0.12, 0.2]), [0.85, 0.06, 0.06]);
        }
        patch.rect(Area::new(0.34, 0.4, 0.66, 0.7), palette.panel);
    });
    let ground = Ground::draw(look);
    for (region, base) in [(HOOD, palette.body), (ROOF, if two_tone { palette.trim } else { palette.body })] {
        canvas.paint(region, [2.0 * half_width, 0.35 * length], |patch| {
            patch.fill(base);
            patch.rect(Area::new(0.5 - stripe, 0.0, 0.5 + stripe, 1.0), palette.accent);
        });
    }
    canvas.paint(TRUNK, [2.0 * half_width, 0.2 * length], |patch| {
        ground.cover(patch, [palette.body, palette.shade], 0.3, look);
    });
    canvas.plain(GLASS, glass);
    canvas.paint(WHEEL, [1.0, 1.0], |patch| {
        patch.fill(RUBBER);
        patch.disc(Area::around([0.5, 0.5], [0.33, 0.33]), mix(palette.panel, [0.7, 0.7, 0.72], 0.4));
        patch.disc(Area::around([0.5, 0.5], [0.12, 0.12]), palette.accent);
    });
    canvas.plain(TYRE, RUBBER);
    canvas.plain(SPOILER, palette.accent);

    let edges = [TYRE, FRONT, HOOD, GLASS, ROOF, GLASS, TRUNK, BACK];
    let hub = [0.5 * (roof_back + roof_front), floor + 0.3 * (nose - floor)];
    let mut solid = prism(&corners, hub, half_width, &edges, LEFT, RIGHT);
    let tread = half_width * shape.uniform(0.14, 0.22);
    for (x, side) in [(0.62, 1.0), (0.62, -1.0), (-0.6, 1.0), (-0.6, -1.0)] {
        let upright = turned(
            &[
                (&[[0.0, -tread], [wheel, -tread]], Skin::Disc(WHEEL)),
                (&[[wheel, -tread], [wheel, tread]], Skin::Wrap(TYRE)),
                (&[[wheel, tread], [0.0, tread]], Skin::Disc(WHEEL)),
            ],
            12,
        );
        let turned = upright.turned(Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        solid = solid.join(turned.moved(x * half, side * half_width, wheel));
    }
    if shape.chance(0.5) {
        let wing = cuboid([0.05 * length, 0.95 * half_width, 0.012 * length], 0.0, &Faces::all(SPOILER));
        let post = cuboid([0.02 * length, 0.1 * half_width, 0.04 * length], 0.0, &Faces::all(SPOILER));
        solid = solid.join(wing.moved(0.04 * length - half, 0.0, belt + 0.09 * length)).join(post.moved(
            0.05 * length - half,
            0.0,
            belt + 0.04 * length,
        ));
    }
    Draft { solid, canvas, density: 450.0 }
}
