//! A robot as a file again: URDF, MJCF, the joints of an MJCF, and a table of parameters.
//!
//! Links that were merged on reading stay merged: a body is one link with one inertia, and the links that were fixed to it are frames
//! without mass. Numbers are written with as many digits as give the same double back.

use std::fmt::Write;

use hysteron_base::{BadInput, Column, Table};

use super::{Frame, Joint, JointKind, Model};
use crate::spatial::{Inertia, Mat3, Pose, Vec3, mul3_transposed};

/// Ends the names of the frames that the reader of MJCF puts into joints.
const PIVOT: &str = "/pivot";
/// Name of the frame that every MJCF has.
const WORLD: &str = "world";
/// Columns of [`Model::parameters_csv`] after the name of the joint.
const PARAMETERS: [&str; 13] = [
    "mass_kg",
    "centre_x_m",
    "centre_y_m",
    "centre_z_m",
    "ixx_kg_m2",
    "ixy_kg_m2",
    "iyy_kg_m2",
    "ixz_kg_m2",
    "iyz_kg_m2",
    "izz_kg_m2",
    "armature",
    "damping",
    "dry_friction",
];

/// A body as a file describes it: its own frame, in the frame of its joint.
struct WrittenBody<'m> {
    name: &'m str,
    pose: Pose<f64>,
    inertia: Inertia<f64>,
    /// Other frames, in the body's own.
    frames: Vec<(&'m str, Pose<f64>)>,
}

/// Which frame of a joint is its body's.
#[derive(Clone, Copy, PartialEq)]
enum BodyOrigin {
    /// The first one at the joint's origin.
    AtJoint,
    /// The first one that is no pivot.
    Anywhere,
}

impl Model {
    /// The robot as URDF. URDF has no armature, springs, gravity and gravity compensation: they are left out.
    ///
    /// # Errors
    /// `BadInput` for a prismatic joint without limits, which URDF cannot hold.
    pub fn to_urdf(&self) -> Result<String, BadInput> {
        let mut out = format!("<robot name=\"{}\">\n", escaped(&self.name));
        let base = self.body(None, BodyOrigin::AtJoint);
        write_link(&mut out, &base);
        let mut bodies: Vec<WrittenBody> = Vec::new();
        for (k, joint) in self.joints.iter().enumerate() {
            let body = self.body(Some(k), BodyOrigin::AtJoint);
            write_link(&mut out, &body);
            let parent = joint.parent.map_or(&base, |parent| &bodies[parent]);
            self.write_urdf_joint(&mut out, joint, parent, &body)?;
            bodies.push(body);
        }
        out.push_str("</robot>\n");
        Ok(out)
    }

    fn write_urdf_joint(
        &self,
        out: &mut String,
        joint: &Joint,
        parent: &WrittenBody,
        body: &WrittenBody,
    ) -> Result<(), BadInput> {
        let kind = match (joint.kind, joint.drive.range) {
            (JointKind::Revolute, Some(_)) => "revolute",
            (JointKind::Revolute, None) => "continuous",
            (JointKind::Prismatic, Some(_)) => "prismatic",
            (JointKind::Prismatic, None) => {
                return Err(BadInput::new(
                    format!("joint {}", joint.name),
                    "a range, which URDF needs",
                    "none",
                )
                .hint("MJCF has it: --out robot.xml"));
            }
        };
        let origin = inverse(&parent.pose).times(&joint.placement).times(&body.pose);
        let axis = mul3_transposed(&body.pose.rotation, [0.0, 0.0, 1.0]);
        let drive = &joint.drive;
        let mut line = |text: String| {
            out.push_str(&text);
            out.push('\n');
        };
        line(format!("  <joint name=\"{}\" type=\"{kind}\">", escaped(&joint.name)));
        line(format!(
            "    <parent link=\"{}\"/>\n    <child link=\"{}\"/>",
            escaped(parent.name),
            escaped(body.name)
        ));
        line(format!("    {}\n    <axis xyz=\"{}\"/>", urdf_origin(&origin), numbers(&axis)));
        let mut limit = String::new();
        if let Some([lower, upper]) = drive.range {
            limit.push_str(&format!(" lower=\"{lower}\" upper=\"{upper}\""));
        }
        for (name, value) in [("effort", drive.effort_limit), ("velocity", drive.speed_limit)] {
            limit.extend(value.map(|value| format!(" {name}=\"{value}\"")));
        }
        if !limit.is_empty() {
            line(format!("    <limit{limit}/>"));
        }
        line(format!("    <dynamics damping=\"{}\" friction=\"{}\"/>", drive.damping, drive.dry_friction));
        if let Some(follower) = joint.follows {
            let leader = escaped(&self.joints[follower.joint].name);
            line(format!(
                "    <mimic joint=\"{leader}\" multiplier=\"{}\" offset=\"{}\"/>",
                follower.ratio, follower.offset
            ));
        }
        line("  </joint>".to_owned());
        Ok(())
    }

