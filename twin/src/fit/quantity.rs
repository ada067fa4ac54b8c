//! What can be fitted of a scene: one line for each.

use hysteron_base::{BadInput, Bounds, Friction, Scene, Tendon};

use super::least_squares::{Parameter, Scale};
use crate::Result;

/// A physical quantity of a scene.
pub struct Quantity {
    /// Name on the command line.
    pub name: &'static str,
    /// The same with the unit in which a person types and reads it, and the factor from SI to that unit.
    pub key: (&'static str, f64),
    /// How it is spread between its bounds.
    pub scale: Scale,
    /// Bounds unless others are given [SI].
    pub bounds: fn(&Scene) -> Bounds,
    /// One per tendon, or one for the whole robot.
    pub per_tendon: bool,
    /// Value, of tendon k where there is one per tendon [SI]; none where the scene lacks what it belongs to.
    pub get: fn(&Scene, usize) -> Option<f64>,
    /// Changes the value where there is one.
    pub set: fn(&mut Scene, usize, f64),
}

/// The modulus may be wrong by this factor: printed and cast materials rarely are by more.
const MODULUS: f64 = 30.0;
/// So may the density, for hoses and cables that a body carries.
const DENSITY: f64 = 3.0;

const fn within(min: f64, max: f64) -> Bounds {
    Bounds { min, max }
}

/// The mean over the tendons.
fn mean(scene: &Scene, of: fn(&Tendon) -> f64) -> f64 {
    scene.tendons.iter().map(of).sum::<f64>() / scene.tendons.len().max(1) as f64
}

/// Friction in the body, which takes places where tendons rub.
fn in_body(scene: &Scene) -> Option<Friction> {
    scene.friction.filter(|friction| friction.points > 0)
}

/// Friction with that of a sheath, which takes a tendon that stretches before it.
fn in_sheath(scene: &Scene) -> Option<Friction> {
    scene.friction.filter(|friction| friction.sheath_compliance_share > 0.0)
}

fn change(scene: &mut Scene, to: impl FnOnce(&mut Friction)) {
    scene.friction.as_mut().map(to);
}

/// Without compliance [m/N], or a share of it [-], before it there is no friction of a sheath: neither goes below this
/// unless the scene has less.
const LEAST_COMPLIANCE: f64 = 1e-9;
const LEAST_SHARE: f64 = 0.02;

/// All of them.
#[rustfmt::skip] // a table
pub const QUANTITIES: [Quantity; 12] = [
    Quantity { name: "youngs_modulus", key: ("youngs_modulus_mpa", 1e-6), scale: Scale::Logarithmic, per_tendon: false,
        bounds: |s| within(s.material.youngs_modulus / MODULUS, s.material.youngs_modulus * MODULUS),
        get: |s, _| Some(s.material.youngs_modulus), set: |s, _, v| s.material.youngs_modulus = v },
    Quantity { name: "poisson_ratio", key: ("poisson_ratio", 1.0), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(0.0, 0.49),
        get: |s, _| Some(s.material.poisson_ratio), set: |s, _, v| s.material.poisson_ratio = v },
    Quantity { name: "density", key: ("density_kg_m3", 1.0), scale: Scale::Logarithmic, per_tendon: false,
        bounds: |s| within(s.material.density / DENSITY, s.material.density * DENSITY),
        get: |s, _| Some(s.material.density), set: |s, _, v| s.material.density = v },
    Quantity { name: "zero", key: ("zero_mm", 1e3), scale: Scale::Linear, per_tendon: true,
        bounds: |_| within(-3e-3, 3e-3),
        get: |s, k| Some(s.tendons[k].zero), set: |s, k, v| s.tendons[k].zero = v },
    Quantity { name: "common_zero", key: ("common_zero_mm", 1e3), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(-3e-3, 3e-3),
        get: |s, _| Some(mean(s, |t| t.zero)), set: |s, _, v| s.tendons.iter_mut().for_each(|t| t.zero = v) },
    Quantity { name: "compliance", key: ("compliance_mm_per_n", 1e3), scale: Scale::Linear, per_tendon: false,
        bounds: |s| within(LEAST_COMPLIANCE.min(mean(s, |t| t.compliance)), 0.5e-3),
        get: |s, _| Some(mean(s, |t| t.compliance)), set: |s, _, v| s.tendons.iter_mut().for_each(|t| t.compliance = v) },
    Quantity { name: "coefficient", key: ("coefficient", 1.0), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(0.0, 0.6),
        get: |s, _| Some(in_body(s)?.coefficient), set: |s, _, v| change(s, |f| f.coefficient = v) },
    Quantity { name: "coulomb", key: ("coulomb_n", 1.0), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(0.0, 3.0),
        get: |s, _| Some(in_body(s)?.coulomb), set: |s, _, v| change(s, |f| f.coulomb = v) },
    Quantity { name: "sheath_exponent", key: ("sheath_exponent", 1.0), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(0.0, 1.5),
        get: |s, _| Some(in_sheath(s)?.sheath_exponent), set: |s, _, v| change(s, |f| f.sheath_exponent = v) },
    Quantity { name: "sheath_coulomb", key: ("sheath_coulomb_n", 1.0), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(0.0, 3.0),
        get: |s, _| Some(in_sheath(s)?.sheath_coulomb), set: |s, _, v| change(s, |f| f.sheath_coulomb = v) },
    Quantity { name: "sheath_compliance_share", key: ("sheath_compliance_share", 1.0), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(LEAST_SHARE, 1.0),
        get: |s, _| Some(in_sheath(s)?.sheath_compliance_share), set: |s, _, v| change(s, |f| f.sheath_compliance_share = v) },
    Quantity { name: "backlash", key: ("backlash_mm", 1e3), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(0.0, 1e-3),
        get: |s, _| Some(s.friction?.backlash), set: |s, _, v| change(s, |f| f.backlash = v) },
];

/// A quantity to fit, of tendon `tendon` where there is one per tendon.
#[derive(Clone)]
pub struct Selected {
    /// Which.
    pub quantity: &'static Quantity,
    /// Of which tendon, from 0.
    pub tendon: usize,
    /// With name, start and bounds.
    pub parameter: Parameter,
}

/// The quantities called `names`, by name or key, with the bounds given here (in the unit of the key) or their own.
///
/// # Errors
/// A name that is none, or twice; both kinds of zeros; friction of a scene that has none; bounds that do not hold the
/// value of the scene.
pub fn select(scene: &Scene, names: &[(String, Option<Bounds>)]) -> Result<Vec<Selected>> {
    let mut selected: Vec<Selected> = Vec::new();
    for (name, bounds) in names {
        let Some(quantity) =
            QUANTITIES.iter().find(|quantity| quantity.name == name || quantity.key.0 == name)
        else {
            let known: Vec<&str> = QUANTITIES.iter().map(|quantity| quantity.name).collect();
            return Err(BadInput::new("--fit", known.join(", "), format!("{name:?}")).into());
        };
        let stem = |quantity: &Quantity| quantity.name.trim_start_matches("common_");
        let clashes = |other: &&Selected| stem(other.quantity) == stem(quantity);
        if let Some(other) = selected.iter().find(clashes) {
            let found = format!("{name:?} beside {:?}", other.quantity.name);
            return Err(BadInput::new("--fit", "each quantity once", found).into());
        }
        let n = if quantity.per_tendon { scene.tendons.len() } else { 1 };
        for tendon in 0..n {
            let si = |value: f64| value / quantity.key.1;
            let bounds = match bounds {
                Some(given) => Bounds { min: si(given.min), max: si(given.max) },
                None => (quantity.bounds)(scene),
            };
            let name = match quantity.per_tendon {
                true => format!("{} of {}", quantity.name, scene.tendons[tendon].name),
                false => quantity.name.to_owned(),
            };
            let start = (quantity.get)(scene, tendon).ok_or_else(|| {
                BadInput::new("--fit", "what the scene has", format!("{name:?}"))
                    .hint("add [friction] to it: points = 4 for friction in the body, sheath_compliance_share = 0.5 before it")
            })?;
            let parameter = Parameter { name, start, bounds, scale: quantity.scale };
            parameter.check()?;
            selected.push(Selected { quantity, tendon, parameter });
        }
    }
    if selected.is_empty() {
        return Err(BadInput::new("--fit", "at least one quantity", "none").into());
    }
    Ok(selected)
}
