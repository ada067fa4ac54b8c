//! A body as a chain of condensed sections, and everything that acts on it: cables, loads, the tip.

use hysteron_base::lanes::Isa;
use hysteron_fem::FemModel;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rayon::prelude::*;

use super::band::BlockVector;
use super::condense::{Condensed, condense};
use super::cut::Cut;
use super::errors::Validation;
use super::rotation::{exp, orthonormal};
use super::section::{Interface, SectionLaw, Site, StrainedPose};
use super::warping::{interfaces, rest};
use super::{PADDED, POSE, Strain, WARPINGS};
use crate::Result;
use crate::cable::Cables;
use crate::equilibrium_residual::least_force;
use crate::model::{Accuracy, Twin};
use crate::registration::Registration;

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
#[derive(Debug, Clone, Default)]
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

/// How parts within a section move in its frame under the forces on them, between interfaces that are held.
#[derive(Debug, Clone)]
pub(crate) struct Sink {
    pub parts: Vec<u32>,
    /// Compliance [m/N], row-major, rows and columns by part, then axis; symmetric.
    pub compliance: Vec<f64>,
}

/// The chain of one robot. Never changes.
#[derive(Debug, Clone)]
pub struct Chain {
    pub(crate) isa: Isa,
    /// Every interface at rest, the clamped one first.
    pub rest: Vec<Interface>,
    pub(crate) laws: Vec<SectionLaw>,
    pub(crate) parts: Vec<ChainPart>,
    /// The twin's cables, carried by parts.
    pub(crate) cables: Cables,
    pub(super) n_friction: usize,
    pub(super) n_backlash: usize,
    pub(crate) segments: Vec<CableSegment>,
    /// Constant forces on parts [N].
    pub(crate) loads: Vec<(u32, [f64; 3])>,
    pub(super) tip: PartSum,
    pub(super) tracker: Registration,
    /// How cable points sink into sections.
    pub(super) sinks: Vec<Sink>,
    /// Length that a rotation of one radian counts as in norms: a radius of the body [m].
    pub(crate) lever: f64,
    pub(crate) accuracy: Accuracy,
    /// Force below which forces count as none [N].
    pub(crate) least_force: f64,
    /// Largest asymmetry that the differences of the sections' forces have shown [-]: the accuracy of their cubic terms.
    pub asymmetry: f64,
    /// Errors against the finite elements; `None` until measured.
    pub validation: Option<Validation>,
}

/// A configuration of a chain.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChainState {
    /// Every interface, the clamped one first.
    pub interfaces: Vec<Interface>,
    /// Tension of each cable [N].
    pub tensions: Vec<f64>,
    /// Part of the constant loads that is applied.
    pub load: f64,
    /// Length of tendon that has slid past each friction point, where it stuck last [m].
    pub slip: Vec<f64>,
    /// Stroke behind the backlash of each real tendon [m]; empty without backlash.
    pub backlash: Vec<f64>,
}

/// Adds parts as they are asked for.
struct PartCollector<'a> {
    body: &'a FemModel,
    cut: &'a Cut,
    sections: &'a [Condensed],
    parts: Vec<ChainPart>,
    /// Nodes and weights of each.
    carriers: Vec<Vec<(u32, f64)>>,
}

