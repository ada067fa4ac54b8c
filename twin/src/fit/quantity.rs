//! Quantities of a scene that can be fitted: one line for each.

use hysteron_base::{BadInput, Bounds, Friction, Scene, Tendon};

use crate::Result;
use hysteron_fit::{Parameter, ParameterScale, Prior};

/// A physical quantity of a scene.
pub struct SceneQuantity {
    /// Name on the command line.
    pub name: &'static str,
    /// The same with the unit in which a person types and reads it, and the factor from SI to that unit.
    pub key: (&'static str, f64),
    /// How it is spread between its bounds.
    pub scale: ParameterScale,
    /// Bounds unless others are given [SI].
    pub bounds: fn(&Scene) -> Bounds,
    /// Standard deviation of the prior, around the scene's value [SI; a factor on a logarithmic scale].
    pub width: f64,
    /// How many values it has.
    pub of: Of,
    /// Value k [SI]; none where the scene lacks what it belongs to.
    pub get: fn(&Scene, usize) -> Option<f64>,
    /// Changes value k where there is one.
    pub set: fn(&mut Scene, usize, f64),
}

impl SceneQuantity {
    /// The unit of its key as people write it; empty where it has none.
    pub fn unit(&self) -> &'static str {
        match self.key.0.trim_start_matches(self.name).trim_start_matches('_') {
            "mpa" => "MPa",
            "kg_m3" => "kg/m³",
            "mm_per_n" => "mm/N",
            "n" => "N",
            plain => plain,
        }
    }
}

/// How many values a quantity has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// One.
    Robot,
    /// One per tendon.
    Tendons,
    /// One per component, by these names.
    Components(&'static [&'static str]),
}

/// The modulus may be wrong by this factor: printed and cast materials rarely are by more.
const MODULUS: f64 = 30.0;
/// So may the density, for hoses and cables that a body carries.
const DENSITY: f64 = 3.0;
/// Acceleration of gravity of a scene that names none [m/s²].
const STANDARD_GRAVITY: f64 = 9.80665;
/// Farthest that gravity leans from an axis of the scene: from 45° on it is nearer to another [rad].
const LEAN: f64 = 44.9 * std::f64::consts::PI / 180.0;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

const fn within(min: f64, max: f64) -> Bounds {
    Bounds { min, max }
}

/// The mean over the tendons.
fn mean(scene: &Scene, of: fn(&Tendon) -> f64) -> f64 {
    scene.tendons.iter().map(of).sum::<f64>() / scene.tendons.len().max(1) as f64
}

/// Friction in the body, which takes places of friction along the tendons.
fn in_body(scene: &Scene) -> Option<Friction> {
    scene.friction.filter(|friction| friction.points > 0)
}

/// Friction with that of a sheath, which takes a tendon that stretches before it.
fn in_sheath(scene: &Scene) -> Option<Friction> {
    scene.friction.filter(|friction| friction.sheath_compliance_share > 0.0)
}

/// The axis of the scene nearest to gravity, its sign, and the two other axes; -z where there is no gravity.
fn down(gravity: [f64; 3]) -> (usize, f64, [usize; 2]) {
    let axis = (0..3).rev().fold(2, |best, c| if gravity[c].abs() > gravity[best].abs() { c } else { best });
    (axis, if gravity[axis] > 0.0 { 1.0 } else { -1.0 }, [(axis + 1) % 3, (axis + 2) % 3])
}

/// Angle by which gravity leans from the axis nearest to it towards the k-th other one [rad].
fn lean(gravity: [f64; 3], k: usize) -> f64 {
    let (axis, _, others) = down(gravity);
    if gravity[axis] == 0.0 { 0.0 } else { gravity[others[k]].atan2(gravity[axis].abs()) }
}

/// Gravity of the same magnitude that leans otherwise.
fn leaning(gravity: [f64; 3], k: usize, angle: f64) -> [f64; 3] {
    let (axis, sign, others) = down(gravity);
    let mut tangents = [lean(gravity, 0).tan(), lean(gravity, 1).tan()];
    tangents[k] = angle.tan();
    let size = gravity.iter().map(|c| c * c).sum::<f64>().sqrt();
    let along = if size > 0.0 { size } else { STANDARD_GRAVITY }
        / (1.0 + tangents[0].powi(2) + tangents[1].powi(2)).sqrt();
    let mut leaning = [0.0; 3];
    leaning[axis] = sign * along;
    leaning[others[0]] = along * tangents[0];
    leaning[others[1]] = along * tangents[1];
    leaning
}

