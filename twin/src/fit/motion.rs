//! What a fit needs of a recording: commands thinned to steps of some size, and the tip where it was measured.

use hysteron_base::{BadInput, Drive, Recording};

use crate::{Result, Target, TendonSpec, Twin};

/// A quasi-static sequence of commands with the tip that was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Name in messages.
    pub name: String,
    /// Rows of the recording that were kept, from 0.
    pub rows: Vec<usize>,
    /// Per row, a target per tendon, auxiliary ones included.
    pub targets: Vec<Vec<Target>>,
    /// Per row, the measured tip [m]; none where the sample was missing.
    pub tips: Vec<Option<[f64; 3]>>,
    /// Coordinates that are used; a constant one measures nothing.
    pub axes: [bool; 3],
}

/// Fewest rows of a motion with a measured tip.
const FEWEST_ROWS: usize = 8;
/// How far from its rest a tip may seem to be, over the robot's length: it can turn over, and a tracker may stand
/// apart a little [-].
const FARTHEST: f64 = 2.5;

impl Motion {
    /// Takes commands and tip out of `recording`, called `name` in messages: rows between which no stroke changed by
    /// `every` [m] are left out, or the tip did not move by as much where a tendon is driven by tension.
    ///
    /// # Errors
    /// Commands of another robot; no tip; a tip farther off than the robot reaches, as of other units; one that never
    /// moves; too few rows.
    pub fn new(twin: &Twin, recording: &Recording, name: &str, every: f64) -> Result<Self> {
        Ok(Self::checked(twin, recording, name, every).map_err(|bad| bad.within(name))?)
    }

    fn checked(
        twin: &Twin,
        recording: &Recording,
        name: &str,
        every: f64,
    ) -> std::result::Result<Self, BadInput> {
        let courses = courses(twin, recording)?;
        let mut measured = [&[][..]; 3];
        for (values, axis) in measured.iter_mut().zip(["x", "y", "z"]) {
            *values = recording.require(&format!("tip_{axis}_m"))?;
        }
        let tip = |row: usize| measured.map(|values| values[row]);
        check_reach(twin, recording, tip)?;

        let by_tip = courses.iter().any(|course| matches!(course, Course::Tensions(_)));
        let moved = |from: usize, to: usize| {
            let by_stroke = courses.iter().map(|course| match course {
                Course::Strokes(values) => (values[to] - values[from]).abs(),
                _ => 0.0,
            });
            let tip = if by_tip { distance(tip(from), tip(to)) } else { 0.0 };
            by_stroke.fold(tip, f64::max)
        };
        let mut rows = vec![0];
        for row in 1..recording.n_samples() {
            if moved(rows[rows.len() - 1], row) >= every {
                rows.push(row);
            }
        }
        let tips: Vec<Option<[f64; 3]>> =
            rows.iter().map(|&row| (!recording.gap()[row]).then(|| tip(row))).collect();
        let axes = std::array::from_fn(|c| is_moving(tips.iter().flatten().map(|tip| tip[c])));
        let n_measured = tips.iter().flatten().count();
        if n_measured < FEWEST_ROWS || axes == [false; 3] {
            let expected = format!("at least {FEWEST_ROWS} rows between which robot and tip move");
            let found = match n_measured {
                FEWEST_ROWS.. => "a tip that never moves".to_owned(),
                n => format!("{n} of {}", recording.n_samples()),
            };
            let hint = "rows count that differ by --every from the one before and are no gap";
            return Err(BadInput::new("recording", expected, found).hint(hint));
        }
        let targets = rows.iter().map(|&row| courses.iter().map(|course| course.at(row)).collect()).collect();
        Ok(Self { name: name.to_owned(), rows, targets, tips, axes })
    }

    /// Rows in which nothing is commanded, nearly: every stroke and tension within a twentieth of its largest.
    pub(super) fn rows_at_zero(&self) -> Vec<usize> {
        let size = |target: &Target| match target {
            Target::Stroke(value) | Target::Tension(value) => value.abs(),
            Target::Free => 0.0,
        };
        let largest = self.targets.iter().flatten().map(size).fold(0.0, f64::max);
        let is_zero = |&row: &usize| self.targets[row].iter().all(|target| size(target) <= 0.05 * largest);
        (0..self.targets.len()).filter(is_zero).collect()
    }
}

