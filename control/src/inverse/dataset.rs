//! Training data of the controller: recordings of commanded strokes and the tip that followed.

use hysteron_base::{BadInput, Bounds, Metadata, Recording, rng};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Axes, TipPosition};
use crate::StrokeLimits;
use crate::split::{MotionKind, draw_validation};

/// Largest difference of a sample's duration that still counts as the same rate [-].
const SAME_STEP: f64 = 0.01;

/// Where strokes and tip come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DataOrigin {
    /// A rig, 𝓓_real; the virtual rig counts.
    Real,
    /// A twin, 𝓓_syn.
    Synthetic,
}

/// One recorded trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Demonstration {
    /// Name in messages and options.
    pub name: String,
    /// SHA-256 of its file.
    pub hash: String,
    /// From a rig or from a twin.
    pub origin: DataOrigin,
    /// Hashes of the rig or the scene that it is of; empty where they are not in the recording.
    pub robot: String,
    /// Family of its plan; empty where it is not in the recording.
    pub family: String,
    /// Duration of a sample [s].
    pub step: f64,
    /// Coordinates of its tip.
    pub axes: Axes,
    /// Tip (n_samples).
    pub tip: Vec<TipPosition>,
    /// True where the sample was filled in (n_samples).
    pub gap: Vec<bool>,
    /// Number of tendons.
    pub n_tendons: usize,
    /// Strokes (n_samples × n_tendons) [m].
    pub strokes: Vec<f64>,
    /// ∂tip/∂stroke (n_samples × axes × n_tendons) [-]; empty where it was not recorded.
    pub jacobian: Vec<f64>,
}