/// Gravity that leans as far as it may towards the k-th other axis, a little farther: that axis is then the nearest.
pub(super) fn beyond(gravity: [f64; 3], k: usize) -> [f64; 3] {
    const FARTHER: f64 = 1.02;
    let (_, _, others) = down(gravity);
    let size = |g: [f64; 3]| g.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut beyond = gravity;
    beyond[others[k]] *= FARTHER;
    beyond.map(|c| c * size(gravity) / size(beyond))
}

/// Gravity along each axis of the scene, of the scene's magnitude [m/s²].
pub(super) fn along_axes(scene: &Scene) -> [[f64; 3]; 6] {
    let size = scene.gravity.iter().map(|c| c * c).sum::<f64>().sqrt();
    let size = if size > 0.0 { size } else { STANDARD_GRAVITY };
    std::array::from_fn(|i| {
        let mut gravity = [0.0; 3];
        gravity[i / 2] = if i % 2 == 0 { -size } else { size };
        gravity
    })
}

fn change(scene: &mut Scene, to: impl FnOnce(&mut Friction)) {
    scene.friction.as_mut().map(to);
}

/// Without compliance [m/N], or a share of it [-], before it there is no friction of a sheath: neither goes below this
/// unless the scene has less.
const MIN_COMPLIANCE: f64 = 1e-9;
const MIN_SHARE: f64 = 0.02;

/// All of them.
#[rustfmt::skip] // a table
pub const QUANTITIES: [SceneQuantity; 15] = [
    SceneQuantity { name: "youngs_modulus", key: ("youngs_modulus_mpa", 1e-6), scale: ParameterScale::Logarithmic, width: 2.0, of: Of::Robot,
        bounds: |s| within(s.material.youngs_modulus / MODULUS, s.material.youngs_modulus * MODULUS),
        get: |s, _| Some(s.material.youngs_modulus), set: |s, _, v| s.material.youngs_modulus = v },
    SceneQuantity { name: "poisson_ratio", key: ("poisson_ratio", 1.0), scale: ParameterScale::Linear, width: 0.05, of: Of::Robot,
        bounds: |_| within(0.0, 0.49),
        get: |s, _| Some(s.material.poisson_ratio), set: |s, _, v| s.material.poisson_ratio = v },
    SceneQuantity { name: "density", key: ("density_kg_m3", 1.0), scale: ParameterScale::Logarithmic, width: 1.3, of: Of::Robot,
        bounds: |s| within(s.material.density / DENSITY, s.material.density * DENSITY),
        get: |s, _| Some(s.material.density), set: |s, _, v| s.material.density = v },
    SceneQuantity { name: "gravity", key: ("gravity_deg", 1.0 / DEGREE), scale: ParameterScale::Linear, width: 45.0 * DEGREE,
        of: Of::Components(&["lean 1", "lean 2"]), bounds: |_| within(-LEAN, LEAN),
        get: |s, k| Some(lean(s.gravity, k)), set: |s, k, v| s.gravity = leaning(s.gravity, k, v) },
    SceneQuantity { name: "tracker_turn", key: ("tracker_turn_deg", 1.0 / DEGREE), scale: ParameterScale::Linear, width: 5.0 * DEGREE,
        of: Of::Components(&["x", "y", "z"]), bounds: |_| within(-30.0 * DEGREE, 30.0 * DEGREE),
        get: |s, k| Some(s.tracker.turn[k]), set: |s, k, v| s.tracker.turn[k] = v },
    SceneQuantity { name: "tracker_shift", key: ("tracker_shift_mm", 1e3), scale: ParameterScale::Linear, width: 2e-3,
        of: Of::Components(&["x", "y", "z"]), bounds: |_| within(-20e-3, 20e-3),
        get: |s, k| Some(s.tracker.shift[k]), set: |s, k, v| s.tracker.shift[k] = v },
    SceneQuantity { name: "zero", key: ("zero_mm", 1e3), scale: ParameterScale::Linear, width: 1e-3, of: Of::Tendons,
        bounds: |_| within(-3e-3, 3e-3),
        get: |s, k| Some(s.tendons[k].zero), set: |s, k, v| s.tendons[k].zero = v },
    SceneQuantity { name: "common_zero", key: ("common_zero_mm", 1e3), scale: ParameterScale::Linear, width: 1e-3, of: Of::Robot,
        bounds: |_| within(-3e-3, 3e-3),
        get: |s, _| Some(mean(s, |t| t.zero)), set: |s, _, v| s.tendons.iter_mut().for_each(|t| t.zero = v) },
    SceneQuantity { name: "compliance", key: ("compliance_mm_per_n", 1e3), scale: ParameterScale::Linear, width: 0.05e-3, of: Of::Robot,
        bounds: |s| within(MIN_COMPLIANCE.min(mean(s, |t| t.compliance)), 0.5e-3),
        get: |s, _| Some(mean(s, |t| t.compliance)), set: |s, _, v| s.tendons.iter_mut().for_each(|t| t.compliance = v) },
    SceneQuantity { name: "coefficient", key: ("coefficient", 1.0), scale: ParameterScale::Linear, width: 0.2, of: Of::Robot,
        bounds: |_| within(0.0, 0.6),
        get: |s, _| Some(in_body(s)?.coefficient), set: |s, _, v| change(s, |f| f.coefficient = v) },
    SceneQuantity { name: "coulomb", key: ("coulomb_n", 1.0), scale: ParameterScale::Linear, width: 1.0, of: Of::Robot,
        bounds: |_| within(0.0, 3.0),
        get: |s, _| Some(in_body(s)?.coulomb), set: |s, _, v| change(s, |f| f.coulomb = v) },
    SceneQuantity { name: "sheath_exponent", key: ("sheath_exponent", 1.0), scale: ParameterScale::Linear, width: 0.4, of: Of::Robot,
        bounds: |_| within(0.0, 1.5),
        get: |s, _| Some(in_sheath(s)?.sheath_exponent), set: |s, _, v| change(s, |f| f.sheath_exponent = v) },
    SceneQuantity { name: "sheath_coulomb", key: ("sheath_coulomb_n", 1.0), scale: ParameterScale::Linear, width: 1.0, of: Of::Robot,
        bounds: |_| within(0.0, 3.0),
        get: |s, _| Some(in_sheath(s)?.sheath_coulomb), set: |s, _, v| change(s, |f| f.sheath_coulomb = v) },
    SceneQuantity { name: "sheath_compliance_share", key: ("sheath_compliance_share", 1.0), scale: ParameterScale::Linear, width: 0.3, of: Of::Robot,
        bounds: |_| within(MIN_SHARE, 1.0),
        get: |s, _| Some(in_sheath(s)?.sheath_compliance_share), set: |s, _, v| change(s, |f| f.sheath_compliance_share = v) },
    SceneQuantity { name: "backlash", key: ("backlash_mm", 1e3), scale: ParameterScale::Linear, width: 0.3e-3, of: Of::Robot,
        bounds: |_| within(0.0, 1e-3),
        get: |s, _| Some(s.friction?.backlash), set: |s, _, v| change(s, |f| f.backlash = v) },
];

