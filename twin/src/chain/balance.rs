//! Energy of a chain, and the residual of its equilibrium.

use std::ops::Range;

use hysteron_base::lanes::{LANES, Simd, WithSimd};
use hysteron_fem::vectors::dot;
use nalgebra::{Matrix3, Vector3};

use super::band::BlockVector;
use super::body::{CableReach, Chain, ChainPart, Sink};
use super::section::{Interface, Site, StrainedPose, Stressed};
use super::{BLOCK, PADDED, Strain};
use crate::cable::CableShape;
use crate::equilibrium_residual::{StepTargets, compare_strokes};

/// Way that cable points still have to sink over the accuracy of strokes, at which they have settled in their sections [-], and
/// passes at most: each leaves the part T/ℓ C of what was missing before.
const SETTLED: f64 = 0.05;
const MAX_SETTLING: usize = 60;
/// Part of the missing way that may be left by a pass until the next ones go half as far, and the least part of it that they go.
const SLOW: f64 = 0.7;
const LEAST_PART: f64 = 0.125;

/// Pull at a section: the generalised force of its strain, a force, and a moment about its centre in its frame; and a
/// force on its end interface with a moment about that one's centre, both in space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SectionPull {
    pub stress: Strain,
    pub force: Vector3<f64>,
    pub moment: Vector3<f64>,
    pub end_force: Vector3<f64>,
    pub end_moment: Vector3<f64>,
}

impl SectionPull {
    /// Adds a force on a part of its section [N]; `frames` are the rotations of the section and of its end.
    #[inline(always)]
    fn add(
        &mut self,
        part: &ChainPart,
        lever: &Vector3<f64>,
        force: &[f64; 4],
        frames: (&Matrix3<f64>, &Matrix3<f64>),
    ) {
        let force = Vector3::new(force[0], force[1], force[2]);
        if force == Vector3::zeros() {
            return;
        }
        let local = match part.site {
            Site::Within(_) => {
                let local = frames.0.tr_mul(&force);
                self.force += part.share * force;
                self.moment += lever.cross(&local);
                local
            }
            Site::End(_) => {
                self.end_force += part.share * force;
                self.end_moment += (frames.1 * lever).cross(&force);
                frames.1.tr_mul(&force)
            }
        };
        let stress = part.site.strain_mut(&mut self.stress);
        for c in 0..3 {
            for (stress, shape) in stress.iter_mut().zip(part.site.strain(&part.shape[c])) {
                *stress += local[c] * shape;
            }
        }
    }
}

const ZERO: Vector3<f64> = Vector3::new(0.0, 0.0, 0.0);
const NO_PULL: SectionPull =
    SectionPull { stress: [0.0; PADDED], force: ZERO, moment: ZERO, end_force: ZERO, end_moment: ZERO };

/// Positions, forces and strokes of some configuration; scratch.
#[derive(Debug, Clone)]
pub(crate) struct ChainBalance {
    pub poses: Vec<StrainedPose>,
    /// Lever of each part beyond its share of its frame's centre, in that frame [m].
    pub levers: Vec<Vector3<f64>>,
    /// How far each part has sunk into its section, in that frame [m].
    sunk: Vec<Vector3<f64>>,
    /// Forces of a section's parts in its frame, and moves under them; scratch.
    local_forces: Vec<f64>,
    local_moves: Vec<f64>,
    /// Rotation of the frame of each section's end.
    pub ends: Vec<Matrix3<f64>>,
    /// Position of each part [m], padded.
    pub positions: Vec<[f64; 4]>,
    /// Force of cables and loads on each part [N], padded.
    pub forces: Vec<[f64; 4]>,
    pub shape: CableShape,
    /// Elastic stress less what pulls at each section.
    pub net: Vec<SectionPull>,
    pulls: Vec<SectionPull>,
    /// Elastic energy [J].
    pub energy: f64,
    /// Largest strain of a section, the root of twice its quadratic energy over E V [-].
    pub strain: f64,
    /// Internal minus applied forces per unknown, moments over the chain's lever [N].
    pub residual: Vec<BlockVector>,
    applied: Vec<BlockVector>,
    /// Norm of `residual` over that of the applied forces [-].
    pub relative: f64,
    /// Missing stroke of each cable, u - s - C T [m]; zero where the tension is prescribed.
    pub stroke_residual: Vec<f64>,
    /// Largest violated stroke condition [m].
    pub violation: f64,
}