    /// The robot as MJCF, without shapes: bodies, joints with armature, damping and frictionloss, sites, equality of joints.
    pub fn to_mjcf(&self) -> String {
        let [x, y, z] = self.gravity;
        let mut out = format!(
            "<mujoco model=\"{}\">\n  <compiler angle=\"radian\"/>\n  <option gravity=\"{x} {y} {z}\"/>\n  <worldbody>\n",
            escaped(&self.name)
        );
        let base = self.body(None, BodyOrigin::Anywhere);
        let is_world = self.frames.iter().all(|frame| frame.joint.is_some() || frame.name == WORLD);
        if is_world && base.inertia.mass == 0.0 {
            self.write_children(&mut out, None, &base, 2);
        } else {
            self.write_body(&mut out, None, &base, &base.pose, 2);
        }
        out.push_str("  </worldbody>\n");
        let followers: Vec<String> =
            self.joints.iter().filter_map(|joint| Some(self.equality(joint, joint.follows?))).collect();
        if !followers.is_empty() {
            let _ = writeln!(out, "  <equality>\n{}\n  </equality>", followers.join("\n"));
        }
        out.push_str("</mujoco>\n");
        out
    }

    fn equality(&self, joint: &Joint, follower: super::Follower) -> String {
        format!(
            "    <joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{} {} 0 0 0\"/>",
            escaped(&joint.name),
            escaped(&self.joints[follower.joint].name),
            follower.offset,
            follower.ratio
        )
    }

    fn write_body(
        &self,
        out: &mut String,
        joint: Option<usize>,
        body: &WrittenBody,
        at: &Pose<f64>,
        depth: usize,
    ) {
        let indent = "  ".repeat(depth);
        let carried = joint.and_then(|joint| self.joints[joint].compensation()).filter(|part| *part != 0.0);
        let carried = carried.map_or_else(String::new, |part| format!(" gravcomp=\"{part}\""));
        let _ = writeln!(out, "{indent}<body name=\"{}\" {}{carried}>", escaped(body.name), mjcf_pose(at));
        if let Some(joint) = joint.map(|joint| &self.joints[joint]) {
            let pivot = inverse(&body.pose).position;
            let axis = mul3_transposed(&body.pose.rotation, [0.0, 0.0, 1.0]);
            let place = format!(" pos=\"{}\" axis=\"{}\"", numbers(&pivot), numbers(&axis));
            let _ = writeln!(out, "{indent}  {}", mjcf_joint(joint, &place));
        }
        if body.inertia.mass > 0.0 {
            let (centre, [xx, xy, yy, xz, yz, zz]) =
                (body.inertia.centre(), body.inertia.second_about_centre());
            let _ = writeln!(
                out,
                "{indent}  <inertial mass=\"{}\" pos=\"{}\" fullinertia=\"{xx} {yy} {zz} {xy} {xz} {yz}\"/>",
                body.inertia.mass,
                numbers(&centre)
            );
        }
        for (name, pose) in &body.frames {
            let _ = writeln!(out, "{indent}  <site name=\"{}\" {}/>", escaped(name), mjcf_pose(pose));
        }
        self.write_children(out, joint, body, depth + 1);
        let _ = writeln!(out, "{indent}</body>");
    }

    fn write_children(&self, out: &mut String, parent: Option<usize>, body: &WrittenBody, depth: usize) {
        for (k, joint) in self.joints.iter().enumerate().filter(|(_, joint)| joint.parent == parent) {
            let child = self.body(Some(k), BodyOrigin::Anywhere);
            let at = inverse(&body.pose).times(&joint.placement).times(&child.pose);
            self.write_body(out, Some(k), &child, &at, depth);
        }
    }

    /// The joints of an MJCF alone, with what resists their motion: armature, damping, frictionloss, range, for a file that has
    /// the bodies.
    pub fn to_mjcf_joints(&self) -> String {
        self.joints.iter().map(|joint| mjcf_joint(joint, "") + "\n").collect()
    }

