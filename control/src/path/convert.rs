//! The one conversion from what was typed to a curve with a timing, and every bound of a target.

use super::outline::{MAX_CROSSING_POINTS, Outline, OutlinePoint, distance};
use super::schema::{CurveFamily, CurveTable, TargetFile};
use super::timing::Ramped;
use super::{csv, family, svg};
use crate::Result;
use crate::plan::Direction;
use hysteron_base::schema::{between, check_header, finite, positive, require, text, within};
use hysteron_base::size::check_at_most;
use hysteron_base::{BadInput, file};
use std::path::Path;

type Check<T> = std::result::Result<T, BadInput>;

const FORMAT: (&str, i64) = ("hysteron-target", 1);
/// More than any target has; keeps a slip of the hand from filling the memory.
const MAX_SAMPLES: f64 = 1e6;
/// Of an outline that must not cross itself, for which all its lines are compared with each other.
const MAX_POINTS: usize = 20_000;
const MAX_LAPS: u32 = 1000;
/// Of a target file, and of an outline's.
pub(super) const MAX_BYTES: usize = 32 << 20;
/// Longest coordinate, size or distance of a target [mm].
const LONGEST: f64 = 1e4;
/// Smallest size of a curve [mm].
const SHORTEST: f64 = 1e-6;
const LONGEST_TIME: f64 = 1e6;
const RATES: [f64; 2] = [1e-2, 1e5];
/// Fewest samples of a lap, and of the way there, that show how it runs.
const MIN_SAMPLES: f64 = 100.0;
const MIN_LEAD_SAMPLES: f64 = 10.0;
/// A curve that begins nearer to the rest point begins there [m].
const AT_REST: f64 = 1e-9;

/// A valid target file, in SI.
pub(super) struct Valid {
    pub name: String,
    pub family: &'static str,
    pub rate_hz: f64,
    pub rest: f64,
    pub lead_in: f64,
    pub laps: u32,
    pub outline: Outline,
    pub is_planar: bool,
    /// Motion along all laps.
    pub motion: Ramped,
    /// Text of the file with the outline, if there is one.
    pub outline_file: String,
}

/// A curve before it is placed.
struct UnplacedCurve {
    /// Its place, for messages.
    place: String,
    family: &'static str,
    points: Vec<OutlinePoint>,
    is_closed: bool,
    is_planar: bool,
    may_cross: bool,
    file: String,
}