impl ChainBalance {
    pub fn new(chain: &Chain) -> Self {
        let (n, parts) = (chain.n_sections(), chain.parts.len());
        let poses = chain.rest.windows(2).zip(&chain.laws);
        Self {
            poses: poses.map(|(pair, law)| StrainedPose::new(&pair[0], &pair[1], &law.rest)).collect(),
            levers: vec![Vector3::zeros(); parts],
            ends: vec![Matrix3::identity(); n],
            sunk: vec![Vector3::zeros(); parts],
            local_forces: Vec::new(),
            local_moves: Vec::new(),
            positions: vec![[0.0; 4]; parts],
            forces: vec![[0.0; 4]; parts],
            shape: chain.cables.shape(),
            net: vec![NO_PULL; n],
            pulls: vec![NO_PULL; n],
            energy: 0.0,
            strain: 0.0,
            residual: vec![[0.0; BLOCK]; n],
            applied: vec![[0.0; BLOCK]; n],
            relative: f64::INFINITY,
            stroke_residual: vec![0.0; chain.cables.len()],
            violation: f64::INFINITY,
        }
    }

    /// Frames of sections, positions of parts, strokes.
    pub fn place(&mut self, chain: &Chain, interfaces: &[Interface]) {
        for ((pose, pair), law) in self.poses.iter_mut().zip(interfaces.windows(2)).zip(&chain.laws) {
            *pose = StrainedPose::new(&pair[0], &pair[1], &law.rest);
        }
        for (end, interface) in self.ends.iter_mut().zip(&interfaces[1..]) {
            *end = interface.rotation;
        }
        chain.isa.run(Levers {
            parts: &chain.parts,
            poses: &self.poses,
            sunk: &self.sunk,
            levers: &mut self.levers,
        });
        for ((part, lever), position) in chain.parts.iter().zip(&self.levers).zip(&mut self.positions) {
            let at = part.at(&self.poses[part.site.section()], interfaces, lever);
            *position = [at[0], at[1], at[2], 0.0];
        }
        chain.cables.measure(&self.positions, &mut self.shape);
    }

    /// Frames, positions and strokes, with cable points sunk in as far as they do under `tensions`, whose forces on the parts are
    /// left in `forces`.
    pub fn settle(&mut self, chain: &Chain, interfaces: &[Interface], tensions: &[f64]) {
        self.place(chain, interfaces);
        let (mut part, mut before) = (1.0, f64::INFINITY);
        for _ in 0..MAX_SETTLING {
            self.forces.fill([0.0; 4]);
            chain.cables.add_forces(&self.shape, tensions, &mut self.forces);
            if chain.sinks.is_empty() {
                return;
            }
            let missing = self.sink(chain, part);
            if missing < SETTLED * chain.accuracy.stroke {
                return;
            }
            chain.cables.measure(&self.positions, &mut self.shape);
            if !missing.is_finite() {
                break;
            }
            // A tense cable through soft points overshoots.
            if missing > SLOW * before {
                part = (0.5 * part).max(LEAST_PART);
            }
            before = missing;
        }
        // Points that do not settle must not be the beginning of the next search.
        self.sunk.fill(Vector3::zeros());
        self.shape.strokes.fill(f64::NAN);
    }

    /// Moves the parts within sections by a part of the way to where their forces bring them; returns the longest way [m].
    fn sink(&mut self, chain: &Chain, share: f64) -> f64 {
        let mut largest = 0.0f64;
        for sink in &chain.sinks {
            let n = 3 * sink.parts.len();
            self.collect_local(chain, sink);
            self.local_moves.resize(n, 0.0);
            chain.isa.run(Multiply {
                matrix: &sink.compliance,
                x: &self.local_forces,
                y: &mut self.local_moves,
            });
            for (&part, moved) in sink.parts.iter().zip(self.local_moves.as_chunks::<3>().0) {
                let part = part as usize;
                let missing = Vector3::from(*moved) - self.sunk[part];
                let change = share * missing;
                let turned = self.poses[chain.parts[part].site.section()].rotation * change;
                self.sunk[part] += change;
                self.levers[part] += change;
                for c in 0..3 {
                    self.positions[part][c] += turned[c];
                }
                // NaN must not pass as zero, and stays.
                let size = missing.norm();
                if size > largest || size.is_nan() {
                    largest = size;
                }
            }
        }
        largest
    }

    /// Forces on the parts of a sink, in the section's frame.
    fn collect_local(&mut self, chain: &Chain, sink: &Sink) {
        self.local_forces.clear();
        for &part in &sink.parts {
            let force = local_force(&self.forces, &self.poses, chain, part);
            self.local_forces.extend_from_slice(force.as_slice());
        }
    }