    /// Mass, centre of mass and second moment about it, in the frame of the joint, armature, damping and dry friction of every
    /// body: a row for each joint. [`Model::with_parameters`] reads it.
    pub fn parameters_csv(&self) -> String {
        let mut out = format!("joint,{}\n", PARAMETERS.join(","));
        for joint in &self.joints {
            let (inertia, drive) = (&joint.inertia, &joint.drive);
            let mut row = vec![inertia.mass];
            row.extend(inertia.centre());
            row.extend(inertia.second_about_centre());
            row.extend([drive.armature, drive.damping, drive.dry_friction]);
            let row: Vec<String> = row.iter().map(f64::to_string).collect();
            let _ = writeln!(out, "{},{}", joint.name.replace([',', '"', '\n'], "_"), row.join(","));
        }
        out
    }

    /// The same robot with the parameters of a table, as [`Model::parameters_csv`] writes it: a row for each joint, in their
    /// order; columns that are not there keep what they were.
    ///
    /// # Errors
    /// `BadInput` naming row and column for another number of joints, a column that is none, or a number that no body has.
    pub fn with_parameters(&self, table: &Table) -> Result<Self, BadInput> {
        let n = self.n_joints();
        if table.n_rows() != n {
            return Err(BadInput::new(
                "rows",
                format!("{n}, one for each joint"),
                table.n_rows().to_string(),
            ));
        }
        let is_known =
            |column: &&Column| column.name == "joint" || PARAMETERS.contains(&column.name.as_str());
        if let Some(other) = table.columns().iter().find(|column| !is_known(column)) {
            let expected = format!("joint or one of {}", PARAMETERS.join(", "));
            return Err(BadInput::new("columns", expected, format!("\"{}\"", other.name)));
        }
        let mut model = self.clone();
        for (row, joint) in model.joints.iter_mut().enumerate() {
            let inertia = &joint.inertia;
            let mut values = [0.0; 13];
            values[0] = inertia.mass;
            values[1..4].copy_from_slice(&inertia.centre());
            values[4..10].copy_from_slice(&inertia.second_about_centre());
            values[10..].copy_from_slice(&[
                joint.drive.armature,
                joint.drive.damping,
                joint.drive.dry_friction,
            ]);
            for (name, value) in PARAMETERS.iter().zip(&mut values) {
                let Some(index) = table.index(name) else { continue };
                *value = table.columns()[index].values[row];
                let is_signed = name.starts_with("centre") || name.starts_with('i');
                if !(value.is_finite() && (is_signed || *value >= 0.0)) {
                    let expected = if is_signed { "a finite number" } else { "a finite number >= 0" };
                    let place = format!("{}: {name} of {}", table.row_name(row), joint.name);
                    return Err(BadInput::new(place, expected, table.shown(index, row)));
                }
            }
            let [mass, x, y, z, second @ .., armature, damping, dry_friction] = values;
            super::build::check_second(&second).map_err(|found| {
                let place = format!("{}: inertia of {}", table.row_name(row), joint.name);
                BadInput::new(place, "an inertia without negative principal value", found)
            })?;
            joint.inertia = Inertia::about_centre(mass, [x, y, z], second);
            (joint.drive.armature, joint.drive.damping, joint.drive.dry_friction) =
                (armature, damping, dry_friction);
        }
        Ok(model)
    }

    /// The body of a joint, or the base.
    fn body(&self, joint: Option<usize>, origin: BodyOrigin) -> WrittenBody<'_> {
        let is_given = |frame: &&Frame| match origin {
            BodyOrigin::AtJoint => true,
            // MJCF has a world of its own.
            BodyOrigin::Anywhere => !(frame.name.ends_with(PIVOT) || joint.is_none() && frame.name == WORLD),
        };
        let own: Vec<&Frame> =
            self.frames.iter().filter(|frame| frame.joint == joint).filter(is_given).collect();
        let fits = |frame: &&&Frame| origin == BodyOrigin::Anywhere || frame.pose.position == [0.0; 3];
        let main = own.iter().find(fits).copied();
        let fallback = joint.map_or("base", |joint| self.joints[joint].name.as_str());
        let (name, pose) = main.map_or((fallback, Pose::IDENTITY), |frame| (frame.name.as_str(), frame.pose));
        let back = inverse(&pose);
        let whole = joint.map_or(&self.base, |joint| &self.joints[joint].inertia);
        let others = own.iter().filter(|frame| frame.name != name);
        WrittenBody {
            name,
            pose,
            inertia: whole.placed(&back.rotation, back.position),
            frames: others.map(|frame| (frame.name.as_str(), back.times(&frame.pose))).collect(),
        }
    }
}