/// `folder` is where a file that the target names is looked for.
pub(super) fn target(typed: TargetFile, folder: &Path) -> Result<Valid> {
    check_header((&typed.format, typed.version), FORMAT)?;
    let name = text("name", typed.name)?;
    let rate_hz = between("rate_hz", typed.rate_hz, RATES)?;
    let speed = positive("speed_mm_s", typed.speed_mm_s)?;
    let ramp = between("ramp_s", typed.ramp_s, [1e-6, LONGEST_TIME])?;
    let rest = between("rest_s", typed.rest_s, [0.0, LONGEST_TIME])?;
    let lead_in = between("lead_in_s", typed.lead_in_s, [0.0, LONGEST_TIME])?;
    let laps = typed.laps.unwrap_or(1);
    require("laps", "1 to 1000", f64::from(laps), (1..=MAX_LAPS).contains(&laps))?;

    let drawn = curve(&typed.curve, folder)?;
    let centre = centre(typed.centre_mm.as_deref(), drawn.is_planar)?;
    let rotation = finite("rotation_deg", typed.rotation_deg.unwrap_or(0.0))?;
    let (sin, cos) = rotation.sin_cos();
    let placed = |[x, y, z]: OutlinePoint| {
        [centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y, centre[2] + z]
    };
    let within = |bad: BadInput| bad.within(&drawn.place);
    let mut outline = Outline::new(drawn.points, drawn.is_closed).map_err(within)?.mapped(placed)?;
    if typed.direction == Some(Direction::Clockwise) {
        outline = outline.reversed()?;
    }
    let n_points = outline.points().len();
    let far = outline.points().iter().flatten().fold(0.0f64, |far, c| far.max(c.abs()));
    if far > 1e-3 * LONGEST {
        let bad = BadInput::new(
            drawn.place,
            format!("at most {LONGEST} mm from rest"),
            format!("{:.3e} mm", 1e3 * far),
        );
        return Err(bad.hint("sizes are in mm").into());
    }
    if n_points > MAX_POINTS && !drawn.may_cross {
        let found = n_points.to_string();
        return Err(BadInput::new(drawn.place, format!("at most {MAX_POINTS} points"), found).into());
    }
    if !drawn.may_cross
        && let Some([x, y]) = outline.crossing()
    {
        let found = format!("a crossing at ({:.2}, {:.2}) mm", 1e3 * x, 1e3 * y);
        return Err(BadInput::new(drawn.place, "a line that does not cross itself", found)
            .hint("may_cross = true in [curve] allows it")
            .into());
    }
    if laps > 1 && !outline.is_closed() {
        return Err(BadInput::new("laps", "1 for an open curve", laps.to_string()).into());
    }
    let motion = motion(&outline, laps, rate_hz, speed, ramp)?;
    check_lead(&outline, lead_in, rate_hz)?;
    let n = 2.0 * (rest + lead_in) * rate_hz + motion.n_steps(rate_hz) as f64;
    if n.is_nan() || n >= MAX_SAMPLES {
        let expected = format!("fewer than {MAX_SAMPLES:e} samples");
        return Err(BadInput::new("target", expected, format!("{n:e}")).hint("times are in seconds").into());
    }
    let (is_planar, family) = (drawn.is_planar, drawn.family);
    let outline_file = drawn.file;
    Ok(Valid { name, family, rate_hz, rest, lead_in, laps, outline, is_planar, motion, outline_file })
}

/// The motion along the curve, which the rate can show and in which the ramps have room.
fn motion(outline: &Outline, laps: u32, rate_hz: f64, speed: f64, ramp: f64) -> Check<Ramped> {
    let most = outline.length() * rate_hz / MIN_SAMPLES;
    if speed > most {
        let expected = format!("at most {:.3}, {MIN_SAMPLES} samples for a lap", 1e3 * most);
        return Err(BadInput::new("speed_mm_s", expected, format!("{}", 1e3 * speed))
            .hint("a higher rate_hz, or a lower speed"));
    }
    let length = outline.length() * f64::from(laps);
    if speed * ramp > length {
        let expected = format!("at most {:.3} at this speed, or the ramps would meet", length / speed);
        return Err(BadInput::new("ramp_s", expected, format!("{ramp}")));
    }
    let n = (length / speed + ramp) * rate_hz;
    if n.is_nan() || n >= MAX_SAMPLES {
        let expected = format!("a speed that gives fewer than {MAX_SAMPLES:e} samples");
        return Err(BadInput::new("speed_mm_s", expected, format!("{n:e}")));
    }
    Ok(Ramped::new(length, speed, ramp, rate_hz))
}

/// From rest to a curve that begins elsewhere takes some time.
fn check_lead(outline: &Outline, lead_in: f64, rate_hz: f64) -> Check<()> {
    let away = [0.0, outline.length()].map(|at| distance(outline.at(at), [0.0; 3]));
    let is_right = away.iter().all(|away| *away <= AT_REST) || lead_in * rate_hz >= MIN_LEAD_SAMPLES;
    let expected = format!(
        "{MIN_LEAD_SAMPLES} samples or more for the way to the curve, {:.1} mm from rest",
        1e3 * away[0].max(away[1])
    );
    require("lead_in_s", &expected, lead_in, is_right).map(|_| ())
}

