//! Strokes and tip of a tendon-driven robot: their sizes against each other and against the body.

use super::series::{MeasuredChannel, MeasuredSeries};
use super::{CheckContext, Finding, Warning};
use crate::statistics::{extremes, range};

/// Largest plausible range of a tip [m]: the longest tendon-driven arms that are used reach 3 m. A robot of 3 mm in metres
/// makes it in millimetres.
const LARGEST_TIP: f64 = 3.0;
/// No robot's tip ranges over this [m].
const IMPOSSIBLE_TIP: f64 = 30.0;
/// Largest plausible stroke [m]: a half-turn of a body bends its tendons, 0.16 m at most from its axis, by π times that.
const LARGEST_STROKE: f64 = 0.5;
/// Plausible range of the tip over that of the strokes [-]. A body of length L bends its tip by L/2d for a unit of stroke, d from the
/// axis: 3 to 100 in what is built; wide enough for a tip that hardly moves and far from a factor of 1000.
const TIP_OVER_STROKE: [f64; 2] = [0.03, 300.0];
/// Strokes below this range move no tip [m].
const STROKES_MOVE: f64 = 1e-4;
/// From this range on a tip was moved [m]: above every tracker's noise.
const TIP_MOVES: f64 = 1e-3;
/// From this range of the strokes on a tip that does not change by a bit was not measured [m].
const STROKES_MUST_MOVE: f64 = 1e-3;
/// How far a tip may be beyond the body's length [-]: what is measured at the tip is mounted on it, and bodies stretch.
const BEYOND: f64 = 1.1;
/// Orientations deviate from unit length by rounding [-]: four digits make 1e-4.
const UNIT_LENGTH: f64 = 1e-2;
/// Of this length they are none [-].
const NO_LENGTH: f64 = 0.1;
/// From this range of the tip on its orientation changes [m].
const TIP_TURNS: f64 = 5e-3;

pub fn check(series: &MeasuredSeries, context: &CheckContext) -> Vec<Warning> {
    let mut found = Vec::new();
    let widest = |channels: &[MeasuredChannel]| {
        channels.iter().map(|channel| range(channel.values.iter().copied())).fold(0.0, f64::max)
    };
    let (stroke, tip) = (widest(&series.strokes), widest(&series.tip));
    found.extend(sizes(stroke, tip));
    if !series.tip.is_empty() && tip == 0.0 && stroke > STROKES_MOVE {
        found.push(frozen(stroke));
    } else if found.is_empty() && stroke > 0.0 && tip > 0.0 && (stroke > STROKES_MOVE || tip > TIP_MOVES) {
        found.extend(ratio(stroke, tip));
    }
    if let Some(length) = context.body_length {
        found.extend(reach(series, length));
    }
    found.extend(orientation(series, tip));
    found
}

fn sizes(stroke: f64, tip: f64) -> Vec<Warning> {
    let warning = |channel: &str, size: f64, limit: f64| {
        let finding = format!("ranges over {size:.2} m; at most {limit} m is plausible");
        Warning::new(Finding::Unit, channel, finding)
            .measured(size, limit, "m")
            .hint("are these millimetres? end the names in _mm")
    };
    let mut found = Vec::new();
    if tip > IMPOSSIBLE_TIP {
        found.push(warning("tip", tip, IMPOSSIBLE_TIP).impossible());
    } else if tip > LARGEST_TIP {
        found.push(warning("tip", tip, LARGEST_TIP));
    }
    if stroke > LARGEST_STROKE {
        found.push(warning("strokes", stroke, LARGEST_STROKE));
    }
    found
}

fn frozen(stroke: f64) -> Warning {
    let finding = format!("the tip never changes while strokes range over {:.2} mm", 1e3 * stroke);
    let warning = Warning::new(Finding::Frozen, "tip", finding)
        .measured(1e3 * stroke, 1e3 * STROKES_MOVE, "mm")
        .hint("was the tracker on, and its marker seen?");
    if stroke >= STROKES_MUST_MOVE { warning.impossible() } else { warning }
}

fn ratio(stroke: f64, tip: f64) -> Option<Warning> {
    let [least, most] = TIP_OVER_STROKE;
    let found = tip / stroke;
    if (least..=most).contains(&found) {
        return None;
    }
    let (limit, hint) = match found < least {
        true => (least, "are strokes in millimetres, or is the tip in metres? end the names in _mm or _m"),
        false => (most, "is the tip in millimetres, or are strokes in metres? end the names in _mm or _m"),
    };
    let finding = format!(
        "the tip ranges over {:.3} mm for strokes of {:.3} mm: {found:.2e} times as much; {least} to {most} is plausible",
        1e3 * tip,
        1e3 * stroke
    );
    Some(Warning::new(Finding::Unit, "tip, strokes", finding).measured(found, limit, "-").hint(hint))
}

/// Between two tips there are at most two lengths of the body, in any frame.
fn reach(series: &MeasuredSeries, length: f64) -> Option<Warning> {
    let sides = series.tip.iter().map(|axis| extremes(axis.values.iter().copied()));
    let (apart, channel) = sides.zip(&series.tip).map(|([min, max], axis)| (max - min, &axis.name)).fold(
        (0.0, ""),
        |widest, (apart, name)| if apart > widest.0 { (apart, name.as_str()) } else { widest },
    );
    let limit = 2.0 * BEYOND * length;
    if apart <= limit {
        return None;
    }
    let finding = format!(
        "ranges over {:.1} mm; a body of {:.1} mm reaches over {:.1} mm at most",
        1e3 * apart,
        1e3 * length,
        1e3 * limit
    );
    Some(
        Warning::new(Finding::Reach, channel, finding)
            .measured(1e3 * apart, 1e3 * limit, "mm")
            .hint("is this the robot of the scene, and are the units right?")
            .impossible(),
    )
}

fn orientation(series: &MeasuredSeries, tip: f64) -> Option<Warning> {
    let parts = &series.orientation;
    if parts.is_empty() {
        return None;
    }
    let length = |i: usize| parts.iter().map(|part| part.values[i].powi(2)).sum::<f64>().sqrt();
    let n = series.time.len();
    let at = (0..n).max_by(|a, b| (length(*a) - 1.0).abs().total_cmp(&(length(*b) - 1.0).abs()))?;
    let off = (length(at) - 1.0).abs();
    if off > UNIT_LENGTH {
        let count = (0..n).filter(|i| (length(*i) - 1.0).abs() > UNIT_LENGTH).count();
        let finding = format!("{count} quaternions have not the length 1; the worst has {:.4}", length(at));
        let warning = Warning::new(Finding::Orientation, "tip_qw … tip_qz", finding)
            .measured(off, UNIT_LENGTH, "-")
            .at_rows(series.rows[at], series.rows[at])
            .hint("are they in the order w, x, y, z, and whole?");
        return Some(if length(at) < NO_LENGTH { warning.impossible() } else { warning });
    }
    let is_frozen = parts.iter().all(|part| part.values.iter().all(|value| *value == part.values[0]));
    (is_frozen && tip > TIP_TURNS).then(|| {
        let finding = format!("the orientation never changes while the tip ranges over {:.1} mm", 1e3 * tip);
        Warning::new(Finding::Frozen, "tip_qw … tip_qz", finding)
            .measured(1e3 * tip, 1e3 * TIP_TURNS, "mm")
            .hint("does the tracker send positions only? leave the orientation out")
    })
}