    /// Adds to W what cable points sink in per tension, at the configuration placed last; `pulls` is scratch.
    pub fn add_sinks(&mut self, chain: &Chain, delassus: &mut [f64], pulls: &mut Vec<f64>) {
        self.local_pulls_into(chain, pulls);
        let m = chain.cables.len();
        for sink in &chain.sinks {
            let n = 3 * sink.parts.len();
            self.local_moves.resize(n, 0.0);
            for &(i, at) in &sink.cables {
                let (matrix, x) = (&sink.compliance, &pulls[at..][..n]);
                chain.isa.run(Multiply { matrix, x, y: &mut self.local_moves });
                for &(j, at) in &sink.cables {
                    delassus[i * m + j] += dot(chain.isa, &self.local_moves, &pulls[at..][..n]);
                }
            }
        }
    }

    /// Writes the pulls of each cable per tension at the parts of its sinks, in their sections' frames, at the configuration
    /// placed last.
    fn local_pulls_into(&mut self, chain: &Chain, pulls: &mut Vec<f64>) {
        pulls.clear();
        pulls.resize(chain.sinks.iter().map(|sink| 3 * sink.parts.len() * sink.cables.len()).sum(), 0.0);
        for (j, reach) in chain.reach.iter().enumerate().filter(|(_, reach)| !reach.sinks.is_empty()) {
            self.forces.fill([0.0; 4]);
            chain.cables.add_forces_of(&self.shape, j, 1.0, &mut self.forces);
            for &(sink, start) in &reach.sinks {
                let parts = &chain.sinks[sink].parts;
                for (pull, &part) in pulls[start..].as_chunks_mut::<3>().0.iter_mut().zip(parts) {
                    *pull = local_force(&self.forces, &self.poses, chain, part).into();
                }
            }
        }
    }

    /// Evaluates everything.
    pub fn evaluate(
        &mut self,
        chain: &Chain,
        control: &StepTargets,
        interfaces: &[Interface],
        tensions: &[f64],
    ) {
        self.settle(chain, interfaces, tensions);
        for &(part, force) in &chain.loads {
            for c in 0..3 {
                self.forces[part as usize][c] += control.load * force[c];
            }
        }
        self.collect(chain);
        self.applied.fill([0.0; BLOCK]);
        spread(&self.poses, &self.pulls, 0..self.pulls.len(), chain.lever, &mut self.applied);
        (self.energy, self.strain) = (0.0, 0.0);
        for (((law, pose), pull), net) in
            chain.laws.iter().zip(&self.poses).zip(&self.pulls).zip(&mut self.net)
        {
            let Stressed { stress, energy, size } = law.stress(chain.isa, &pose.strain);
            self.energy += energy;
            self.strain = self.strain.max(size);
            net.force = -pull.force;
            net.moment = -pull.moment;
            net.end_force = -pull.end_force;
            net.end_moment = -pull.end_moment;
            for k in 0..PADDED {
                net.stress[k] = stress[k] - pull.stress[k];
            }
        }
        self.residual.fill([0.0; BLOCK]);
        spread(&self.poses, &self.net, 0..self.net.len(), chain.lever, &mut self.residual);
        let square = |blocks: &[BlockVector]| blocks.as_flattened().iter().map(|f| f * f).sum::<f64>();
        self.relative = square(&self.residual).sqrt() / square(&self.applied).sqrt().max(chain.least_force);
        self.compare_strokes(chain, control, tensions);
    }

    /// Forces of parts as pulls at their sections.
    fn collect(&mut self, chain: &Chain) {
        let Self { poses, ends, levers, forces, pulls, .. } = self;
        pulls.fill(NO_PULL);
        for ((part, lever), force) in chain.parts.iter().zip(levers).zip(forces) {
            let e = part.site.section();
            pulls[e].add(part, lever, force, (&poses[e].rotation, &ends[e]));
        }
    }

    /// Writes row j of J, ∂s_j per unknown, at the configuration placed last.
    pub fn row_into(&mut self, chain: &Chain, j: usize, row: &mut [BlockVector]) {
        let CableReach { parts, blocks, .. } = &chain.reach[j];
        for &part in parts {
            self.forces[part as usize] = [0.0; 4];
        }
        chain.cables.add_forces_of(&self.shape, j, 1.0, &mut self.forces);
        self.pulls[blocks.clone()].fill(NO_PULL);
        for part in parts.iter().map(|part| *part as usize) {
            let (lever, force) = (&self.levers[part], &self.forces[part]);
            let part = &chain.parts[part];
            let e = part.site.section();
            self.pulls[e].add(part, lever, force, (&self.poses[e].rotation, &self.ends[e]));
        }
        row.fill([0.0; BLOCK]);
        spread(&self.poses, &self.pulls, blocks.clone(), chain.lever, row);
    }

