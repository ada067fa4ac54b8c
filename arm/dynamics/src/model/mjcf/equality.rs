//! Equality of joints and of tendons over two joints: one joint follows another. Other constraints close loops.

use std::collections::BTreeMap;

use super::super::MAX_JOINTS;
use super::super::description::Mimic;
use super::super::xml::Check;
use super::attributes::{Attributes, EQUALITY, MAIN, entry_of};
use super::element::{MjcfElement, brief};
use super::schema;
use super::tree::{MjcfTree, Placement, Tree};

/// q of `follower` = `ratio` · q of `leader` + `offset`, joints by their numbers in the tree.
#[derive(Debug, Clone, Copy)]
struct Relation {
    follower: usize,
    leader: usize,
    ratio: f64,
    offset: f64,
}

/// Joints that move by their names: number in the tree, and reference coordinate.
type Joints = BTreeMap<String, (usize, f64)>;

/// Reads the equality constraints that are active, those of attached models under the names that they have here.
///
/// # Errors
/// `BadInput` for constraints that are no such equality, joints that are not there, and joints that follow two others.
pub(super) fn read(sources: &[MjcfTree], tree: &mut Tree) -> Check<()> {
    // More joints are refused when the model is built.
    if !sources[0].settings.equality || tree.references.len() > MAX_JOINTS {
        return Ok(());
    }
    let references: BTreeMap<&str, f64> = tree.references.iter().map(|(name, q)| (&**name, *q)).collect();
    let numbered = tree.joints.iter().enumerate();
    let joints: Joints = numbered
        .filter_map(|(k, joint)| Some((joint.name.clone(), (k, *references.get(&*joint.name)?))))
        .collect();
    let mut leaders: BTreeMap<usize, Relation> = BTreeMap::new();
    for placement in &tree.placements {
        let source = &sources[placement.source];
        for element in source.root.children_of("equality").flat_map(|equality| &equality.children) {
            if !is_active(element, source)? {
                continue;
            }
            let Some(relation) = relation(element, source, placement, &joints)? else { continue };
            let relation = if leaders.contains_key(&relation.follower) && *element.tag == *"tendon" {
                relation.reversed()
            } else {
                relation
            };
            if leaders.insert(relation.follower, relation).is_some() {
                let found = format!("\"{}\" as follower twice", tree.joints[relation.follower].name);
                return Err(element.error("a joint that follows one other", found));
            }
        }
    }
    for (follower, relation) in &leaders {
        let Relation { leader, ratio, offset, .. } = relation.resolved(&leaders).ok_or_else(|| {
            let joint = &tree.joints[*follower];
            hysteron_base::BadInput::new(
                &joint.place,
                "a joint that does not follow itself",
                format!("\"{}\", which does by way of others", joint.name),
            )
        })?;
        let joint = tree.joints[leader].name.clone();
        tree.joints[*follower].mimic = Some(Mimic { joint, ratio, offset });
    }
    Ok(())
}

impl Relation {
    /// The same with the other joint as follower.
    fn reversed(&self) -> Self {
        let ratio = 1.0 / self.ratio;
        Self { follower: self.leader, leader: self.follower, ratio, offset: -self.offset * ratio }
    }

    /// The same to the joint at the end of a chain of followers; `None` for one that ends nowhere.
    fn resolved(mut self, leaders: &BTreeMap<usize, Self>) -> Option<Self> {
        for _ in 0..=leaders.len() {
            let Some(next) = leaders.get(&self.leader) else { return Some(self) };
            self.leader = next.leader;
            self.offset += self.ratio * next.offset;
            self.ratio *= next.ratio;
        }
        None
    }
}

/// False where a constraint is switched off, by itself or by its class.
fn is_active(element: &MjcfElement, source: &MjcfTree) -> Check<bool> {
    let at = Attributes::unchecked(element, source.classes, EQUALITY, MAIN)?;
    Ok(at.word("active", &["true", "false"])? == 0)
}

