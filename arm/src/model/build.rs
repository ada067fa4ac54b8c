//! From a description to a model: links without a joint merged, frames turned, loops and masses checked.

use std::collections::{BTreeMap, BTreeSet};

use hysteron_base::BadInput;
use nalgebra::Matrix3;

use super::description::{Description, JointDescription, JointKind, Link, Mimic};
use super::xml::Check;
use super::{Follower, Frame, Joint, MOST_JOINTS, Model, Weightless};
use crate::spatial::{Inertia, Mat3, Pose, Sym3, Vec3, cross, dot3};

/// Part of the greatest principal inertia by which rounded numbers of a file may fall below zero.
const ROUNDED: f64 = 1e-6;

pub(super) fn build(description: Description) -> Check<Model> {
    let children = children_of(&description)?;
    let root = root_of(&description)?;
    let mut model = Model {
        name: description.name.clone(),
        joints: Vec::new(),
        frames: Vec::new(),
        gravity: description.gravity,
        base: Inertia::ZERO,
    };
    let mut mimics = Vec::new();
    let mut reached = BTreeSet::new();
    // Depth first, in the order of the file: a link, the joint before it, and the body and pose that the joint stands in.
    let mut waiting = vec![(root, None, None, Pose::IDENTITY)];
    while let Some((link, via, body, pose)) = waiting.pop() {
        let (body, pose) = match via {
            None => (body, pose),
            Some(j) => {
                let joint: &JointDescription = &description.joints[j];
                let at = pose.times(&joint.origin);
                match joint.kind {
                    None => (body, at),
                    Some(kind) => {
                        mimics.push(joint.mimic.clone().map(|mimic| (j, mimic)));
                        model.open(joint, kind, body, &at)
                    }
                }
            }
        };
        reached.insert(link);
        model.carry(&description.links[link], body, pose);
        for (name, _, site) in description.sites.iter().filter(|(_, of, _)| *of == link) {
            model.frames.push(Frame { name: name.clone(), joint: body, pose: pose.times(site) });
        }
        waiting
            .extend(children[link].iter().rev().map(|&j| (description.joints[j].child, Some(j), body, pose)));
    }
    if let Some(lost) = (0..description.links.len()).find(|link| !reached.contains(link)) {
        return Err(closed_loop(&description, lost));
    }
    check_names(&description, &model)?;
    check_joints(&description, &model)?;
    for (joint, mimic) in mimics.iter().enumerate() {
        if let Some((j, mimic)) = mimic {
            model.joints[joint].follows = Some(follower(&description, &model, &mimics, *j, mimic)?);
        }
    }
    Ok(model)
}

/// Joints by the link that they start at.
fn children_of(description: &Description) -> Check<Vec<Vec<usize>>> {
    let mut children = vec![Vec::new(); description.links.len()];
    let mut parent: Vec<Option<usize>> = vec![None; description.links.len()];
    for (j, joint) in description.joints.iter().enumerate() {
        if let Some(first) = parent[joint.child].replace(j) {
            let link = &description.links[joint.child].name;
            let found = format!("link \"{link}\" as child of \"{}\" too", description.joints[first].name);
            return Err(BadInput::new(&joint.place, "a tree, in which a link has one parent", found)
                .hint("closed loops are not simulated: cut the loop at one joint"));
        }
        children[joint.parent].push(j);
    }
    Ok(children)
}

fn root_of(description: &Description) -> Check<usize> {
    let is_child = |link: usize| description.joints.iter().any(|joint| joint.child == link);
    let roots: Vec<usize> = (0..description.links.len()).filter(|link| !is_child(*link)).collect();
    let file = &description.file;
    match roots[..] {
        [root] => Ok(root),
        [] if description.links.is_empty() => Err(BadInput::new(file, "links", "none")),
        [] => Err(closed_loop(description, 0)),
        [a, b, ..] => {
            let name = |link: usize| &description.links[link].name;
            let found = format!("{}: \"{}\", \"{}\"", roots.len(), name(a), name(b));
            Err(BadInput::new(file, "one link without parent, the base", found)
                .hint("connect them by fixed joints, or remove those that are not used"))
        }
    }
}

fn closed_loop(description: &Description, link: usize) -> BadInput {
    let link = &description.links[link];
    BadInput::new(
        &link.place,
        "a tree that starts at the base",
        format!("link \"{}\" in a closed loop", link.name),
    )
    .hint("closed loops are not simulated: cut the loop at one joint")
}

impl Model {
    /// Adds the body that `joint` carries; returns its number and the pose of the child link in it.
    fn open(
        &mut self,
        joint: &JointDescription,
        kind: JointKind,
        parent: Option<usize>,
        at: &Pose<f64>,
    ) -> (Option<usize>, Pose<f64>) {
        let turned = Pose { rotation: axes_with_z(joint.axis), position: [0.0; 3] };
        let [x, y, z] = turned.rotation;
        self.joints.push(Joint {
            name: joint.name.clone(),
            kind,
            parent,
            placement: at.times(&turned),
            inertia: Inertia::ZERO,
            drive: joint.drive.clone(),
            follows: None,
            weightless: Weightless::default(),
        });
        let back = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
        (Some(self.joints.len() - 1), Pose { rotation: back, position: [0.0; 3] })
    }

