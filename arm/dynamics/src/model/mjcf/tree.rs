//! The tree of bodies: frames and replicas resolved, joints, masses and sites collected.

use std::rc::Rc;

use hysteron_base::BadInput;

use super::super::build::check_second;
use super::super::description::{FreeJoint, JointDescription, JointLimits, Link};
use super::super::xml::Check;
use super::assets::Assets;
use super::attributes::{Attributes, Classes, MAIN, entry_of};
use super::element::{MjcfElement, brief};
use super::geom;
use super::joint::{Hinge, hinge};
use super::mass::Mass;
use super::orientation::{about, euler, pose, segment};
use super::schema::{self, MjcfEntry};
use super::settings::{InertiaSource, Settings};
use crate::JointKind;
use crate::spatial::{Inertia, Pose};

/// Elements that replicas may make of a file.
const MAX_PLACED: usize = 200_000;

/// A document with its settings, classes and assets.
pub(super) struct MjcfTree<'a> {
    pub root: &'a MjcfElement,
    pub settings: Settings,
    pub classes: &'a Classes<'a>,
    pub assets: Assets<'a>,
}

/// Where elements are put: the frame around them in their body, their class, and what is added to their names.
#[derive(Debug, Clone)]
struct Around<'a> {
    pose: Pose<f64>,
    class: &'a str,
    prefix: Rc<str>,
    suffix: Rc<str>,
    /// Number of their document.
    source: usize,
}

impl Around<'_> {
    fn named(&self, name: &str) -> String {
        format!("{}{name}{}", self.prefix, self.suffix)
    }
}

/// Who carries the gravity compensation of what a body carries: joints whose actuators do, and others.
#[derive(Debug, Clone, Copy, Default)]
struct Carriers {
    actuated: bool,
    passive: bool,
}

/// A body that waits for its turn.
struct Waiting<'a> {
    element: &'a MjcfElement,
    parent: usize,
    around: Around<'a>,
    carriers: Carriers,
}

/// Contents of a body, its frames and its replicas.
#[derive(Default)]
struct Contents<'a> {
    joints: Vec<(Hinge, Option<String>, String)>,
    inertial: Option<Inertia<f64>>,
    geoms: Vec<(Attributes<'a>, Around<'a>)>,
    sites: Vec<(String, Pose<f64>)>,
    bodies: Vec<(&'a MjcfElement, Around<'a>)>,
}

/// A joint whose spring and damper are made to have a time constant [s] and a damping ratio.
pub(super) struct Response {
    pub joint: String,
    pub time: f64,
    pub ratio: f64,
}

/// A document that is part of the robot, and what is added to its names there.
pub(super) struct Placement {
    pub source: usize,
    prefix: Rc<str>,
    suffix: Rc<str>,
}

impl Placement {
    pub fn named(&self, name: &str) -> String {
        format!("{}{name}{}", self.prefix, self.suffix)
    }
}

/// Links, joints, sites and masses collected from the bodies of a robot.
#[derive(Default)]
pub(super) struct Tree {
    /// The first document, and every attached one as often as it is.
    pub placements: Vec<Placement>,
    pub links: Vec<Link>,
    pub joints: Vec<JointDescription>,
    pub sites: Vec<(String, usize, Pose<f64>)>,
    /// Free joints, which are taken as fixed.
    pub free: Vec<FreeJoint>,
    /// Links that are bodies of the file, their document, and what they weigh.
    pub masses: Vec<(usize, usize, Mass)>,
    pub responses: Vec<Response>,
    /// Coordinate of every joint in the configuration of the file, in their order.
    pub references: Vec<(String, f64)>,
}

/// Collects the tree of the first of `sources`, to which the others may be attached.
pub(super) struct Walker<'a, 's> {
    sources: &'s [MjcfTree<'a>],
    tree: Tree,
    waiting: Vec<Waiting<'a>>,
    placed: usize,
}

