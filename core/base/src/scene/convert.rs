//! The one conversion from what was typed to what is valid, and every bound of a scene.
//!
//! Bounds are checked on the typed numbers, so a message shows the number of the file in its unit.

use super::{
    AuxiliaryLayout, Bounds, Friction, Insert, Material, PointForce, Region, Scene, Solver, Tendon,
    TipDefinition, TrackerFrame, schema,
};
use crate::BadInput;
use crate::schema::{
    FixedArray, between, check_header, count, not_negative, require, text, vector, vector_within, within,
};
use crate::size::check_at_most;
use std::path::Path;

type Check<T> = std::result::Result<T, BadInput>;

const FORMAT: &str = "hysteron-scene";
const VERSION: i64 = 1;

/// More than any robot has; keeps a slip of the hand from filling the memory, or from asking for a body that no
/// arithmetic can follow.
const MAX_SEGMENTS: i64 = 1000;
const MAX_CABLES: i64 = 100;
const MAX_AUXILIARY: usize = 500;
const MAX_FRICTION_POINTS: i64 = 100;
const MAX_TENDONS: usize = 100;
const MAX_POINTS: usize = 1000;
const MAX_FORCES: usize = 1000;
/// Longest length and stroke [mm].
const LONGEST: f64 = 1e5;
/// Largest force and tension [N].
const LARGEST_FORCE: f64 = 1e6;
/// Largest acceleration [m/s²]: a thousand times that of the earth.
const LARGEST_ACCELERATION: f64 = 1e4;
/// Densest material [kg/m³]; osmium has 22 590.
const DENSEST: f64 = 1e5;
/// Softest and stiffest material [Pa]: below any gel, above diamond.
const MODULI: [f64; 2] = [1.0, 1e13];
/// Largest angle, ten turns [deg].
const LARGEST_ANGLE: f64 = 3600.0;
/// Largest friction coefficient and exponent [-].
const LARGEST_FRICTION: f64 = 100.0;

/// The scene that was typed, still without its hash.
pub(super) fn scene(typed: schema::SceneFile, folder: &Path) -> Check<Scene> {
    check_header((&typed.format, typed.version), (FORMAT, VERSION))?;
    check_at_most("tendon", typed.tendon.len(), MAX_TENDONS)?;
    check_at_most("point_force", typed.point_force.len(), MAX_FORCES)?;
    let mut tendons: Vec<Tendon> = Vec::new();
    for (i, typed) in typed.tendon.into_iter().enumerate() {
        let tendon = tendon(typed, i + 1)?;
        if tendons.iter().any(|earlier| earlier.name == tendon.name) {
            let place = format!("tendon[{}].name", i + 1);
            return Err(BadInput::new(place, "a unique name", format!("\"{}\" again", tendon.name)));
        }
        tendons.push(tendon);
    }
    let friction = typed.friction.map(|typed| friction(&typed, &tendons)).transpose()?;
    let mut point_forces = Vec::new();
    for (i, force) in typed.point_force.into_iter().enumerate() {
        let key = format!("point_force[{}]", i + 1);
        point_forces.push(PointForce {
            at: vector_within(&format!("{key}.at_mm"), force.at_mm, LONGEST)?,
            force: vector_within(&format!("{key}.force_n"), force.force_n, LARGEST_FORCE)?,
        });
    }
    Ok(Scene {
        name: text("name", typed.name)?,
        seed: typed.seed,
        hash: String::new(),
        mesh_path: folder.join(text("mesh.file", typed.mesh.file)?),
        mesh_unit: typed.mesh.unit,
        reduced_path: match typed.reduced {
            Some(typed) => Some(folder.join(text("reduced.file", typed.file)?)),
            None => None,
        },
        clamp: region("clamp", typed.clamp.group, typed.clamp.box_min_mm, typed.clamp.box_max_mm)?,
        material: material(&typed.material)?,
        inserts: typed.insert.into_iter().enumerate().map(insert).collect::<Check<_>>()?,
        gravity: vector_within(
            "gravity.acceleration_m_s2",
            typed.gravity.acceleration_m_s2,
            LARGEST_ACCELERATION,
        )?,
        point_forces,
        tip: tip(typed.tip)?,
        tracker: typed.tracker.map_or(Ok(TrackerFrame::default()), |typed| tracker(&typed))?,
        tendons,
        friction,
        auxiliary: typed.auxiliary.map(|typed| auxiliary(&typed)).transpose()?,
        solver: typed.solver.map_or(Ok(Solver::default()), |typed| solver(&typed))?,
    })
}

