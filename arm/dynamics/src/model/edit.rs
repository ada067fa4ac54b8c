//! Other robots from a robot: joints locked, payloads attached, parameters replaced.

use std::collections::BTreeMap;

use hysteron_base::BadInput;

use super::build::{check_second, principal};
use super::{Joint, JointKind, JointLimits, Model};
use crate::spatial::{Inertia, Pose, Sym3, Vec3};

impl Model {
    /// The same robot with some joints locked at coordinates [rad] or [m].
    ///
    /// # Errors
    /// `BadInput` for a joint that is not there, a coordinate that is not finite, or where nothing is left to move.
    pub fn with_locked(&self, locked: &[(&str, f64)]) -> Result<Self, BadInput> {
        let mut at = BTreeMap::new();
        for (name, q) in locked {
            at.insert(self.named_joint(name)?, *q);
            if !q.is_finite() {
                return Err(BadInput::new(format!("joint {name}"), "a finite coordinate", q.to_string()));
            }
        }
        if at.len() == self.n_joints() {
            return Err(BadInput::new("locked joints", "one joint left that moves", "all of them locked"));
        }
        let mut model = Self { joints: Vec::new(), ..self.clone() };
        // Where the bodies of the old joints are now: the new joint that carries them, and their pose in its frame.
        let mut moved: Vec<(Option<usize>, Pose<f64>)> = Vec::new();
        for (i, joint) in self.joints.iter().enumerate() {
            let (carrier, pose) = joint.parent.map_or((None, Pose::IDENTITY), |p| moved[p]);
            let placement = pose.times(&joint.placement);
            match at.get(&i) {
                Some(q) => {
                    let pose = placement.times(&joint.motion(*q));
                    let inertia = joint.inertia.placed(&pose.rotation, pose.position);
                    let whole = carrier.map_or(&mut model.base, |c: usize| &mut model.joints[c].inertia);
                    *whole = whole.plus(&inertia);
                    if let Some(c) = carrier {
                        let weightless = &mut model.joints[c].weightless;
                        *weightless = weightless.plus(&joint.weightless.placed(&pose));
                    }
                    moved.push((carrier, pose));
                }
                None => {
                    moved.push((Some(model.joints.len()), Pose::IDENTITY));
                    model.joints.push(Joint { parent: carrier, placement, ..joint.clone() });
                }
            }
        }
        for (i, joint) in self.joints.iter().enumerate() {
            let (Some(new), false) = (moved[i].0, at.contains_key(&i)) else { continue };
            model.joints[new].follows = joint.follows.and_then(|mut follower| {
                follower.joint = moved[follower.joint].0.filter(|_| !at.contains_key(&follower.joint))?;
                Some(follower)
            });
        }
        for frame in &mut model.frames {
            if let Some(old) = frame.joint {
                let (carrier, pose) = moved[old];
                (frame.joint, frame.pose) = (carrier, pose.times(&frame.pose));
            }
        }
        Ok(model)
    }

    /// The same robot with a body held at the frame called `frame`: mass [kg], centre of mass in that frame [m], second
    /// moment about the centre of mass in its axes (xx, xy, yy, xz, yz, zz) [kg m²].
    ///
    /// # Errors
    /// `BadInput` for a frame that is not there, or a body that cannot be.
    pub fn with_payload(
        &self,
        frame: &str,
        mass: f64,
        centre: Vec3<f64>,
        second: Sym3<f64>,
    ) -> Result<Self, BadInput> {
        let finite = centre.iter().chain(&second).all(|x| x.is_finite());
        if !(mass >= 0.0 && mass.is_finite() && finite) {
            let found = format!("{mass} kg at {centre:?}, {second:?}");
            return Err(BadInput::new("payload", "a mass >= 0 and finite numbers", found));
        }
        check_second(&second).map_err(|found| {
            BadInput::new("payload", "an inertia without negative principal value", found)
        })?;
        let at = &self.frames[self.frame(frame)?];
        let body = Inertia::about_centre(mass, centre, second).placed(&at.pose.rotation, at.pose.position);
        let mut model = self.clone();
        let whole = at.joint.map_or(&mut model.base, |joint| &mut model.joints[joint].inertia);
        *whole = whole.plus(&body);
        Ok(model)
    }

    /// The same robot with other gravity in the axes of the base [m/s²].
    #[must_use]
    pub fn with_gravity(&self, gravity: Vec3<f64>) -> Self {
        Self { gravity, ..self.clone() }
    }

    /// The same robot with mass, first moments and inertia of every moving body `factor` times as large; rotors stay.
    #[must_use]
    pub fn with_scaled_bodies(&self, factor: f64) -> Self {
        let mut model = self.clone();
        for joint in &mut model.joints {
            joint.inertia = Inertia::from_parameters(joint.inertia.parameters().map(|p| p * factor));
            joint.weightless.mass *= factor;
            joint.weightless.first.iter_mut().for_each(|h| *h *= factor);
        }
        model
    }

    /// The same robot with other inertias and drives: `change` is given each joint's number, inertia and drive.
    #[must_use]
    pub fn with_bodies_and_drives(
        &self,
        mut change: impl FnMut(usize, &mut Inertia<f64>, &mut JointLimits),
    ) -> Self {
        let mut model = self.clone();
        for (k, joint) in model.joints.iter_mut().enumerate() {
            change(k, &mut joint.inertia, &mut joint.drive);
        }
        model
    }

