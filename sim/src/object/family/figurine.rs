//! Dolls.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Label, Palette, Region, hsl};
use crate::object::solid::{Faces, Skin, cuboid, ellipsoid, tube, turned};
use nalgebra::Vector3;
use std::f64::consts::PI;
use vantage_dataset::Stream;

const HEAD: Region = Region::new(0, 0, 128, 48);
const COAT: Region = Region::new(0, 48, 128, 48);
const HAT: Region = Region::new(0, 96, 32, 32);
const SLEEVE: Region = Region::new(32, 96, 32, 32);
const PACK: Region = Region::new(64, 96, 32, 32);
const BALL: Region = Region::new(96, 96, 32, 32);

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let height = shape.uniform(0.1, 0.17);
    let hem = height * shape.uniform(0.2, 0.27);
    let waist = hem * shape.uniform(0.6, 0.85);
    let neck = 0.55 * height;
    let head = height * shape.uniform(0.19, 0.24);

    let palette = Palette::draw(look);
    let skin = hsl(look.uniform(0.05, 0.1), look.uniform(0.35, 0.6), look.uniform(0.4, 0.82));
    let hair = match look.below(3) {
        0 => hsl(look.uniform(0.04, 0.14), look.uniform(0.4, 0.8), look.uniform(0.1, 0.5)),
        1 => palette.accent,
        _ => hsl(look.unit(), 0.3, 0.12),
    };
    let mut canvas = Canvas::new(palette.body);
    canvas.wrap(HEAD, [2.0 * PI * head, PI * head], |patch| {
        patch.fill(hair);
        let face = Label::share(look.uniform(-5.0, 5.0));
        let brow = look.uniform(0.26, 0.36);
        let cheek = look.uniform(52.0, 66.0) / 360.0;
        patch.disc(Area::new(face - cheek, brow, face + cheek, 1.1), skin);
        let gap = look.uniform(19.0, 25.0) / 360.0;
        let size = look.uniform(0.055, 0.08);
        for side in [-gap, gap] {
            patch.disc(patch.square([face + side, 0.5], 1.5 * size), [0.98, 0.98, 0.98]);
            patch.disc(patch.square([face + side, 0.51], size), [0.08, 0.06, 0.08]);
        }
        let mouth = look.uniform(12.0, 22.0) / 360.0;
        patch.disc(Area::new(face - mouth, 0.66, face + mouth, 0.76), [0.75, 0.12, 0.14]);
    });
    let ground = Ground::draw(look);
    let grain = look.uniform(0.15, 0.35);
    canvas.wrap(COAT, [2.0 * PI * waist, neck], |patch| {
        ground.cover(patch, [palette.body, palette.shade], grain, look);
        let half = look.uniform(20.0, 32.0) / 360.0;
        patch.rect(Area::new(0.5 - half, 0.0, 0.5 + half, 1.0), palette.panel);
        for t in [0.2, 0.45, 0.7] {
            patch.disc(patch.square([0.5, t], 0.07), palette.ink);
        }
        let belt = look.uniform(0.5, 0.6);
        patch.rect(Area::band(belt, belt + 0.1), palette.trim);
        patch.rect(Area::band(0.9, 1.0), palette.accent);
    });
    canvas.plain(HAT, palette.accent);
    canvas.plain(SLEEVE, palette.shade);
    let emblem = Emblem::draw(look);
    canvas.paint(PACK, [1.0, 1.0], |patch| {
        patch.fill(palette.trim);
        patch.emblem(Area::new(0.15, 0.15, 0.85, 0.85), emblem, palette.panel);
    });
    canvas.paint(BALL, [2.0, 1.0], |patch| {
        patch.fill(palette.accent);
        patch.rect(Area::band(0.4, 0.6), palette.panel);
    });

    let coat = turned(
        &[
            (&[[0.0, 0.0], [hem, 0.0]], Skin::Disc(SLEEVE)),
            (
                &[
                    [hem, 0.0],
                    [0.97 * hem, 0.1 * neck],
                    [waist, 0.5 * neck],
                    [0.85 * waist, 0.85 * neck],
                    [0.45 * waist, neck],
                ],
                Skin::Wrap(COAT),
            ),
            (&[[0.45 * waist, neck], [0.0, neck]], Skin::Disc(SLEEVE)),
        ],
        16,
    );
    let face = ellipsoid([head, 0.95 * head, head], 16, 8, HEAD).moved(0.0, 0.0, neck + 0.8 * head);
    let shoulder = Vector3::new(0.0, 0.75 * waist, 0.8 * neck);
    let lift = shape.uniform(0.0, 0.25) * neck;
    let arm_radius = 0.2 * waist;
    let arm = |side: f64, hand: Vector3<f64>| {
        let start = Vector3::new(shoulder.x, side * shoulder.y, shoulder.z);
        let bend = 0.5 * (start + hand) + Vector3::new(0.0, side * 0.25 * waist, 0.0);
        let plane = (bend - start).cross(&(hand - start)).normalize();
        let path: Vec<Vector3<f64>> = (0..5)
            .map(|i| {
                let u = f64::from(i) / 4.0;
                start * ((1.0 - u) * (1.0 - u)) + bend * (2.0 * u * (1.0 - u)) + hand * (u * u)
            })
            .collect();
        tube(&path, |_| [arm_radius, arm_radius], plane, 6, SLEEVE)
    };
    let right_hand = Vector3::new(0.6 * waist, -1.35 * waist, 0.5 * neck + lift);
    let left_hand = Vector3::new(0.15 * waist, 1.4 * waist, 0.35 * neck);
    let ball = shape.uniform(0.3, 0.45) * waist;
    let pack = [0.3 * waist, shape.uniform(0.5, 0.65) * waist, shape.uniform(0.2, 0.27) * neck];
    let mut solid = coat
        .join(face)
        .join(arm(1.0, left_hand))
        .join(arm(-1.0, right_hand))
        .join(ellipsoid([ball; 3], 10, 6, BALL).moved(right_hand.x + 0.6 * ball, right_hand.y, right_hand.z))
        .join(cuboid(pack, 0.2 * pack[0], &Faces::all(PACK)).moved(-waist - 0.4 * pack[0], 0.0, 0.62 * neck));
    if shape.chance(0.6) {
        let brim = neck + 1.45 * head;
        let tip = shape.uniform(0.5, 1.0) * head;
        let hat = turned(
            &[
                (&[[0.0, 0.0], [0.8 * head, 0.0]], Skin::Disc(HAT)),
                (&[[0.8 * head, 0.0], [0.4 * head, 0.6 * tip], [0.0, tip]], Skin::Wrap(HAT)),
            ],
            14,
        );
        solid = solid.join(hat.moved(-0.1 * head, 0.0, brim));
    }
    Draft { solid, canvas, density: 500.0 }
}
