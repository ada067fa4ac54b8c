//! The one conversion from what was typed to what is valid, and every bound of a scene.
//!
//! Bounds are checked on the typed numbers, so a message shows what stands in the file and in its unit.

use super::{
    AuxiliaryLayout, Bounds, Friction, Material, PointForce, Region, Scene, Solver, Tendon, Tip,
    TrackerFrame, typed,
};
use crate::BadInput;
use crate::typed::{check_header, count, finite, not_negative, positive, require, text, vector};
use std::path::Path;

type Check<T> = std::result::Result<T, BadInput>;

const FORMAT: &str = "hysteron-scene";
const VERSION: i64 = 1;

/// More than any robot has; keeps a slip of the hand from filling the memory.
const MOST_SEGMENTS: i64 = 1000;
const MOST_CABLES: i64 = 100;
const MOST_FRICTION_POINTS: i64 = 100;

pub(super) fn scene(typed: typed::SceneFile, hash: String, folder: &Path) -> Check<Scene> {
    check_header((&typed.format, typed.version), (FORMAT, VERSION))?;
    let mut tendons: Vec<Tendon> = Vec::new();
    for (i, typed) in typed.tendon.into_iter().enumerate() {
        let tendon = tendon(typed, i + 1)?;
        if tendons.iter().any(|earlier| earlier.name == tendon.name) {
            let place = format!("tendon[{}].name", i + 1);
            return Err(BadInput::new(place, "a name of its own", format!("\"{}\" again", tendon.name)));
        }
        tendons.push(tendon);
    }
    let friction = typed.friction.map(|typed| friction(&typed, &tendons)).transpose()?;
    let mut point_forces = Vec::new();
    for (i, force) in typed.point_force.into_iter().enumerate() {
        let key = format!("point_force[{}]", i + 1);
        point_forces.push(PointForce {
            at: vector(&format!("{key}.at_mm"), force.at_mm)?,
            force: vector(&format!("{key}.force_n"), force.force_n)?,
        });
    }
    Ok(Scene {
        name: text("name", typed.name)?,
        seed: typed.seed,
        hash,
        mesh_path: folder.join(text("mesh.file", typed.mesh.file)?),
        mesh_unit: typed.mesh.unit,
        clamp: clamp(typed.clamp)?,
        material: material(&typed.material)?,
        gravity: vector("gravity.acceleration_m_s2", typed.gravity.acceleration_m_s2)?,
        point_forces,
        tip: tip(typed.tip)?,
        tracker: typed.tracker.map_or(Ok(TrackerFrame::default()), |typed| tracker(&typed))?,
        tendons,
        friction,
        auxiliary: typed.auxiliary.map(|typed| auxiliary(&typed)).transpose()?,
        solver: typed.solver.map_or(Ok(Solver::default()), |typed| solver(&typed))?,
    })
}

fn clamp(typed: typed::Clamp) -> Check<Region> {
    let expected = "either group, or box_min_mm and box_max_mm";
    match (typed.group, typed.box_min_mm, typed.box_max_mm) {
        (Some(group), None, None) => Ok(Region::Group(text("clamp.group", group)?)),
        (None, Some(low), Some(high)) => {
            let region =
                Region::Box { min: vector("clamp.box_min_mm", low)?, max: vector("clamp.box_max_mm", high)? };
            match (0..3).find(|&axis| low[axis] > high[axis]) {
                Some(axis) => Err(BadInput::new(
                    format!("clamp.box_min_mm[{axis}]"),
                    format!("at most box_max_mm[{axis}] = {:?}", high[axis]),
                    format!("{:?}", low[axis]),
                )),
                None => Ok(region),
            }
        }
        (None, None, None) => Err(BadInput::new("clamp", expected, "neither")),
        (Some(_), _, _) => Err(BadInput::new("clamp", expected, "both")),
        (None, Some(_), None) => Err(BadInput::new("clamp", expected, "box_min_mm alone")),
        (None, None, Some(_)) => Err(BadInput::new("clamp", expected, "box_max_mm alone")),
    }
}

fn tip(typed: typed::Tip) -> Check<Tip> {
    match (typed.group, typed.point_mm) {
        (Some(group), None) => Ok(Tip::Group(text("tip.group", group)?)),
        (None, Some(point)) => Ok(Tip::Point(vector("tip.point_mm", point)?)),
        (None, None) => Err(BadInput::new("tip", "either group or point_mm", "neither")),
        (Some(_), Some(_)) => Err(BadInput::new("tip", "either group or point_mm", "both")),
    }
}

fn tracker(typed: &typed::Tracker) -> Check<TrackerFrame> {
    let turn = vector("tracker.turn_deg", typed.turn_deg.unwrap_or_default())?;
    let angle = turn.iter().map(|c| c * c).sum::<f64>().sqrt();
    if angle > std::f64::consts::PI {
        let expected = "a rotation vector of at most 180 deg";
        return Err(BadInput::new("tracker.turn_deg", expected, format!("{:.1} deg", angle.to_degrees())));
    }
    Ok(TrackerFrame { turn, shift: vector("tracker.shift_mm", typed.shift_mm.unwrap_or_default())? })
}

fn material(typed: &typed::Material) -> Check<Material> {
    let variants = [
        ("material.youngs_modulus_pa", typed.youngs_modulus_pa),
        ("material.youngs_modulus_kpa", typed.youngs_modulus_kpa),
        ("material.youngs_modulus_mpa", typed.youngs_modulus_mpa),
        ("material.youngs_modulus_gpa", typed.youngs_modulus_gpa),
    ];
    let given: Vec<(&str, f64)> = variants.into_iter().filter_map(|(key, x)| Some((key, x?))).collect();
    let [(key, modulus)] = given[..] else {
        let found = match given.len() {
            0 => "none".to_owned(),
            _ => given
                .iter()
                .map(|(key, _)| key.trim_start_matches("material."))
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
        youngs_modulus: positive(key, modulus)?,
        poisson_ratio: checked_nu?,
        density: not_negative("material.density_kg_m3", typed.density_kg_m3)?,
    })
}

