//! Meshes and models that a file names, opened when something needs them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::super::xml::Check;
use super::attributes::{Attributes, Classes, MAIN, entry_of};
use super::element::{MjcfElement, brief};
use super::mass::ShapeMoments;
use super::settings::Settings;
use super::{mesh, schema};

/// Assets of one document.
pub(super) struct Assets<'a> {
    meshes: BTreeMap<String, &'a MjcfElement>,
    /// Shapes of meshes that were needed, by the name.
    shapes: RefCell<BTreeMap<String, ShapeMoments>>,
    /// Numbers of the documents of models, by the name.
    pub models: BTreeMap<String, usize>,
    folder: Option<PathBuf>,
}

impl<'a> Assets<'a> {
    /// Those of a document in `folder`; `models` by their names.
    pub fn read(root: &'a MjcfElement, folder: Option<&Path>, models: BTreeMap<String, usize>) -> Self {
        let meshes = root.children_of("asset").flat_map(|section| section.children_of("mesh"));
        let meshes = meshes.filter_map(|element| Some((mesh::name(element)?, element))).collect();
        Self { meshes, shapes: RefCell::default(), models, folder: folder.map(Path::to_owned) }
    }

    /// The shape of the mesh that `element`, a geom, names.
    ///
    /// # Errors
    /// `BadInput` for a name of no mesh, and a mesh without shape.
    pub fn shape(
        &self,
        element: &MjcfElement,
        name: &str,
        classes: &Classes,
        settings: &Settings,
    ) -> Check<ShapeMoments> {
        if let Some(shape) = self.shapes.borrow().get(name) {
            return Ok(*shape);
        }
        let Some(asset) = self.meshes.get(name) else {
            return Err(element.error("a mesh of <asset>", format!("\"{}\"", brief(name))));
        };
        let entry = entry_of(entry_of(schema::root(), "asset"), "mesh");
        if let Some(plugin) = asset.children.first() {
            return Err(plugin.error("a mesh without plugin, where it gives a body its mass", "one"));
        }
        let at = Attributes::of(asset, entry, classes, MAIN)?;
        let shape = mesh::shape(&at, settings, self.folder.as_deref())?;
        self.shapes.borrow_mut().insert(name.to_owned(), shape);
        Ok(shape)
    }
}
