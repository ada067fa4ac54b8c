//! Equality of joints: one follows another. Other constraints close loops.

use std::collections::BTreeMap;

use super::super::description::Mimic;
use super::super::xml::Check;
use super::attributes::{Attributes, EQUALITY, MAIN, entry_of};
use super::element::{Element, brief};
use super::schema;
use super::tree::{Source, Tree};

/// Reads `<joint joint1 joint2 polycoef>`, joint1 follows joint2: with their references r, q₁ − r₁ = c₀ + c₁ (q₂ − r₂).
///
/// # Errors
/// `BadInput` for constraints that are no such equality, and joints that are not there.
pub(super) fn read(sources: &[Source], tree: &mut Tree) -> Check<()> {
    let section = entry_of(schema::root(), "equality");
    let references: BTreeMap<String, f64> = tree.references.iter().cloned().collect();
    let numbers: BTreeMap<String, usize> =
        tree.joints.iter().enumerate().map(|(k, joint)| (joint.name.clone(), k)).collect();
    for (number, source) in sources.iter().enumerate() {
        for element in source.root.children_of("equality").flat_map(|equality| &equality.children) {
            let entry = entry_of(section, &element.tag);
            if !sources[0].settings.equality || !is_active(element, source)? {
                continue;
            }
            let at = Attributes::of(element, entry, source.classes, MAIN)?;
            if number > 0 {
                return Err(element
                    .error("equality in the first file alone", "one in an attached model")
                    .hint("write the equality in the file that attaches, with the prefixed names"));
            }
            let follower = at.required("joint1")?;
            let [offset, ratio, rest @ ..] = at.array("polycoef")?.unwrap_or([0.0, 1.0, 0.0, 0.0, 0.0]);
            if rest != [0.0; 3] {
                let found = format!("\"{}\"", at.text("polycoef").unwrap_or_default());
                return Err(element.error("polycoef of first order", found));
            }
            let leader = at.required("joint2")?;
            let known = |name: &str, which: &str| match (numbers.get(name), references.get(name)) {
                (Some(joint), Some(reference)) => Ok((*joint, *reference)),
                _ => Err(element.error(&format!("{which} of this robot"), format!("\"{}\"", brief(name)))),
            };
            let ((joint, own), (_, other)) = (known(follower, "joint1")?, known(leader, "joint2")?);
            let offset = offset + own - ratio * other;
            tree.joints[joint].mimic = Some(Mimic { joint: leader.to_owned(), ratio, offset });
        }
    }
    Ok(())
}

/// False where a constraint is switched off, by itself or by its class.
fn is_active(element: &Element, source: &Source) -> Check<bool> {
    let at = Attributes::unchecked(element, source.classes, EQUALITY, MAIN)?;
    Ok(at.word("active", &["true", "false"])? == 0)
}
