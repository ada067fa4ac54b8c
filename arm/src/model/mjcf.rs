//! The part of MJCF that arms need: bodies with `<inertial>`, hinges and slides with armature, damping, friction and range,
//! default classes, sites, and equality of joints. What would change the motion and is not read is an error, not a surprise.
//!
//! # Reference
//! mujoco.readthedocs.io, XML reference.

use std::collections::BTreeMap;

use super::Model;
use super::build::{check_second, unit};
use super::description::{Description, Drive, JointDescription, JointKind, Link, Mimic};
use super::xml::{Check, Node, Place, parse};
use crate::spatial::{Inertia, Mat3, Pose, Vec3, cross};

/// Attributes that each class gives to joints.
type Classes<'t> = BTreeMap<&'t str, BTreeMap<&'t str, &'t str>>;

/// What `<compiler>` says about how the rest is read.
struct Compiler {
    /// rad for one unit of an angle.
    angle: f64,
    /// Axes of `euler`, in turn.
    sequence: [char; 3],
    ranges_limit: bool,
}

/// A joint with its pivot [m] and axis in the body that it moves.
struct Hinge {
    name: String,
    kind: JointKind,
    pivot: Vec3<f64>,
    axis: Vec3<f64>,
    drive: Drive,
}

struct Reader<'f, 'a, 'i> {
    place: Place<'f>,
    compiler: Compiler,
    classes: Classes<'a>,
    description: Description,
    /// Bodies that wait for their turn: their node, parent link, and class.
    waiting: Vec<(Node<'a, 'i>, usize, &'a str)>,
}

pub(super) fn read(text: &str, file: &str) -> Check<Model> {
    let document = parse(text, file)?;
    let (root, place) = (document.root_element(), Place { file });
    if root.tag_name().name() != "mujoco" {
        return Err(place.error(&root, "<mujoco>", format!("<{}>", root.tag_name().name())));
    }
    if let Some(node) = root.descendants().find(|node| node.tag_name().name() == "include") {
        return Err(place
            .error(&node, "a file that stands alone", "<include>")
            .hint("paste the other file here"));
    }
    let compiler = compiler(&place, &root)?;
    let mut classes = Classes::from([("main", BTreeMap::new())]);
    for node in place.children(&root, "default") {
        read_class(&node, node.attribute("class").unwrap_or("main"), &BTreeMap::new(), &mut classes);
    }
    let gravity = match place.child(&root, "option")? {
        Some(node) => place.array(&node, "gravity")?.unwrap_or([0.0, 0.0, -9.81]),
        None => [0.0, 0.0, -9.81],
    };
    let world =
        place.child(&root, "worldbody")?.ok_or_else(|| place.error(&root, "a <worldbody>", "none"))?;
    let name = root.attribute("model").unwrap_or("robot").to_owned();
    let link = Link { name: "world".to_owned(), place: place.of(&world), inertia: None };
    let description = Description {
        file: file.to_owned(),
        name,
        links: vec![link],
        joints: Vec::new(),
        sites: Vec::new(),
        gravity,
    };
    let mut reader = Reader { place, compiler, classes, description, waiting: Vec::new() };
    reader.queue(&world, 0, "main");
    while let Some((node, parent, class)) = reader.waiting.pop() {
        reader.body(&node, parent, class)?;
    }
    for equality in reader.place.children(&root, "equality") {
        reader.equality(&equality)?;
    }
    super::build::build(reader.description)
}

fn compiler(place: &Place, root: &Node) -> Check<Compiler> {
    let mut compiler =
        Compiler { angle: std::f64::consts::PI / 180.0, sequence: ['x', 'y', 'z'], ranges_limit: true };
    for node in place.children(root, "compiler") {
        match node.attribute("angle") {
            None | Some("degree") => {}
            Some("radian") => compiler.angle = 1.0,
            Some(other) => return Err(place.error(&node, "angle degree or radian", other)),
        }
        compiler.ranges_limit = node.attribute("autolimits") != Some("false");
        if let Some(text) = node.attribute("eulerseq") {
            let axes: Vec<char> = text.chars().collect();
            let known = axes.iter().all(|axis| "xyzXYZ".contains(*axis));
            compiler.sequence = <[char; 3]>::try_from(axes)
                .ok()
                .filter(|_| known)
                .ok_or_else(|| place.error(&node, "eulerseq of three letters x, y, z", text))?;
        }
    }
    Ok(compiler)
}