impl<'a, 's> Walker<'a, 's> {
    /// The tree of `sources[0]`.
    ///
    /// # Errors
    /// `BadInput` for anything but a tree of bodies on hinges and slides.
    pub fn walk(sources: &'s [MjcfTree<'a>]) -> Check<Tree> {
        let mut walker = Self { sources, tree: Tree::default(), waiting: Vec::new(), placed: 0 };
        let root = sources[0].root;
        let mut worlds = root.children_of("worldbody").peekable();
        let Some(first) = worlds.peek() else { return Err(root.error("a <worldbody>", "none")) };
        walker.tree.links.push(Link {
            name: "world".to_owned(),
            place: first.place(),
            inertia: None,
            compensation: 0.0,
        });
        let (entry, none) = (entry_of(schema::root(), "worldbody"), Rc::<str>::from(""));
        let (prefix, suffix) = (none.clone(), none.clone());
        walker.tree.placements.push(Placement { source: 0, prefix, suffix });
        let mut contents = Contents::default();
        for world in worlds {
            let (prefix, suffix) = (none.clone(), none.clone());
            let around = Around { pose: Pose::IDENTITY, class: MAIN, prefix, suffix, source: 0 };
            walker.collect(world, entry, &around, &mut contents)?;
            if !contents.joints.is_empty() || contents.inertial.is_some() {
                return Err(
                    world.error("bodies, which joints and masses belong to", "one in the world itself")
                );
            }
        }
        walker.tree.sites.extend(contents.sites.into_iter().map(|(name, pose)| (name, 0, pose)));
        walker.queue(contents.bodies, 0, Carriers::default());
        while let Some(waiting) = walker.waiting.pop() {
            walker.body(waiting)?;
        }
        Ok(walker.tree)
    }

    fn settings(&self, around: &Around) -> &'s Settings {
        &self.sources[around.source].settings
    }

    /// Puts bodies in front of those that wait.
    fn queue(&mut self, bodies: Vec<(&'a MjcfElement, Around<'a>)>, parent: usize, carriers: Carriers) {
        let waiting = |(element, around)| Waiting { element, parent, around, carriers };
        self.waiting.extend(bodies.into_iter().rev().map(waiting));
    }

    fn body(&mut self, Waiting { element, parent, around, mut carriers }: Waiting<'a>) -> Check<()> {
        let entry = entry_of(entry_of(schema::root(), "worldbody"), "body");
        let at = Attributes::plain(element, entry)?;
        let n = self.tree.links.len();
        let name = element.attribute("name").filter(|name| !name.is_empty());
        let name = name.map_or_else(|| format!("body_{n}"), |name| around.named(name));
        let mut origin = around.pose.times(&pose(&at, self.settings(&around))?);
        let class = self.class(element, &around)?;
        let inner = Around { pose: Pose::IDENTITY, class, ..around.clone() };
        let mut contents = Contents::default();
        self.collect(element, entry, &inner, &mut contents)?;
        // Several joints of one body: links without mass between them.
        let (mut link, count) = (parent, contents.joints.len());
        for (k, (hinge, joint_name, place)) in contents.joints.iter().enumerate() {
            if hinge.is_actuator_compensated {
                carriers.actuated = true
            } else {
                carriers.passive = true
            }
            let joint_name = joint_name.clone().unwrap_or_else(|| format!("{name}/joint_{k}"));
            let link_name =
                if k + 1 == count { format!("{name}/pivot") } else { format!("{name}/pivot_{k}") };
            (link, origin) = self.join(hinge, [joint_name, link_name], place, link, &origin);
        }
        let mut mass = self.mass(&contents, &inner)?;
        mass.compensation = self.compensation(&at, carriers)?;
        let own = self.tree.links.len();
        self.tree.links.push(Link {
            name: name.clone(),
            place: element.place(),
            inertia: None,
            compensation: 0.0,
        });
        self.tree.masses.push((own, around.source, mass));
        self.tree.joints.push(JointDescription {
            name: format!("{name}/fixed"),
            place: element.place(),
            kind: None,
            parent: link,
            child: own,
            origin,
            axis: [0.0, 0.0, 1.0],
            drive: JointLimits::default(),
            mimic: None,
        });
        self.tree.sites.extend(contents.sites.into_iter().map(|(name, pose)| (name, own, pose)));
        self.queue(contents.bodies, own, carriers);
        Ok(())
    }

    /// Adds a joint and the link that it moves; the link, and what is left to go from there to the body.
    fn join(
        &mut self,
        hinge: &Hinge,
        [name, link_name]: [String; 2],
        place: &str,
        parent: usize,
        origin: &Pose<f64>,
    ) -> (usize, Pose<f64>) {
        let child = self.tree.links.len();
        let inertia = Some(Inertia::ZERO);
        let place_of_link = place.to_owned();
        self.tree.links.push(Link { name: link_name, place: place_of_link, inertia, compensation: 0.0 });
        // At its reference coordinate the body has the pose of the file.
        let back = -hinge.reference;
        let moved = match hinge.kind {
            JointKind::Revolute => Pose { rotation: about(hinge.axis, back), position: [0.0; 3] },
            JointKind::Prismatic => Pose { position: hinge.axis.map(|a| a * back), ..Pose::IDENTITY },
        };
        let pivot = Pose { position: hinge.pivot, ..Pose::IDENTITY };
        let placed = origin.times(&pivot);
        let placed = if hinge.reference == 0.0 { placed } else { placed.times(&moved) };
        if let Some([time, ratio]) = hinge.response {
            self.tree.responses.push(Response { joint: name.clone(), time, ratio });
        }
        self.tree.references.push((name.clone(), hinge.reference));
        self.tree.joints.push(JointDescription {
            name,
            place: place.to_owned(),
            kind: Some(hinge.kind),
            parent,
            child,
            origin: placed,
            axis: hinge.axis,
            drive: hinge.drive.clone(),
            mimic: None,
        });
        (child, Pose { position: hinge.pivot.map(|x| -x), ..Pose::IDENTITY })
    }

    /// The class that holds within `element`.
    fn class(&self, element: &'a MjcfElement, around: &Around<'a>) -> Check<&'a str> {
        match element.attribute("childclass") {
            Some(class) if !self.sources[around.source].classes.contains(class) => {
                Err(element.error("a childclass of <default>", format!("\"{}\"", brief(class))))
            }
            own => Ok(own.unwrap_or(around.class)),
        }
    }

    /// Adds the contents of `element`, a body, frame or replica, and in the frames and replicas within it.
    fn collect(
        &mut self,
        element: &'a MjcfElement,
        entry: &'static MjcfEntry,
        around: &Around<'a>,
        contents: &mut Contents<'a>,
    ) -> Check<()> {
        for inner in &element.children {
            self.count(inner)?;
            let entry = entry_of(entry, &inner.tag);
            match &*inner.tag {
                "body" => contents.bodies.push((inner, around.clone())),
                "frame" => {
                    let at = Attributes::plain(inner, entry)?;
                    let pose = around.pose.times(&pose(&at, self.settings(around))?);
                    let around = Around { pose, class: self.class(inner, around)?, ..around.clone() };
                    self.collect(inner, entry, &around, contents)?;
                }
                "replicate" => self.replicate(inner, entry, around, contents)?,
                "attach" => self.attach(inner, entry, around, contents)?,
                _ => self.part(inner, entry, around, contents)?,
            }
        }
        Ok(())
    }

    /// Counts an element that is put somewhere.
    fn count(&mut self, element: &MjcfElement) -> Check<()> {
        self.placed += 1;
        match self.placed > MAX_PLACED {
            true => Err(too_many(element)),
            false => Ok(()),
        }
    }

    fn replicate(
        &mut self,
        element: &'a MjcfElement,
        entry: &'static MjcfEntry,
        around: &Around<'a>,
        contents: &mut Contents<'a>,
    ) -> Check<()> {
        let at = Attributes::plain(element, entry)?;
        let text = at.required("count")?;
        let count = text.trim().parse::<usize>().ok().filter(|count| *count > 0);
        let count = count.ok_or_else(|| element.error("a count > 0", format!("\"{}\"", brief(text))))?;
        // Each is an element at least.
        if count > MAX_PLACED - self.placed {
            return Err(too_many(element));
        }
        let settings = self.settings(around);
        let step = Pose {
            rotation: euler(at.array("euler")?.unwrap_or_default(), settings),
            position: at.array("offset")?.unwrap_or_default(),
        };
        let (separator, digits) = (at.text("sep").unwrap_or_default(), count.to_string().len());
        let mut pose = around.pose;
        for k in 0..count {
            let suffix = Rc::from(format!("{separator}{k:0digits$}{}", around.suffix));
            let around = Around { pose, suffix, ..around.clone() };
            self.collect(element, entry, &around, contents)?;
            pose = pose.times(&step);
            // Replicas of nothing count too.
            self.count(element)?;
        }
        Ok(())
    }

    /// Puts a body of another document, or its whole world, in a frame.
    fn attach(
        &mut self,
        element: &'a MjcfElement,
        entry: &'static MjcfEntry,
        around: &Around<'a>,
        contents: &mut Contents<'a>,
    ) -> Check<()> {
        let at = Attributes::plain(element, entry)?;
        let model = at.required("model")?;
        let source = self.sources[around.source].assets.models.get(model).copied();
        let source =
            source.ok_or_else(|| element.error("a model of <asset>", format!("\"{}\"", brief(model))))?;
        if let Some(frame) = at.text("frame") {
            let found = format!("frame=\"{}\"", brief(frame));
            return Err(element.error("a body of the model", found).hint("put the frame into a body"));
        }
        let own = at.text("prefix").unwrap_or_default();
        let prefix: Rc<str> = Rc::from(format!("{}{own}", around.prefix));
        let suffix = around.suffix.clone();
        self.tree.placements.push(Placement { source, prefix: prefix.clone(), suffix });
        let inner = Around { class: MAIN, prefix, source, ..around.clone() };
        let world_entry = entry_of(schema::root(), "worldbody");
        let root = self.sources[source].root;
        // Its equality comes with it.
        for equality in root.children_of("equality").flat_map(|section| &section.children) {
            self.count(equality)?;
        }
        let Some(name) = at.text("body") else {
            for world in root.children_of("worldbody") {
                self.collect(world, world_entry, &inner, contents)?;
            }
            return Ok(());
        };
        let body = root.children_of("worldbody").find_map(|world| find_body(world, name));
        let body =
            body.ok_or_else(|| element.error("a body of the model", format!("\"{}\"", brief(name))))?;
        contents.bodies.push((body, inner));
        Ok(())
    }

    /// An element that is neither body nor frame.
    fn part(
        &mut self,
        element: &'a MjcfElement,
        entry: &'static MjcfEntry,
        around: &Around<'a>,
        contents: &mut Contents<'a>,
    ) -> Check<()> {
        let (sources, settings) = (self.sources, self.settings(around));
        let classes = sources[around.source].classes;
        let is_free = element.attribute("type") == Some("free") && *element.tag == *"joint";
        match &*element.tag {
            "freejoint" => self.tree.free.push(floating(element)),
            "joint" if is_free => self.tree.free.push(floating(element)),
            "joint" => {
                let at = Attributes::of(element, entry, classes, around.class)?;
                if at.text("type") == Some("free") {
                    self.tree.free.push(floating(element));
                    return Ok(());
                }
                let hinge = hinge(&at, settings, &around.pose)?;
                let name = element.attribute("name").map(|name| around.named(name));
                contents.joints.push((hinge, name, element.place()));
            }
            "inertial" => {
                if contents.inertial.is_some() {
                    return Err(element.error("one <inertial> of a body", "a second one"));
                }
                contents.inertial =
                    Some(inertial(&Attributes::plain(element, entry)?, settings, &around.pose)?);
            }
            "geom" => {
                let at = Attributes::of(element, entry, classes, around.class)?;
                contents.geoms.push((at, around.clone()));
            }
            "site" => {
                let at = Attributes::of(element, entry, classes, around.class)?;
                if let Some(name) = element.attribute("name") {
                    let own = match segment(&at)? {
                        Some((pose, _)) => pose,
                        None => pose(&at, settings)?,
                    };
                    contents.sites.push((around.named(name), around.pose.times(&own)));
                }
            }
            _ => {
                Attributes::plain(element, entry)?;
            }
        }
        Ok(())
    }

    /// Mass of a body, from the source that the settings name.
    fn mass(&self, contents: &Contents<'a>, around: &Around<'a>) -> Check<Mass> {
        let source = self.settings(around).inertia_from;
        let from_geoms = match source {
            InertiaSource::Inertial => false,
            InertiaSource::Either => contents.inertial.is_none(),
            InertiaSource::Geoms => !contents.geoms.is_empty(),
        };
        if !from_geoms {
            return Ok(contents.inertial.map_or_else(Mass::default, |inertia| Mass::of(&inertia)));
        }
        let mut whole = Inertia::ZERO;
        for (at, around) in &contents.geoms {
            if let Some(plugin) = at.element.children.first() {
                return Err(plugin.error("a geom without plugin, where it gives a body its mass", "one"));
            }
            let MjcfTree { settings, assets, classes, .. } = &self.sources[around.source];
            if let Some(inertia) = geom::inertia(at, settings, (assets, classes), &around.pose)? {
                whole = whole.plus(&inertia);
            }
        }
        Ok(Mass::of(&whole))
    }

    /// Share of the weight of a body that is compensated without a torque.
    fn compensation(&self, at: &Attributes, carriers: Carriers) -> Check<f64> {
        let compensation = at.number("gravcomp")?.unwrap_or(0.0);
        let settings = &self.sources[0].settings;
        match carriers {
            _ if compensation == 0.0 || !(settings.springs || settings.dampers) => Ok(0.0),
            Carriers { actuated: true, passive: true } => {
                let expected =
                    "gravcomp of a body that only joints with actuatorgravcomp carry, or only others";
                Err(at.element.error(expected, "both"))
            }
            // The actuators bring it: it is part of the torques that are computed.
            Carriers { actuated: true, .. } => Ok(0.0),
            Carriers { .. } => Ok(compensation),
        }
    }
}

