//! Cartons.

use super::Draft;
use crate::object::paint::{Area, Canvas, Label, Palette, Region, mix};
use crate::object::solid::{Skin, prism, turned};
use nalgebra::Vector3;
use vantage_dataset::Stream;

const FRONT: Region = Region::new(0, 0, 44, 72);
const BACK: Region = Region::new(44, 0, 40, 72);
const LEFT: Region = Region::new(84, 0, 44, 72);
const RIGHT: Region = Region::new(84, 72, 44, 56);
const FRONT_SLOPE: Region = Region::new(0, 72, 42, 28);
const BACK_SLOPE: Region = Region::new(42, 72, 42, 28);
const CAP: Region = Region::new(0, 100, 42, 28);
const PLAIN: Region = Region::new(42, 100, 42, 28);

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let width = shape.uniform(0.07, 0.1);
    let depth = width * shape.uniform(0.58, 0.8);
    let wall = width * shape.uniform(1.25, 1.9);
    let gable = width * shape.uniform(0.3, 0.45);
    let (crest, top) = (0.05 * depth, wall + gable);

    let palette = Palette::draw(look);
    let label = Label::draw(palette, look);
    let mut canvas = Canvas::new(palette.body);
    let jitter = |look: &mut Stream| look.uniform(-0.06, 0.06);
    let (front, back, side) = ([width, wall], [width, wall], [depth, top]);
    let shoulder = gable / top;
    canvas.paint(FRONT, front, |patch| {
        label.background(patch, look);
        let center = [0.5 + jitter(look), 0.5 + jitter(look)];
        let half = [look.uniform(0.38, 0.45), look.uniform(0.34, 0.43)];
        label.front(patch, Area::around(center, half), look);
    });
    canvas.paint(BACK, back, |patch| {
        label.background(patch, look);
        let center = [0.5 + jitter(look), 0.7 + jitter(look)];
        label.back(patch, Area::around(center, [look.uniform(0.28, 0.38), 0.14]), look);
    });
    canvas.paint(LEFT, side, |patch| {
        label.background(patch, look);
        let center = [0.5 + jitter(look), 0.56 + 0.4 * shoulder + jitter(look)];
        let half = [look.uniform(0.3, 0.38), look.uniform(0.26, 0.33)];
        patch.table(Area::around(center, half), 5 + look.below(3), look);
    });
    canvas.paint(RIGHT, side, |patch| {
        label.background(patch, look);
        let s = 0.5 + jitter(look);
        let half = look.uniform(0.24, 0.34);
        label.picture(patch, Area::new(s - half, shoulder, s + half, 1.0));
    });
    canvas.paint(FRONT_SLOPE, [width, gable], |patch| patch.fill(palette.accent));
    canvas.paint(BACK_SLOPE, [width, gable], |patch| {
        patch.fill(palette.body);
        patch.writing(Area::new(0.15, 0.3, 0.85, 0.8), 2, palette.panel, look);
    });
    canvas.plain(CAP, palette.panel);
    canvas.plain(PLAIN, mix(palette.body, palette.shade, 0.5));

    let half = 0.5 * depth;
    let corners = [[-half, 0.0], [half, 0.0], [half, wall], [crest, top], [-crest, top], [-half, wall]];
    let edges = [PLAIN, FRONT, FRONT_SLOPE, PLAIN, BACK_SLOPE, BACK];
    let pack = prism(&corners, [0.0, 0.5 * wall], 0.5 * width, &edges, LEFT, RIGHT);
    let fin_height = 0.12 * width;
    let fin = prism(
        &[[-0.25 * crest, 0.0], [0.25 * crest, 0.0], [0.25 * crest, fin_height], [-0.25 * crest, fin_height]],
        [0.0, 0.5 * fin_height],
        0.5 * width,
        &[PLAIN; 4],
        PLAIN,
        PLAIN,
    );

    let radius = gable * shape.uniform(0.3, 0.4);
    let stem = radius * shape.uniform(0.7, 1.1);
    let cap = turned(
        &[
            (&[[0.0, 0.0], [radius, 0.0]], Skin::Disc(CAP)),
            (&[[radius, 0.0], [radius, stem]], Skin::Wrap(CAP)),
            (&[[radius, stem], [0.0, stem]], Skin::Disc(CAP)),
        ],
        14,
    );
    let (run, rise) = (half - crest, gable);
    let middle = crest + 0.52 * run;
    let cap = cap.turned(Vector3::y_axis(), libm::atan2(rise, run)).moved(
        middle,
        width * shape.uniform(-0.06, 0.06),
        wall + 0.48 * rise,
    );
    Draft { solid: pack.join(fin.moved(0.0, 0.0, top)).join(cap), canvas, density: 600.0 }
}
