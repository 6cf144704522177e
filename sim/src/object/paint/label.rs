//! The layout of a package's label, the same for all instances but for modest jitter: a large panel in front, a table
//! on the left, a picture on the right, a barcode behind.

use super::{Area, Emblem, Ground, Palette, Patch};
use vantage_dataset::Stream;

/// What one instance's label looks like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Label {
    palette: Palette,
    ground: Ground,
    grain: f64,
    emblem: Emblem,
    frame: Frame,
    table_rows: usize,
    band: f64,
}

/// The outline of the front panel.
#[derive(Clone, Copy, Debug)]
enum Frame {
    Rectangle,
    Ellipse,
    Shield,
    Octagon,
}

impl Frame {
    fn contains(self, p: f64, q: f64) -> bool {
        match self {
            Frame::Rectangle => true,
            Frame::Ellipse => p * p + q * q <= 1.0,
            Frame::Shield => q <= 0.2 || p.abs() <= 1.0 - (q - 0.2) * (q - 0.2) * 1.3,
            Frame::Octagon => p.abs() + q.abs() <= 1.5,
        }
    }
}

impl Label {
    /// Draws a label in the given colours.
    pub fn draw(palette: Palette, look: &mut Stream) -> Self {
        let frames = [Frame::Rectangle, Frame::Rectangle, Frame::Ellipse, Frame::Shield, Frame::Octagon];
        Self {
            palette,
            ground: Ground::draw(look),
            grain: look.uniform(0.1, 0.28),
            emblem: Emblem::draw(look),
            frame: frames[look.below(frames.len())],
            table_rows: 4 + look.below(4),
            band: if look.chance(0.6) { look.uniform(0.05, 0.14) } else { 0.0 },
        }
    }

    /// The share `s` of a wrapped patch at an azimuth in degrees.
    pub fn share(azimuth: f64) -> f64 {
        0.5 + azimuth / 360.0
    }

    /// All around a patch that wraps about z.
    pub fn wrap(&self, patch: &mut Patch<'_>, look: &mut Stream) {
        self.background(patch, look);
        let mut stripe = |azimuth: f64, half: [f64; 2], center: [f64; 2], half_height: [f64; 2]| {
            let s = Self::share(azimuth + look.uniform(-8.0, 8.0));
            let half = look.uniform(half[0], half[1]) / 360.0;
            let t = look.uniform(center[0], center[1]);
            Area::around([s, t], [half, look.uniform(half_height[0], half_height[1])])
        };
        let picture = stripe(-98.0, [25.0, 33.0], [0.5, 0.5], [0.5, 0.5]);
        let table = stripe(92.0, [20.0, 26.0], [0.48, 0.54], [0.3, 0.38]);
        let code = stripe(180.0, [20.0, 28.0], [0.68, 0.76], [0.13, 0.18]);
        let front = stripe(0.0, [40.0, 52.0], [0.46, 0.54], [0.32, 0.4]);
        self.picture(patch, picture);
        patch.table(table, self.table_rows, look);
        self.back(patch, code, look);
        self.front(patch, front, look);
    }

    /// The pattern of the body, with bands at its top and bottom.
    pub fn background(&self, patch: &mut Patch<'_>, look: &mut Stream) {
        let Palette { body, shade, accent, .. } = self.palette;
        self.ground.cover(patch, [body, shade], self.grain, look);
        if self.band > 0.0 {
            patch.rect(Area::band(0.0, self.band), accent);
            patch.rect(Area::band(1.0 - self.band, 1.0), accent);
        }
    }

    /// The front panel: a heading over the logo over a line of writing.
    pub fn front(&self, patch: &mut Patch<'_>, area: Area, look: &mut Stream) {
        let Palette { panel, ink, logo, .. } = self.palette;
        patch.draw(area, |p, q| self.frame.contains(p, q).then_some(ink));
        patch.draw(area.part(0.04, 0.04, 0.96, 0.96), |p, q| self.frame.contains(p, q).then_some(panel));
        patch.writing(area.part(0.2, 0.1, 0.84, 0.3), 1, ink, look);
        patch.emblem(area.part(0.12, 0.32, 0.88, 0.78), self.emblem, logo);
        patch.writing(area.part(0.26, 0.8, 0.76, 0.92), 1, ink, look);
    }

    /// The picture on the right: a stripe of the accent with three light spots.
    pub fn picture(&self, patch: &mut Patch<'_>, area: Area) {
        let accent = self.palette.accent;
        patch.rect(area, accent);
        for t in [0.2, 0.5, 0.8] {
            patch.emblem(area.part(0.15, t - 0.14, 0.85, t + 0.14), self.emblem, self.palette.over(accent));
        }
    }

    /// The back: a line of writing over a barcode in `code`.
    pub fn back(&self, patch: &mut Patch<'_>, code: Area, look: &mut Stream) {
        patch.writing(code.part(0.0, -1.5, 1.0, -0.3), 3, self.palette.over(self.palette.body), look);
        patch.barcode(code, look);
    }
}