enum Course<'a> {
    Strokes(&'a [f64]),
    Tensions(&'a [f64]),
    Constant(Target),
}

impl Course<'_> {
    fn at(&self, row: usize) -> Target {
        match self {
            Course::Strokes(values) => Target::Stroke(values[row]),
            Course::Tensions(values) => Target::Tension(values[row]),
            Course::Constant(target) => *target,
        }
    }
}

/// What every tendon follows: primary ones as the scene drives them, auxiliary ones their recorded strokes or nothing.
fn courses<'a>(twin: &Twin, recording: &'a Recording) -> std::result::Result<Vec<Course<'a>>, BadInput> {
    let (primary, auxiliary) = twin.tendons.split_at(twin.n_primary);
    let strokes = recording.strokes();
    let by_stroke = primary.iter().any(|tendon| tendon.drive == Drive::Stroke);
    if (by_stroke || !strokes.is_empty()) && strokes.len() != primary.len() {
        let expected = format!("{}, one per tendon of the scene", primary.len());
        return Err(BadInput::new("stroke columns", expected, strokes.len().to_string())
            .hint("is this a recording of another robot?"));
    }
    let mut courses = Vec::new();
    for (k, tendon) in primary.iter().enumerate() {
        courses.push(match tendon.drive {
            Drive::Stroke => Course::Strokes(strokes[k]),
            Drive::Tension => Course::Tensions(tensions(recording, tendon, k + 1)?),
            Drive::Free => Course::Constant(Target::Free),
        });
    }
    let aux = recording.aux();
    if !aux.is_empty() && aux.len() != auxiliary.len() {
        let expected = format!("{}, as the layout has", auxiliary.len());
        return Err(BadInput::new("aux columns", expected, aux.len().to_string()));
    }
    for (k, tendon) in auxiliary.iter().enumerate() {
        courses.push(match (aux.get(k), tendon.drive) {
            (Some(values), _) => Course::Strokes(values),
            (None, Drive::Stroke) => Course::Constant(Target::Stroke(tendon.stroke.clamp(0.0))),
            (None, Drive::Tension) => Course::Constant(Target::Tension(tendon.tension.clamp(0.0))),
            (None, Drive::Free) => Course::Constant(Target::Free),
        });
    }
    Ok(courses)
}

fn tensions<'a>(
    recording: &'a Recording,
    tendon: &TendonSpec,
    number: usize,
) -> std::result::Result<&'a [f64], BadInput> {
    let name = format!("tension_{number}_n");
    let values = recording.require(&name)?;
    match values.iter().position(|value| !tendon.tension.contains(*value)) {
        None => Ok(values),
        Some(row) => Err(BadInput::new(
            format!("row {}: {name}", row + 1),
            format!("{} to {} N, the bounds of {}", tendon.tension.min, tendon.tension.max, tendon.name),
            format!("{} N", values[row]),
        )),
    }
}

/// No tip may lie farther from its rest than the robot reaches.
fn check_reach(
    twin: &Twin,
    recording: &Recording,
    tip: impl Fn(usize) -> [f64; 3],
) -> std::result::Result<(), BadInput> {
    let rest = twin.tip_of(&twin.rest());
    let length = length_of(twin);
    let far = |row: &usize| distance(tip(*row), rest) > FARTHEST * length;
    let Some(row) = (0..recording.n_samples()).filter(|&row| !recording.gap()[row]).find(far) else {
        return Ok(());
    };
    let mm = tip(row).map(|c| 1e3 * c);
    Err(BadInput::new(
        format!("row {}: tip", row + 1),
        format!("within reach of a robot of {:.1} mm", 1e3 * length),
        format!("({:.1}, {:.1}, {:.1}) mm", mm[0], mm[1], mm[2]),
    )
    .hint("is the unit of the columns their ending, _mm or _m? are they in the frame of the scene?"))
}

/// Distance of the tip from the farthest node at rest [m].
pub(super) fn length_of(twin: &Twin) -> f64 {
    let tip = twin.tip_of(&twin.rest());
    twin.body.rest.iter().map(|&[x, y, z, _]| distance([x, y, z], tip)).fold(0.0, f64::max)
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

fn is_moving(mut values: impl Iterator<Item = f64>) -> bool {
    let first = values.next();
    values.any(|value| Some(value) != first)
}