impl Chain {
    /// Condenses the body of a twin.
    ///
    /// # Errors
    /// A body that cannot be cut into sections, or that nothing holds.
    pub fn new(twin: &Twin) -> Result<Self> {
        let body = &twin.body;
        let ends: Vec<[f64; 3]> = (0..twin.tendons.len())
            .flat_map(|j| {
                let line = twin.cables.polyline(j, &body.rest);
                line.first().copied().into_iter().chain(line.last().copied())
            })
            .collect();
        let cut = Cut::new(body, &ends)?;
        let interfaces = interfaces(twin, &cut)?;
        let mut sections: Vec<Condensed> = (0..cut.n_sections)
            .into_par_iter()
            .map(|e| condense(body, &cut, e, (&interfaces[e], &interfaces[e + 1])))
            .collect::<Result<_>>()?;
        let mut parts =
            PartCollector { body, cut: &cut, sections: &sections, parts: Vec::new(), carriers: Vec::new() };
        let mut known: Vec<(Vec<(u32, f64)>, PartSum)> = Vec::new();
        let cables = twin.cables.carried_by(|offset, carriers| {
            let sum = match known.iter().find(|(same, _)| same == carriers) {
                Some((_, sum)) => sum.clone(),
                None => {
                    let sum = parts.sum(carriers);
                    known.push((carriers.to_vec(), sum.clone()));
                    sum
                }
            };
            ((sum.offset + Vector3::from(offset)).into(), sum.parts)
        });
        let n_carrying = parts.parts.len();
        let tip: Vec<(u32, f64)> =
            twin.tip.nodes.iter().copied().zip(twin.tip.weights.iter().copied()).collect();
        let tip = parts.sum(&tip);
        let loads = parts.loads(&twin.loads);
        let asymmetry = sections.iter().map(|section| section.asymmetry).fold(0.0, f64::max);
        let PartCollector { parts, carriers, .. } = parts;
        let sinks = sinks(&mut sections, &parts[..n_carrying], &carriers);
        let volume: f64 = body.nodal_volumes.iter().sum();
        let length = interfaces.windows(2).map(|pair| (pair[1].center - pair[0].center).norm()).sum::<f64>();
        let at_rest = |center| Interface { center, rotation: Matrix3::identity(), warping: [0.0; WARPINGS] };
        Ok(Self {
            isa: body.isa,
            rest: interfaces.iter().map(|interface| at_rest(interface.center)).collect(),
            n_friction: twin.friction.len(),
            n_backlash: twin.n_backlash(),
            segments: segments(&cables),
            cables,
            loads,
            tip,
            parts,
            laws: sections.into_iter().map(|section| section.law).collect(),
            lever: (volume / length / std::f64::consts::PI).sqrt(),
            least_force: least_force(twin),
            accuracy: twin.accuracy,
            tracker: twin.tracker,
            sinks,
            asymmetry,
            validation: None,
        })
    }

    /// Number of sections.
    pub fn n_sections(&self) -> usize {
        self.laws.len()
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.laws.len() * super::BLOCK
    }

    /// The unloaded chain.
    pub fn rest(&self) -> ChainState {
        ChainState {
            interfaces: self.rest.clone(),
            tensions: vec![0.0; self.cables.len()],
            load: 0.0,
            slip: vec![0.0; self.n_friction],
            backlash: vec![0.0; self.n_backlash],
        }
    }

    /// Position of the tip, in the frame in which it is recorded [m].
    pub fn tip_of(&self, state: &ChainState) -> [f64; 3] {
        let mut at = self.tip.offset;
        for &(part, weight) in &self.tip.parts {
            let part = &self.parts[part as usize];
            let e = part.site.section();
            let pose = StrainedPose::new(&state.interfaces[e], &state.interfaces[e + 1], &self.laws[e].rest);
            let deformed = |c: usize| part.shape[c].iter().zip(&pose.strain).map(|(a, b)| a * b).sum::<f64>();
            let lever = part.arm + Vector3::from_fn(|c, _| deformed(c));
            at += weight * part.at(&pose, &state.interfaces, &lever);
        }
        self.tracker.point(at.into())
    }