/// Joint attributes of a class and of those within it.
fn read_class<'a>(
    node: &Node<'a, '_>,
    name: &'a str,
    outer: &BTreeMap<&'a str, &'a str>,
    classes: &mut Classes<'a>,
) {
    let mut own = outer.clone();
    for joint in node.children().filter(|child| child.tag_name().name() == "joint") {
        own.extend(joint.attributes().map(|attribute| (attribute.name(), attribute.value())));
    }
    for inner in node.children().filter(|child| child.tag_name().name() == "default") {
        if let Some(name) = inner.attribute("class") {
            read_class(&inner, name, &own, classes);
        }
    }
    classes.insert(name, own);
}

impl<'a, 'i> Reader<'_, 'a, 'i> {
    /// Puts the bodies within `node` in front of those that wait.
    fn queue(&mut self, node: &Node<'a, 'i>, link: usize, class: &'a str) {
        let inner: Vec<_> = self.place.children(node, "body").collect();
        self.waiting.extend(inner.into_iter().rev().map(|body| (body, link, class)));
    }

    fn body(&mut self, node: &Node<'a, 'i>, parent: usize, class: &'a str) -> Check<()> {
        let class = node.attribute("childclass").unwrap_or(class);
        if self.place.children(node, "freejoint").next().is_some() {
            return Err(self.place.error(node, "a body on hinges, slides or fixed", "a <freejoint>"));
        }
        let n = self.description.links.len();
        let name = node.attribute("name").map_or_else(|| format!("body_{n}"), str::to_owned);
        let mut origin = self.pose(node)?;
        // Several joints of one body: links without mass between them.
        let joints: Vec<Node> = self.place.children(node, "joint").collect();
        let mut at = parent;
        for (k, joint) in joints.iter().enumerate() {
            let Hinge { name: joint_name, kind, pivot, axis, drive } = self.joint(joint, class, &name, k)?;
            let place = self.place.of(joint);
            let between = self.description.links.len();
            self.description.links.push(Link {
                name: if k + 1 == joints.len() {
                    format!("{name}/pivot")
                } else {
                    format!("{name}/pivot_{k}")
                },
                place: place.clone(),
                inertia: Some(Inertia::ZERO),
            });
            let pivot = Pose { rotation: Pose::IDENTITY.rotation, position: pivot };
            self.description.joints.push(JointDescription {
                name: joint_name,
                place,
                kind: Some(kind),
                parent: at,
                child: between,
                origin: origin.times(&pivot),
                axis,
                drive,
                mimic: None,
            });
            let back = pivot.position.map(|x| -x);
            (at, origin) = (between, Pose { rotation: pivot.rotation, position: back });
        }
        let link = self.description.links.len();
        let inertia = self.inertia(node)?;
        if inertia.is_none() && !joints.is_empty() && self.place.children(node, "geom").next().is_some() {
            return Err(self.place.error(node, "an <inertial>", "geoms only").hint(
                "inertias from shapes are not computed; save the compiled model (mj_saveLastXML), which has them",
            ));
        }
        self.description.links.push(Link { name: name.clone(), place: self.place.of(node), inertia });
        self.description.joints.push(JointDescription {
            name: format!("{name}/fixed"),
            place: self.place.of(node),
            kind: None,
            parent: at,
            child: link,
            origin,
            axis: [0.0, 0.0, 1.0],
            drive: Drive::default(),
            mimic: None,
        });
        for site in self.place.children(node, "site") {
            if let Some(name) = site.attribute("name") {
                let pose = self.pose(&site)?;
                self.description.sites.push((name.to_owned(), link, pose));
            }
        }
        self.queue(node, link, class);
        Ok(())
    }

    /// The joint number `k` of `body`.
    fn joint(&self, node: &Node<'a, '_>, class: &'a str, body: &str, k: usize) -> Check<Hinge> {
        let class = node.attribute("class").unwrap_or(class);
        let Some(defaults) = self.classes.get(class) else {
            return Err(self.place.error(node, "a class of <default>", format!("\"{class}\"")));
        };
        let text = |name: &str| node.attribute(name).or_else(|| defaults.get(name).copied());
        let numbers = |name: &str, n: usize| -> Check<Option<Vec<f64>>> {
            let Some(text) = text(name) else { return Ok(None) };
            let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
            let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
            match numbers {
                Some(numbers) if numbers.len() == n => Ok(Some(numbers)),
                _ => Err(self.place.error(
                    node,
                    &format!("{n} finite numbers in {name}"),
                    format!("\"{text}\""),
                )),
            }
        };
        let kind = match text("type") {
            None | Some("hinge") => JointKind::Revolute,
            Some("slide") => JointKind::Prismatic,
            Some(other) => return Err(self.place.error(node, "type hinge or slide", format!("\"{other}\""))),
        };
        for (name, neutral) in [("stiffness", 0.0), ("ref", 0.0)] {
            if numbers(name, 1)?.is_some_and(|x| x[0] != neutral) {
                return Err(self.place.error(node, &format!("no {name}"), text(name).unwrap_or_default()));
            }
        }
        let not_negative = |name: &str| match numbers(name, 1)?.map_or(0.0, |x| x[0]) {
            x if x < 0.0 => Err(self.place.error(node, &format!("{name} >= 0"), x.to_string())),
            x => Ok(x),
        };
        let scale = if kind == JointKind::Revolute { self.compiler.angle } else { 1.0 };
        let is_limited = match text("limited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.compiler.ranges_limit,
        };
        let range = match numbers("range", 2)? {
            Some(range) if is_limited && range[0] > range[1] => {
                return Err(self.place.error(node, "a range that ascends", format!("{range:?}")));
            }
            Some(range) if is_limited => Some([range[0] * scale, range[1] * scale]),
            _ => None,
        };
        let axis = numbers("axis", 3)?.map_or([0.0, 0.0, 1.0], |a| [a[0], a[1], a[2]]);
        let axis = unit(axis)
            .ok_or_else(|| self.place.error(node, "an axis longer than zero", format!("{axis:?}")))?;
        let force = numbers("actuatorfrcrange", 2)?.map(|range| range[1].abs().min(range[0].abs()));
        let drive = Drive {
            range,
            speed_limit: None,
            effort_limit: force,
            armature: not_negative("armature")?,
            damping: not_negative("damping")?,
            dry_friction: not_negative("frictionloss")?,
        };
        let pivot = numbers("pos", 3)?.map_or([0.0; 3], |p| [p[0], p[1], p[2]]);
        let name = node.attribute("name").map_or_else(|| format!("{body}/joint_{k}"), str::to_owned);
        Ok(Hinge { name, kind, pivot, axis, drive })
    }

    fn inertia(&self, body: &Node) -> Check<Option<Inertia<f64>>> {
        let place = &self.place;
        let Some(node) = place.child(body, "inertial")? else { return Ok(None) };
        let mass = place.required(&node, "mass")?;
        if mass < 0.0 {
            return Err(place.error(&node, "a mass >= 0 kg", mass.to_string()));
        }
        let second = match (place.array::<6>(&node, "fullinertia")?, place.array::<3>(&node, "diaginertia")?)
        {
            (Some([xx, yy, zz, xy, xz, yz]), _) => [xx, xy, yy, xz, yz, zz],
            (None, Some([xx, yy, zz])) => [xx, 0.0, yy, 0.0, 0.0, zz],
            (None, None) => return Err(place.error(&node, "diaginertia or fullinertia", "neither")),
        };
        check_second(&second)
            .map_err(|found| place.error(&node, "an inertia without negative principal value", found))?;
        let pose = self.pose(&node)?;
        Ok(Some(Inertia { mass, first: [0.0; 3], second }.placed(&pose.rotation, pose.position)))
    }

    /// `pos` and one of the ways to say how a frame is turned.
    fn pose(&self, node: &Node) -> Check<Pose<f64>> {
        let place = &self.place;
        let position = place.array(node, "pos")?.unwrap_or_default();
        let longer = |what: &str| place.error(node, &format!("{what} longer than zero"), "zero");
        let rotation = if let Some([w, x, y, z]) = place.array::<4>(node, "quat")? {
            let length = (w * w + x * x + y * y + z * z).sqrt();
            let [w, x, y, z] =
                if length > 1e-12 { [w, x, y, z].map(|c| c / length) } else { return Err(longer("a quat")) };
            rotation_of(w, [x, y, z])
        } else if let Some([x, y, z, angle]) = place.array::<4>(node, "axisangle")? {
            let axis = unit([x, y, z]).ok_or_else(|| longer("an axis"))?;
            about(axis, angle * self.compiler.angle)
        } else if let Some(angles) = place.array::<3>(node, "euler")? {
            self.euler(angles)
        } else if let Some([a, b, c, d, e, f]) = place.array::<6>(node, "xyaxes")? {
            let x = unit([a, b, c]).ok_or_else(|| longer("xyaxes"))?;
            let z = unit(cross(x, [d, e, f])).ok_or_else(|| longer("xyaxes"))?;
            let y = cross(z, x);
            [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
        } else if node.has_attribute("zaxis") {
            return Err(place.error(node, "quat, axisangle, euler or xyaxes", "zaxis"));
        } else {
            Pose::IDENTITY.rotation
        };
        Ok(Pose { rotation, position })
    }

    fn euler(&self, angles: Vec3<f64>) -> Mat3<f64> {
        let mut turned = Pose::IDENTITY;
        for (axis, angle) in self.compiler.sequence.iter().zip(angles) {
            let unit = match axis.to_ascii_lowercase() {
                'x' => [1.0, 0.0, 0.0],
                'y' => [0.0, 1.0, 0.0],
                _ => [0.0, 0.0, 1.0],
            };
            let step = Pose { rotation: about(unit, angle * self.compiler.angle), position: [0.0; 3] };
            // Small letters turn with the frame, capitals about fixed axes.
            turned = if axis.is_ascii_lowercase() { turned.times(&step) } else { step.times(&turned) };
        }
        turned.rotation
    }

    /// `<joint joint1 joint2 polycoef>`: joint1 follows joint2.
    fn equality(&mut self, equality: &Node) -> Check<()> {
        for node in equality.children().filter(Node::is_element) {
            if node.tag_name().name() != "joint" {
                let found = format!("<{}>", node.tag_name().name());
                return Err(self.place.error(&node, "an equality of joints", found));
            }
            let follower = self.place.text(&node, "joint1")?;
            let [offset, ratio, a, b, c] =
                self.place.array(&node, "polycoef")?.unwrap_or([0.0, 1.0, 0.0, 0.0, 0.0]);
            if [a, b, c] != [0.0; 3] {
                return Err(self.place.error(
                    &node,
                    "polycoef of first order",
                    format!("{:?}", [offset, ratio, a, b, c]),
                ));
            }
            let leader = self.place.text(&node, "joint2")?.to_owned();
            let joint = self.description.joints.iter_mut().find(|joint| joint.name == follower);
            match joint {
                Some(joint) => joint.mimic = Some(Mimic { joint: leader, ratio, offset }),
                None => {
                    return Err(self.place.error(&node, "joint1 of this robot", format!("\"{follower}\"")));
                }
            }
        }
        Ok(())
    }
}

/// Rotation of the unit quaternion w + x i + y j + z k.
fn rotation_of(w: f64, [x, y, z]: Vec3<f64>) -> Mat3<f64> {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Rotation by `angle` [rad] about a unit vector.
fn about(axis: Vec3<f64>, angle: f64) -> Mat3<f64> {
    let (sin, cos) = (0.5 * angle).sin_cos();
    rotation_of(cos, axis.map(|x| sin * x))
}
