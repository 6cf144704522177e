//! Books, lying; the reader of the cover stands in front.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Palette, Region, hsl, mix};
use crate::object::solid::{Faces, cuboid};
use vantage_dataset::Stream;

const COVER: Region = Region::new(0, 0, 64, 84);
const BACK: Region = Region::new(64, 0, 64, 84);
const SPINE: Region = Region::new(0, 84, 80, 22);
const FOOT_PAGES: Region = Region::new(0, 106, 64, 22);
const HEAD_PAGES: Region = Region::new(64, 106, 64, 22);
const EDGE: Region = Region::new(80, 84, 24, 22);
const RIBBON: Region = Region::new(104, 84, 24, 22);

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let length = shape.uniform(0.13, 0.2);
    let width = length * shape.uniform(0.66, 0.84);
    let thickness = length * shape.uniform(0.18, 0.34);
    let board = 0.08 * thickness;

    let palette = Palette::draw(look);
    let emblem = Emblem::draw(look);
    let ground = Ground::draw(look);
    let grain = look.uniform(0.06, 0.2);
    let mut canvas = Canvas::new(palette.body);
    canvas.paint(COVER, [width, length], |patch| {
        ground.cover(patch, [palette.body, palette.shade], grain, look);
        patch.rect(Area::new(0.0, 0.0, look.uniform(0.1, 0.16), 1.0), palette.trim);
        let title = look.uniform(0.34, 0.42);
        patch.rect(Area::new(0.2, 0.07, 0.96, title), palette.panel);
        patch.writing(Area::new(0.27, 0.09, 0.92, title), 2, palette.ink, look);
        let t = look.uniform(0.59, 0.64);
        let size = look.uniform(0.17, 0.22);
        let picture = patch.square([0.58 + look.uniform(-0.05, 0.05), t], size);
        patch.emblem(picture, emblem, palette.over(palette.body));
        patch.rect(Area::new(0.0, 0.84, 1.0, 1.0), palette.accent);
        patch.writing(Area::new(0.3, 0.88, 0.86, 0.98), 1, palette.over(palette.accent), look);
    });
    canvas.paint(BACK, [width, length], |patch| {
        patch.fill(palette.body);
        patch.writing(Area::new(0.15, 0.1, 0.85, 0.5), 6, palette.panel, look);
        patch.barcode(Area::new(0.5, 0.7, 0.9, 0.9), look);
    });
    canvas.paint(SPINE, [length, thickness], |patch| {
        patch.fill(palette.trim);
        patch.rect(Area::new(0.12, 0.1, look.uniform(0.55, 0.7), 0.9), palette.panel);
        patch.writing(Area::new(0.16, 0.2, 0.6, 0.85), 1, palette.ink, look);
        patch.emblem(Area::new(0.78, 0.1, 0.96, 0.9), emblem, palette.over(palette.trim));
    });
    let paper = hsl(look.uniform(0.09, 0.15), look.uniform(0.15, 0.4), look.uniform(0.82, 0.93));
    let shadow = mix(paper, [0.3, 0.25, 0.2], 0.35);
    for (region, extent) in [(FOOT_PAGES, width), (HEAD_PAGES, length)] {
        canvas.paint(region, [extent, thickness], |patch| {
            Ground::Bands.cover(patch, [paper, shadow], 0.25, look);
        });
    }
    canvas.plain(EDGE, mix(palette.body, [0.0; 3], 0.15));
    canvas.plain(RIBBON, palette.accent);

    let (half_length, half_width) = (0.5 * length, 0.5 * width);
    let slab = |top: Region, bottom: Region| {
        let faces = Faces { top, bottom, ..Faces::all(EDGE) };
        cuboid([half_length, half_width, board], 0.0, &faces)
    };
    let pages = Faces { front: FOOT_PAGES, left: HEAD_PAGES, ..Faces::all(HEAD_PAGES) };
    let overhang = 0.03 * length;
    let block = cuboid(
        [half_length - overhang, half_width - overhang, 0.5 * thickness - board],
        0.0,
        &Faces { back: FOOT_PAGES, ..pages },
    );
    let spine =
        cuboid([half_length, board, 0.5 * thickness], 0.0, &Faces { right: SPINE, ..Faces::all(EDGE) });
    let ribbon = [length * shape.uniform(0.06, 0.1), width * shape.uniform(0.04, 0.06), 0.3 * board];
    let ribbon_y = width * shape.uniform(-0.2, 0.05);
    let solid = slab(COVER, EDGE)
        .moved(0.0, 0.0, 0.5 * thickness - board)
        .join(slab(EDGE, BACK).moved(0.0, 0.0, board - 0.5 * thickness))
        .join(block)
        .join(spine.moved(0.0, -half_width, 0.0))
        .join(cuboid(ribbon, 0.0, &Faces::all(RIBBON)).moved(half_length, ribbon_y, 0.1 * thickness));
    Draft { solid, canvas, density: 500.0 }
}
