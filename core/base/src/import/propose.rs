//! A map that the program writes from names, units and ranges, for a person to edit.

use crate::statistics::nearest_quantile;
use crate::{Table, units::Unit};
use std::fmt::Write as _;

/// Columns of a family at most that are named one by one.
const MAX_NAMED: usize = 60;
/// A tip that moves further than this is not in metres [m].
const LARGEST_TIP_M: f64 = 3.0;
/// A stroke longer than this is not in metres [m].
const LONGEST_STROKE_M: f64 = 0.3;
/// A joint that turns further than this is not in radians [rad].
const LARGEST_TURN: f64 = 2.2 * std::f64::consts::PI;
/// A current above this is not in amperes [A].
const LARGEST_CURRENT: f64 = 60.0;

/// Role that a column may have: the target without its unit, names of it (lower case, without number), the
/// units it may have with the largest plausible size in each.
struct ColumnRole {
    target: &'static str,
    names: &'static [&'static str],
    units: &'static [(&'static str, f64)],
}

const ANY: f64 = f64::INFINITY;
const ROLES: [ColumnRole; 11] = [
    ColumnRole {
        target: "tip_x",
        names: &["x", "tip_x", "px", "pos_x", "position_x", "tx"],
        units: &[("m", LARGEST_TIP_M), ("mm", ANY)],
    },
    ColumnRole {
        target: "tip_y",
        names: &["y", "tip_y", "py", "pos_y", "position_y", "ty"],
        units: &[("m", LARGEST_TIP_M), ("mm", ANY)],
    },
    ColumnRole {
        target: "tip_z",
        names: &["z", "tip_z", "pz", "pos_z", "position_z", "tz"],
        units: &[("m", LARGEST_TIP_M), ("mm", ANY)],
    },
    ColumnRole {
        target: "stroke_*",
        names: &[
            "stroke",
            "cmd",
            "command",
            "tendon",
            "cable",
            "servo",
            "displacement",
            "u",
            "pull",
            "l",
            "length",
        ],
        units: &[("m", LONGEST_STROKE_M), ("mm", ANY)],
    },
    ColumnRole { target: "tension_*", names: &["tension", "load_cell", "loadcell"], units: &[("n", ANY)] },
    ColumnRole {
        target: "q_*",
        names: &[
            "q",
            "pos",
            "position",
            "positions",
            "joint",
            "angle",
            "joint_position",
            "observation.state",
            "theta",
        ],
        units: &[("rad", LARGEST_TURN), ("deg", ANY)],
    },
    ColumnRole {
        target: "dq_*",
        names: &["dq", "qd", "vel", "velocity", "velocities", "speed", "joint_velocity"],
        units: &[("rad_s", 4.0 * LARGEST_TURN), ("deg_s", ANY)],
    },
    ColumnRole {
        target: "tau_*",
        names: &["tau", "torque", "torques", "effort", "joint_effort"],
        units: &[("n_m", ANY)],
    },
    ColumnRole {
        target: "current_*",
        names: &["current", "cur", "i"],
        units: &[("a", LARGEST_CURRENT), ("ma", ANY)],
    },
    ColumnRole {
        target: "goal_*",
        names: &["goal", "goal_pos", "action", "target", "target_positions", "cmd_pos"],
        units: &[("rad", LARGEST_TURN), ("deg", ANY)],
    },
    ColumnRole { target: "temperature_*", names: &["temp", "temperature"], units: &[("degc", ANY)] },
];
const TIMES: [&str; 10] =
    ["t", "time", "times", "timestamp", "timestamps", "stamp", "elapsed", "sec", "secs", "zeit"];
const QUATERNION: [(&str, [&str; 5]); 4] = [
    ("tip_qw", ["qw", "tip_qw", "quat_w", "q_w", "rot_w"]),
    ("tip_qx", ["qx", "tip_qx", "quat_x", "q_x", "rot_x"]),
    ("tip_qy", ["qy", "tip_qy", "quat_y", "q_y", "rot_y"]),
    ("tip_qz", ["qz", "tip_qz", "quat_z", "q_z", "rot_z"]),
];

/// A column's name without its number and unit, in lower case, and what unit it states.
struct ParsedName {
    stem: String,
    number: Option<usize>,
    unit: Option<&'static Unit>,
}

