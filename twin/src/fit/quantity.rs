//! What can be fitted of a scene: one line for each.

use hysteron_base::{BadInput, Bounds, Scene};

use super::least_squares::{Parameter, Scale};
use crate::Result;

/// A scene with what a fit moves beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The scene.
    pub scene: Scene,
    /// How far each primary tendon has already been pulled when a recording says stroke zero [m].
    pub zeros: Vec<f64>,
}

impl Candidate {
    /// The scene as it is.
    pub fn new(scene: &Scene) -> Self {
        Self { scene: scene.clone(), zeros: vec![0.0; scene.tendons.len()] }
    }
}

/// A physical quantity of a scene.
pub struct Quantity {
    /// Name on the command line.
    pub name: &'static str,
    /// Its unit, with the factor from SI.
    pub unit: (&'static str, f64),
    /// How it is spread between its bounds.
    pub scale: Scale,
    /// Bounds unless others are given [SI].
    pub bounds: fn(&Scene) -> Bounds,
    /// One per tendon, or one for the whole robot.
    pub per_tendon: bool,
    /// Value, of tendon k where there is one per tendon [SI].
    pub get: fn(&Candidate, usize) -> f64,
    /// Changes the value.
    pub set: fn(&mut Candidate, usize, f64),
}

/// The modulus may be wrong by this factor: printed and cast materials rarely are by more.
const MODULUS: f64 = 30.0;
/// So may the density, for hoses and cables that a body carries.
const DENSITY: f64 = 3.0;

const fn within(min: f64, max: f64) -> Bounds {
    Bounds { min, max }
}

/// All of them.
#[rustfmt::skip] // a table
pub const QUANTITIES: [Quantity; 5] = [
    Quantity { name: "youngs_modulus", unit: ("MPa", 1e-6), scale: Scale::Logarithmic, per_tendon: false,
        bounds: |s| within(s.material.youngs_modulus / MODULUS, s.material.youngs_modulus * MODULUS),
        get: |c, _| c.scene.material.youngs_modulus, set: |c, _, v| c.scene.material.youngs_modulus = v },
    Quantity { name: "poisson_ratio", unit: ("", 1.0), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(0.0, 0.49),
        get: |c, _| c.scene.material.poisson_ratio, set: |c, _, v| c.scene.material.poisson_ratio = v },
    Quantity { name: "density", unit: ("kg/m³", 1.0), scale: Scale::Logarithmic, per_tendon: false,
        bounds: |s| within(s.material.density / DENSITY, s.material.density * DENSITY),
        get: |c, _| c.scene.material.density, set: |c, _, v| c.scene.material.density = v },
    Quantity { name: "zero", unit: ("mm", 1e3), scale: Scale::Linear, per_tendon: true,
        bounds: |_| within(-3e-3, 3e-3),
        get: |c, k| c.zeros[k], set: |c, k, v| c.zeros[k] = v },
    Quantity { name: "common_zero", unit: ("mm", 1e3), scale: Scale::Linear, per_tendon: false,
        bounds: |_| within(-3e-3, 3e-3),
        get: |c, _| c.zeros.iter().sum::<f64>() / c.zeros.len() as f64, set: |c, _, v| c.zeros.fill(v) },
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

/// The quantities called `names`, with the bounds given here (in the quantity's unit) or their own.
///
/// # Errors
/// A name that is none, or twice; both kinds of zeros; bounds that do not hold the value of the scene.
pub fn select(scene: &Scene, names: &[(String, Option<Bounds>)]) -> Result<Vec<Selected>> {
    let start = Candidate::new(scene);
    let mut selected: Vec<Selected> = Vec::new();
    for (name, bounds) in names {
        let Some(quantity) = QUANTITIES.iter().find(|quantity| quantity.name == name) else {
            let known: Vec<&str> = QUANTITIES.iter().map(|quantity| quantity.name).collect();
            return Err(BadInput::new("--fit", known.join(", "), format!("{name:?}")).into());
        };
        let clashes = |other: &Selected| {
            other.quantity.name.trim_start_matches("common_") == name.trim_start_matches("common_")
        };
        if let Some(other) = selected.iter().find(|other| clashes(other)) {
            let found = format!("{name:?} beside {:?}", other.quantity.name);
            return Err(BadInput::new("--fit", "each quantity once", found).into());
        }
        let n = if quantity.per_tendon { scene.tendons.len() } else { 1 };
        for tendon in 0..n {
            let si = |value: f64| value / quantity.unit.1;
            let bounds = match bounds {
                Some(given) => Bounds { min: si(given.min), max: si(given.max) },
                None => (quantity.bounds)(scene),
            };
            let name = match quantity.per_tendon {
                true => format!("{name} of {}", scene.tendons[tendon].name),
                false => name.clone(),
            };
            let parameter =
                Parameter { name, start: (quantity.get)(&start, tendon), bounds, scale: quantity.scale };
            parameter.check()?;
            selected.push(Selected { quantity, tendon, parameter });
        }
    }
    if selected.is_empty() {
        return Err(BadInput::new("--fit", "at least one quantity", "none").into());
    }
    Ok(selected)
}