fn too_many(element: &MjcfElement) -> BadInput {
    element.error(&format!("at most {MAX_PLACED} elements, replicas counted"), "more")
}

/// A free joint, which is taken as fixed where the file places its body.
fn floating(element: &MjcfElement) -> FreeJoint {
    FreeJoint {
        name: element.attribute("name").unwrap_or(&element.tag).to_owned(),
        place: element.place(),
        kind: "free".to_owned(),
    }
}

/// The body called `name` within `element`.
fn find_body<'a>(element: &'a MjcfElement, name: &str) -> Option<&'a MjcfElement> {
    element.children.iter().find_map(|inner| match &*inner.tag {
        "body" if inner.attribute("name") == Some(name) => Some(inner),
        "body" | "frame" => find_body(inner, name),
        _ => None,
    })
}

/// `<inertial>` in `frame` of its body.
fn inertial(at: &Attributes, settings: &Settings, frame: &Pose<f64>) -> Check<Inertia<f64>> {
    let mass = at.parse_array::<1>("mass", at.required("mass")?)?[0];
    if mass < 0.0 {
        return Err(at.element.error("a mass >= 0 kg", mass.to_string()));
    }
    let second = match (at.array::<6>("fullinertia")?, at.array::<3>("diaginertia")?) {
        (Some(_), Some(_)) => return Err(at.element.error("diaginertia or fullinertia", "both")),
        (Some([xx, yy, zz, xy, xz, yz]), None) => [xx, xy, yy, xz, yz, zz],
        (None, Some([xx, yy, zz])) => [xx, 0.0, yy, 0.0, 0.0, zz],
        (None, None) => return Err(at.element.error("diaginertia or fullinertia", "neither")),
    };
    check_second(&second)
        .map_err(|found| at.element.error("an inertia without negative principal value", found))?;
    let placed = frame.times(&pose(at, settings)?);
    Ok(Inertia { mass, first: [0.0; 3], second }.placed(&placed.rotation, placed.position))
}