/// Stiffest and softest part over the body [-]: beyond, the factors of the stiffness lose their digits.
const MODULUS_RATIOS: [f64; 2] = [1e-4, 1e4];

fn insert((i, typed): (usize, schema::InsertTable)) -> Check<Insert> {
    let key = format!("insert[{}]", i + 1);
    let region = region(&key, typed.group, typed.box_min_mm, typed.box_max_mm)?;
    let modulus_ratio = between(&format!("{key}.modulus_ratio"), typed.modulus_ratio, MODULUS_RATIOS)?;
    Ok(Insert { region, modulus_ratio })
}

/// The part of a mesh that table `key` names.
fn region(
    key: &str,
    group: Option<String>,
    low: Option<FixedArray<f64, 3>>,
    high: Option<FixedArray<f64, 3>>,
) -> Check<Region> {
    let expected = "either group, or box_min_mm and box_max_mm";
    match (group, low, high) {
        (Some(group), None, None) => Ok(Region::Group(text(&format!("{key}.group"), group)?)),
        (None, Some(low), Some(high)) => {
            let region = Region::Box {
                min: vector_within(&format!("{key}.box_min_mm"), low, LONGEST)?,
                max: vector_within(&format!("{key}.box_max_mm"), high, LONGEST)?,
            };
            match (0..3).find(|&axis| low[axis] > high[axis]) {
                Some(axis) => Err(BadInput::new(
                    format!("{key}.box_min_mm[{axis}]"),
                    format!("at most box_max_mm[{axis}] = {:?}", high[axis]),
                    format!("{:?}", low[axis]),
                )),
                None => Ok(region),
            }
        }
        (None, None, None) => Err(BadInput::new(key, expected, "neither")),
        (Some(_), _, _) => Err(BadInput::new(key, expected, "both")),
        (None, Some(_), None) => Err(BadInput::new(key, expected, "box_min_mm alone")),
        (None, None, Some(_)) => Err(BadInput::new(key, expected, "box_max_mm alone")),
    }
}

fn tip(typed: schema::TipTable) -> Check<TipDefinition> {
    match (typed.group, typed.point_mm) {
        (Some(group), None) => Ok(TipDefinition::Group(text("tip.group", group)?)),
        (None, Some(point)) => Ok(TipDefinition::Point(vector_within("tip.point_mm", point, LONGEST)?)),
        (None, None) => Err(BadInput::new("tip", "either group or point_mm", "neither")),
        (Some(_), Some(_)) => Err(BadInput::new("tip", "either group or point_mm", "both")),
    }
}

fn tracker(typed: &schema::TrackerTable) -> Check<TrackerFrame> {
    let turn = vector("tracker.turn_deg", typed.turn_deg.unwrap_or_default())?;
    let angle = turn.iter().map(|c| c * c).sum::<f64>().sqrt();
    if angle > std::f64::consts::PI {
        let expected = "a rotation vector of at most 180 deg";
        return Err(BadInput::new("tracker.turn_deg", expected, format!("{:.1} deg", angle.to_degrees())));
    }
    Ok(TrackerFrame {
        turn,
        shift: vector_within("tracker.shift_mm", typed.shift_mm.unwrap_or_default(), LONGEST)?,
    })
}

fn material(typed: &schema::MaterialTable) -> Check<Material> {
    let variants = [
        ("material.youngs_modulus_pa", typed.youngs_modulus_pa, 1.0),
        ("material.youngs_modulus_kpa", typed.youngs_modulus_kpa, 1e3),
        ("material.youngs_modulus_mpa", typed.youngs_modulus_mpa, 1e6),
        ("material.youngs_modulus_gpa", typed.youngs_modulus_gpa, 1e9),
    ];
    let moduli: Vec<(&str, f64, f64)> =
        variants.into_iter().filter_map(|(key, x, pascal)| Some((key, x?, pascal))).collect();
    let [(key, modulus, pascal)] = moduli[..] else {
        let found = match moduli.len() {
            0 => "none".to_owned(),
            _ => moduli
                .iter()
                .map(|(key, ..)| key.trim_start_matches("material."))
                .collect::<Vec<_>>()
                .join(" and "),
        };
        let expected = "one of youngs_modulus_pa, _kpa, _mpa, _gpa";
        return Err(BadInput::new("material.youngs_modulus", expected, found));
    };
    let nu = typed.poisson_ratio;
    let mut checked_nu = require("material.poisson_ratio", "-1 < nu < 0.5", nu, -1.0 < nu && nu < 0.5);
    if nu == 0.5 {
        checked_nu = checked_nu.map_err(|bad| bad.hint("use 0.49 and a quadratic mesh"));
    }
    Ok(Material {
        law: typed.law,
        youngs_modulus: between(key, modulus, MODULI.map(|modulus| modulus / pascal))?,
        poisson_ratio: checked_nu?,
        density: up_to("material.density_kg_m3", typed.density_kg_m3, DENSEST)?,
    })
}