    /// Rotation of the last interface since rest, in the frame in which the tip is recorded.
    pub fn tip_rotation_of(&self, state: &ChainState) -> UnitQuaternion<f64> {
        let turn = state.interfaces.last().map_or_else(Matrix3::identity, |last| last.rotation);
        let recorded = self.tracker.turn * turn * self.tracker.turn.transpose();
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(recorded))
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

impl PartCollector<'_> {
    /// The sum of nodes with weights.
    fn sum(&mut self, carriers: &[(u32, f64)]) -> PartSum {
        let mut sum = PartSum::default();
        let mut groups: Vec<(Site, Vec<(u32, f64)>)> = Vec::new();
        for &(node, weight) in carriers {
            match self.cut.site(node) {
                None => sum.offset += weight * rest(self.body, node),
                Some(site) => match groups.iter_mut().find(|(known, _)| *known == site) {
                    Some((_, group)) => group.push((node, weight)),
                    None => groups.push((site, vec![(node, weight)])),
                },
            }
        }
        sum.parts = groups.iter().map(|(site, group)| (self.add(*site, group), 1.0)).collect();
        sum
    }

    /// One part; its number.
    fn add(&mut self, site: Site, carriers: &[(u32, f64)]) -> u32 {
        let section = &self.sections[site.section()];
        let (center, rigid) = match site {
            Site::End(_) => (section.end, POSE + WARPINGS),
            Site::Within(_) => (section.center, 0),
        };
        let mut part = ChainPart { site, share: 0.0, arm: Vector3::zeros(), shape: [[0.0; PADDED]; 3] };
        for &(node, weight) in carriers {
            // Nodes of a section are few: a linear search.
            let Some(i) = section.nodes.iter().position(|&own| own == node) else { continue };
            part.share += weight;
            part.arm += weight * (rest(self.body, node) - center);
            for c in 0..3 {
                for (sum, shape) in part.shape[c].iter_mut().zip(&section.shapes[i][c]).skip(rigid) {
                    *sum += weight * shape;
                }
            }
        }
        self.parts.push(part);
        self.carriers.push(carriers.to_vec());
        self.parts.len() as u32 - 1
    }

    /// Constant nodal forces [N] as forces of one newton on parts, one per section and axis.
    fn loads(&mut self, nodal: &[[f64; 4]]) -> Vec<(u32, [f64; 3])> {
        let mut loads = Vec::new();
        let sites = (0..self.sections.len()).flat_map(|e| [Site::Within(e), Site::End(e)]);
        for site in sites {
            for c in 0..3 {
                let own: Vec<(u32, f64)> = (0..self.body.n_free as u32)
                    .filter(|&node| nodal[node as usize][c] != 0.0 && self.cut.site(node) == Some(site))
                    .map(|node| (node, nodal[node as usize][c]))
                    .collect();
                if !own.is_empty() {
                    let mut force = [0.0; 3];
                    force[c] = 1.0;
                    loads.push((self.add(site, &own), force));
                }
            }
        }
        loads
    }
}

/// Local compliance of every section that has parts within it.
fn sinks(sections: &mut [Condensed], parts: &[ChainPart], carriers: &[Vec<(u32, f64)>]) -> Vec<Sink> {
    let mut sinks = Vec::new();
    for (e, section) in sections.iter_mut().enumerate() {
        let within = (0..parts.len()).filter(|&p| parts[p].site == Site::Within(e));
        let own: Vec<u32> = within.map(|p| p as u32).collect();
        if !own.is_empty() {
            let sums: Vec<&[(u32, f64)]> = own.iter().map(|&p| &carriers[p as usize][..]).collect();
            sinks.push(Sink { compliance: section.local_compliance(&sums), parts: own });
        }
    }
    sinks
}

/// The distinct segments of all cables: those of friction run along their tendons.
pub(super) fn segments(cables: &Cables) -> Vec<CableSegment> {
    let mut segments: Vec<CableSegment> = Vec::new();
    for j in 0..cables.len() {
        for p in cables.points_of(j).skip(1).map(|next| next - 1) {
            match segments.iter_mut().find(|known| cables.is_same_segment(known.first, p)) {
                Some(known) => known.cables.push(j),
                None => segments.push(CableSegment { first: p, cables: vec![j] }),
            }
        }
    }
    segments
}