/// Names of groups of quantities.
const GROUPS: [(&str, [&str; 2]); 1] = [("tracker", ["tracker_turn", "tracker_shift"])];

/// A quantity that is to be fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FitParameter {
    /// Name, key, or name of a group.
    pub name: String,
    /// Bounds in the unit of the key, in place of its own.
    pub bounds: Option<Bounds>,
    /// Standard deviation of the prior around the scene's value, in the unit of the key (a factor on a
    /// logarithmic scale), in place of its own.
    pub width: Option<f64>,
}

impl FitParameter {
    /// With bounds and width of the program.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), bounds: None, width: None }
    }
}

/// One value of a quantity to fit.
#[derive(Clone)]
pub struct Selected {
    /// Which.
    pub quantity: &'static SceneQuantity,
    /// Which of its values, from 0.
    pub component: usize,
    /// With name, start, bounds and prior.
    pub parameter: Parameter,
}

impl Selected {
    /// The value that a scene has [SI].
    pub fn value_of(&self, scene: &Scene) -> Option<f64> {
        (self.quantity.get)(scene, self.component)
    }
}

/// The quantities called for, value by value.
///
/// # Errors
/// A name that is none, or twice; both kinds of zeros; friction of a scene that has none; bounds that do not hold the
/// value of the scene; a width that is no positive number, or on a logarithmic scale no factor above one.
pub fn select(scene: &Scene, requested: &[FitParameter]) -> Result<Vec<Selected>> {
    let mut selected: Vec<Selected> = Vec::new();
    for requested in requested {
        let group = GROUPS.iter().find(|(name, _)| *name == requested.name);
        let names = group.map_or_else(|| vec![requested.name.as_str()], |(_, names)| names.to_vec());
        for name in names {
            let more = values(scene, name, requested, &selected)?;
            selected.extend(more);
        }
    }
    if selected.is_empty() {
        return Err(BadInput::new("--fit", "at least one quantity", "none").into());
    }
    Ok(selected)
}