fn centre(typed: Option<&[f64]>, is_planar: bool) -> Check<OutlinePoint> {
    const KEY: &str = "centre_mm";
    let typed = typed.unwrap_or(&[0.0, 0.0]);
    let n = if is_planar { 2..=2 } else { 2..=3 };
    if !n.contains(&typed.len()) {
        let expected = if is_planar { "[x, y]" } else { "[x, y] or [x, y, z]" };
        return Err(BadInput::new(KEY, expected, format!("{typed:?}")));
    }
    let mut centre = [0.0; 3];
    for (c, value) in typed.iter().enumerate() {
        centre[c] = within(&format!("{KEY}[{c}]"), *value, LONGEST)?;
    }
    Ok(centre)
}

/// Keys of each family next to `family`; the required ones first, their number after them.
fn keys(family: CurveFamily) -> (&'static str, &'static [&'static str], usize) {
    match family {
        CurveFamily::Circle => ("circle", &["size_mm"], 1),
        CurveFamily::Diamond => ("diamond", &["size_mm"], 1),
        CurveFamily::Square => ("square", &["size_mm"], 1),
        CurveFamily::Lissajous => ("lissajous", &["size_mm", "width_mm", "cycles", "phase_deg"], 4),
        CurveFamily::FigureEight => ("figure_eight", &["size_mm"], 1),
        CurveFamily::Ellipse => ("ellipse", &["size_mm", "aspect"], 2),
        CurveFamily::Rose => ("rose", &["size_mm", "k"], 2),
        CurveFamily::Spiral => ("spiral", &["size_mm", "turns"], 2),
        CurveFamily::Polyline => ("polyline", &["points_mm", "closed", "may_cross"], 1),
        CurveFamily::Outline => ("outline", &["file", "closed", "may_cross"], 1),
    }
}

fn check_keys(typed: &CurveTable) -> Check<&'static str> {
    let (name, allowed, n_required) = keys(typed.family);
    let given = [
        ("size_mm", typed.size_mm.is_some()),
        ("width_mm", typed.width_mm.is_some()),
        ("cycles", typed.cycles.is_some()),
        ("phase_deg", typed.phase_deg.is_some()),
        ("turns", typed.turns.is_some()),
        ("aspect", typed.aspect.is_some()),
        ("k", typed.k.is_some()),
        ("points_mm", typed.points_mm.is_some()),
        ("file", typed.file.is_some()),
        ("closed", typed.closed.is_some()),
        ("may_cross", typed.may_cross.is_some()),
    ];
    for (key, is_given) in given {
        let place = format!("curve.{key}");
        if is_given && !allowed.contains(&key) {
            return Err(BadInput::new(place, format!("no such key for {name}"), "one"));
        }
        if !is_given && allowed[..n_required].contains(&key) {
            return Err(BadInput::new(place, format!("this key for {name}"), "nothing"));
        }
    }
    Ok(name)
}

fn curve(typed: &CurveTable, folder: &Path) -> Result<UnplacedCurve> {
    let family = check_keys(typed)?;
    // What is required was found above.
    let size = typed.size_mm.map_or(Ok(0.0), |size| between("curve.size_mm", size, [SHORTEST, LONGEST]))?;
    let drawn = |points, is_closed, may_cross| UnplacedCurve {
        place: "curve".to_owned(),
        family,
        points,
        is_closed,
        is_planar: true,
        may_cross,
        file: String::new(),
    };
    Ok(match typed.family {
        CurveFamily::Circle => drawn(family::circle(size), true, true),
        CurveFamily::Diamond => drawn(family::diamond(size), true, true),
        CurveFamily::Square => drawn(family::square(size), true, true),
        CurveFamily::FigureEight => drawn(family::figure_eight(size), true, true),
        CurveFamily::Ellipse => {
            let aspect = typed.aspect.unwrap_or_default();
            require("curve.aspect", "0 < aspect <= 1", aspect, aspect > 0.0 && aspect <= 1.0)?;
            drawn(family::ellipse(size, aspect), true, true)
        }
        CurveFamily::Rose => {
            let k = typed.k.unwrap_or_default();
            require("curve.k", "2 to 8", f64::from(k), (2..=8).contains(&k))?;
            drawn(family::rose(size, k), true, true)
        }
        CurveFamily::Spiral => {
            let turns = positive("curve.turns", typed.turns.unwrap_or_default())?;
            require("curve.turns", "at most 100", turns, turns <= 100.0)?;
            drawn(family::spiral(size, turns), false, true)
        }
        CurveFamily::Lissajous => {
            let width = between("curve.width_mm", typed.width_mm.unwrap_or_default(), [SHORTEST, LONGEST])?;
            let phase = finite("curve.phase_deg", typed.phase_deg.unwrap_or_default())?;
            let cycles = cycles(typed.cycles.unwrap_or_default().0)?;
            drawn(family::lissajous(width, size, cycles, phase), true, true)
        }
        CurveFamily::Polyline => {
            let (points, is_planar) = points(typed.points_mm.as_deref().unwrap_or_default())?;
            let is_closed = typed.closed.unwrap_or(points.first() == points.last());
            UnplacedCurve { is_planar, ..drawn(points, is_closed, typed.may_cross.unwrap_or(false)) }
        }
        CurveFamily::Outline => {
            let name = typed.file.as_deref().unwrap_or_default();
            let (points, is_closed, is_planar, file) = outline_file(name, folder)?;
            let is_closed = typed.closed.unwrap_or(is_closed);
            UnplacedCurve {
                is_planar,
                file,
                place: folder.join(name).display().to_string(),
                ..drawn(points, is_closed, typed.may_cross.unwrap_or(false))
            }
        }
    })
}

