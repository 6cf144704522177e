//! Marks on packages and toys.

use super::{Area, Emblem, Patch, Rgb};
use vantage_dataset::Stream;

impl Patch<'_> {
    /// A logo, kept undistorted in the middle of `area`.
    pub fn emblem(&mut self, area: Area, emblem: Emblem, colour: Rgb) {
        let square = self.square_in(area);
        self.draw(square, |p, q| emblem.contains(p, q).then_some(colour));
    }

    /// Rows of letter-like blocks in words of random length.
    pub fn writing(&mut self, area: Area, rows: usize, ink: Rgb, look: &mut Stream) {
        let pitch = area.height() / rows as f64;
        let letter = 0.55 * pitch / self.aspect();
        for row in 0..rows {
            let top = area.t[0] + (row as f64 + 0.15) * pitch;
            let end = area.s[1] - if rows > 1 { look.uniform(0.0, 0.3) * area.width() } else { 0.0 };
            let mut left = area.s[0];
            while left + letter <= end {
                let height = pitch * if look.chance(0.3) { 0.7 } else { 0.5 };
                let width = letter * look.uniform(0.6, 0.95);
                self.rect(Area::new(left, top + 0.7 * pitch - height, left + width, top + 0.7 * pitch), ink);
                left += letter * if look.chance(0.2) { 2.0 } else { 1.0 };
            }
        }
    }

    /// Dark bars of random widths on white.
    pub fn barcode(&mut self, area: Area, look: &mut Stream) {
        self.rect(area, [0.97, 0.97, 0.96]);
        let bars = area.part(0.1, 0.12, 0.9, 0.82);
        let mut left = bars.s[0];
        while left < bars.s[1] {
            let width = bars.width() * look.uniform(0.04, 0.12);
            self.rect(
                Area::new(left, bars.t[0], (left + width).min(bars.s[1]), bars.t[1]),
                [0.06, 0.06, 0.08],
            );
            left += width + bars.width() * look.uniform(0.04, 0.1);
        }
    }

    /// A white table with a dark frame, a heavy heading and thin rows.
    pub fn table(&mut self, area: Area, rows: usize, look: &mut Stream) {
        let (paper, ink) = ([0.97, 0.97, 0.95], [0.08, 0.08, 0.1]);
        self.rect(area, ink);
        self.rect(area.part(0.07, 0.03, 0.93, 0.97), paper);
        self.rect(area.part(0.14, 0.07, look.uniform(0.6, 0.86), 0.17), ink);
        for row in 0..rows {
            let top = 0.23 + 0.72 * row as f64 / rows as f64;
            let bottom = top + 0.3 / rows as f64;
            self.rect(area.part(0.14, top, look.uniform(0.4, 0.6), bottom), ink);
            self.rect(area.part(0.72, top, 0.86, bottom), ink);
        }
    }
}