    /// The same robot with a rotor on a joint: inertia of rotor and gear train about the motor's axis [kg m²], and turns of
    /// the motor for one of the joint.
    ///
    /// # Errors
    /// `BadInput` for a joint that is not there, or an inertia that is negative.
    pub fn with_rotor(&self, joint: &str, inertia: f64, ratio: f64) -> Result<Self, BadInput> {
        let index = self.named_joint(joint)?;
        let armature = inertia * ratio * ratio;
        if !(armature >= 0.0 && armature.is_finite()) {
            let found = format!("{inertia} kg m², ratio {ratio}");
            return Err(BadInput::new(
                format!("rotor of {joint}"),
                "an inertia >= 0 and a finite ratio",
                found,
            ));
        }
        let mut model = self.clone();
        model.joints[index].drive.armature += armature;
        Ok(model)
    }

    fn named_joint(&self, name: &str) -> Result<usize, BadInput> {
        self.joint(name).ok_or_else(|| {
            let names: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
            BadInput::new("joint", format!("one of {}", names.join(", ")), format!("\"{name}\""))
        })
    }

    /// Distance [m] that no frame can be from the base's origin: the lengths of the way to the farthest one, summed.
    pub fn reach(&self) -> f64 {
        let length = |v: Vec3<f64>| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut reaches: Vec<f64> = Vec::new();
        for joint in &self.joints {
            let extension = match (joint.kind, joint.drive.range) {
                (JointKind::Prismatic, Some([low, high])) => low.abs().max(high.abs()),
                _ => 0.0,
            };
            let before = joint.parent.map_or(0.0, |parent| reaches[parent]);
            reaches.push(before + length(joint.placement.position) + extension);
        }
        let frames =
            self.frames.iter().map(|f| f.joint.map_or(0.0, |j| reaches[j]) + length(f.pose.position));
        frames.fold(0.0, f64::max)
    }

    /// Warnings about numbers that are possible but implausible: one sentence each.
    pub fn suspicions(&self) -> Vec<String> {
        let mut found = Vec::new();
        for joint in &self.joints {
            let name = &joint.name;
            let (mass, [a, b, c]) = (joint.inertia.mass, principal(&joint.inertia.second_about_centre()));
            if mass > 0.0 && c <= 0.0 {
                found.push(format!("{name}: {mass} kg without moment of inertia: a point mass"));
            } else if a + b < c * (1.0 - 1e-3) {
                found.push(format!(
                    "{name}: principal moments of inertia {a:.3e}, {b:.3e}, {c:.3e} kg m² violate the triangle inequality \
                     {a:.3e} + {b:.3e} >= {c:.3e}: no body has them"
                ));
            }
            // Radius of gyration; a body of an arm is neither a millimetre nor ten metres wide.
            let radius = (c / mass).sqrt();
            if mass > 0.0 && radius > 10.0 {
                found.push(format!("{name}: radius of gyration {radius:.1} m: inertia in kg mm² or g mm²?"));
            }
            if mass > 500.0 {
                found.push(format!("{name}: {mass} kg: mass in g?"));
            }
            let reach = joint.placement.position.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if reach > 20.0 {
                found.push(format!("{name}: {reach:.1} m from the joint before it: lengths in mm?"));
            }
            if let Some(limits) = limits_in_degrees(joint) {
                found.push(limits);
            }
            if joint.drive.range.is_some_and(|[low, high]| low == high) {
                found.push(format!("{name}: its range is one point, so that it cannot move"));
            }
            let named = [("speed", joint.drive.speed_limit), ("torque", joint.drive.effort_limit)];
            for (what, _) in named.iter().filter(|(_, limit)| *limit == Some(0.0)) {
                found.push(format!("{name}: its limit of {what} is zero"));
            }
        }
        found
    }
}

/// Turns beyond which no cable of a joint follows, and below which limits may be angles in degrees [rad].
const ANGLES_IN_DEGREES: [f64; 2] = [4.0 * std::f64::consts::PI, 720.0];

/// A sentence where the limits of a joint that turns are whole numbers far beyond two turns.
pub(super) fn limits_in_degrees(joint: &Joint) -> Option<String> {
    let [low, high] = joint.drive.range.filter(|_| joint.kind == JointKind::Revolute)?;
    let most = low.abs().max(high.abs());
    let is_angle = (ANGLES_IN_DEGREES[0]..=ANGLES_IN_DEGREES[1]).contains(&most);
    (is_angle && low.fract() == 0.0 && high.fract() == 0.0).then(|| {
        let turns = most / std::f64::consts::TAU;
        format!(
            "{}: limits {low} and {high} rad, {turns:.0} turns: in degrees? (hint: {:.4} and {:.4} are those angles in rad)",
            joint.name,
            low.to_radians(),
            high.to_radians()
        )
    })
}

impl Joint {
    /// The part of its body's weight that is carried without torques of the joints; `None` where it is no part of the whole body.
    pub fn compensation(&self) -> Option<f64> {
        let (whole, carried) = (&self.inertia, &self.weightless);
        let part = if whole.mass == 0.0 { 0.0 } else { carried.mass / whole.mass };
        let scale = whole.first.iter().fold(whole.mass, |most, h| most.max(h.abs()));
        let is_part = (0..3).all(|k| (carried.first[k] - part * whole.first[k]).abs() <= 1e-12 * scale);
        is_part.then_some(part)
    }

    /// Pose of the joint's moving frame in its frame at zero.
    pub(crate) fn motion(&self, q: f64) -> Pose<f64> {
        match self.kind {
            JointKind::Revolute => {
                let (sin, cos) = q.sin_cos();
                Pose { rotation: [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]], position: [0.0; 3] }
            }
            JointKind::Prismatic => Pose { position: [0.0, 0.0, q], ..Pose::IDENTITY },
        }
    }
}