/// Cycles of x and y without a common divisor: with one, the curve would be run through several times.
fn cycles(typed: [u32; 2]) -> Check<[u32; 2]> {
    let divides = |k: u32| typed.iter().all(|cycles| cycles % k == 0);
    if typed.iter().any(|cycles| !(1..=20).contains(cycles)) || (2..=20).any(divides) {
        let expected = "two numbers from 1 to 20 without a common divisor";
        return Err(BadInput::new("curve.cycles", expected, format!("{typed:?}")));
    }
    Ok(typed)
}

/// Points as typed, all with x and y or all with x, y and z; and whether they are planar.
fn points(typed: &[Vec<f64>]) -> Check<(Vec<OutlinePoint>, bool)> {
    check_at_most("curve.points_mm", typed.len(), MAX_CROSSING_POINTS)?;
    let n = typed.first().map_or(2, Vec::len);
    let mut points = Vec::new();
    for (i, point) in typed.iter().enumerate() {
        let key = format!("curve.points_mm[{i}]");
        if point.len() != n || !(2..=3).contains(&n) {
            return Err(BadInput::new(key, "[x, y], or [x, y, z] for all", format!("{point:?}")));
        }
        let mut own = [0.0; 3];
        for (c, value) in point.iter().enumerate() {
            own[c] = within(&format!("{key}[{c}]"), *value, LONGEST)?;
        }
        points.push(own);
    }
    Ok((points, n == 2))
}

/// Points of an outline in a file, whether they close, whether they are planar, and the text of the file.
fn outline_file(name: &str, folder: &Path) -> Result<(Vec<OutlinePoint>, bool, bool, String)> {
    let path = folder.join(name);
    let place = path.display().to_string();
    let kind = path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
    Ok(match kind.as_deref() {
        Some("csv") => {
            let text = outline_text(&path)?;
            let (points, has_z) = csv::read(&text).map_err(|bad| bad.within(place))?;
            let is_closed = points.first() == points.last();
            (points, is_closed, !has_z, text)
        }
        Some("svg") => {
            let text = outline_text(&path)?;
            let (points, is_closed) = svg::read(&text).map_err(|bad| bad.within(place))?;
            let meets = points.first() == points.last();
            (points, is_closed || meets, true, text)
        }
        _ => return Err(BadInput::new("curve.file", "an outline: .csv or .svg", place).into()),
    })
}

fn outline_text(path: &Path) -> Result<String> {
    let text = file::read_text(path)?;
    let place = format!("{}: bytes", path.display());
    check_at_most(&place, text.len(), MAX_BYTES)?;
    Ok(text)
}
