//! A virtual robot exactly as typed: one field per key, units still in the names; and every bound.

use super::bounds::{Check, finite, not_negative, positive, require, vector};
use super::population_schema::{RangesFile, SpreadFile, population};
use super::robot::{BodyParameters, ServoParameters, TendonParameters, TrackerParameters, VirtualRobot};
use hysteron_actuator::{FrictionLaw, Prony, ServoSpec, Stribeck};
use hysteron_base::BadInput;
use hysteron_base::schema::FixedArray;
use serde::Deserialize;

const FORMAT: &str = "hysteron-virtual-rig";
const VERSION: i64 = 1;
/// More than the rod needs for any purpose here.
const MAX_SECTIONS: i64 = 64;
const MAX_TENDONS: usize = 16;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    format: String,
    version: i64,
    name: String,
    body: BodyTable,
    tendons: VirtualTendonsTable,
    servos: VirtualServosTable,
    tracker: VirtualTrackerTable,
    spread: Option<SpreadFile>,
    ranges: Option<RangesFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyTable {
    length_mm: f64,
    sections: i64,
    bending_stiffness_n_m2: FixedArray<f64, 2>,
    principal_axes_deg: f64,
    /// Every section as stiff as the body where absent.
    section_stiffness: Option<Vec<f64>>,
    torsional_stiffness_n_m2: f64,
    axial_stiffness_n: f64,
    natural_curvature_1_m: FixedArray<f64, 2>,
    creep_weights: Vec<f64>,
    creep_times_s: Vec<f64>,
    mass_kg: f64,
    gravity_m_s2: FixedArray<f64, 3>,
    tip_load_n: FixedArray<f64, 3>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct VirtualTendonsTable {
    radius_mm: f64,
    angles_deg: Vec<f64>,
    /// The position by radius and angle if absent.
    offsets_mm: Option<Vec<FixedArray<f64, 2>>>,
    axial_stiffness_n: f64,
    transmission_length_mm: f64,
    friction_coefficient: f64,
    friction_force_n: f64,
    /// Coulomb's where absent; the others give way over `presliding_mm`.
    friction_law: Option<LawName>,
    presliding_mm: Option<f64>,
    base_wrap_deg: f64,
    slack_mm: Vec<f64>,
    play_mm: f64,
    /// None where absent.
    zero_errors_mm: Option<Vec<f64>>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum LawName {
    Coulomb,
    Dahl,
    Prandtl,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct VirtualServosTable {
    pulley_radius_mm: f64,
    /// `pulley_radius_mm` if absent.
    true_radii_mm: Option<Vec<f64>>,
    directions: Vec<i64>,
    supply_v: f64,
    stall_torque_n_m: f64,
    no_load_speed_rad_s: f64,
    stall_current_a: f64,
    inertia_kg_m2: f64,
    coulomb_friction_n_m: f64,
    breakaway_friction_n_m: f64,
    stribeck_velocity_rad_s: f64,
    viscous_friction_n_m_s: f64,
    dead_band_ticks: f64,
    heat_capacity_j_k: f64,
    thermal_resistance_k_w: f64,
    ambient_temperature_degc: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct VirtualTrackerTable {
    rate_hz: f64,
    position_noise_mm: f64,
    orientation_noise_deg: f64,
    bias_mm: f64,
    bias_time_s: f64,
    latency_ms: f64,
    latency_jitter_ms: f64,
    dropout_probability: f64,
    robot_position_mm: FixedArray<f64, 3>,
    robot_rotation_deg: FixedArray<f64, 3>,
}

impl RobotFile {
    pub(super) fn checked(self) -> Check<VirtualRobot> {
        if self.format != FORMAT {
            return Err(BadInput::new("format", format!("\"{FORMAT}\""), format!("\"{}\"", self.format)));
        }
        if self.version != VERSION {
            return Err(BadInput::new("version", VERSION.to_string(), self.version.to_string()));
        }
        if self.name.trim().is_empty() {
            return Err(BadInput::new("name", "a name", format!("{:?}", self.name)));
        }
        let n = self.tendons.angles_deg.len();
        if !(1..=MAX_TENDONS).contains(&n) {
            let expected = format!("1 to {MAX_TENDONS} tendons");
            return Err(BadInput::new("tendons.angles_deg", expected, n.to_string()));
        }
        Ok(VirtualRobot {
            name: self.name,
            body: body(self.body)?,
            tendons: tendons(self.tendons)?,
            servos: servos(self.servos, n)?,
            tracker: tracker(&self.tracker)?,
            population: population(self.spread, self.ranges)?,
        })
    }
}

fn body(typed: BodyTable) -> Check<BodyParameters> {
    let n_sections = match usize::try_from(typed.sections) {
        Ok(n) if (1..=MAX_SECTIONS).contains(&typed.sections) => n,
        _ => {
            let expected = format!("a whole number from 1 to {MAX_SECTIONS}");
            return Err(BadInput::new("body.sections", expected, typed.sections.to_string()));
        }
    };
    let bending = typed.bending_stiffness_n_m2;
    Ok(BodyParameters {
        length: positive("body.length_mm", typed.length_mm)?,
        n_sections,
        bending_stiffness: [
            positive("body.bending_stiffness_n_m2[0]", bending[0])?,
            positive("body.bending_stiffness_n_m2[1]", bending[1])?,
        ],
        section_factors: section_factors(typed.section_stiffness, n_sections)?,
        axes_angle: finite("body.principal_axes_deg", typed.principal_axes_deg)?,
        torsional_stiffness: positive("body.torsional_stiffness_n_m2", typed.torsional_stiffness_n_m2)?,
        axial_stiffness: positive("body.axial_stiffness_n", typed.axial_stiffness_n)?,
        natural_curvature: vector("body.natural_curvature_1_m", typed.natural_curvature_1_m)?,
        prony: Prony::new(typed.creep_weights, typed.creep_times_s).map_err(|bad| {
            let place = bad.place.replace("prony.weights", "creep_weights");
            let place = place.replace("prony.times", "creep_times_s").replace("prony", "creep_weights");
            BadInput { place: format!("body.{place}"), ..bad }
        })?,
        mass: not_negative("body.mass_kg", typed.mass_kg)?,
        gravity: vector("body.gravity_m_s2", typed.gravity_m_s2)?,
        tip_load: vector("body.tip_load_n", typed.tip_load_n)?,
    })
}

fn tendons(typed: VirtualTendonsTable) -> Check<TendonParameters> {
    let n = typed.angles_deg.len();
    same_count("tendons.slack_mm", n, typed.slack_mm.len())?;
    let each = |key: &str, values: Vec<f64>| -> Check<Vec<f64>> {
        values.into_iter().enumerate().map(|(k, x)| finite(&format!("{key}[{k}]"), x)).collect()
    };
    let offsets = typed.offsets_mm.unwrap_or_else(|| vec![FixedArray([0.0; 2]); n]);
    same_count("tendons.offsets_mm", n, offsets.len())?;
    let offset = |(k, offset)| vector(&format!("tendons.offsets_mm[{k}]"), offset);
    let zero_errors = typed.zero_errors_mm.unwrap_or_else(|| vec![0.0; n]);
    same_count("tendons.zero_errors_mm", n, zero_errors.len())?;
    Ok(TendonParameters {
        radius: positive("tendons.radius_mm", typed.radius_mm)?,
        angles: each("tendons.angles_deg", typed.angles_deg)?,
        offsets: offsets.into_iter().enumerate().map(offset).collect::<Check<_>>()?,
        axial_stiffness: positive("tendons.axial_stiffness_n", typed.axial_stiffness_n)?,
        transmission_length: positive("tendons.transmission_length_mm", typed.transmission_length_mm)?,
        friction: not_negative("tendons.friction_coefficient", typed.friction_coefficient)?,
        friction_force: positive("tendons.friction_force_n", typed.friction_force_n)
            .map_err(|bad| bad.hint("use a few millinewtons for a smooth guide"))?,
        law: law(typed.friction_law, typed.presliding_mm)?,
        base_wrap: not_negative("tendons.base_wrap_deg", typed.base_wrap_deg)?,
        slack: each("tendons.slack_mm", typed.slack_mm)?,
        play: not_negative("tendons.play_mm", typed.play_mm)?,
        zero_errors: each("tendons.zero_errors_mm", zero_errors)?,
    })
}

fn section_factors(typed: Option<Vec<f64>>, n_sections: usize) -> Check<Vec<f64>> {
    const KEY: &str = "body.section_stiffness";
    let factors = typed.unwrap_or_else(|| vec![1.0; n_sections]);
    if factors.len() != n_sections {
        let expected = format!("{n_sections} factors, one per section, base first");
        return Err(BadInput::new(KEY, expected, factors.len().to_string()));
    }
    factors.into_iter().enumerate().map(|(s, x)| positive(&format!("{KEY}[{s}]"), x)).collect()
}

/// Coulomb's law has no slip over which it gives way, the others have one.
fn law(name: Option<LawName>, presliding_mm: Option<f64>) -> Check<FrictionLaw> {
    const KEY: &str = "tendons.presliding_mm";
    let of_length: fn(f64) -> FrictionLaw = match name.unwrap_or(LawName::Coulomb) {
        LawName::Coulomb => {
            return match presliding_mm {
                None => Ok(FrictionLaw::Coulomb),
                Some(found) => Err(BadInput::new(
                    KEY,
                    "friction_law = \"dahl\" or \"prandtl\" with it",
                    found.to_string(),
                )),
            };
        }
        LawName::Dahl => FrictionLaw::Dahl,
        LawName::Prandtl => FrictionLaw::Prandtl,
    };
    let length = presliding_mm.ok_or_else(|| BadInput::new(KEY, "this key with the law", "nothing"))?;
    positive(KEY, length).map(of_length)
}

fn servos(typed: VirtualServosTable, n_tendons: usize) -> Check<ServoParameters> {
    same_count("servos.directions", n_tendons, typed.directions.len())?;
    let mut directions = Vec::with_capacity(n_tendons);
    for (k, direction) in typed.directions.into_iter().enumerate() {
        directions.push(match direction {
            1 => 1.0,
            -1 => -1.0,
            other => {
                let place = format!("servos.directions[{k}]");
                return Err(BadInput::new(place, "1 or -1", other.to_string()));
            }
        });
    }
    let friction = Stribeck::new(
        not_negative("servos.coulomb_friction_n_m", typed.coulomb_friction_n_m)?,
        not_negative("servos.breakaway_friction_n_m", typed.breakaway_friction_n_m)?,
        positive("servos.stribeck_velocity_rad_s", typed.stribeck_velocity_rad_s)?,
        not_negative("servos.viscous_friction_n_m_s", typed.viscous_friction_n_m_s)?,
    )
    .map_err(|bad| BadInput { place: "servos.breakaway_friction_n_m".to_owned(), ..bad })?;
    let spec = ServoSpec {
        stall_torque: positive("servos.stall_torque_n_m", typed.stall_torque_n_m)?,
        no_load_speed: positive("servos.no_load_speed_rad_s", typed.no_load_speed_rad_s)?,
        stall_current: positive("servos.stall_current_a", typed.stall_current_a)?,
        inertia: positive("servos.inertia_kg_m2", typed.inertia_kg_m2)?,
        friction,
        dead_band: not_negative("servos.dead_band_ticks", typed.dead_band_ticks)?,
        heat_capacity: positive("servos.heat_capacity_j_k", typed.heat_capacity_j_k)?,
        thermal_resistance: positive("servos.thermal_resistance_k_w", typed.thermal_resistance_k_w)?,
        ambient_temperature: finite("servos.ambient_temperature_degc", typed.ambient_temperature_degc)?,
    };
    let true_radii = typed.true_radii_mm.unwrap_or_else(|| vec![typed.pulley_radius_mm; n_tendons]);
    same_count("servos.true_radii_mm", n_tendons, true_radii.len())?;
    let true_radius = |(k, x)| positive(&format!("servos.true_radii_mm[{k}]"), x);
    Ok(ServoParameters {
        spec: spec.checked().map_err(|bad| bad.within("servos"))?,
        pulley_radius: positive("servos.pulley_radius_mm", typed.pulley_radius_mm)?,
        true_radii: true_radii.into_iter().enumerate().map(true_radius).collect::<Check<_>>()?,
        directions,
        supply: positive("servos.supply_v", typed.supply_v)?,
    })
}

fn tracker(typed: &VirtualTrackerTable) -> Check<TrackerParameters> {
    let dropout = typed.dropout_probability;
    Ok(TrackerParameters {
        rate: require("tracker.rate_hz", "0 < x <= 1000", typed.rate_hz, {
            0.0 < typed.rate_hz && typed.rate_hz <= 1000.0
        })?,
        position_noise: not_negative("tracker.position_noise_mm", typed.position_noise_mm)?,
        orientation_noise: not_negative("tracker.orientation_noise_deg", typed.orientation_noise_deg)?,
        bias: not_negative("tracker.bias_mm", typed.bias_mm)?,
        bias_time: positive("tracker.bias_time_s", typed.bias_time_s)?,
        latency: not_negative("tracker.latency_ms", typed.latency_ms)?,
        latency_jitter: not_negative("tracker.latency_jitter_ms", typed.latency_jitter_ms)?,
        dropout: require("tracker.dropout_probability", "0 <= x < 1", dropout, {
            (0.0..1.0).contains(&dropout)
        })?,
        robot_position: vector("tracker.robot_position_mm", typed.robot_position_mm)?,
        robot_rotation: vector("tracker.robot_rotation_deg", typed.robot_rotation_deg)?,
    })
}

fn same_count(key: &str, n_tendons: usize, n: usize) -> Check<()> {
    if n == n_tendons {
        return Ok(());
    }
    let expected = format!("{n_tendons} values, one per tendon in tendons.angles_deg");
    Err(BadInput::new(key, expected, n.to_string()))
}
