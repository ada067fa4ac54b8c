//! A body as a chain of condensed sections, and everything that acts on it: cables, loads, the tip.

use std::ops::Range;

use hysteron_base::Material;
use hysteron_base::lanes::Isa;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::band::BlockVector;
use super::errors::Validation;
use super::rotation::{exp, orthonormal};
use super::section::{Interface, SectionLaw, Site, StrainedPose};
use super::{POSE, Strain};
use crate::body_shape::BodyShape;
use crate::cable::Cables;
use crate::registration::Registration;
use crate::report::Accuracy;

/// Part of the largest validated strain up to which a step counts as within [-].
const BEYOND: f64 = 1.25;

/// A weighted sum of nodes of one interface, or of one section without them: `share` c + R (`arm` + Ψ ε) in the frame of its
/// site. What pulls at the body pulls at parts.
#[derive(Debug, Clone)]
pub(crate) struct ChainPart {
    pub site: Site,
    /// Sum of the weights [-].
    pub share: f64,
    /// Weighted sum of the arms from the frame's centre at rest [m].
    pub arm: Vector3<f64>,
    /// Ψ by rows.
    pub shape: [Strain; 3],
}

impl ChainPart {
    /// Position [m] with its lever in the frame of its site.
    pub fn at(&self, pose: &StrainedPose, interfaces: &[Interface], lever: &Vector3<f64>) -> Vector3<f64> {
        let (center, rotation) = match self.site {
            Site::Within(_) => (&pose.center, &pose.rotation),
            Site::End(e) => (&interfaces[e + 1].center, &interfaces[e + 1].rotation),
        };
        self.share * center + rotation * lever
    }
}

/// A weighted sum of nodes of the whole body.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct PartSum {
    /// Share of clamped nodes [m].
    pub offset: Vector3<f64>,
    /// Parts, and their weights.
    pub parts: Vec<(u32, f64)>,
}

/// Two neighbouring points of cables, and the cables that run from one to the other.
#[derive(Debug, Clone)]
pub(crate) struct CableSegment {
    /// The first point; the other is the next.
    pub first: usize,
    pub cables: Vec<usize>,
}

/// The parts and interfaces that a cable pulls at.
#[derive(Debug, Clone)]
pub(crate) struct CableReach {
    /// The parts that carry its points, ascending.
    pub parts: Vec<u32>,
    /// The free interfaces that these move with, and the sections before them.
    pub blocks: Range<usize>,
    /// The sinks with some of these parts, and where its pulls at each begin among those of all cables.
    pub sinks: Vec<(usize, usize)>,
}

/// How parts within a section move in its frame under the forces on them, between interfaces that are held.
#[derive(Debug, Clone)]
pub(crate) struct Sink {
    pub parts: Vec<u32>,
    /// Compliance [m/N], row-major, rows and columns by part, then axis; symmetric.
    pub compliance: Vec<f64>,
    /// The cables that pull at them, and where their pulls begin among those of all.
    pub cables: Vec<(usize, usize)>,
}

/// The chain of one robot. Never changes.
#[derive(Debug, Clone)]
pub struct Chain {
    pub(crate) isa: Isa,
    /// Every interface at rest, the clamped one first.
    pub rest: Vec<Interface>,
    pub(crate) laws: Vec<SectionLaw>,
    pub(crate) parts: Vec<ChainPart>,
    /// Carriers of each point of each tendon, auxiliary ones included.
    pub(super) points: Vec<Vec<PartSum>>,
    pub(super) tip: PartSum,
    /// Parts that are the masses of sections and interfaces: their shares are in kilograms.
    pub(super) masses: Vec<u32>,
    /// Constant forces on parts besides gravity [N].
    pub(super) forces: Vec<(u32, [f64; 3])>,
    /// How cable points sink into sections.
    pub(super) sinks: Vec<Sink>,
    /// The body that it stands for.
    pub(super) shape: BodyShape,
    /// Young's modulus [Pa] and density [kg/m³] that laws, sinks and masses are for.
    pub(super) material: ScaledBy,
    /// Length that a rotation of one radian counts as in norms: a radius of the body [m].
    pub(crate) lever: f64,
    /// Largest asymmetry that the differences of the sections' forces have shown [-]: the accuracy of their cubic terms.
    pub asymmetry: f64,
    /// Errors against the finite elements; `None` until measured.
    pub validation: Option<Validation>,
    // What a twin adds.
    /// The twin's cables, carried by parts.
    pub(crate) cables: Cables,
    pub(crate) segments: Vec<CableSegment>,
    /// Of each cable.
    pub(super) reach: Vec<CableReach>,
    /// All constant forces on parts [N].
    pub(crate) loads: Vec<(u32, [f64; 3])>,
    pub(super) tracker: Registration,
    pub(crate) accuracy: Accuracy,
    /// Force below which forces count as none [N].
    pub(crate) least_force: f64,
}

/// Properties of a material that forces are proportional to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScaledBy {
    /// Young's modulus [Pa].
    pub youngs_modulus: f64,
    /// Density [kg/m³].
    pub density: f64,
}

impl ScaledBy {
    pub fn of(material: &Material) -> Self {
        Self { youngs_modulus: material.youngs_modulus, density: material.density }
    }
}

impl Chain {
    /// Number of sections.
    pub fn n_sections(&self) -> usize {
        self.laws.len()
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.laws.len() * super::BLOCK
    }

    /// How far a strain lies beyond those that were validated [-].
    pub(crate) fn excess(&self, strain: f64) -> f64 {
        match &self.validation {
            Some(validation) if strain > BEYOND * validation.strain => strain / validation.strain - 1.0,
            _ => 0.0,
        }
    }

    /// Turns and moves every free interface by `factor` times a change of the unknowns.
    pub(crate) fn apply(&self, factor: f64, change: &[BlockVector], interfaces: &mut [Interface]) {
        for (interface, change) in interfaces[1..].iter_mut().zip(change) {
            let turn = Vector3::new(change[3], change[4], change[5]);
            interface.center += factor * Vector3::new(change[0], change[1], change[2]);
            interface.rotation = orthonormal(&(exp(&(factor / self.lever * turn)) * interface.rotation));
            for (amplitude, change) in interface.warping.iter_mut().zip(&change[POSE..]) {
                *amplitude += factor * change;
            }
        }
    }
}