/// The relation of a constraint; `None` for one of a model of which other parts were attached.
fn relation(
    element: &MjcfElement,
    source: &MjcfTree,
    placement: &Placement,
    joints: &Joints,
) -> Check<Option<Relation>> {
    let entry = entry_of(entry_of(schema::root(), "equality"), &element.tag);
    let at = Attributes::of(element, entry, source.classes, MAIN)
        .map_err(|refused| refused.hint(way_out(element, source)))?;
    let [offset, ratio, rest @ ..] = at.array("polycoef")?.unwrap_or([0.0, 1.0, 0.0, 0.0, 0.0]);
    if rest != [0.0; 3] {
        let found = format!("\"{}\"", at.text("polycoef").unwrap_or_default());
        return Err(element.error("polycoef of first order", found));
    }
    let known = |name: &str| joints.get(&placement.named(name)).copied();
    if *element.tag == *"tendon" {
        return over_tendons(&at, source, [offset, ratio], &known);
    }
    let names = [at.required("joint1")?, at.required("joint2")?];
    let found = names.map(known);
    if found == [None; 2] && placement.source > 0 {
        return Ok(None);
    }
    let [(follower, own), (leader, other)] = [
        found[0].ok_or_else(|| no_joint(element, names[0]))?,
        found[1].ok_or_else(|| no_joint(element, names[1]))?,
    ];
    Ok(Some(Relation { follower, leader, ratio, offset: offset + own - ratio * other }))
}

/// With lengths L and those at the reference coordinates L₀: L₁ − L₁₀ = c₀ + c₁ (L₂ − L₂₀), without the second tendon L₁ − L₁₀ = c₀.
fn over_tendons(
    at: &Attributes,
    source: &MjcfTree,
    [offset, ratio]: [f64; 2],
    known: &dyn Fn(&str) -> Option<(usize, f64)>,
) -> Check<Option<Relation>> {
    let first = (at.required("tendon1")?, 1.0);
    let second = at.text("tendon2").map(|name| (name, -ratio));
    // Sum of c (q − r) over the joints; those of a model of which other parts were attached are not there.
    let (mut terms, mut missing) = (BTreeMap::<usize, [f64; 2]>::new(), None);
    for (name, factor) in [Some(first), second].into_iter().flatten() {
        for part in fixed_tendon(at.element, source, name)? {
            let entry = entry_of(entry_of(entry_of(schema::root(), "tendon"), "fixed"), "joint");
            let part = Attributes::plain(part, entry)?;
            let joint = part.required("joint")?;
            let coefficient = factor * part.parse_array::<1>("coef", part.required("coef")?)?[0];
            match known(joint) {
                Some((number, reference)) => {
                    let term = terms.entry(number).or_insert([0.0, reference]);
                    term[0] += coefficient;
                }
                None => missing = Some(no_joint(part.element, joint)),
            }
        }
    }
    terms.retain(|_, [coefficient, _]| *coefficient != 0.0);
    let terms: Vec<_> = terms.into_iter().collect();
    match (missing, &terms[..]) {
        (Some(_), []) => Ok(None),
        (Some(error), _) => Err(error),
        (None, &[(leader, [b, other]), (follower, [a, own])]) => {
            let ratio = -b / a;
            Ok(Some(Relation { follower, leader, ratio, offset: own - ratio * other + offset / a }))
        }
        (None, others) => {
            let found = format!("{} joints", others.len());
            Err(at.element.error("equality of tendons over two joints", found).hint(OPENED))
        }
    }
}

/// Joints of the tendon `name`, which must be a sum of them.
fn fixed_tendon<'a>(element: &MjcfElement, source: &MjcfTree<'a>, name: &str) -> Check<&'a [MjcfElement]> {
    let mut tendons = source.root.children_of("tendon").flat_map(|section| &section.children);
    match tendons.find(|tendon| tendon.attribute("name") == Some(name)) {
        Some(tendon) if *tendon.tag == *"fixed" => Ok(&tendon.children),
        Some(_) => {
            let found = format!("\"{}\", which runs through space", brief(name));
            Err(element.error("equality of a tendon <fixed>", found).hint(OPENED))
        }
        None => Err(element.error("a tendon of this robot", format!("\"{}\"", brief(name)))),
    }
}

fn no_joint(element: &MjcfElement, name: &str) -> hysteron_base::BadInput {
    element.error("a joint of this robot that moves", format!("\"{}\"", brief(name)))
}

const OPENED: &str = "remove it, or set active=\"false\" in it, for the torques of the tree without it";

/// Hint for a constraint that is refused.
fn way_out(element: &MjcfElement, source: &MjcfTree) -> &'static str {
    let names = ["body1", "body2"].map(|name| element.attribute(name));
    match names.into_iter().flatten().any(|name| is_mocap(source.root, name)) {
        true => {
            "a mocap body drags the robot by it: remove it, or set active=\"false\" in it, for the torques of the robot \
             alone"
        }
        false => OPENED,
    }
}

/// True where `name` is a mocap body within `element`.
fn is_mocap(element: &MjcfElement, name: &str) -> bool {
    let is_it = element.attribute("name") == Some(name) && element.attribute("mocap") == Some("true");
    is_it || element.children.iter().any(|inner| is_mocap(inner, name))
}
