//! MJCF, MuJoCo's language of robots. It is closed: every element and attribute of its schema is read, known to change nothing
//! that is computed, or refused by name and line (`schema`).
//!
//! # Reference
//! MuJoCo 4.0.0, XML reference.

mod assets;
mod attributes;
mod element;
mod equality;
mod geom;
mod joint;
mod mass;
mod mesh;
mod orientation;
mod schema;
mod settings;
mod tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::DMatrix;

use super::Model;
use super::description::Description;
use super::xml::Check;
use crate::{Data, mass_matrix};
use assets::Assets;
use attributes::{Attributes, Classes, MAIN, entry_of};
use element::{Files, MjcfElement};
use settings::Settings;
use tree::{MjcfTree, Response, Tree, Walker};

/// Documents that a robot may be put together from.
const MAX_MODELS: usize = 64;

/// A document that is read: its root, its folder, and the numbers of the models that it names.
struct Document {
    root: MjcfElement,
    folder: Option<PathBuf>,
    models: BTreeMap<String, usize>,
}

/// Reads `text`, the content of `file`; other files are found from `folder`.
///
/// # Errors
/// `BadInput` naming file, line and element for unknown elements and for models that are no arm.
pub(super) fn read(text: &str, file: &str, folder: Option<&Path>) -> Check<Model> {
    let documents = documents(text, file, folder)?;
    let classes: Vec<Classes> =
        documents.iter().map(|document| Classes::read(&document.root)).collect::<Check<_>>()?;
    let sources: Vec<MjcfTree> = documents
        .iter()
        .zip(&classes)
        .map(|(document, classes)| source(document, classes))
        .collect::<Check<_>>()?;
    let mut tree = Walker::walk(&sources)?;
    for source in &sources {
        check_forces(source)?;
    }
    weigh(&sources, &mut tree);
    let MjcfTree { root, settings, .. } = &sources[0];
    equality::read(&sources, &mut tree)?;
    let renamed = rename_sites_like_bodies(&mut tree);
    let Tree { links, joints, sites, free, responses, references, .. } = tree;
    let mut model = super::build::build(Description {
        file: file.to_owned(),
        name: root.attribute("model").unwrap_or("robot").to_owned(),
        links,
        joints,
        sites,
        free,
        faults: Vec::new(),
        gravity: settings.gravity,
    })?;
    model.notes.warnings.extend(renamed);
    respond(&mut model, &responses, &references, settings);
    Ok(model)
}

/// Renames sites with the name of a body, because here both are frames; returns the names.
fn rename_sites_like_bodies(tree: &mut Tree) -> Vec<String> {
    let bodies: BTreeSet<&str> = tree.links.iter().map(|link| &*link.name).collect();
    let mut renamed = Vec::new();
    for (name, ..) in tree.sites.iter_mut().filter(|(name, ..)| bodies.contains(&**name)) {
        let own = format!("{name}/site");
        renamed.push(format!("a body and a site are called \"{name}\": the frame of the site is \"{own}\""));
        *name = own;
    }
    renamed
}

/// The document of `text` and those that it attaches, in this order.
fn documents(text: &str, file: &str, folder: Option<&Path>) -> Check<Vec<Document>> {
    let mut files = Files::new(folder);
    let root = files.assemble(text, file)?;
    let mut all = vec![Document { root, folder: folder.map(Path::to_owned), models: BTreeMap::new() }];
    let mut next = 0;
    while next < all.len() {
        let root = &all[next].root;
        if *root.tag != *"mujoco" {
            return Err(root.error("<mujoco>", format!("<{}>", root.tag)));
        }
        schema::check(root, schema::root())?;
        let entry = entry_of(entry_of(schema::root(), "asset"), "model");
        let mut found = Vec::new();
        for element in root.children_of("asset").flat_map(|section| section.children_of("model")) {
            let at = Attributes::plain(element, entry)?;
            let file = at.required("file")?;
            let (root, folder) = files.open(element, all[next].folder.as_deref(), file)?;
            let name = at.text("name").or_else(|| root.attribute("model")).unwrap_or_default().to_owned();
            found.push((name, Document { root, folder: Some(folder), models: BTreeMap::new() }));
            if all.len() + found.len() > MAX_MODELS {
                return Err(element.error(&format!("at most {MAX_MODELS} models in one another"), "more"));
            }
        }
        for (name, document) in found {
            let number = all.len();
            all[next].models.insert(name, number);
            all.push(document);
        }
        next += 1;
    }
    Ok(all)
}

fn source<'a>(document: &'a Document, classes: &'a Classes<'a>) -> Check<MjcfTree<'a>> {
    let settings = Settings::read(&document.root)?;
    let assets = Assets::read(&document.root, document.folder.as_deref(), document.models.clone());
    Ok(MjcfTree { root: &document.root, settings, classes, assets })
}

/// Refuses tendons and actuators that add to the forces on the robot, and deformable bodies.
fn check_forces(source: &MjcfTree) -> Check<()> {
    for section in ["tendon", "actuator", "deformable"] {
        let entry = entry_of(schema::root(), section);
        for element in source.root.children_of(section).flat_map(|section| &section.children) {
            Attributes::of(element, entry_of(entry, &element.tag), source.classes, MAIN)?;
        }
    }
    Ok(())
}

/// Gives the links their masses, with what the settings of their documents do to them.
fn weigh(sources: &[MjcfTree], tree: &mut Tree) {
    let settings: Vec<&Settings> = sources.iter().map(|source| &source.settings).collect();
    mass::apply(&settings, &mut tree.masses);
    for (link, _, mass) in &tree.masses {
        tree.links[*link].inertia = Some(mass.inertia()).filter(|inertia| inertia.mass > 0.0);
        tree.links[*link].compensation = mass.compensation;
    }
}

/// Springs and dampers of a time constant T and a damping ratio ζ at the reference coordinates: with the inertia
/// m = 1 / (M⁻¹)ᵢᵢ of the joint there, all others free, stiffness m / (T ζ)² and damping 2 m / T.
fn respond(model: &mut Model, responses: &[Response], references: &[(String, f64)], settings: &Settings) {
    if responses.is_empty() {
        return;
    }
    let n = model.n_joints();
    let at: BTreeMap<&str, f64> = references.iter().map(|(name, q)| (name.as_str(), *q)).collect();
    let q: Vec<f64> =
        model.joints.iter().map(|joint| at.get(joint.name.as_str()).copied().unwrap_or(0.0)).collect();
    let mut mass = vec![0.0; n * n];
    mass_matrix(model, &mut Data::new(model, 0.0), &q, &mut mass);
    let Some(inverse) = DMatrix::from_row_slice(n, n, &mass).try_inverse() else { return };
    let numbers: BTreeMap<String, usize> =
        model.joints.iter().enumerate().map(|(k, joint)| (joint.name.clone(), k)).collect();
    for Response { joint, time, ratio } in responses {
        let Some(&k) = numbers.get(joint) else { continue };
        let (felt, drive) = (1.0 / inverse[(k, k)], &mut model.joints[k].drive);
        if settings.springs {
            drive.stiffness = felt / (time * ratio).powi(2);
        }
        if settings.dampers {
            drive.damping = 2.0 * felt / time;
        }
    }
}

/// The table of the schema as Markdown.
pub(super) fn table() -> String {
    schema::markdown()
}
