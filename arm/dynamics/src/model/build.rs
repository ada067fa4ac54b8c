//! From a description to a model: links without a joint merged, frames turned, loops and masses checked.

use std::collections::{BTreeMap, BTreeSet};

use hysteron_base::BadInput;
use hysteron_base::plausible_range::{DAMPING, DRY_FRICTION, INERTIA, LENGTH, MASS, RATIO};
use nalgebra::Matrix3;

use super::description::{Description, JointDescription, JointKind, Link, Mimic};
use super::xml::Check;
use super::{Follower, Frame, Joint, MAX_JOINTS, Model, Notes, Weightless};
use crate::spatial::{Inertia, Mat3, Pose, Sym3, Vec3, cross, dot3};

/// Part of the greatest principal inertia by which rounded numbers of a file may fall below zero.
const ROUNDED: f64 = 1e-6;

/// Radius of gyration [m] below which a body is a point: numbers below are rounding.
const POINT: f64 = 1e-6;

pub(super) fn build(description: Description) -> Check<Model> {
    check_count(&description)?;
    check_plausible(&description)?;
    let children = children_of(&description)?;
    let root = root_of(&description)?;
    let mut sites = vec![Vec::new(); description.links.len()];
    for (name, link, pose) in &description.sites {
        sites[*link].push((name, pose));
    }
    let mut model = Model {
        name: description.name.clone(),
        joints: Vec::new(),
        frames: Vec::new(),
        gravity: description.gravity,
        base: Inertia::ZERO,
        notes: Notes { welded: description.free.clone(), warnings: Vec::new() },
    };
    let mut moves = vec![false; description.links.len()];
    let mut mimics = Vec::new();
    let mut reached = BTreeSet::new();
    // Depth first, in the order of the file: a link, the joint before it, and the parent body and pose of the joint.
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
        moves[link] = body.is_some();
        for (name, site) in &sites[link] {
            model.frames.push(Frame { name: (*name).clone(), joint: body, pose: pose.times(site) });
        }
        waiting
            .extend(children[link].iter().rev().map(|&j| (description.joints[j].child, Some(j), body, pose)));
    }
    if let Some(lost) = (0..description.links.len()).find(|link| !reached.contains(link)) {
        return Err(closed_loop(&description, lost));
    }
    check_names(&description, &model)?;
    for (link, fault) in &description.faults {
        if moves[*link] {
            return Err(fault.clone());
        }
        model.notes.warnings.push(format!("{fault}; the link does not move, so that nothing depends on it"));
    }
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

/// Refuses numbers that no machine has.
fn check_plausible(description: &Description) -> Check<()> {
    for link in &description.links {
        let Some(inertia) = link.inertia else { continue };
        MASS.check(&link.place, inertia.mass)?;
        LENGTH.check_all(&link.place, &inertia.centre())?;
        INERTIA.check_all(&link.place, &inertia.second_about_centre())?;
    }
    for joint in &description.joints {
        LENGTH.check_all(&joint.place, &joint.origin.position)?;
        DAMPING.check(&joint.place, joint.drive.damping)?;
        DRY_FRICTION.check(&joint.place, joint.drive.dry_friction)?;
        INERTIA.check(&joint.place, joint.drive.armature)?;
        if let Some(mimic) = &joint.mimic {
            RATIO.check_all(&joint.place, &[mimic.ratio, mimic.offset])?;
        }
        if let (Some(JointKind::Prismatic), Some(range)) = (joint.kind, joint.drive.range) {
            LENGTH.check_all(&joint.place, &range)?;
        }
    }
    description.sites.iter().try_for_each(|(name, _, pose)| {
        LENGTH.check_all(&format!("{}: site[{name}]", description.file), &pose.position)
    })
}

fn root_of(description: &Description) -> Check<usize> {
    let mut is_child = vec![false; description.links.len()];
    description.joints.iter().for_each(|joint| is_child[joint.child] = true);
    let roots: Vec<usize> = (0..description.links.len()).filter(|link| !is_child[*link]).collect();
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

    /// Adds a link at `pose` in a body.
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

/// Refuses robots without a joint and with too many, before work is done for each.
fn check_count(description: &Description) -> Check<()> {
    let n = description.joints.iter().filter(|joint| joint.kind.is_some()).count();
    if (1..=MAX_JOINTS).contains(&n) || description.links.is_empty() {
        return Ok(());
    }
    let found = if n == 0 { "none".to_owned() } else { n.to_string() };
    let bad = BadInput::new(&description.file, format!("1 to {MAX_JOINTS} joints that move"), found);
    Err(if n == 0 { bad } else { bad.hint("make joints fixed that are not needed, as those of fingers") })
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

/// Refuses a tensor with a negative principal value, with its value.
pub(super) fn check_second(second: &Sym3<f64>) -> Result<(), String> {
    check_inertia(0.0, second)
}

/// Refuses the tensor of a mass [kg] with a negative principal value, with its value. What would be the tensor of the same
/// mass within [`POINT`] is zero but for rounding.
pub(super) fn check_inertia(mass: f64, second: &Sym3<f64>) -> Result<(), String> {
    let [least, _, most] = principal(second);
    let rounding = (ROUNDED * most.abs()).max(mass * POINT * POINT);
    let is_negative = least < -rounding || (most < 0.0 && mass == 0.0);
    if is_negative { Err(format!("{least:.3e} kg m²")) } else { Ok(()) }
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