fn tendon(typed: typed::Tendon, number: usize) -> Check<Tendon> {
    let name = text(&format!("tendon[{number}].name"), typed.name)?;
    let key = |key: &str| format!("tendon.{name}.{key}");
    if typed.points_mm.len() < 2 {
        let found = format!("{} of them", typed.points_mm.len());
        return Err(BadInput::new(key("points_mm"), "at least 2 points, from base to tip", found));
    }
    let mut points = Vec::with_capacity(typed.points_mm.len());
    for (i, &point) in typed.points_mm.iter().enumerate() {
        let place = key(&format!("points_mm[{i}]"));
        points.push(vector(&place, point)?);
        if i > 0 && typed.points_mm[i - 1] == point {
            return Err(BadInput::new(place, "a point away from the one before", format!("{point:?} again")));
        }
    }
    let (tension, stroke) = (
        bounds(&key("tension_min_n"), typed.tension_min_n, &key("tension_max_n"), typed.tension_max_n)?,
        bounds(&key("stroke_min_mm"), typed.stroke_min_mm, &key("stroke_max_mm"), typed.stroke_max_mm)?,
    );
    let attach_within = not_negative(&key("attach_within_mm"), typed.attach_within_mm)?;
    let ring = not_negative(&key("ring_mm"), typed.ring_mm.unwrap_or(0.0))?;
    let compliance = not_negative(&key("compliance_mm_per_n"), typed.compliance_mm_per_n.unwrap_or(0.0))?;
    let zero = finite(&key("zero_mm"), typed.zero_mm.unwrap_or(0.0))?;
    let drive = typed.drive;
    Ok(Tendon { name, points, drive, tension, stroke, attach_within, ring, compliance, zero })
}

fn friction(typed: &typed::Friction, tendons: &[Tendon]) -> Check<Friction> {
    let number =
        |key: &str, typed: Option<f64>| not_negative(&format!("friction.{key}"), typed.unwrap_or(0.0));
    let points = typed.points.map(|points| count("friction.points", points, MOST_FRICTION_POINTS));
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
        return Err(BadInput::new("friction.points", "places at which the tendons rub", "nothing")
            .hint("points = 4 is enough for a circular bend"));
    }
    if friction.sheath_exponent > 0.0 || friction.sheath_coulomb > 0.0 {
        if share == 0.0 {
            return Err(BadInput::new("friction.sheath_compliance_share", "more than 0", "0.0")
                .hint("friction after a tendon that does not stretch leaves the body as it is"));
        }
        if let Some(stiff) = tendons.iter().find(|tendon| tendon.compliance == 0.0) {
            let place = format!("tendon.{}.compliance_mm_per_n", stiff.name);
            return Err(BadInput::new(place, "more than 0", "0.0")
                .hint("friction of the sheath needs a tendon that stretches"));
        }
    }
    Ok(friction)
}

fn auxiliary(typed: &typed::Auxiliary) -> Check<AuxiliaryLayout> {
    Ok(AuxiliaryLayout {
        segments: count("auxiliary.segments", typed.segments, MOST_SEGMENTS)?,
        segment_length: positive("auxiliary.segment_length_mm", typed.segment_length_mm)?,
        start: finite("auxiliary.start_mm", typed.start_mm)?,
        radius: positive("auxiliary.radius_mm", typed.radius_mm)?,
        cables_per_segment: count("auxiliary.cables_per_segment", typed.cables_per_segment, MOST_CABLES)?,
        first_plane: finite("auxiliary.first_plane_deg", typed.first_plane_deg)?,
        plane_step: finite("auxiliary.plane_step_deg", typed.plane_step_deg)?,
        drive: typed.drive,
        tension: bounds(
            "auxiliary.tension_min_n",
            typed.tension_min_n,
            "auxiliary.tension_max_n",
            typed.tension_max_n,
        )?,
        stroke: bounds(
            "auxiliary.stroke_min_mm",
            typed.stroke_min_mm,
            "auxiliary.stroke_max_mm",
            typed.stroke_max_mm,
        )?,
        stroke_rate: match typed.stroke_rate_max_mm_s {
            Some(rate) => positive("auxiliary.stroke_rate_max_mm_s", rate)?,
            None => f64::INFINITY,
        },
        attach_within: not_negative("auxiliary.attach_within_mm", typed.attach_within_mm)?,
    })
}

fn solver(typed: &typed::Solver) -> Check<Solver> {
    let mut solver = Solver::default();
    if let Some(x) = typed.relative_residual {
        solver.relative_residual = require("solver.relative_residual", "0 < x < 1", x, 0.0 < x && x < 1.0)?;
    }
    if let Some(x) = typed.stroke_tolerance_mm {
        solver.stroke_tolerance = positive("solver.stroke_tolerance_mm", x)?;
    }
    Ok(solver)
}

fn bounds(min_key: &str, min: f64, max_key: &str, max: f64) -> Check<Bounds> {
    let si = Bounds { min: finite(min_key, min)?, max: finite(max_key, max)? };
    if min > max {
        let name = max_key.rsplit('.').next().unwrap_or(max_key);
        return Err(BadInput::new(min_key, format!("at most {name} = {max:?}"), format!("{min:?}")));
    }
    Ok(si)
}