    /// Missing strokes at the configuration placed last.
    pub fn compare_strokes(&mut self, chain: &Chain, control: &StepTargets, tensions: &[f64]) {
        self.violation =
            compare_strokes(&chain.cables, control, &self.shape, tensions, &mut self.stroke_residual);
    }

    /// True where forces and strokes meet the accuracy asked for.
    pub fn is_met(&self, chain: &Chain) -> bool {
        self.relative <= chain.accuracy.relative_residual && self.violation <= chain.accuracy.stroke
    }

    /// True when all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.relative.is_finite() && !self.violation.is_nan()
    }

    /// Energy of the chain less the work of the constant loads and of prescribed tensions [J], at the configuration evaluated
    /// last.
    #[cfg(test)]
    pub fn potential(&self, chain: &Chain, load: f64, tensions: &[f64]) -> f64 {
        let mut potential = self.energy;
        for &(part, force) in &chain.loads {
            for c in 0..3 {
                potential -= load * force[c] * self.positions[part as usize][c];
            }
        }
        // Half of what the forces do on the points that sink in is stored.
        for sink in &chain.sinks {
            for &part in &sink.parts {
                let [x, y, z, _] = self.forces[part as usize];
                let rotation = &self.poses[chain.parts[part as usize].site.section()].rotation;
                potential += 0.5 * rotation.tr_mul(&Vector3::new(x, y, z)).dot(&self.sunk[part as usize]);
            }
        }
        potential - tensions.iter().zip(&self.shape.strokes).map(|(t, s)| t * s).sum::<f64>()
    }
}

/// Force on a part in its section's frame.
fn local_force(forces: &[[f64; 4]], poses: &[StrainedPose], chain: &Chain, part: u32) -> Vector3<f64> {
    let [x, y, z, _] = forces[part as usize];
    poses[chain.parts[part as usize].site.section()].rotation.tr_mul(&Vector3::new(x, y, z))
}

/// Writes a symmetric matrix times a vector.
struct Multiply<'a> {
    matrix: &'a [f64],
    x: &'a [f64],
    y: &'a mut [f64],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.y.fill(0.0);
        for (row, x) in self.matrix.chunks_exact(self.x.len()).zip(self.x) {
            for (y, entry) in self.y.iter_mut().zip(row) {
                *y += x * entry;
            }
        }
    }
}

/// Writes the lever of every part, arm + Ψ ε and what it has sunk in.
struct Levers<'a> {
    parts: &'a [ChainPart],
    poses: &'a [StrainedPose],
    sunk: &'a [Vector3<f64>],
    levers: &'a mut [Vector3<f64>],
}

impl WithSimd for Levers<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for ((part, sunk), lever) in self.parts.iter().zip(self.sunk).zip(self.levers) {
            let strain = part.site.strain(&self.poses[part.site.section()].strain);
            for c in 0..3 {
                let mut sums = [0.0; LANES];
                let row = part.site.strain(&part.shape[c]);
                for (row, strain) in row.as_chunks::<LANES>().0.iter().zip(strain.as_chunks::<LANES>().0) {
                    for lane in 0..LANES {
                        sums[lane] += row[lane] * strain[lane];
                    }
                }
                lever[c] = part.arm[c] + sunk[c] + sums.iter().sum::<f64>();
            }
        }
    }
}

/// Adds the pulls' forces on the free interfaces, moments over `lever`.
fn spread(
    poses: &[StrainedPose],
    pulls: &[SectionPull],
    sections: Range<usize>,
    lever: f64,
    out: &mut [BlockVector],
) {
    for e in sections.clone() {
        let (pose, pull) = (&poses[e], &pulls[e]);
        let (before, from) = out.split_at_mut(e);
        pose.add_work(&pull.stress, &pull.force, &pull.moment, before.last_mut(), &mut from[0]);
        for c in 0..3 {
            from[0][c] += pull.end_force[c];
            from[0][3 + c] += pull.end_moment[c];
        }
    }
    // The first section moves the block before it too, if there is one.
    for block in &mut out[sections.start.saturating_sub(1)..sections.end] {
        for c in 3..6 {
            block[c] /= lever;
        }
    }
}
