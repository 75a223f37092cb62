//! Colours: the colour-blind-safe set of Okabe and Ito (2008), darkened where it carries text or thin lines on white.

/// Red, green and blue, 0 to 255.
pub type Colour = (u8, u8, u8);

/// Text and axes.
pub const INK: Colour = (31, 41, 51);
/// Secondary text.
pub const MUTED: Colour = (91, 103, 116);
/// Grid lines.
pub const GRID: Colour = (223, 227, 232);
/// Page.
pub const PAPER: Colour = (255, 255, 255);
/// First series, predictions.
pub const BLUE: Colour = (0, 99, 158);
/// Limits that must be kept, failures.
pub const VERMILION: Colour = (196, 72, 0);
/// Kept limits, good news.
pub const GREEN: Colour = (0, 122, 89);
/// Held-out data, cautions.
pub const AMBER: Colour = (184, 122, 0);
/// Further series.
pub const PURPLE: Colour = (158, 74, 124);
/// Further series.
pub const SKY: Colour = (62, 146, 196);
/// Shade behind held-out data.
pub const SHADE: Colour = (250, 240, 214);

/// Colours of series, in order; they repeat after the sixth.
pub const SERIES: [Colour; 6] = [BLUE, VERMILION, GREEN, PURPLE, AMBER, SKY];

/// Colour of the series with this position.
pub fn series(position: usize) -> Colour {
    SERIES[position % SERIES.len()]
}

/// A colour between two, `share` in 0..1 of the way to the second.
pub fn between(from: Colour, to: Colour, share: f64) -> Colour {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    (mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}

/// Diverging colour for a value in -1..1: blue below zero, white at zero, vermilion above.
pub fn diverging(value: f64) -> Colour {
    if value.is_nan() {
        return (236, 238, 240);
    }
    if value < 0.0 { between(PAPER, (20, 106, 172), -value) } else { between(PAPER, (206, 84, 14), value) }
}

/// Whether dark text is the more legible on this colour.
pub fn is_light(colour: Colour) -> bool {
    0.299 * f64::from(colour.0) + 0.587 * f64::from(colour.1) + 0.114 * f64::from(colour.2) > 140.0
}
