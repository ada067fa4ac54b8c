//! Parameters of the tentacle that can be fitted, and its twin for given values.

use anyhow::Result;
use hysteron_base::{Bounds, Material, MaterialLaw, Tendon};
use hysteron_fem::{Layers, Mesh, Order, Tube};
use hysteron_twin::fit::{Parameter, ParameterScale};
use hysteron_twin::{Stepper, Target, Twin, TwinState};
use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;

use super::holds::{Hold, Markers, N_MARKERS, in_mocap};
use crate::tendon::scenes::{Setting, tendon, twin};

/// Largest tension step of a fit [N].
const TENSION_STEP: f64 = 0.5;
/// Segments of a whole tendon.
const SEGMENTS: usize = 30;
const LINK: f64 = 0.305;
/// Radius of the circle that carries a tendon point [m]: a point alone would sink into one element.
const RING: f64 = 1.5e-3;

/// Parameters that the shape of the body depends on.
pub type Key = ([f64; 3], [f64; 2]);

/// The tentacle as it hangs in the room.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Young's modulus [Pa], Poisson's ratio [-], density [kg/m³].
    pub material: [f64; 3],
    /// Turn of the robot against the mocap frame, a rotation vector in the mesh's axes [rad].
    pub turn: [f64; 3],
    /// Shift of the base [m], mesh axes.
    pub shift: [f64; 3],
    /// Gravity across the nominal axis [m/s²], mesh x and y.
    pub across: [f64; 2],
    /// Turn of the markers' arms about the axis [rad].
    pub twist: f64,
}

/// Name, start, bounds, scale, and how it is set.
type Line = (&'static str, f64, [f64; 2], ParameterScale, fn(&mut Setup, f64));

const THREE: [Line; 3] = [
    ("Young's modulus [Pa]", 505e3, [50e3, 5e6], ParameterScale::Logarithmic, |s, v| s.material[0] = v),
    ("Poisson's ratio [-]", 0.45, [0.2, 0.49], ParameterScale::Linear, |s, v| s.material[1] = v),
    ("density [kg/m³]", 1500.0, [500.0, 4500.0], ParameterScale::Logarithmic, |s, v| s.material[2] = v),
];
const FRAME: [Line; 9] = [
    ("turn about x [rad]", 0.0, [-0.6, 0.6], ParameterScale::Linear, |s, v| s.turn[0] = v),
    ("turn about y [rad]", 0.0, [-0.6, 0.6], ParameterScale::Linear, |s, v| s.turn[1] = v),
    ("turn about z [rad]", 0.0, [-0.6, 0.6], ParameterScale::Linear, |s, v| s.turn[2] = v),
    ("shift along x [m]", 0.0, [-0.04, 0.04], ParameterScale::Linear, |s, v| s.shift[0] = v),
    ("shift along y [m]", 0.0, [-0.04, 0.04], ParameterScale::Linear, |s, v| s.shift[1] = v),
    ("shift along z [m]", 0.0, [-0.04, 0.04], ParameterScale::Linear, |s, v| s.shift[2] = v),
    ("gravity along x [m/s²]", 0.0, [-6.0, 6.0], ParameterScale::Linear, |s, v| s.across[0] = v),
    ("gravity along y [m/s²]", 0.0, [-6.0, 6.0], ParameterScale::Linear, |s, v| s.across[1] = v),
    ("turn of the arms [rad]", 0.0, [-0.8, 0.8], ParameterScale::Linear, |s, v| s.twist = v),
];

/// Parameters that are fitted together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// Modulus, Poisson's ratio, density.
    Three,
    /// And how robot, gravity and arms lie in the mocap frame.
    Frame,
}

impl Set {
    /// All of them, in the order of a table.
    pub const ALL: [Self; 2] = [Self::Three, Self::Frame];

    /// For a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Three => "E, nu, rho",
            Self::Frame => "+ frame, gravity's direction, arms",
        }
    }

    fn lines(self) -> Vec<Line> {
        match self {
            Self::Three => THREE.to_vec(),
            Self::Frame => [&THREE[..], &FRAME].concat(),
        }
    }

    /// Parameters of the fit.
    pub fn parameters(self) -> Vec<Parameter> {
        let parameter = |(name, start, [min, max], scale, _): Line| Parameter {
            name: name.into(),
            start,
            bounds: Bounds { min, max },
            scale,
            prior: None,
        };
        self.lines().into_iter().map(parameter).collect()
    }

    /// The tentacle with these values.
    pub fn setup(self, values: &[f64]) -> Setup {
        let mut setup = Setup::NOMINAL;
        self.lines().iter().zip(values).for_each(|((.., set), value)| set(&mut setup, *value));
        setup
    }
}

impl Setup {
    /// Upstream's numbers.
    pub const NOMINAL: Self = Self {
        material: [505e3, 0.45, 1500.0],
        turn: [0.0; 3],
        shift: [0.0; 3],
        across: [0.0; 2],
        twist: 0.0,
    };

    /// Parameters that the shape of the body depends on; the rest only moves the markers.
    pub fn key(&self) -> Key {
        (self.material, self.across)
    }

