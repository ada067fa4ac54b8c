//! A virtual arm exactly as typed: one field per key, units still in the names; and every bound.

use hysteron_base::BadInput;
use hysteron_base::schema::{FixedArray, between, check_header, text, vector_within, within};
use nalgebra::{Matrix3, Unit, Vector3};
use serde::Deserialize;

use super::chain::{ArmBody, ArmLink, BodyChain, N_JOINTS};
use super::gripper::VirtualGripper;
use super::robot::{ArmVariation, Supply, TelemetryNoise, VirtualArm, VirtualForceSensor};
use super::servo::{GearFriction, VirtualServo, WindingHeat};

type Check<T> = std::result::Result<T, BadInput>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ArmFile {
    format: String,
    version: i64,
    name: String,
    step_ms: f64,
    gravity_m_s2: FixedArray<f64, 3>,
    tip_mm: FixedArray<f64, 3>,
    links: Vec<LinkTable>,
    servo: ServoTable,
    gripper: GripperTable,
    supply: SupplyTable,
    telemetry: TelemetryTable,
    force_sensor: SensorTable,
    spread: SpreadTable,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LinkTable {
    origin_mm: FixedArray<f64, 3>,
    axis: FixedArray<f64, 3>,
    range_deg: FixedArray<f64, 2>,
    mass_kg: f64,
    centre_mm: FixedArray<f64, 3>,
    /// About the centre: xx, yy, zz, xy, xz, yz.
    inertia_kg_m2: FixedArray<f64, 6>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ServoTable {
    torque_constant_n_m_per_a: f64,
    resistance_ohm: f64,
    current_limit_a: f64,
    armature_kg_m2: f64,
    stiffness_n_m_per_rad: f64,
    damping_n_m_s_per_rad: f64,
    backlash_deg: f64,
    bearing_friction_n_m: f64,
    p_gain_count: i64,
    d_gain_count: i64,
    friction: FrictionTable,
    heat: HeatTable,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrictionTable {
    friction_base_n_m: f64,
    friction_stribeck_n_m: f64,
    friction_viscous_n_m_s_per_rad: f64,
    load_friction_motor: f64,
    load_friction_external: f64,
    load_friction_motor_stribeck: f64,
    load_friction_external_stribeck: f64,
    load_friction_motor_quad_per_n_m: f64,
    load_friction_external_quad_per_n_m: f64,
    stribeck_speed_rad_s: f64,
    alpha: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HeatTable {
    winding_j_per_k: f64,
    to_case_k_per_w: f64,
    case_j_per_k: f64,
    to_air_k_per_w: f64,
    resistance_slope_per_k: f64,
    magnet_slope_per_k: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GripperTable {
    lever_mm: f64,
    closed_deg: f64,
    stiffness_n_per_m: f64,
    friction_coefficient: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SupplyTable {
    voltage_v: f64,
    resistance_ohm: f64,
    air_degc: f64,
    warm_start_k: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TelemetryTable {
    period_ms: f64,
    jitter_ms: f64,
    late_probability: f64,
    late_by_ms: f64,
    speed_filter_ms: f64,
    current_step_ma: f64,
    current_noise_ma: f64,
    speed_step_rad_s: f64,
    voltage_step_mv: f64,
    voltage_noise_mv: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorTable {
    noise_n: f64,
    offset_n: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpreadTable {
    mass_relative: f64,
    centre_mm: f64,
    inertia_relative: f64,
    motor_relative: f64,
    friction_relative: f64,
    backlash_relative: f64,
}

impl ArmFile {
    pub(super) fn checked(self, hash: String) -> Check<VirtualArm> {
        check_header((&self.format, self.version), ("hysteron-virtual-arm", 1))?;
        let n = self.links.len();
        let links: [LinkTable; N_JOINTS] = self.links.try_into().map_err(|_| {
            BadInput::new("links", format!("{N_JOINTS} tables [[links]], base first"), n.to_string())
        })?;
        let mut checked = Vec::with_capacity(N_JOINTS);
        for (k, typed) in links.iter().enumerate() {
            checked.push(link(&format!("links[{}]", k + 1), typed)?);
        }
        let links: [ArmLink; N_JOINTS] = std::array::from_fn(|k| checked[k]);
        check_layout(&links)?;
        let gravity = vector_within("gravity_m_s2", self.gravity_m_s2, 100.0)?;
        let chain = BodyChain {
            links,
            tip: vector_within("tip_mm", self.tip_mm, 5000.0)?.into(),
            gravity: gravity.into(),
        };
        let servo = servo(&self.servo)?;
        Ok(VirtualArm {
            name: text("name", self.name)?,
            chain,
            servos: [servo; N_JOINTS],
            gripper: gripper(&self.gripper, servo)?,
            supply: supply(&self.supply)?,
            telemetry: telemetry(&self.telemetry)?,
            sensor: VirtualForceSensor {
                noise: between("force_sensor.noise_n", self.force_sensor.noise_n, [0.0, 100.0])?,
                offset: between("force_sensor.offset_n", self.force_sensor.offset_n, [0.0, 100.0])?,
            },
            spread: spread(&self.spread)?,
            step: between("step_ms", self.step_ms, [0.01, 2.0])?,
            hash,
        })
    }
}

/// The hand at the leader knows one kind of arm: a vertical axis, then three across it, everything in one plane.
fn check_layout(links: &[ArmLink; N_JOINTS]) -> Check<()> {
    let expected = ["[0.0, 0.0, 1.0]", "[0.0, 1.0, 0.0]"];
    for (k, link) in links.iter().enumerate() {
        let (axis, expected) = if k == 0 { (Vector3::z(), expected[0]) } else { (Vector3::y(), expected[1]) };
        if (link.axis.into_inner() - axis).norm() > 1e-9 {
            let found = format!("{:?}", link.axis.as_slice());
            return Err(BadInput::new(format!("links[{}].axis", k + 1), expected, found)
                .hint("arms laid out like the OpenManipulator-X are simulated"));
        }
        if link.origin.y != 0.0 {
            let place = format!("links[{}].origin_mm", k + 1);
            return Err(BadInput::new(place, "0.0 in y", format!("{:?}", link.origin.as_slice())));
        }
    }
    // Of upper arm and forearm.
    let (elbow, wrist) = (links[2].origin, links[3].origin);
    for (k, length) in [(3, elbow.x.hypot(elbow.z)), (4, wrist.x)] {
        if length < SHORTEST {
            let place = format!("links[{k}].origin_mm");
            let expected = format!("{} mm or more from the joint before", 1e3 * SHORTEST);
            return Err(BadInput::new(place, expected, format!("{:?} mm", 1e3 * length)));
        }
    }
    Ok(())
}

/// Shortest upper arm and forearm [m].
const SHORTEST: f64 = 1e-3;

fn link(place: &str, typed: &LinkTable) -> Check<ArmLink> {
    let key = |name: &str| format!("{place}.{name}");
    let axis: Vector3<f64> = vector_within(&key("axis"), typed.axis, 1e3)?.into();
    let Some(axis) = Unit::try_new(axis, 1e-6) else {
        return Err(BadInput::new(key("axis"), "a direction", format!("{:?}", typed.axis)));
    };
    let mut range = [0.0; 2];
    for (end, typed) in range.iter_mut().zip(typed.range_deg.0) {
        *end = within(&key("range_deg"), typed, 360.0)?;
    }
    if range[0] >= range[1] {
        return Err(BadInput::new(key("range_deg"), "[least, greatest]", format!("{:?}", typed.range_deg)));
    }
    let mass = between(&key("mass_kg"), typed.mass_kg, [1e-6, 1e3])?;
    let mut moments = [0.0; 6];
    for (moment, typed) in moments.iter_mut().zip(typed.inertia_kg_m2.0) {
        *moment = within(&key("inertia_kg_m2"), typed, 1e3)?;
    }
    let [xx, yy, zz, xy, xz, yz] = moments;
    let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let principal = inertia.symmetric_eigenvalues();
    // No mass distribution has a moment above the sum of the others.
    if !(principal.min() > 0.0 && principal.sum() - 2.0 * principal.max() >= -1e-9 * principal.max()) {
        let expected = "moments of a body: positive, none above the sum of the others";
        return Err(BadInput::new(key("inertia_kg_m2"), expected, format!("{:?}", typed.inertia_kg_m2))
            .hint("the order is xx, yy, zz, xy, xz, yz, about the centre of mass"));
    }
    Ok(ArmLink {
        origin: vector_within(&key("origin_mm"), typed.origin_mm, 5000.0)?.into(),
        axis,
        range,
        body: ArmBody {
            mass,
            centre: vector_within(&key("centre_mm"), typed.centre_mm, 5000.0)?.into(),
            inertia,
        },
    })
}

fn servo(typed: &ServoTable) -> Check<VirtualServo> {
    let friction = &typed.friction;
    let dry = |name: &str, typed: f64| between(&format!("servo.friction.{name}"), typed, [0.0, 1e3]);
    // Above 1, a gear under load would hold against any torque.
    let share = |name: &str, typed: f64| between(&format!("servo.friction.{name}"), typed, [0.0, 0.9]);
    let friction = GearFriction {
        base: dry("friction_base_n_m", friction.friction_base_n_m)?,
        stribeck: dry("friction_stribeck_n_m", friction.friction_stribeck_n_m)?,
        viscous: dry("friction_viscous_n_m_s_per_rad", friction.friction_viscous_n_m_s_per_rad)?,
        load: [
            share("load_friction_motor", friction.load_friction_motor)?,
            share("load_friction_external", friction.load_friction_external)?,
        ],
        load_stribeck: [
            share("load_friction_motor_stribeck", friction.load_friction_motor_stribeck)?,
            share("load_friction_external_stribeck", friction.load_friction_external_stribeck)?,
        ],
        load_squared: [
            share("load_friction_motor_quad_per_n_m", friction.load_friction_motor_quad_per_n_m)?,
            share("load_friction_external_quad_per_n_m", friction.load_friction_external_quad_per_n_m)?,
        ],
        stribeck_speed: between(
            "servo.friction.stribeck_speed_rad_s",
            friction.stribeck_speed_rad_s,
            [1e-4, 1e3],
        )?,
        alpha: between("servo.friction.alpha", friction.alpha, [0.1, 10.0])?,
    };
    let warm = &typed.heat;
    let heat = WindingHeat {
        winding: between("servo.heat.winding_j_per_k", warm.winding_j_per_k, [1e-2, 1e9])?,
        to_case: between("servo.heat.to_case_k_per_w", warm.to_case_k_per_w, [1e-3, 1e4])?,
        case: between("servo.heat.case_j_per_k", warm.case_j_per_k, [1e-2, 1e9])?,
        to_air: between("servo.heat.to_air_k_per_w", warm.to_air_k_per_w, [1e-3, 1e4])?,
        resistance_slope: between(
            "servo.heat.resistance_slope_per_k",
            warm.resistance_slope_per_k,
            [0.0, 0.01],
        )?,
        magnet_slope: between("servo.heat.magnet_slope_per_k", warm.magnet_slope_per_k, [0.0, 0.005])?,
    };
    let gain = |name: &str, typed: i64| match typed {
        0..=16383 => Ok(typed as f64),
        _ => Err(BadInput::new(format!("servo.{name}"), "a register value, 0 to 16383", typed.to_string())),
    };
    Ok(VirtualServo {
        torque_constant: between(
            "servo.torque_constant_n_m_per_a",
            typed.torque_constant_n_m_per_a,
            [1e-3, 1e3],
        )?,
        resistance: between("servo.resistance_ohm", typed.resistance_ohm, [1e-3, 1e4])?,
        current_limit: between("servo.current_limit_a", typed.current_limit_a, [1e-3, 1e3])?,
        armature: between("servo.armature_kg_m2", typed.armature_kg_m2, [1e-6, 1e2])?,
        stiffness: between("servo.stiffness_n_m_per_rad", typed.stiffness_n_m_per_rad, [1.0, 1e5])?,
        damping: between("servo.damping_n_m_s_per_rad", typed.damping_n_m_s_per_rad, [0.0, 1e3])?,
        backlash: between("servo.backlash_deg", typed.backlash_deg, [0.0, 20.0])?,
        bearing: between("servo.bearing_friction_n_m", typed.bearing_friction_n_m, [0.0, 1e2])?,
        friction,
        heat,
        gains: [gain("p_gain_count", typed.p_gain_count)?, gain("d_gain_count", typed.d_gain_count)?],
    })
}

fn gripper(typed: &GripperTable, servo: VirtualServo) -> Check<VirtualGripper> {
    Ok(VirtualGripper {
        servo,
        lever: between("gripper.lever_mm", typed.lever_mm, [0.1, 1e3])?,
        closed: within("gripper.closed_deg", typed.closed_deg, 360.0)?,
        stiffness: between("gripper.stiffness_n_per_m", typed.stiffness_n_per_m, [10.0, 1e6])?,
        friction: between("gripper.friction_coefficient", typed.friction_coefficient, [0.01, 10.0])?,
    })
}

fn supply(typed: &SupplyTable) -> Check<Supply> {
    Ok(Supply {
        voltage: between("supply.voltage_v", typed.voltage_v, [1.0, 100.0])?,
        resistance: between("supply.resistance_ohm", typed.resistance_ohm, [0.0, 10.0])?,
        air: within("supply.air_degc", typed.air_degc, 100.0)?,
        warm_start: between("supply.warm_start_k", typed.warm_start_k, [0.0, 60.0])?,
    })
}

/// Coarsest step, and most noise, of a current [mA] and of a voltage [mV].
const COARSEST: f64 = 1e5;

fn telemetry(typed: &TelemetryTable) -> Check<TelemetryNoise> {
    let pair = |first: &str, a: f64, second: &str, b: f64| -> Check<[f64; 2]> {
        Ok([
            between(&format!("telemetry.{first}"), a, [1e-6, COARSEST])?,
            between(&format!("telemetry.{second}"), b, [0.0, COARSEST])?,
        ])
    };
    let period = between("telemetry.period_ms", typed.period_ms, [2.0, 1000.0])?;
    let jitter = between("telemetry.jitter_ms", typed.jitter_ms, [0.0, 1000.0])?;
    // Rows must come in order.
    if jitter > 0.1 * period {
        let expected = format!("at most a tenth of period_ms, {}", 0.1 * typed.period_ms);
        return Err(BadInput::new("telemetry.jitter_ms", expected, typed.jitter_ms.to_string()));
    }
    Ok(TelemetryNoise {
        period,
        jitter,
        late: [
            between("telemetry.late_probability", typed.late_probability, [0.0, 0.5])?,
            between("telemetry.late_by_ms", typed.late_by_ms, [0.0, 1000.0])?,
        ],
        speed_filter: between("telemetry.speed_filter_ms", typed.speed_filter_ms, [0.0, 1000.0])?,
        current: pair("current_step_ma", typed.current_step_ma, "current_noise_ma", typed.current_noise_ma)?,
        speed_step: between("telemetry.speed_step_rad_s", typed.speed_step_rad_s, [1e-9, 100.0])?,
        voltage: pair("voltage_step_mv", typed.voltage_step_mv, "voltage_noise_mv", typed.voltage_noise_mv)?,
    })
}

fn spread(typed: &SpreadTable) -> Check<ArmVariation> {
    let relative = |name: &str, typed: f64| between(&format!("spread.{name}"), typed, [0.0, 0.5]);
    Ok(ArmVariation {
        mass: relative("mass_relative", typed.mass_relative)?,
        centre: between("spread.centre_mm", typed.centre_mm, [0.0, 100.0])?,
        inertia: relative("inertia_relative", typed.inertia_relative)?,
        motor: relative("motor_relative", typed.motor_relative)?,
        friction: relative("friction_relative", typed.friction_relative)?,
        backlash: relative("backlash_relative", typed.backlash_relative)?,
    })
}