fn parsed(table: &Table, k: usize) -> ParsedName {
    let name = table.columns()[k].name.trim();
    let bracket = name.find(['[', '(']).filter(|at| name.ends_with([']', ')']) && *at > 0);
    // `state[3]` has a number in brackets, `X [mm]` a unit.
    let inside = bracket.map(|at| name[at + 1..name.len() - 1].trim());
    let (base, stated) = match (bracket, inside) {
        (Some(at), Some(inside)) if inside.parse::<usize>().is_err() => (name[..at].trim(), inside),
        _ => (name, table.unit(k)),
    };
    let lower = base.to_lowercase().replace([' ', '-'], "_");
    let lower = lower.trim_end_matches(']').replace('[', "_");
    let (stem, own) = match Unit::of_name(&lower) {
        Some((stem, unit)) => (stem.to_owned(), Some(unit)),
        None => (lower.clone(), None),
    };
    let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let (text, number) = stem.split_at(stem.len() - digits);
    ParsedName {
        stem: text.trim_end_matches('_').to_owned(),
        number: number.parse().ok(),
        unit: own.or_else(|| Unit::from_suffix(&suffix(stated))),
    }
}

/// A unit as people write it as the ending of a name: `N·m` is `n_m`.
fn suffix(unit: &str) -> String {
    match unit.trim() {
        "°" | "degrees" | "degree" => "deg".to_owned(),
        "°/s" | "dps" => "deg_s".to_owned(),
        "°C" | "C" => "degc".to_owned(),
        "Nm" | "N m" | "N·m" | "N*m" => "n_m".to_owned(),
        "sec" | "seconds" => "s".to_owned(),
        "µs" | "μs" => "us".to_owned(),
        "µm" | "μm" => "um".to_owned(),
        "%" => "percent".to_owned(),
        other => other.to_lowercase().replace(['/', ' ', '*', '·'], "_").replace('²', "2"),
    }
}

/// Smallest and largest number of a column; none where it has no number.
fn range(values: &[f64]) -> Option<[f64; 2]> {
    let finite = values.iter().copied().filter(|x| x.is_finite());
    finite.fold(None, |range, x| match range {
        Some([low, high]) => Some([f64::min(low, x), f64::max(high, x)]),
        None => Some([x, x]),
    })
}

