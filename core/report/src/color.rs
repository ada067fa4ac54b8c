//! Colours on white paper, and what they become on black.
//!
//! Figures are drawn in colours for white paper. A style sheet replaces each by its partner where the reader's setting
//! is dark (`prefers-color-scheme`), in a page as in a file; programs that know no style sheets show the white figure.
//! The same sheet gives curves over time a pattern of dashes by their colour, as a second cue.

use plotters::style::RGBColor;

/// Colours that can be distinguished without red and green (Okabe and Ito, 2008).
pub const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
];
/// The same on black paper.
const COLORS_ON_BLACK: [RGBColor; 7] = [
    RGBColor(70, 150, 235),
    RGBColor(242, 125, 60),
    RGBColor(40, 196, 148),
    RGBColor(228, 156, 198),
    RGBColor(242, 184, 60),
    RGBColor(160, 222, 250),
    RGBColor(214, 218, 224),
];
/// Dashes and gaps of a curve in each of the colours [px]; none is solid.
const DASHES: [&[u32]; 7] = [&[], &[8, 3], &[10, 3, 2, 3], &[3, 2], &[14, 4], &[8, 2, 2, 2, 2, 2], &[]];

/// Paper, in figures and pages.
pub(crate) const PAPER: RGBColor = RGBColor(255, 255, 255);
/// Text.
pub(crate) const INK: RGBColor = RGBColor(40, 44, 52);
/// Lines at the ticks.
pub(crate) const GRID: RGBColor = RGBColor(225, 228, 232);
/// Axes and their ticks.
pub(crate) const AXIS: RGBColor = RGBColor(120, 126, 134);
/// Spans of time.
pub(crate) const SHADES: [RGBColor; 2] = [RGBColor(246, 222, 206), RGBColor(214, 226, 240)];
/// A body behind others, to be seen and not looked at.
pub const GHOST: RGBColor = RGBColor(246, 247, 249);
/// A line without information, such as that of a slack tendon.
pub const DULL: RGBColor = RGBColor(90, 96, 104);

/// Colours of a ramp that differ: few enough for a style sheet.
const LEVELS: usize = 48;

type Stops = [[f64; 3]; 5];

/// Five colours of the map `plasma` (S. van der Walt and N. Smith, CC0), without its palest end.
const PLASMA: Stops = [
    [13.0, 8.0, 135.0],
    [120.0, 1.0, 168.0],
    [196.0, 62.0, 127.0],
    [241.0, 130.0, 77.0],
    [252.0, 206.0, 37.0],
];
/// The same without what black paper swallows.
const PLASMA_ON_BLACK: Stops = [
    [112.0, 92.0, 240.0],
    [172.0, 84.0, 224.0],
    [226.0, 96.0, 152.0],
    [246.0, 148.0, 92.0],
    [254.0, 220.0, 96.0],
];

/// Colour of a part from 0 to 1: dark violet over red to yellow, even in lightness.
pub fn ramp(part: f64) -> RGBColor {
    let level = (part.clamp(0.0, 1.0) * (LEVELS - 1) as f64).round();
    mixed(&PLASMA, level / (LEVELS - 1) as f64)
}

fn mixed(stops: &Stops, part: f64) -> RGBColor {
    let at = part * (stops.len() - 1) as f64;
    let k = (at as usize).min(stops.len() - 2);
    let [r, g, b] =
        [0, 1, 2].map(|c| (stops[k][c] + (at - k as f64) * (stops[k + 1][c] - stops[k][c])).round());
    RGBColor(r as u8, g as u8, b as u8)
}

/// A colour as figures write it.
pub(crate) fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Rules for everything in an SVG: colours on black paper, and dashes in an SVG of the class `dashed` that is drawn
/// `scale` times as large.
pub(crate) fn style(scale: u32) -> String {
    let dashed = COLORS.iter().zip(DASHES).filter(|(_, dashes)| !dashes.is_empty());
    let dashes = dashed.map(|(color, dashes)| {
        let lengths: Vec<String> = dashes.iter().map(|length| (length * scale).to_string()).collect();
        let color = hex(*color);
        format!(".dashed polyline[stroke=\"{color}\"]{{stroke-dasharray:{}}}", lengths.join(" "))
    });
    let on_black = pairs().into_iter().map(|(white, black)| {
        let (white, black) = (hex(white), hex(black));
        format!("svg [fill=\"{white}\"]{{fill:{black}}}svg [stroke=\"{white}\"]{{stroke:{black}}}")
    });
    format!(
        "{}@media(prefers-color-scheme:dark){{{}}}",
        dashes.collect::<String>(),
        on_black.collect::<String>()
    )
}

/// Every colour of figures that black paper changes, with its partner.
fn pairs() -> Vec<(RGBColor, RGBColor)> {
    let named = [
        (PAPER, RGBColor(21, 24, 29)),
        (INK, RGBColor(224, 227, 232)),
        (GRID, RGBColor(48, 53, 61)),
        (AXIS, RGBColor(134, 141, 151)),
        (SHADES[0], RGBColor(78, 52, 36)),
        (SHADES[1], RGBColor(34, 52, 76)),
        (GHOST, RGBColor(36, 40, 47)),
        (DULL, RGBColor(160, 166, 176)),
    ];
    let levels = (0..LEVELS).map(|k| k as f64 / (LEVELS - 1) as f64);
    let ramps = levels.map(|part| (mixed(&PLASMA, part), mixed(&PLASMA_ON_BLACK, part)));
    named.into_iter().chain(COLORS.into_iter().zip(COLORS_ON_BLACK)).chain(ramps).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance (WCAG 2.2).
    fn luminance(RGBColor(r, g, b): RGBColor) -> f64 {
        let [r, g, b] = [r, g, b].map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    fn contrast(a: RGBColor, b: RGBColor) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn text_and_curves_are_seen_on_black_paper_and_a_ramp_grows_lighter() {
        let pairs = pairs();
        let black = pairs[0].1;
        assert!(contrast(INK, PAPER) > 7.0 && contrast(pairs[1].1, black) > 7.0);
        for color in COLORS_ON_BLACK {
            assert!(contrast(color, black) > 4.5, "{}", hex(color));
        }
        for stops in [PLASMA, PLASMA_ON_BLACK] {
            let light: Vec<f64> = (0..LEVELS).map(|k| luminance(mixed(&stops, k as f64 / 47.0))).collect();
            assert!(light.windows(2).all(|pair| pair[0] < pair[1] + 1e-3));
        }
        assert!(contrast(mixed(&PLASMA_ON_BLACK, 0.0), black) > 3.0);
    }

    #[test]
    fn a_colour_has_one_partner() {
        let pairs = pairs();
        for (k, (white, _)) in pairs.iter().enumerate() {
            assert!(pairs[..k].iter().all(|(other, _)| other != white), "{}", hex(*white));
        }
        assert!((0..200).all(|k| pairs.iter().any(|(white, _)| *white == ramp(f64::from(k) / 199.0))));
    }
}