fn tendon(typed: schema::TendonTable, number: usize) -> Check<Tendon> {
    let name = text(&format!("tendon[{number}].name"), typed.name)?;
    let key = |key: &str| format!("tendon.{name}.{key}");
    if typed.points_mm.len() < 2 {
        let found = format!("{} of them", typed.points_mm.len());
        return Err(BadInput::new(key("points_mm"), "at least 2 points, from base to tip", found));
    }
    check_at_most(&key("points_mm"), typed.points_mm.len(), MAX_POINTS)?;
    let mut points = Vec::with_capacity(typed.points_mm.len());
    for (i, &point) in typed.points_mm.iter().enumerate() {
        let place = key(&format!("points_mm[{i}]"));
        let point = point.at_mm();
        points.push(vector_within(&place, point, LONGEST)?);
        if i > 0 && typed.points_mm[i - 1].at_mm() == point {
            return Err(BadInput::new(place, "a point away from the one before", format!("{point:?} again")));
        }
    }
    let fixed = (0..points.len()).filter(|&i| typed.points_mm[i].is_fixed()).collect();
    let (tension, stroke) = (
        bounds(
            [&key("tension_min_n"), &key("tension_max_n")],
            [typed.tension_min_n, typed.tension_max_n],
            LARGEST_FORCE,
        )?,
        bounds(
            [&key("stroke_min_mm"), &key("stroke_max_mm")],
            [typed.stroke_min_mm, typed.stroke_max_mm],
            LONGEST,
        )?,
    );
    let attach_within = up_to(&key("attach_within_mm"), typed.attach_within_mm, LONGEST)?;
    let ring = up_to(&key("ring_mm"), typed.ring_mm.unwrap_or(0.0), LONGEST)?;
    let anchor = anchor(&key("anchor_radius_mm"), typed.anchor_radius_mm)?;
    if anchor.is_some() && ring > 0.0 {
        let expected = "either ring_mm or anchor_radius_mm";
        return Err(BadInput::new(key("anchor_radius_mm"), expected, "both")
            .hint("an anchor spreads each point over the body around it, the wall of its channel included"));
    }
    let compliance = typed.compliance_mm_per_n.unwrap_or(0.0);
    let compliance = up_to(&key("compliance_mm_per_n"), compliance, LONGEST)?;
    let zero = within(&key("zero_mm"), typed.zero_mm.unwrap_or(0.0), LONGEST)?;
    let drive = typed.drive;
    Ok(Tendon { name, points, fixed, drive, tension, stroke, attach_within, ring, anchor, compliance, zero })
}

fn friction(typed: &schema::TendonFrictionTable, tendons: &[Tendon]) -> Check<Friction> {
    let number = |key: &str, typed: Option<f64>| {
        let largest = match key.rsplit('_').next() {
            Some("n") => LARGEST_FORCE,
            Some("mm") => LONGEST,
            _ => LARGEST_FRICTION,
        };
        up_to(&format!("friction.{key}"), typed.unwrap_or(0.0), largest)
    };
    let points = typed.points.map(|points| count("friction.points", points, MAX_FRICTION_POINTS));
    let share = typed.sheath_compliance_share.unwrap_or(0.0);
    let friction = Friction {
        coefficient: number("coefficient", typed.coefficient)?,
        coulomb: number("coulomb_n", typed.coulomb_n)?,
        points: points.transpose()?.unwrap_or(0),
        sheath_exponent: number("sheath_exponent", typed.sheath_exponent)?,
        sheath_coulomb: number("sheath_coulomb_n", typed.sheath_coulomb_n)?,
        sheath_compliance_share: require(
            "friction.sheath_compliance_share",
            "0 <= x <= 1",
            share,
            (0.0..=1.0).contains(&share),
        )?,
        backlash: number("backlash_mm", typed.backlash_mm)?,
    };
    if friction.points == 0 && (friction.coefficient > 0.0 || friction.coulomb > 0.0) {
        return Err(BadInput::new("friction.points", "the number of friction points", "nothing")
            .hint("points = 4 is enough for a circular bend"));
    }
    if friction.sheath_exponent > 0.0 || friction.sheath_coulomb > 0.0 {
        if share == 0.0 {
            return Err(BadInput::new("friction.sheath_compliance_share", "more than 0", "0.0")
                .hint("friction of the sheath has no effect on a tendon that does not stretch"));
        }
        if let Some(stiff) = tendons.iter().find(|tendon| tendon.compliance == 0.0) {
            let place = format!("tendon.{}.compliance_mm_per_n", stiff.name);
            return Err(BadInput::new(place, "more than 0", "0.0")
                .hint("friction of the sheath needs a tendon that stretches"));
        }
    }
    Ok(friction)
}