fn mjcf_joint(joint: &Joint, place: &str) -> String {
    let kind = if joint.kind == JointKind::Revolute { "hinge" } else { "slide" };
    let drive = &joint.drive;
    let mut text = format!("<joint name=\"{}\" type=\"{kind}\"{place}", escaped(&joint.name));
    if let Some([low, high]) = drive.range {
        text.push_str(&format!(" limited=\"true\" range=\"{low} {high}\""));
    }
    if let Some(most) = drive.effort_limit {
        text.push_str(&format!(" actuatorfrclimited=\"true\" actuatorfrcrange=\"-{most} {most}\""));
    }
    if drive.stiffness != 0.0 {
        text.push_str(&format!(
            " stiffness=\"{}\" springref=\"{}\"",
            drive.stiffness, drive.spring_reference
        ));
    }
    text.push_str(&format!(
        " armature=\"{}\" damping=\"{}\" frictionloss=\"{}\"/>",
        drive.armature, drive.damping, drive.dry_friction
    ));
    text
}

/// A link, and its frames as links fixed to it.
fn write_link(out: &mut String, body: &WrittenBody) {
    let name = escaped(body.name);
    let (centre, [xx, xy, yy, xz, yz, zz]) = (body.inertia.centre(), body.inertia.second_about_centre());
    let _ = writeln!(
        out,
        "  <link name=\"{name}\">\n    <inertial>\n      <origin xyz=\"{}\"/>\n      <mass value=\"{}\"/>\n      \
         <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>\n  </link>",
        numbers(&centre),
        body.inertia.mass
    );
    for (frame, pose) in &body.frames {
        let frame = escaped(frame);
        let _ = writeln!(
            out,
            "  <link name=\"{frame}\"/>\n  <joint name=\"{frame}/fixed\" type=\"fixed\">\n    <parent link=\"{name}\"/>\n    \
             <child link=\"{frame}\"/>\n    {}\n  </joint>",
            urdf_origin(pose)
        );
    }
}

fn inverse(pose: &Pose<f64>) -> Pose<f64> {
    let [x, y, z] = pose.rotation;
    let rotation = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
    let position = mul3_transposed(&pose.rotation, pose.position).map(|p| 0.0 - p);
    Pose { rotation, position }
}

fn numbers(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    texts.join(" ")
}

fn urdf_origin(pose: &Pose<f64>) -> String {
    format!(
        "<origin xyz=\"{}\" rpy=\"{}\"/>",
        numbers(&pose.position),
        numbers(&roll_pitch_yaw(&pose.rotation))
    )
}

/// Angles of R = R_z(yaw) R_y(pitch) R_x(roll). Roll is taken from what is left after yaw, so that it is accurate where pitch is
/// a right angle too.
fn roll_pitch_yaw(r: &Mat3<f64>) -> Vec3<f64> {
    let yaw = if r[0][0] == 0.0 && r[1][0] == 0.0 { 0.0 } else { r[1][0].atan2(r[0][0]) };
    let (sin, cos) = yaw.sin_cos();
    let pitch = (-r[2][0]).atan2(cos * r[0][0] + sin * r[1][0]);
    let roll = (sin * r[0][2] - cos * r[1][2]).atan2(cos * r[1][1] - sin * r[0][1]);
    [roll, pitch, yaw]
}

fn mjcf_pose(pose: &Pose<f64>) -> String {
    format!("pos=\"{}\" quat=\"{}\"", numbers(&pose.position), numbers(&quaternion(&pose.rotation)))
}

/// w, x, y, z of a rotation, by the largest of the four (Shepperd 1978).
fn quaternion(r: &Mat3<f64>) -> [f64; 4] {
    let trace = r[0][0] + r[1][1] + r[2][2];
    let squares = [trace, 2.0 * r[0][0] - trace, 2.0 * r[1][1] - trace, 2.0 * r[2][2] - trace];
    let largest = (0..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
    let [a, b, c] = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]];
    let [d, e, f] = [r[1][0] + r[0][1], r[2][0] + r[0][2], r[2][1] + r[1][2]];
    let one = 1.0 + squares[largest];
    let q = match largest {
        0 => [one, a, b, c],
        1 => [a, one, d, e],
        2 => [b, d, one, f],
        _ => [c, e, f, one],
    };
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / length)
}

/// Text escaped for XML attributes.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