fn size(values: &[f64]) -> f64 {
    range(values).map_or(0.0, |[low, high]| low.abs().max(high.abs()))
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// The map in TOML. Every line gives the reason for its quantity; columns without a quantity follow as comments
/// with their ranges.
pub fn propose(table: &Table, source: &str) -> String {
    let names: Vec<ParsedName> = (0..table.columns().len()).map(|k| parsed(table, k)).collect();
    let mut is_taken = vec![false; names.len()];
    let mut lines = String::new();
    let time = time_line(table, &names, &mut is_taken);
    for (target, known) in QUATERNION {
        let found =
            names.iter().position(|name| known.contains(&name.stem.as_str()) && name.number.is_none());
        if let Some(k) = found.filter(|k| size(&table.columns()[*k].values) <= 1.0 + 1e-3) {
            is_taken[k] = true;
            let _ = writeln!(
                lines,
                "{target} = {}    # no larger than 1: a part of a quaternion",
                quoted(&table.columns()[k].name)
            );
        }
    }
    for role in &ROLES {
        lines.push_str(&role_line(role, table, &names, &mut is_taken));
    }
    let mut text = format!(
        "# What the columns of {} are: proposed from their names, units and ranges.\n\
         # Check every line, then: hysteron import {} --map THIS_FILE --out recording.parquet\n\
         format = \"hysteron-columns\"\nversion = 1\n",
        source.replace(['\n', '\r'], " "),
        source.replace(['\n', '\r'], " "),
    );
    if time.is_empty() {
        text.push_str("rate_hz = 100.0    # CHECK: no column looks like a time; rows per second\n");
    }
    let split = names
        .iter()
        .position(|name| ["episode", "episode_index", "trial", "run"].contains(&name.stem.as_str()));
    if let Some(k) = split
        .filter(|k| range(&table.columns()[*k].values).is_some_and(|[a, b]| a != b) || table.has_words(*k))
    {
        is_taken[k] = true;
        let _ = writeln!(
            text,
            "episode = {}    # a recording for each of its values",
            quoted(&table.columns()[k].name)
        );
    }
    let _ = write!(text, "\n[columns]\n{time}{lines}");
    let left: Vec<usize> = (0..names.len()).filter(|k| !is_taken[*k]).collect();
    if !left.is_empty() {
        text.push_str("\n# Not taken (add a line where one matters; a target ends in its unit):\n");
    }
    for k in left.iter().take(MAX_NAMED) {
        let column = &table.columns()[*k];
        let held = match range(&column.values) {
            _ if table.has_words(*k) => "text".to_owned(),
            Some([low, high]) => format!("{low:.6} to {high:.6}"),
            None => "no numbers".to_owned(),
        };
        let _ = writeln!(text, "# {}: {held} {}", quoted(&column.name), table.unit(*k));
    }
    if left.len() > MAX_NAMED {
        let _ = writeln!(text, "# and {} more", left.len() - MAX_NAMED);
    }
    for (name, what) in table.left_out() {
        let _ = writeln!(text, "# {}: {what}, which cannot be read", quoted(name));
    }
    text
}

/// The line of the times; empty where no column looks like one.
fn time_line(table: &Table, names: &[ParsedName], is_taken: &mut [bool]) -> String {
    let rises = |k: usize| table.columns()[k].values.windows(2).filter(|pair| pair[1] > pair[0]).count();
    let is_time = |k: &usize| {
        let n = table.n_rows().saturating_sub(1);
        (table.is_in_seconds(*k) || TIMES.contains(&names[*k].stem.as_str())) && 10 * rises(*k) >= 9 * n
    };
    let Some(k) = (0..names.len()).find(is_time) else { return String::new() };
    is_taken[k] = true;
    let name = quoted(&table.columns()[k].name);
    if table.is_in_seconds(k) {
        return format!(
            "time_s = {name}    # stamps or spans of time, which say themselves what they count\n"
        );
    }
    if let Some(unit) = names[k].unit.filter(|unit| unit.si_suffix == "s") {
        return format!("time_{} = {name}    # its unit is stated\n", unit.suffix);
    }
    let mut steps: Vec<f64> = table.columns()[k].values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = nearest_quantile(&mut steps, 0.5).unwrap_or(0.0);
    let (unit, divided) = match step {
        step if step < 1.0 => ("s", ""),
        step if step < 1000.0 => ("ms", ""),
        step if step < 1e6 => ("us", ""),
        _ => ("us", ", divided_by = 1000"),
    };
    let column = if divided.is_empty() { name } else { format!("{{ columns = {name}{divided} }}") };
    format!(
        "time_{unit} = {column}    # CHECK: rises by {step:.6} a row, so taken for {unit}{}\n",
        if divided.is_empty() { "" } else { " of 1000 ns" }
    )
}

/// The line of a role; empty where no column has it.
fn role_line(role: &ColumnRole, table: &Table, names: &[ParsedName], is_taken: &mut [bool]) -> String {
    let is_family = role.target.ends_with('*');
    let si_of = |suffix: &str| Unit::from_suffix(suffix).map(|unit| unit.si_suffix);
    let fits = |k: usize, name: &str| {
        let stated = names[k].unit.map(|unit| unit.si_suffix);
        !is_taken[k]
            && names[k].stem == name
            && names[k].number.is_some() == is_family
            && !table.has_words(k)
            && stated.is_none_or(|si| role.units.iter().any(|(unit, _)| si_of(unit) == Some(si)))
    };
    let family =
        role.names.iter().map(|name| (0..names.len()).filter(|k| fits(*k, name)).collect::<Vec<_>>());
    let Some(mut family) = family.into_iter().find(|family| !family.is_empty()) else { return String::new() };
    family.sort_by_key(|k| names[*k].number);
    let largest = family.iter().map(|k| size(&table.columns()[*k].values)).fold(0.0, f64::max);
    let (unit, why) = match names[family[0]].unit {
        Some(unit) => (unit.suffix, "its unit is stated".to_owned()),
        None => {
            let unit = role.units.iter().find(|(_, most)| largest <= *most).map_or("", |(unit, _)| unit);
            (unit, format!("CHECK: no larger than {largest:.6}, so taken for {unit}"))
        }
    };
    family.iter().for_each(|k| is_taken[*k] = true);
    let listed: Vec<String> = family.iter().map(|k| quoted(&table.columns()[*k].name)).collect();
    let listed = if is_family { format!("[{}]", listed.join(", ")) } else { listed.concat() };
    format!("{} = {listed}    # {why}\n", quoted(&format!("{}_{unit}", role.target)))
}
