//! Settings of `<compiler>`, `<option>` and `<flag>` for the whole file: of several settings of one attribute
//! the last holds.

use std::collections::BTreeMap;

use super::super::xml::Check;
use super::attributes::{Attributes, entry_of};
use super::element::MjcfElement;
use super::schema;
use crate::spatial::Vec3;

/// Default gravity of MuJoCo [m/s²].
const GRAVITY: Vec3<f64> = [0.0, 0.0, -9.81];

/// The flags that are read.
const FLAGS: [&str; 7] = ["gravity", "constraint", "spring", "damper", "frictionloss", "limit", "equality"];

/// Where masses and inertias come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InertiaSource {
    /// `<inertial>`, and geoms where there is none.
    Either,
    /// `<inertial>` alone.
    Inertial,
    /// Geoms, and `<inertial>` where there are none.
    Geoms,
}

/// Compiler settings for all bodies of a file.
#[derive(Debug, Clone)]
pub(super) struct Settings {
    /// rad for one unit of an angle.
    pub angle: f64,
    /// Axes of `euler`, in turn.
    pub sequence: [char; 3],
    pub ranges_limit: bool,
    pub inertia_from: InertiaSource,
    /// Groups of geoms that count, least and greatest.
    pub inertia_groups: [f64; 2],
    /// Least mass of a body [kg], and least principal moment of inertia [kg m²].
    pub least_mass: f64,
    pub least_inertia: f64,
    pub balances_inertia: bool,
    /// Mass of all bodies together [kg].
    pub total_mass: Option<f64>,
    pub mesh_folder: String,
    pub strips_paths: bool,
    pub fits_boxes: bool,
    pub gravity: Vec3<f64>,
    /// Which forces there are.
    pub springs: bool,
    pub dampers: bool,
    pub dry_friction: bool,
    pub limits: bool,
    pub equality: bool,
}

impl Settings {
    /// Those of a document.
    ///
    /// # Errors
    /// `BadInput` for values that the table refuses or that have another form.
    pub fn read(root: &MjcfElement) -> Check<Self> {
        let mut settings = Self {
            angle: std::f64::consts::PI / 180.0,
            sequence: ['x', 'y', 'z'],
            ranges_limit: true,
            inertia_from: InertiaSource::Either,
            inertia_groups: [0.0, 5.0],
            least_mass: 0.0,
            least_inertia: 0.0,
            balances_inertia: false,
            total_mass: None,
            mesh_folder: String::new(),
            strips_paths: false,
            fits_boxes: false,
            gravity: GRAVITY,
            springs: true,
            dampers: true,
            dry_friction: true,
            limits: true,
            equality: true,
        };
        let entry = entry_of(schema::root(), "compiler");
        let mut folders = BTreeMap::new();
        for element in root.children_of("compiler") {
            settings.compiler(&Attributes::plain(element, entry)?)?;
            folders.extend(element.attributes());
        }
        let folder = folders.get("meshdir").or_else(|| folders.get("assetdir"));
        settings.mesh_folder = folder.copied().unwrap_or_default().to_owned();
        settings.options(root)?;
        Ok(settings)
    }

    fn compiler(&mut self, at: &Attributes) -> Check<()> {
        let has = |name: &str| at.text(name).is_some();
        if has("angle") {
            let radian = at.word("angle", &["degree", "radian"])? == 1;
            self.angle = if radian { 1.0 } else { std::f64::consts::PI / 180.0 };
        }
        if has("autolimits") {
            self.ranges_limit = at.is_true("autolimits")?;
        }
        if let Some(text) = at.text("eulerseq") {
            let axes: Vec<char> = text.chars().collect();
            let known = axes.iter().all(|axis| "xyzXYZ".contains(*axis));
            self.sequence = <[char; 3]>::try_from(axes)
                .ok()
                .filter(|_| known)
                .ok_or_else(|| at.element.error("eulerseq of three letters x, y, z", text))?;
        }
        if has("inertiafromgeom") {
            let sources = [InertiaSource::Either, InertiaSource::Inertial, InertiaSource::Geoms];
            self.inertia_from = sources[at.word("inertiafromgeom", &["auto", "false", "true"])?];
        }
        if let Some(groups) = at.array("inertiagrouprange")? {
            self.inertia_groups = groups;
        }
        if has("boundmass") {
            self.least_mass = at.not_negative("boundmass")?;
        }
        if has("boundinertia") {
            self.least_inertia = at.not_negative("boundinertia")?;
        }
        if has("balanceinertia") {
            self.balances_inertia = at.is_true("balanceinertia")?;
        }
        if let Some(mass) = at.number("settotalmass")? {
            self.total_mass = Some(mass).filter(|mass| *mass > 0.0);
        }
        if has("strippath") {
            self.strips_paths = at.is_true("strippath")?;
        }
        if has("fitaabb") {
            self.fits_boxes = at.is_true("fitaabb")?;
        }
        Ok(())
    }

    fn options(&mut self, root: &MjcfElement) -> Check<()> {
        let entry = entry_of(schema::root(), "option");
        let of_flags = entry_of(entry, "flag");
        let mut flags = BTreeMap::new();
        for element in root.children_of("option") {
            let at = Attributes::plain(element, entry)?;
            if let Some(gravity) = at.array("gravity")? {
                self.gravity = gravity;
            }
            for element in element.children_of("flag") {
                let at = Attributes::plain(element, of_flags)?;
                for name in FLAGS.iter().filter(|name| at.text(name).is_some()) {
                    flags.insert(*name, at.word(name, &["disable", "enable"])? == 1);
                }
            }
        }
        let is_on = |name: &str| flags.get(name).copied().unwrap_or(true);
        let constraint = is_on("constraint");
        self.springs = is_on("spring");
        self.dampers = is_on("damper");
        self.dry_friction = constraint && is_on("frictionloss");
        self.limits = constraint && is_on("limit");
        self.equality = constraint && is_on("equality");
        if !is_on("gravity") {
            self.gravity = [0.0; 3];
        }
        Ok(())
    }
}