fn auxiliary(typed: &schema::AuxiliaryTable) -> Check<AuxiliaryLayout> {
    let segments = count("auxiliary.segments", typed.segments, MAX_SEGMENTS)?;
    let cables_per_segment = count("auxiliary.cables_per_segment", typed.cables_per_segment, MAX_CABLES)?;
    check_at_most(
        "auxiliary: segments times cables_per_segment",
        segments * cables_per_segment,
        MAX_AUXILIARY,
    )?;
    let length = |key: &str, mm: f64| between(&format!("auxiliary.{key}"), mm, [1e-3, LONGEST]);
    Ok(AuxiliaryLayout {
        segments,
        segment_length: length("segment_length_mm", typed.segment_length_mm)?,
        start: within("auxiliary.start_mm", typed.start_mm, LONGEST)?,
        radius: length("radius_mm", typed.radius_mm)?,
        cables_per_segment,
        first_plane: within("auxiliary.first_plane_deg", typed.first_plane_deg, LARGEST_ANGLE)?,
        plane_step: within("auxiliary.plane_step_deg", typed.plane_step_deg, LARGEST_ANGLE)?,
        drive: typed.drive,
        tension: bounds(
            ["auxiliary.tension_min_n", "auxiliary.tension_max_n"],
            [typed.tension_min_n, typed.tension_max_n],
            LARGEST_FORCE,
        )?,
        stroke: bounds(
            ["auxiliary.stroke_min_mm", "auxiliary.stroke_max_mm"],
            [typed.stroke_min_mm, typed.stroke_max_mm],
            LONGEST,
        )?,
        stroke_rate: match typed.stroke_rate_max_mm_s {
            Some(rate) => length("stroke_rate_max_mm_s", rate)?,
            None => f64::INFINITY,
        },
        attach_within: up_to("auxiliary.attach_within_mm", typed.attach_within_mm, LONGEST)?,
        anchor: anchor("auxiliary.anchor_radius_mm", typed.anchor_radius_mm)?,
    })
}

/// The radius of an anchor [mm], where there is one.
fn anchor(key: &str, typed: Option<f64>) -> Check<Option<f64>> {
    typed.map(|radius| between(key, radius, [1e-3, LONGEST])).transpose()
}

/// A number from 0 to `most`, in the unit of the key.
fn up_to(key: &str, typed: f64, most: f64) -> Check<f64> {
    let holds = typed <= most;
    if holds || !typed.is_finite() { not_negative(key, typed) } else { between(key, typed, [0.0, most]) }
}

fn solver(typed: &schema::SolverTable) -> Check<Solver> {
    let mut solver = Solver::default();
    if let Some(x) = typed.relative_residual {
        solver.relative_residual =
            require("solver.relative_residual", "1e-13 <= x < 1", x, (1e-13..1.0).contains(&x))?;
    }
    if let Some(x) = typed.stroke_tolerance_mm {
        solver.stroke_tolerance = between("solver.stroke_tolerance_mm", x, [1e-10, LONGEST])?;
    }
    Ok(solver)
}

fn bounds([min_key, max_key]: [&str; 2], [min, max]: [f64; 2], most: f64) -> Check<Bounds> {
    let si = Bounds { min: within(min_key, min, most)?, max: within(max_key, max, most)? };
    if min > max {
        let name = max_key.rsplit('.').next().unwrap_or(max_key);
        return Err(BadInput::new(min_key, format!("at most {name} = {max:?}"), format!("{min:?}")));
    }
    Ok(si)
}
