//! Colours that go together.

use vantage_dataset::Stream;

/// sRGB-encoded, each channel in `[0, 1]`.
pub(crate) type Rgb = [f32; 3];

/// `a` and `b` mixed, `share` of `b`.
pub(crate) fn mix(a: Rgb, b: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share as f32)
}

/// How light a colour looks, in `[0, 1]` (Rec. 709 weights on encoded values).
fn luma(c: Rgb) -> f64 {
    0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2])
}

/// A colour from its hue in turns, saturation and lightness in `[0, 1]`.
pub(crate) fn hsl(hue: f64, saturation: f64, lightness: f64) -> Rgb {
    let chroma = (1.0 - (2.0 * lightness - 1.0).abs()) * saturation;
    std::array::from_fn(|channel| {
        let sixth = (6.0 * (hue + [0.0, 2.0 / 3.0, 1.0 / 3.0][channel])).rem_euclid(6.0);
        let ramp = ((sixth - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (lightness + chroma * (ramp - 0.5)) as f32
    })
}

/// The colours of one instance. Their parts are fixed, which makes the layout of a family learnable; their hues
/// are not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Palette {
    /// Most of the surface.
    pub body: Rgb,
    /// A second tone of the body, for its pattern.
    pub shade: Rgb,
    /// The front panel: far from the body in lightness.
    pub panel: Rgb,
    /// Writing on the panel.
    pub ink: Rgb,
    /// The logo on the panel.
    pub logo: Rgb,
    /// Another hue, far from the body.
    pub accent: Rgb,
    /// Caps, handles and rims.
    pub trim: Rgb,
}

impl Palette {
    /// Draws colours.
    pub fn draw(look: &mut Stream) -> Self {
        let hue = look.unit();
        let (saturation, lightness) = match look.below(8) {
            0 => (look.uniform(0.0, 0.1), look.uniform(0.72, 0.92)),
            1 => (look.uniform(0.3, 0.7), look.uniform(0.68, 0.82)),
            2 => (look.uniform(0.0, 0.5), look.uniform(0.14, 0.26)),
            _ => (look.uniform(0.42, 0.92), look.uniform(0.3, 0.58)),
        };
        let body = hsl(hue, saturation, lightness);
        let light_body = luma(body) > 0.58;

        let away = [0.5, 0.36, 0.64, 0.2, 0.8][look.below(5)] + look.uniform(-0.05, 0.05);
        let accent_lightness =
            if luma(body) > 0.42 { look.uniform(0.2, 0.4) } else { look.uniform(0.5, 0.68) };
        let accent = hsl(hue + away, look.uniform(0.65, 1.0), accent_lightness);

        let panel_hue = if look.chance(0.5) { hue } else { hue + away };
        let panel = if light_body {
            hsl(panel_hue, look.uniform(0.5, 0.95), look.uniform(0.18, 0.34))
        } else {
            hsl(panel_hue, look.uniform(0.1, 0.9), look.uniform(0.86, 0.96))
        };
        let ink = if light_body {
            hsl(look.unit(), 0.4, look.uniform(0.85, 0.97))
        } else {
            hsl(look.unit(), look.uniform(0.3, 0.9), look.uniform(0.1, 0.28))
        };

        let logo_lightness = if light_body { look.uniform(0.66, 0.8) } else { look.uniform(0.28, 0.46) };
        let logo = hsl(hue + away + look.uniform(-0.12, 0.12), look.uniform(0.6, 1.0), logo_lightness);

        let shift = if lightness > 0.5 { -look.uniform(0.1, 0.24) } else { look.uniform(0.1, 0.24) };
        let shade = hsl(hue + look.uniform(-0.06, 0.06), saturation, (lightness + shift).clamp(0.06, 0.95));
        let trim = match look.below(4) {
            0 => hsl(hue, 0.05, if luma(body) > 0.5 { 0.14 } else { 0.92 }),
            1 => hsl(hue + away, 0.7, if luma(body) > 0.5 { 0.22 } else { 0.78 }),
            _ => accent,
        };
        Self { body, shade, panel, ink, logo, accent, trim }
    }

    /// The colour of panel, ink and logo that stands out most over `ground`.
    pub fn over(&self, ground: Rgb) -> Rgb {
        let contrast = |c: &Rgb| (luma(*c) - luma(ground)).abs();
        let [panel, ink, logo] = [self.panel, self.ink, self.logo];
        let better = if contrast(&ink) > contrast(&panel) { ink } else { panel };
        if contrast(&logo) > contrast(&better) { logo } else { better }
    }
}
