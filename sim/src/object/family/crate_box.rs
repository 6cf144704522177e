//! Crates: equal to themselves turned by a quarter, bit for bit.

use super::Draft;
use crate::object::paint::{Area, Canvas, Emblem, Ground, Palette, Region, hsl, mix};
use crate::object::solid::{Faces, cuboid};
use vantage_dataset::Stream;

const SIDE: Region = Region::new(0, 0, 72, 72);
const LID: Region = Region::new(72, 0, 56, 56);
const POST: Region = Region::new(72, 56, 28, 72);
const BASE: Region = Region::new(100, 56, 28, 72);

pub(crate) fn draft(shape: &mut Stream, look: &mut Stream) -> Draft {
    let half = shape.uniform(0.035, 0.065);
    let half_height = half * shape.uniform(0.6, 1.1);
    let post = half * shape.uniform(0.1, 0.2);

    let mut palette = Palette::draw(look);
    if look.chance(0.4) {
        let (hue, lightness) = (look.uniform(0.06, 0.11), look.uniform(0.35, 0.6));
        palette.body = hsl(hue, look.uniform(0.35, 0.6), lightness);
        palette.shade = hsl(hue, 0.5, lightness - 0.12);
    }
    let ground = Ground::draw(look);
    let emblem = Emblem::draw(look);
    let grain = look.uniform(0.14, 0.34);
    let mut canvas = Canvas::new(palette.body);
    canvas.paint(SIDE, [half, half_height], |patch| {
        ground.cover(patch, [palette.body, palette.shade], grain, look);
        let framed = look.chance(0.6);
        if framed {
            let size = look.uniform(0.3, 0.38);
            patch.disc(patch.square_in(Area::around([0.5, 0.5], [size, size])), palette.panel);
        }
        let colour = if framed { palette.logo } else { palette.over(palette.body) };
        let size = look.uniform(0.2, 0.3);
        patch.emblem(Area::around([0.5, 0.5], [size, size]), emblem, colour);
        let rail = look.uniform(0.08, 0.16);
        patch.rect(Area::band(0.0, rail), palette.trim);
        patch.rect(Area::band(1.0 - rail, 1.0), palette.trim);
    });
    let lid_ground = Ground::draw(look);
    canvas.paint(LID, [1.0, 1.0], |patch| {
        lid_ground.cover(patch, [palette.shade, palette.body], grain, look);
        let rail = look.uniform(0.08, 0.2);
        patch.rect(Area::band(0.0, rail), palette.trim);
        patch.rect(Area::new(0.0, 0.0, rail, 1.0), palette.trim);
        let size = look.uniform(0.14, 0.26);
        patch.disc(Area::around([0.5, 0.5], [size, size]), palette.accent);
        patch.repeat_quarters();
    });
    canvas.plain(POST, palette.trim);
    canvas.plain(BASE, mix(palette.body, [0.0; 3], 0.3));

    let faces = Faces { bottom: BASE, ..Faces::around(SIDE, LID) };
    let mut solid = cuboid([half, half, half_height], 0.0, &faces);
    let mut corner =
        cuboid([post, post, half_height + 0.4 * post], 0.25 * post, &Faces::all(POST)).moved(half, half, 0.0);
    for _ in 0..4 {
        solid = solid.join(corner.clone());
        corner = corner.quarter_turned();
    }
    Draft { solid, canvas, density: 350.0 }
}
