//! Toy houses.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Palette, Patch, Region, Rgb, hsl, mix};
use crate::object::solid::{Faces, cuboid, prism};
use vantage_dataset::Stream;

const FRONT: Region = Region::new(0, 0, 48, 44);
const BACK: Region = Region::new(48, 0, 48, 44);
const LEFT: Region = Region::new(0, 44, 48, 44);
const RIGHT: Region = Region::new(48, 44, 48, 44);
const FRONT_ROOF: Region = Region::new(0, 88, 64, 40);
const BACK_ROOF: Region = Region::new(64, 88, 64, 40);
const CHIMNEY: Region = Region::new(96, 0, 32, 32);
const GABLE: Region = Region::new(96, 32, 32, 28);
const DARK: Region = Region::new(96, 60, 16, 28);
const AWNING: Region = Region::new(112, 60, 16, 28);

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let half_width = shape.uniform(0.04, 0.062);
    let half_depth = half_width * shape.uniform(0.65, 0.95);
    let wall = half_width * shape.uniform(1.2, 1.8);
    let rise = half_width * shape.uniform(0.6, 1.0);
    let eaves = half_width * shape.uniform(0.1, 0.2);

    let palette = Palette::draw(look);
    let glass = hsl(look.uniform(0.5, 0.62), look.uniform(0.3, 0.7), look.uniform(0.25, 0.5));
    let ground = [Ground::Plain, Ground::Bands, Ground::Checks, Ground::Pinstripes][look.below(4)];
    let grain = look.uniform(0.12, 0.22);
    let mut canvas = Canvas::new(palette.body);
    let window = |patch: &mut Patch<'_>, area: Area, frame: Rgb| {
        patch.rect(area, frame);
        patch.rect(area.part(0.12, 0.1, 0.88, 0.9), glass);
        patch.rect(area.part(0.44, 0.0, 0.56, 1.0), frame);
        patch.rect(area.part(0.0, 0.45, 1.0, 0.55), frame);
    };
    let tones = [palette.body, mix(palette.body, palette.shade, 0.6)];
    canvas.paint(FRONT, [2.0 * half_width, wall], |patch| {
        ground.cover(patch, tones, grain, look);
        let door = 0.5 + look.uniform(-0.08, 0.08);
        let half = look.uniform(0.14, 0.18);
        patch.rect(Area::new(door - half - 0.04, 0.26, door + half + 0.04, 1.0), palette.panel);
        patch.rect(Area::new(door - half, 0.32, door + half, 1.0), palette.accent);
        patch.disc(patch.square([door + 0.6 * half, 0.68], 0.04), palette.panel);
        for s in [0.16, 0.84] {
            window(patch, Area::around([s, 0.45], [0.12, 0.2]), palette.panel);
        }
    });
    canvas.paint(BACK, [2.0 * half_width, wall], |patch| {
        ground.cover(patch, tones, grain, look);
        for s in [0.2, 0.5, 0.8] {
            window(patch, Area::around([s, 0.32], [0.11, 0.16]), palette.panel);
        }
        patch.rect(Area::band(look.uniform(0.6, 0.7), 1.0), palette.accent);
    });
    canvas.paint(LEFT, [2.0 * half_depth, wall], |patch| {
        ground.cover(patch, tones, grain, look);
        let size = look.uniform(0.24, 0.32);
        let porthole = patch.square([0.5 + look.uniform(-0.07, 0.07), 0.45], size);
        patch.disc(porthole, palette.panel);
        patch.disc(porthole.part(0.12, 0.12, 0.88, 0.88), glass);
    });
    let leaf = hsl(look.uniform(0.22, 0.4), look.uniform(0.5, 0.8), look.uniform(0.22, 0.4));
    canvas.paint(RIGHT, [2.0 * half_depth, wall], |patch| {
        ground.cover(patch, tones, grain, look);
        for s in [0.3, 0.7] {
            window(patch, Area::around([s, 0.3], [0.12, 0.18]), palette.panel);
        }
        for i in 0..7 {
            let center = [0.08 + 0.14 * f64::from(i), look.uniform(0.78, 0.92)];
            patch.disc(patch.square(center, look.uniform(0.12, 0.22)), leaf);
        }
    });
    let tiles = palette.trim;
    let roof_ground = [Ground::Plain, Ground::Bands, Ground::Checks, Ground::Diagonals][look.below(4)];
    for region in [FRONT_ROOF, BACK_ROOF] {
        canvas.paint(region, [2.0 * half_width, rise], |patch| {
            roof_ground.cover(patch, [tiles, mix(tiles, [0.0; 3], 0.3)], 0.2, look);
            if region == FRONT_ROOF {
                let skylight = Area::around([0.3 + look.uniform(-0.04, 0.04), 0.5], [0.13, 0.24]);
                window(patch, skylight, palette.panel);
            }
        });
    }
    canvas.paint(CHIMNEY, [1.0, 1.0], |patch| {
        Ground::Bands.cover(patch, [[0.62, 0.28, 0.2], [0.5, 0.22, 0.17]], 0.2, look);
    });
    let emblem = Emblem::draw(look);
    canvas.paint(GABLE, [2.0 * half_depth, rise], |patch| {
        patch.fill(palette.shade);
        patch.emblem(Area::new(0.3, 0.4, 0.7, 0.95), emblem, palette.panel);
    });
    canvas.plain(AWNING, palette.accent);
    canvas.plain(DARK, mix(tiles, [0.0; 3], 0.5));

    let walls = cuboid(
        [half_depth, half_width, 0.5 * wall],
        0.0,
        &Faces { front: FRONT, back: BACK, left: LEFT, right: RIGHT, top: DARK, bottom: DARK },
    );
    let edge = half_depth + eaves;
    let roof = prism(
        &[[-edge, 0.0], [edge, 0.0], [0.0, rise]],
        [0.0, 0.4 * rise],
        half_width + 0.6 * eaves,
        &[DARK, FRONT_ROOF, BACK_ROOF],
        GABLE,
        GABLE,
    );
    let stack = half_width * shape.uniform(0.13, 0.2);
    let stack_half_height = rise * shape.uniform(0.4, 0.55);
    let chimney = cuboid([stack, stack, stack_half_height], 0.0, &Faces::around(CHIMNEY, DARK));
    let porch = [half_depth * shape.uniform(0.2, 0.32), half_width * shape.uniform(0.36, 0.5)];
    let step = cuboid([porch[0], porch[1], 0.05 * wall], 0.0, &Faces::all(DARK));
    let awning = cuboid([porch[0], porch[1], 0.03 * wall], 0.0, &Faces::all(AWNING));
    let solid = walls
        .moved(0.0, 0.0, 0.5 * wall)
        .join(roof.moved(0.0, 0.0, wall))
        .join(chimney.moved(-0.5 * half_depth, half_width * shape.uniform(0.4, 0.62), wall + 0.7 * rise))
        .join(step.moved(half_depth + 0.9 * porch[0], 0.0, 0.05 * wall))
        .join(awning.moved(half_depth + 0.9 * porch[0], 0.0, 0.78 * wall));
    Draft { solid, canvas, density: 400.0 }
}
