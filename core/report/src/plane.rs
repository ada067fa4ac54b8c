//! Lines in a plane that are drawn to one scale on both axes.

use plotters::prelude::*;

use crate::sheet::{Chart, Sheet};
use crate::simplify::{between_sharp_turns, simplified};

/// Points of a line, in the unit of the axes.
pub type PlanePath = Vec<(f64, f64)>;

/// Middle and half the side of a square around all points, with some air.
pub fn square_around<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> ([f64; 2], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (x, y) in points {
        low = [low[0].min(*x), low[1].min(*y)];
        high = [high[0].max(*x), high[1].max(*y)];
    }
    let half = 0.54 * (high[0] - low[0]).max(high[1] - low[1]).max(1e-3);
    ([0, 1].map(|c| 0.5 * (low[c] + high[c])), half)
}

/// Every other part of this length of a line.
pub fn dashes(line: &[(f64, f64)], length: f64) -> Vec<PlanePath> {
    let mut dashes = vec![vec![line[0]]];
    let (mut is_drawn, mut left) = (true, length);
    for pair in line.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let rest = (to.0 - from.0).hypot(to.1 - from.1);
            let part = if rest > 0.0 { (left / rest).min(1.0) } else { 1.0 };
            let at = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
            if let (true, Some(dash)) = (is_drawn, dashes.last_mut()) {
                dash.push(at);
            }
            left -= part * rest;
            from = at;
            if part >= 1.0 && left > 0.0 {
                break;
            }
            (is_drawn, left) = (!is_drawn, length);
            if is_drawn {
                dashes.push(vec![at]);
            }
        }
    }
    // One that would begin where the line ends.
    dashes.retain(|dash| dash[0] != dash[dash.len() - 1]);
    dashes
}

/// The first point, and each that is this far from the one taken before.
pub(crate) fn spaced(points: &[(f64, f64)], distance: f64) -> PlanePath {
    let mut taken: PlanePath = Vec::new();
    for point in points {
        if taken.last().is_none_or(|last| (point.0 - last.0).hypot(point.1 - last.1) >= distance) {
            taken.push(*point);
        }
    }
    taken
}

/// Draws a simplified line, without the points within `tolerance` of the rest of it.
pub(crate) fn draw_simplified<DB: DrawingBackend>(
    chart: &mut Chart<DB>,
    sheet: &Sheet<DB>,
    line: &[(f64, f64)],
    tolerance: f64,
    (color, width): (RGBColor, f64),
) -> anyhow::Result<()>
where
    DB::ErrorType: 'static,
{
    for run in between_sharp_turns(&simplified(line, tolerance)) {
        chart.draw_series(LineSeries::new(run.iter().copied(), sheet.line(color, width)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_cover_half_of_a_line() {
        let line = [(0.0, 0.0), (3.0, 0.0), (3.0, 5.0)];
        let drawn = dashes(&line, 1.0);
        assert_eq!(drawn.len(), 4);
        assert_eq!(drawn[1], [(2.0, 0.0), (3.0, 0.0)]);
        let length = |dash: &PlanePath| {
            dash.windows(2).map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1)).sum::<f64>()
        };
        assert!((drawn.iter().map(length).sum::<f64>() - 4.0).abs() < 1e-12);
    }
}