    /// Adds a link that stands at `pose` in a body.
    fn carry(&mut self, link: &Link, body: Option<usize>, pose: Pose<f64>) {
        let inertia = link.inertia.unwrap_or(Inertia::ZERO).placed(&pose.rotation, pose.position);
        if let (Some(body), true) = (body, link.compensation != 0.0) {
            let weightless = &mut self.joints[body].weightless;
            *weightless = weightless.plus(&Weightless::part(&inertia, link.compensation));
        }
        let whole = body.map_or(&mut self.base, |body| &mut self.joints[body].inertia);
        *whole = whole.plus(&inertia);
        self.frames.push(Frame { name: link.name.clone(), joint: body, pose });
    }
}

fn check_names(description: &Description, model: &Model) -> Check<()> {
    let mut names = BTreeMap::new();
    for joint in &description.joints {
        if names.insert(&joint.name, ()).is_some() {
            let found = format!("\"{}\" twice", joint.name);
            return Err(BadInput::new(&joint.place, "names of joints that differ", found));
        }
    }
    let mut names = BTreeSet::new();
    match model.frames.iter().find(|frame| !names.insert(&frame.name)) {
        Some(frame) => {
            let found = format!("\"{}\" twice", frame.name);
            Err(BadInput::new(&description.file, "names of links and sites that differ", found))
        }
        None => Ok(()),
    }
}

fn check_joints(description: &Description, model: &Model) -> Check<()> {
    let n = model.joints.len();
    if n == 0 || n > MOST_JOINTS {
        let found = if n == 0 { "none".to_owned() } else { n.to_string() };
        return Err(BadInput::new(&description.file, format!("1 to {MOST_JOINTS} joints that move"), found));
    }
    let mut carried: Vec<f64> = model.joints.iter().map(|joint| joint.inertia.mass).collect();
    for j in (0..n).rev() {
        if let Some(parent) = model.joints[j].parent {
            carried[parent] += carried[j];
        }
    }
    for (joint, carried) in model.joints.iter().zip(carried) {
        let Some(described) = description.joints.iter().find(|d| d.name == joint.name) else { continue };
        let link = &description.links[described.child];
        let missing = link.inertia.is_none() && joint.inertia.mass == 0.0;
        if missing || carried == 0.0 {
            let found = if missing { "none" } else { "no mass on it, nor on what it carries" };
            return Err(BadInput::new(
                &link.place,
                format!("an <inertial> with a mass, because joint \"{}\" moves this link", joint.name),
                found,
            ));
        }
    }
    Ok(())
}

fn follower(
    description: &Description,
    model: &Model,
    mimics: &[Option<(usize, Mimic)>],
    j: usize,
    mimic: &Mimic,
) -> Check<Follower> {
    let bad = |expected: &str| {
        BadInput::new(&description.joints[j].place, expected, format!("mimic of \"{}\"", mimic.joint))
    };
    let joint = model.joint(&mimic.joint).ok_or_else(|| bad("mimic of a joint that moves"))?;
    if mimics[joint].is_some() {
        return Err(bad("mimic of another joint that follows none itself"));
    }
    Ok(Follower { joint, ratio: mimic.ratio, offset: mimic.offset })
}

/// Principal values of a symmetric tensor, ascending.
pub(super) fn principal(s: &Sym3<f64>) -> Vec3<f64> {
    let values = Matrix3::new(s[0], s[1], s[3], s[1], s[2], s[4], s[3], s[4], s[5]).symmetric_eigenvalues();
    let mut values = [values[0], values[1], values[2]];
    values.sort_by(f64::total_cmp);
    values
}

/// Refuses a tensor with a negative principal value; says which.
pub(super) fn check_second(second: &Sym3<f64>) -> Result<(), String> {
    let [least, _, most] = principal(second);
    if least < -ROUNDED * most.abs() || most < 0.0 { Err(format!("{least:.3e} kg m²")) } else { Ok(()) }
}

/// `a` with length one, unless it has none.
pub(super) fn unit(a: Vec3<f64>) -> Option<Vec3<f64>> {
    let length = dot3(a, a).sqrt();
    // Axes of one exact unit stay as they are.
    (length > 1e-12 && length.is_finite()).then(|| if length == 1.0 { a } else { a.map(|x| x / length) })
}

/// Rotation whose third column is the unit vector `z`; exact where `z` is an axis.
pub(super) fn axes_with_z(z: Vec3<f64>) -> Mat3<f64> {
    let mut least = 0;
    for c in 1..3 {
        if z[c].abs() < z[least].abs() {
            least = c;
        }
    }
    let mut x = z.map(|component| -z[least] * component);
    x[least] += 1.0;
    let length = dot3(x, x).sqrt();
    let x = x.map(|component| component / length);
    let y = cross(z, x);
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
}