impl Demonstration {
    /// Takes a recording with `tip_x_m`, `tip_y_m`, in space `tip_z_m`, and `stroke_1_m`, …; and the twin's local
    /// Jacobian where there are `tip_x_per_stroke_1_ratio`, …, and as many for the other axes.
    ///
    /// # Errors
    /// Channels are missing, the rate is not fixed, or the Jacobian has not all tendons.
    pub fn new(name: &str, hash: &str, recording: &Recording, axes: Axes) -> Result<Self, BadInput> {
        let within = |bad: BadInput| bad.within(name);
        let coordinates = axes.names().iter().map(|axis| recording.require(&format!("tip_{axis}_m")));
        let coordinates = coordinates.collect::<Result<Vec<_>, _>>().map_err(within)?;
        recording.require("stroke_1_m").map_err(within)?;
        let strokes = recording.strokes();
        let rate = recording.rate_hz().ok_or_else(|| {
            BadInput::new(format!("{name}: time_s"), "a fixed rate", "uneven steps").hint("resample it")
        })?;
        let n = recording.n_samples();
        let row = |axis: &&str| recording.numbered(&format!("tip_{axis}_per_stroke"), "ratio");
        let rows: Vec<Vec<&[f64]>> = axes.names().iter().map(row).collect();
        let counts: Vec<usize> = rows.iter().map(Vec::len).collect();
        let n_series: usize = counts.iter().sum();
        if n_series > 0 && counts.iter().any(|count| *count != strokes.len()) {
            let expected = format!(
                "tip_x_per_stroke_k_ratio, and as many for {}, of {} tendons",
                axes.names()[1..].join(" and "),
                strokes.len()
            );
            return Err(BadInput::new(name, expected, format!("{counts:?}")));
        }
        let jacobian = |i: usize| rows.iter().flatten().map(move |series| series[i]);
        let tip = |i: usize| {
            let mut tip = [0.0; 3];
            tip.iter_mut().zip(&coordinates).for_each(|(c, series)| *c = series[i]);
            tip
        };
        let (origin, robot) = robot_of(recording.meta());
        Ok(Self {
            name: name.to_owned(),
            hash: hash.to_owned(),
            origin,
            robot,
            family: recording.meta().extra.get("plan.family").cloned().unwrap_or_default(),
            step: rate.recip(),
            axes,
            tip: (0..n).map(tip).collect(),
            gap: recording.gap().to_vec(),
            n_tendons: strokes.len(),
            strokes: (0..n).flat_map(|i| strokes.iter().map(move |series| series[i])).collect(),
            jacobian: (0..n).flat_map(jacobian).collect(),
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.tip.len()
    }

    /// False: a recording has samples.
    pub fn is_empty(&self) -> bool {
        self.tip.is_empty()
    }

    /// Kind of its motion: the family of its plan, or where it has none the class of its strokes.
    pub fn kind(&self) -> String {
        match &self.family[..] {
            "" => MotionKind::of(&self.strokes, self.n_tendons).name().to_owned(),
            family => family.to_owned(),
        }
    }

    /// Strokes of a sample [m].
    pub fn strokes_at(&self, sample: usize) -> &[f64] {
        &self.strokes[sample * self.n_tendons..(sample + 1) * self.n_tendons]
    }
}

/// A rig leaves its hash, a twin that of its scene; what was identified on a rig's recording has both and is the rig's.
fn robot_of(meta: &Metadata) -> (DataOrigin, String) {
    let of = |key: &str| meta.extra.get(key).map_or("", String::as_str);
    let rig = [of("rig.sha256"), of("virtual.robot")];
    match (rig, &meta.scene_hash[..]) {
        (["", _], scene) if !scene.is_empty() => (DataOrigin::Synthetic, scene.to_owned()),
        ([hash, ""], _) => (DataOrigin::Real, hash.to_owned()),
        ([hash, robot], _) => (DataOrigin::Real, format!("{hash} {robot}")),
    }
}

/// Demonstrations of one robot, split by whole trajectories.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// Training demonstrations.
    pub training: Vec<Demonstration>,
    /// Validation demonstrations, for early stopping; never in the fit.
    pub validation: Vec<Demonstration>,
    /// Duration of a sample [s].
    pub step: f64,
    /// Number of tendons.
    pub n_tendons: usize,
    /// Coordinates of the tips.
    pub axes: Axes,
}

impl Dataset {
    /// Splits demonstrations: those named in `held_out` are validated on; without names a sixth of every kind of
    /// motion, and at least one where there are two, drawn by `seed` from the real ones, or from the synthetic ones where
    /// there is no real one.
    ///
    /// # Errors
    /// Fewer than two demonstrations, none left to learn from, a name that is not among them, or different robots,
    /// rates or numbers of tendons.
    pub fn new(all: Vec<Demonstration>, held_out: &[String], seed: u64) -> Result<Self, BadInput> {
        check_alike(&all)?;
        let held_out = Self::held_out(&all, held_out, seed)?;
        let (step, n_tendons, axes) = (all[0].step, all[0].n_tendons, all[0].axes);
        let (validation, training): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|one| held_out.contains(&one.name));
        Ok(Self { training, validation, step, n_tendons, axes })
    }

    /// The names in `held_out`, or those that are drawn without them.
    pub(super) fn held_out(
        all: &[Demonstration],
        held_out: &[String],
        seed: u64,
    ) -> Result<Vec<String>, BadInput> {
        let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
        if let Some(unknown) = held_out.iter().find(|name| !names.contains(&name.as_str())) {
            return Err(BadInput::new("held out", format!("of {}", names.join(", ")), unknown));
        }
        let held_out = if held_out.is_empty() { drawn(all, seed) } else { held_out.to_vec() };
        if names.iter().all(|name| held_out.iter().any(|other| other == name)) {
            return Err(BadInput::new("held out", "some recordings for training", "all of them"));
        }
        Ok(held_out)
    }

    /// The demonstrations of one origin, split as here; none where none of them is left to learn from.
    pub fn only(&self, origin: DataOrigin) -> Option<Self> {
        let theirs = |all: &[Demonstration]| -> Vec<Demonstration> {
            all.iter().filter(|one| one.origin == origin).cloned().collect()
        };
        let only = Self { training: theirs(&self.training), validation: theirs(&self.validation), ..*self };
        let is_validated = self.validation.is_empty() || !only.validation.is_empty();
        (!only.training.is_empty() && is_validated).then_some(only)
    }