/// All values of the quantity called `name`, which is not among `before`.
fn values(scene: &Scene, name: &str, requested: &FitParameter, before: &[Selected]) -> Result<Vec<Selected>> {
    let is_named = |quantity: &&SceneQuantity| quantity.name == name || quantity.key.0 == name;
    let Some(quantity) = QUANTITIES.iter().find(is_named) else {
        let known = QUANTITIES.iter().map(|quantity| quantity.name).chain(GROUPS.iter().map(|group| group.0));
        return Err(BadInput::new("--fit", known.collect::<Vec<_>>().join(", "), format!("{name:?}")).into());
    };
    if let Some(other) = before.iter().find(|other| stem(other.quantity) == stem(quantity)) {
        let found = format!("{name:?} together with {:?}", other.quantity.name);
        return Err(BadInput::new("--fit", "each quantity once", found).into());
    }
    let si = |value: f64| value / quantity.key.1;
    let width = match (requested.width, quantity.scale) {
        (Some(width), ParameterScale::Linear) => si(width),
        (width, _) => width.unwrap_or(quantity.width),
    };
    let least = if quantity.scale == ParameterScale::Logarithmic { 1.0 } else { 0.0 };
    if !(width > least && width.is_finite()) {
        let expected = format!("a number above {least}");
        return Err(BadInput::new(format!("width of {name}"), expected, width.to_string()).into());
    }
    let bounds = match requested.bounds {
        Some(given) => Bounds { min: si(given.min), max: si(given.max) },
        None => (quantity.bounds)(scene),
    };
    let n = match quantity.of {
        Of::Robot => 1,
        Of::Tendons => scene.tendons.len(),
        Of::Components(names) => names.len(),
    };
    let value = |component: usize| {
        let start = (quantity.get)(scene, component).ok_or_else(|| {
            BadInput::new("--fit", "a quantity of the scene", format!("{name:?}"))
                .hint("add [friction] to it: points = 4 for friction in the body, sheath_compliance_share = 0.5 before it")
        })?;
        let name = match quantity.of {
            Of::Robot => quantity.name.to_owned(),
            Of::Tendons => format!("{} of {}", quantity.name, scene.tendons[component].name),
            Of::Components(names) => format!("{} {}", quantity.name, names[component]),
        };
        let prior = Some(Prior { center: start, width });
        let parameter = Parameter { name, start, bounds, scale: quantity.scale, prior };
        parameter.check()?;
        Ok(Selected { quantity, component, parameter })
    };
    (0..n).map(value).collect()
}

/// Name that two selected quantities must not share.
pub(super) fn stem(quantity: &SceneQuantity) -> &str {
    quantity.name.trim_start_matches("common_")
}

#[cfg(test)]
mod tests {
    use super::{along_axes, lean, leaning};
    use crate::scenes;

    #[test]
    fn gravity_leans_without_losing_its_size() {
        let size = |g: [f64; 3]| g.iter().map(|c| c * c).sum::<f64>().sqrt();
        for gravity in along_axes(&scenes::robot().0) {
            let once = leaning(gravity, 0, 0.3);
            let both = leaning(once, 1, -0.7);
            for (k, angle) in [0.3, -0.7].into_iter().enumerate() {
                assert!((lean(both, k) - angle).abs() < 1e-12, "{gravity:?}: {}", lean(both, k));
            }
            assert!((size(both) - size(gravity)).abs() < 1e-12);
            // The angle between both directions: its tangent is that of the two leans together.
            let along: f64 = (0..3).map(|c| both[c] * gravity[c]).sum::<f64>() / size(gravity).powi(2);
            let expected = 1.0 / (1.0 + 0.3f64.tan().powi(2) + 0.7f64.tan().powi(2)).sqrt();
            assert!((along - expected).abs() < 1e-12);
        }
        // Beyond 45° another axis is the nearest.
        let far = leaning([0.0, 0.0, -9.81], 0, super::LEAN);
        assert!(super::down(far).0 == 2 && super::down(super::beyond(far, 0)).0 == 0);
        assert!((size(super::beyond(far, 0)) - 9.81).abs() < 1e-12);
        // A scene without gravity hangs nowhere: down is -z until something else is found.
        assert_eq!(leaning([0.0; 3], 0, 0.0), [0.0, 0.0, -9.80665]);
    }
}