    /// The twin, with further tendons behind the real ones.
    pub fn twin(&self, mesh: &Mesh, further: &[Tendon]) -> Result<Twin> {
        let [youngs_modulus, poisson_ratio, density] = self.material;
        let material = Material { law: MaterialLaw::Corotational, youngs_modulus, poisson_ratio, density };
        let mut tendons: Vec<Tendon> = [30.0f64, 150.0]
            .map(|degrees| {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let points = (0..=SEGMENTS).map(|k| {
                    let s = LINK * k as f64 / SEGMENTS as f64;
                    let r = 0.0114 - 0.0295 * s;
                    [r * cos, r * sin, s]
                });
                tendon(format!("tendon {degrees}"), points.collect(), Bounds { min: 0.0, max: 100.0 })
            })
            .to_vec();
        tendons.extend_from_slice(further);
        let [x, y] = self.across;
        let along = (9.81f64.powi(2) - x * x - y * y).max(0.0).sqrt();
        twin(Setting { ring: RING, ..Setting::TARGETS }, material, mesh, tendons, [x, y, along])
    }

    /// Markers in the mocap frame.
    pub fn markers(
        &self,
        markers: &Markers,
        state: &TwinState,
        base: Vector3<f64>,
    ) -> [Vector3<f64>; N_MARKERS] {
        let turn = Rotation3::from_scaled_axis(Vector3::from(self.turn));
        let points = markers.in_body(state, self.twist);
        points.map(|point| in_mocap(turn * point + Vector3::from(self.shift), base))
    }

    /// States of the twin in all `holds`, each tendon's in ascending tension. `further` gives the targets of the
    /// tendons behind the real ones under given tensions. Holds are static: shapes `near`, one for each, save the way.
    pub fn states(
        &self,
        twin: &Twin,
        holds: &[Hold],
        near: Option<&[TwinState]>,
        further: &(dyn Fn([f64; 2]) -> Vec<Target> + Sync),
    ) -> hysteron_twin::Result<Vec<TwinState>> {
        if let Some(near) = near
            && let Ok(states) = self.states_near(twin, holds, near, further)
        {
            return Ok(states);
        }
        let of = |tendon: usize| -> hysteron_twin::Result<Vec<(usize, TwinState)>> {
            let mut order: Vec<usize> =
                (0..holds.len()).filter(|&k| holds[k].tensions[tendon] > 0.0).collect();
            order.sort_by(|&a, &b| holds[a].tensions[tendon].total_cmp(&holds[b].tensions[tendon]));
            let mut stepper = Stepper::new(twin);
            let go = |tension: f64, stepper: &mut Stepper| {
                let mut tensions = [0.0; 2];
                tensions[tendon] = tension;
                let targets = [tensions.map(Target::Tension).to_vec(), further(tensions)].concat();
                stepper.step(twin, &targets)
            };
            go(0.0, &mut stepper)?;
            let (mut from, mut states) = (0.0, Vec::new());
            for k in order {
                let rise = holds[k].tensions[tendon] - from;
                let n = (rise / TENSION_STEP).ceil().max(1.0) as usize;
                for i in 1..=n {
                    go(from + rise * i as f64 / n as f64, &mut stepper)?;
                }
                from = holds[k].tensions[tendon];
                states.push((k, stepper.state().clone()));
            }
            Ok(states)
        };
        let both: Vec<_> = (0..2).into_par_iter().map(of).collect::<hysteron_twin::Result<_>>()?;
        let mut states = both.concat();
        states.sort_by_key(|(k, _)| *k);
        Ok(states.into_iter().map(|(_, state)| state).collect())
    }

    fn states_near(
        &self,
        twin: &Twin,
        holds: &[Hold],
        near: &[TwinState],
        further: &(dyn Fn([f64; 2]) -> Vec<Target> + Sync),
    ) -> hysteron_twin::Result<Vec<TwinState>> {
        let mut stepper = Stepper::new(twin);
        let mut step = |(hold, near): (&Hold, &TwinState)| {
            stepper.restore(twin, near)?;
            let targets = [hold.tensions.map(Target::Tension).to_vec(), further(hold.tensions)].concat();
            stepper.step(twin, &targets).map(|_| stepper.state().clone())
        };
        holds.iter().zip(near).map(&mut step).collect()
    }
}

/// The body of `meshes/tentacle` with fewer elements: eight sides, with the bending stiffness of the circles. Linear
/// tetrahedra are too stiff in bending; a fitted modulus takes that up.
pub fn coarse_body() -> Result<Mesh> {
    let turn = std::f64::consts::FRAC_PI_4;
    let wider = (3.0 * turn / (turn.sin() * (2.0 + turn.cos()))).powf(0.25);
    let tube = Tube {
        profile: [[0.0, 15.41e-3], [0.305, 6.42e-3], [0.360, 4.80e-3]].map(|[z, r]| [z, wider * r]).to_vec(),
        bore_radius: 0.0,
        channels: Vec::new(),
        outer_divisions: 8,
        bore_divisions: 0,
        channel_divisions: 0,
        layers: Layers::Count(45),
        order: Order::Linear,
    };
    Ok(tube.mesh()?)
}