    /// How many demonstrations to learn from have this origin.
    pub fn count(&self, origin: DataOrigin) -> usize {
        self.training.iter().filter(|one| one.origin == origin).count()
    }

    /// Kinds of motion in training that validation lacks, with the names of their training demonstrations: of the rig, where
    /// some are of one.
    pub fn unvalidated(&self) -> Vec<(String, Vec<String>)> {
        let validated: Vec<String> = self.validation.iter().map(Demonstration::kind).collect();
        let mut left: std::collections::BTreeMap<String, Vec<String>> = std::collections::BTreeMap::new();
        let is_validated = |origin| self.validation.iter().any(|one| one.origin == origin);
        for one in self.training.iter().filter(|one| is_validated(one.origin)) {
            let kind = one.kind();
            if !validated.contains(&kind) {
                left.entry(kind).or_default().push(one.name.clone());
            }
        }
        left.into_iter().collect()
    }

    /// The robots that it is of, rig before scene.
    pub fn robots(&self) -> Vec<String> {
        let all = || self.training.iter().chain(&self.validation);
        let of = |origin| all().find(|one| one.origin == origin).map(|one| one.robot.clone());
        [DataOrigin::Real, DataOrigin::Synthetic].into_iter().filter_map(of).collect()
    }

    /// Range of the training strokes [m], and their largest rate [m/s].
    pub fn limits(&self) -> StrokeLimits {
        let values = self.training.iter().flat_map(|one| &one.strokes);
        let stroke = values.fold(Bounds { min: f64::INFINITY, max: f64::NEG_INFINITY }, |bounds, &stroke| {
            Bounds { min: bounds.min.min(stroke), max: bounds.max.max(stroke) }
        });
        let n = self.n_tendons;
        let changes = self.training.iter().flat_map(|one| {
            one.strokes.iter().zip(&one.strokes[n..]).map(|(before, after)| (after - before).abs())
        });
        StrokeLimits { stroke, stroke_rate: changes.fold(0.0, f64::max) / self.step }
    }
}

pub(super) fn check_alike(all: &[Demonstration]) -> Result<(), BadInput> {
    if all.len() < 2 {
        return Err(BadInput::new("recordings", "at least two", all.len().to_string())
            .hint("early stopping needs a validation trajectory"));
    }
    let first = &all[0];
    for one in all {
        let same_origin = all.iter().find(|other| other.origin == one.origin).unwrap_or(one);
        if one.robot != same_origin.robot {
            let expected = format!("recordings of one robot, {} as {}", same_origin.robot, same_origin.name);
            return Err(BadInput::new(&one.name, expected, &one.robot));
        }
        if one.axes != first.axes {
            let expected =
                format!("tips measured along {}, as {}", first.axes.names().join(", "), first.name);
            return Err(BadInput::new(&one.name, expected, one.axes.names().join(", ")));
        }
        if one.n_tendons != first.n_tendons {
            let expected = format!("{} tendons, as {}", first.n_tendons, first.name);
            return Err(BadInput::new(&one.name, expected, one.n_tendons.to_string()));
        }
        if (one.step / first.step - 1.0).abs() > SAME_STEP {
            let expected = format!("{:.4} Hz, as {}", first.step.recip(), first.name);
            return Err(
                BadInput::new(&one.name, expected, format!("{:.4} Hz", one.step.recip())).hint("resample it")
            );
        }
    }
    Ok(())
}

/// Names of what to validate on: some of every kind of motion. Synthetic demonstrations show how well a twin is learned, not
/// its robot: they are validated on only where there is no real one.
fn drawn(all: &[Demonstration], seed: u64) -> Vec<String> {
    let real: Vec<&Demonstration> = all.iter().filter(|one| one.origin == DataOrigin::Real).collect();
    let usable = if real.is_empty() { all.iter().collect() } else { real };
    let kinds: Vec<String> = usable.iter().map(|one| one.kind()).collect();
    let drawn = draw_validation(&kinds, &mut rng(seed, "inverse/held-out"));
    drawn.into_iter().map(|k| usable[k].name.clone()).collect()
}
