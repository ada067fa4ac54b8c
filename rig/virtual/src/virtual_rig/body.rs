//! The body: an elastic rod of sections with constant strain, creeping, pulled by tendons through guides.
//!
//! Here is what it is, what it remembers, and the forces at given strains. Strains are taken in the principal axes of
//! bending, so stiffness and creep are one number per strain. The force residual is exact; its tangent leaves out
//! the change of wrap angles and some terms of second order in a section's angle.

use super::linear::{
    IDENTITY, Lu, M3, V3, about_z, add, apply, apply_transposed, cross, dot, product, quaternion, scale, sub,
};
use super::section::SectionPose;
use hysteron_actuator::{Prony, PronyStep, TendonModel, TendonTrial};

/// Whether a factor of the tangent is used for more than one iteration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FactorReuse {
    WhileTheyServe,
    AlwaysNew,
}

/// Definition of a body. All vectors in the robot's frame: base at the origin, rod along z.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BodySpec {
    /// Length at rest [m].
    pub length: f64,
    /// Number of sections.
    pub n_sections: usize,
    /// Relaxed stiffness: bending about the two principal axes, torsion [N m²], stretch [N].
    pub stiffness: [f64; 4],
    /// Stiffness of each section over that (n_sections) [-].
    pub section_factors: Vec<f64>,
    /// Turn of the principal axes about z [rad].
    pub axes_angle: f64,
    /// Curvature without load about x and y [1/m].
    pub natural_curvature: [f64; 2],
    /// Creep of every strain.
    pub prony: Prony,
    /// Mass [kg].
    pub mass: f64,
    /// Acceleration of gravity [m/s²].
    pub gravity: V3,
    /// Force on the tip [N].
    pub tip_load: V3,
    /// Where the tendons pass the cross-section [m].
    pub guides: Vec<[f64; 2]>,
    /// Turn of each tendon where it enters the body, at rest [rad].
    pub base_wrap: f64,
}

/// A body with its tendons and their memory.
#[derive(Debug, Clone)]
pub(crate) struct TendonBody {
    pub(crate) spec: BodySpec,
    /// Strains of each section: bending, bending, torsion [rad], stretch [-] (n_sections).
    pub(crate) strains: Vec<[f64; 4]>,
    /// Strains one step earlier, and that step's length [s].
    pub(super) last_strains: Vec<[f64; 4]>,
    pub(super) last_step: f64,
    /// Elastic strains of the Maxwell elements (n_sections × 4 × n_terms).
    pub(super) elastic: Vec<f64>,
    /// First segment outside of the body, the others one per section.
    pub(crate) tendons: Vec<TendonModel>,
    /// Strokes less slack in the last step (n_tendons) [m].
    pub(crate) pulled: Vec<f64>,
    /// Work that creep has turned into heat so far [J].
    pub(crate) creep_heat: f64,
    /// Stiffness of each section per strain: of rotations [N m], of stretch [N m] (n_sections).
    pub(super) stiffness: Vec<[f64; 4]>,
    /// Strains without load.
    pub(super) natural: [f64; 4],
    /// Tendon positions in the principal axes [m].
    pub(super) guides: Vec<V3>,
    /// Forces on the section ends but the tip's, and on the tip, in the principal axes [N].
    pub(super) node_force: V3,
    pub(super) tip_force: V3,
    pub(super) use_of_factor: FactorReuse,
    pub(super) work: EquilibriumScratch,
}

/// Scratch of the equilibrium.
#[derive(Debug, Clone)]
pub(super) struct EquilibriumScratch {
    pub(super) sections: Vec<SectionPose>,
    /// Segments of the tendons (n_sections × n_tendons).
    segments: Vec<TendonSegment>,
    /// Lengths (n_segments) and wraps (n_segments + 1) per tendon.
    lengths: Vec<Vec<f64>>,
    pub(super) wraps: Vec<Vec<f64>>,
    pub(super) trials: Vec<TendonTrial>,
    /// Orientation and position of each section end, base first (n_sections + 1).
    nodes: Vec<(M3, V3)>,
    /// ∂P/∂q of a section's end as turn and shift, per unknown.
    turns: Vec<[V3; 4]>,
    shifts: Vec<[V3; 4]>,
    pub(super) prony: PronyStep,
    pub(super) prony_step: f64,
    /// Residual over the root of the stiffness (4 n_sections) [√J].
    pub(super) residual: Vec<f64>,
    pub(super) direction: Vec<f64>,
    pub(super) trial_strains: Vec<[f64; 4]>,
    pub(super) best_strains: Vec<[f64; 4]>,
    pub(super) lu: Lu,
    /// Whether `lu` holds a factor that has served.
    pub(super) has_factor: bool,
}

/// A tendon between two guides.
#[derive(Debug, Clone, Copy, Default)]
struct TendonSegment {
    /// Its length [m], and how that changes with the section's strains.
    length: f64,
    by: [f64; 4],
    /// From guide to guide, of length 1, in the frame of the section's beginning.
    unit: V3,
    /// Far guide from the section's end, in the frame of its beginning [m].
    arm: V3,
    /// ∂(far guide)/∂strain [m].
    end_by: [V3; 4],
}

impl TendonBody {
    /// A body at rest with `tendons` that have as many segments as it has sections, and one more.
    pub(crate) fn new(spec: BodySpec, tendons: Vec<TendonModel>) -> Self {
        let n = spec.n_sections;
        let section = spec.length / n as f64;
        let to_axes = about_z(-spec.axes_angle);
        let natural = apply(&to_axes, [spec.natural_curvature[0], spec.natural_curvature[1], 0.0]);
        let natural = [natural[0] * section, natural[1] * section, 0.0, 0.0];
        let b = spec.stiffness;
        let uniform = [b[0] / section, b[1] / section, b[2] / section, b[3] * section];
        let stiffness = spec.section_factors.iter().map(|factor| uniform.map(|k| k * factor)).collect();
        let guides: Vec<V3> = spec.guides.iter().map(|g| apply(&to_axes, [g[0], g[1], 0.0])).collect();
        let weight = scale(spec.mass / n as f64, apply(&to_axes, spec.gravity));
        let strains = vec![natural; n];
        let work = EquilibriumScratch {
            sections: vec![SectionPose::default(); n],
            segments: vec![TendonSegment::default(); n * guides.len()],
            lengths: tendons.iter().map(|tendon| tendon.spec.rest_lengths.clone()).collect(),
            wraps: tendons.iter().map(|tendon| vec![0.0; tendon.n_segments() + 1]).collect(),
            trials: tendons.iter().map(TendonModel::trial).collect(),
            nodes: vec![(IDENTITY, [0.0; 3]); n + 1],
            turns: vec![[[0.0; 3]; 4]; n],
            shifts: vec![[[0.0; 3]; 4]; n],
            prony: PronyStep::default(),
            prony_step: f64::NAN,
            residual: vec![0.0; 4 * n],
            direction: vec![0.0; 4 * n],
            trial_strains: strains.clone(),
            best_strains: strains.clone(),
            lu: Lu::new(4 * n),
            has_factor: false,
        };
        let mut body = Self {
            stiffness,
            natural,
            guides,
            node_force: weight,
            // Half of each section's mass sits at either end of it.
            tip_force: add(scale(0.5, weight), apply(&to_axes, spec.tip_load)),
            last_strains: strains.clone(),
            last_step: 0.0,
            elastic: vec![0.0; 4 * n * spec.prony.n_terms()],
            pulled: vec![0.0; tendons.len()],
            creep_heat: 0.0,
            tendons,
            strains,
            spec,
            use_of_factor: FactorReuse::WhileTheyServe,
            work,
        };
        body.place(true);
        body
    }

    /// Sets the force on the tip, in the robot's frame [N], from the next balance on.
    pub(crate) fn set_tip_load(&mut self, force: V3) {
        let to_axes = about_z(-self.spec.axes_angle);
        self.spec.tip_load = force;
        self.tip_force = add(scale(0.5, self.node_force), apply(&to_axes, force));
    }

    /// Sections and nodes at the trial strains; with `commit` at the present ones.
    fn place(&mut self, commit: bool) {
        let length = self.spec.length / self.spec.n_sections as f64;
        let work = &mut self.work;
        if commit {
            work.trial_strains.copy_from_slice(&self.strains);
        }
        for (s, strain) in work.trial_strains.iter().enumerate() {
            let section = SectionPose::new(strain, length);
            let (q, p) = work.nodes[s];
            work.nodes[s + 1] = (product(&q, &section.r), add(p, apply(&q, section.d)));
            work.sections[s] = section;
        }
    }

    /// Orientation (quaternion) and position [m] of the tip in the robot's frame.
    pub(crate) fn tip(&self) -> ([f64; 4], V3) {
        let (q, p) = self.work.nodes[self.spec.n_sections];
        let to_robot = about_z(self.spec.axes_angle);
        let orientation = product(&product(&to_robot, &q), &about_z(-self.spec.axes_angle));
        (quaternion(&orientation), apply(&to_robot, p))
    }

    /// Lengths, wraps, tensions and the residual at the trial strains, for strokes less slack; returns its norm
    /// [√J].
    ///
    /// The residual is divided by the root of each stiffness; a unit of it is a root of energy.
    pub(super) fn evaluate(&mut self, pulled: &[f64]) -> f64 {
        self.place(false);
        self.measure_tendons();
        let n_tendons = self.tendons.len();
        let n_terms = self.spec.prony.n_terms();
        let EquilibriumScratch { trials, lengths, wraps, segments, residual, prony, trial_strains, .. } =
            &mut self.work;
        for (k, tendon) in self.tendons.iter().enumerate() {
            tendon.solve(&lengths[k], &wraps[k], pulled[k], &mut trials[k]);
        }
        for s in 0..self.spec.n_sections {
            for a in 0..4 {
                let strain = trial_strains[s][a];
                let increment = strain - self.strains[s][a];
                let y = &self.elastic[(4 * s + a) * n_terms..(4 * s + a + 1) * n_terms];
                let mut force = self.stiffness[s][a] * prony.stress(strain - self.natural[a], increment, y);
                for k in 0..n_tendons {
                    force += trials[k].tensions[s + 1] * segments[s * n_tendons + k].by[a];
                }
                residual[4 * s + a] = force;
            }
        }
        self.subtract_loads();
        let mut square = 0.0;
        for (i, r) in self.work.residual.iter_mut().enumerate() {
            *r /= self.stiffness[i / 4][i % 4].sqrt();
            square += *r * *r;
        }
        square.sqrt()
    }

    /// Chords between the guides of every section, and the angles between successive ones.
    fn measure_tendons(&mut self) {
        let n_tendons = self.guides.len();
        let work = &mut self.work;
        for (s, section) in work.sections.iter().enumerate() {
            for (k, &guide) in self.guides.iter().enumerate() {
                let arm = apply(&section.r, guide);
                let chord = sub(add(section.d, arm), guide);
                let length = dot(chord, chord).sqrt();
                let unit = scale(1.0 / length, chord);
                let mut end_by = section.d_by;
                for j in 0..3 {
                    end_by[j] = add(end_by[j], cross(section.omega[j], arm));
                }
                let by = end_by.map(|by| dot(unit, by));
                // The last chord in the frame of this section's beginning, which is the last one's end.
                let before = match s {
                    0 => [0.0, 0.0, 1.0],
                    _ => {
                        apply_transposed(&work.sections[s - 1].r, work.segments[(s - 1) * n_tendons + k].unit)
                    }
                };
                let gap = sub(unit, before);
                // |u - v| = 2 sin(angle/2).
                let angle = 2.0 * (0.5 * dot(gap, gap).sqrt()).min(1.0).asin();
                work.wraps[k][s + 1] = if s == 0 { angle + self.spec.base_wrap } else { angle };
                work.lengths[k][s + 1] = length;
                work.segments[s * n_tendons + k] = TendonSegment { length, by, unit, arm, end_by };
            }
        }
    }

    fn has_loads(&self) -> bool {
        dot(self.node_force, self.node_force) + dot(self.tip_force, self.tip_force) > 0.0
    }

    /// Takes gravity and the tip's load out of the residual: -Σ G_i·∂P_i/∂q.
    fn subtract_loads(&mut self) {
        if !self.has_loads() {
            return;
        }
        let n = self.spec.n_sections;
        let work = &mut self.work;
        // Force beyond, and its moment about the section's end.
        let (mut force, mut moment) = (self.tip_force, [0.0; 3]);
        for s in (0..n).rev() {
            let (q, section) = (work.nodes[s].0, &work.sections[s]);
            for a in 0..4 {
                let shift = apply(&q, section.d_by[a]);
                let turn = if a < 3 { apply(&q, section.omega[a]) } else { [0.0; 3] };
                work.residual[4 * s + a] -= dot(force, shift) + dot(turn, moment);
                (work.shifts[s][a], work.turns[s][a]) = (shift, turn);
            }
            let arm = sub(work.nodes[s + 1].1, work.nodes[s].1);
            moment = add(moment, cross(arm, force));
            force = add(force, self.node_force);
        }
    }

    /// Writes the tangent of the scaled residual at the strains evaluated last, unfactored.
    pub(super) fn assemble(&mut self) {
        let (n, n_tendons) = (self.spec.n_sections, self.guides.len());
        let size = 4 * n;
        self.work.lu.a.fill(0.0);
        for s in 0..n {
            let block = self.section_tangent(s);
            for a in 0..4 {
                self.work.lu.a[(4 * s + a) * size + 4 * s..][..4].copy_from_slice(&block[a]);
            }
        }
        self.add_load_tangent();
        let EquilibriumScratch { lu, trials, segments, .. } = &mut self.work;
        for (k, trial) in trials.iter_mut().enumerate() {
            trial.tangent(&self.tendons[k]);
            for s in 0..n {
                let rows = segments[s * n_tendons + k].by;
                for t in 0..n {
                    let stiffness = trial.tangent[(s + 1) * (n + 1) + t + 1];
                    if stiffness == 0.0 {
                        continue;
                    }
                    let columns = segments[t * n_tendons + k].by;
                    for a in 0..4 {
                        let row = &mut lu.a[(4 * s + a) * size + 4 * t..][..4];
                        let factor = stiffness * rows[a];
                        for b in 0..4 {
                            row[b] += factor * columns[b];
                        }
                    }
                }
            }
        }
        let scale = |i: usize| 1.0 / self.stiffness[i / 4][i % 4].sqrt();
        for (i, row) in lu.a.chunks_exact_mut(size).enumerate() {
            let of_row = scale(i);
            for (j, x) in row.iter_mut().enumerate() {
                *x *= of_row * scale(j);
            }
        }
    }

    /// Elastic and geometric tangent of one section: T (∂²l/∂q∂q).
    fn section_tangent(&self, s: usize) -> [[f64; 4]; 4] {
        let n_tendons = self.guides.len();
        let section = &self.work.sections[s];
        let mut pull = [0.0; 3];
        let mut outer = [[0.0; 3]; 3];
        let mut block = [[0.0; 4]; 4];
        for k in 0..n_tendons {
            let (segment, tension) =
                (&self.work.segments[s * n_tendons + k], self.work.trials[k].tensions[s + 1]);
            if tension == 0.0 {
                continue;
            }
            let force = scale(tension, segment.unit);
            pull = add(pull, force);
            for i in 0..3 {
                outer[i] = add(outer[i], scale(segment.arm[i], force));
            }
            let factor = tension / segment.length;
            for a in 0..4 {
                for b in 0..4 {
                    let across = dot(segment.end_by[a], segment.end_by[b]) - segment.by[a] * segment.by[b];
                    block[a][b] += factor * across;
                }
            }
        }
        let bend = section.bend(pull);
        let turn = turned_twice(&outer, &section.omega);
        for a in 0..4 {
            for b in 0..4 {
                block[a][b] += bend[a][b] + if a < 3 && b < 3 { turn[a][b] } else { 0.0 };
            }
            block[a][a] += self.stiffness[s][a] * self.work.prony.tangent;
        }
        block
    }

    /// Takes the second derivatives of the loads' potential out of the tangent.
    fn add_load_tangent(&mut self) {
        if !self.has_loads() {
            return;
        }
        let n = self.spec.n_sections;
        let size = 4 * n;
        let work = &mut self.work;
        // Beyond the section: force F, and S = Σ (P_i - P) Gᵀ; Σ (w × x) × G = (S - tr S) w.
        let (mut force, mut s_sum) = (self.tip_force, [[0.0; 3]; 3]);
        for t in (0..n).rev() {
            let q = work.nodes[t].0;
            let trace = s_sum[0][0] + s_sum[1][1] + s_sum[2][2];
            let mut moments = [[0.0; 3]; 4];
            for b in 0..4 {
                let turn = work.turns[t][b];
                let turned = sub(apply(&s_sum, turn), scale(trace, turn));
                moments[b] = add(cross(work.shifts[t][b], force), turned);
            }
            for s in 0..t {
                for a in 0..3 {
                    for b in 0..4 {
                        let value = dot(work.turns[s][a], moments[b]);
                        work.lu.a[(4 * s + a) * size + 4 * t + b] -= value;
                        work.lu.a[(4 * t + b) * size + 4 * s + a] -= value;
                    }
                }
            }
            // Within the section, symmetrised.
            let bend = work.sections[t].bend(apply_transposed(&q, force));
            for a in 0..4 {
                for b in 0..4 {
                    let mut value = bend[a][b];
                    if a < 3 && b < 3 {
                        let turned = |a: usize, b: usize| {
                            let w = work.turns[t][b];
                            dot(work.turns[t][a], sub(apply(&s_sum, w), scale(trace, w)))
                        };
                        value += 0.5 * (turned(a, b) + turned(b, a));
                    }
                    work.lu.a[(4 * t + a) * size + 4 * t + b] -= value;
                }
            }
            let arm = sub(work.nodes[t + 1].1, work.nodes[t].1);
            for i in 0..3 {
                s_sum[i] = add(s_sum[i], scale(arm[i], force));
            }
            force = add(force, self.node_force);
        }
    }

    /// Energy of rod, Maxwell elements, tendons and loads [J].
    pub(crate) fn stored_energy(&self) -> f64 {
        let n_terms = self.spec.prony.n_terms();
        let mut energy = 0.0;
        for (s, strain) in self.strains.iter().enumerate() {
            for a in 0..4 {
                energy += 0.5 * self.stiffness[s][a] * (strain[a] - self.natural[a]).powi(2);
                for (k, weight) in self.spec.prony.weights.iter().enumerate() {
                    energy +=
                        0.5 * self.stiffness[s][a] * weight * self.elastic[(4 * s + a) * n_terms + k].powi(2);
                }
            }
        }
        for (_, p) in &self.work.nodes[1..self.spec.n_sections] {
            energy -= dot(self.node_force, *p);
        }
        energy -= dot(self.tip_force, self.work.nodes[self.spec.n_sections].1);
        energy + self.tendons.iter().map(TendonModel::stored_energy).sum::<f64>()
    }

    /// Makes the trial strains the present ones, after a step of `h` [s].
    pub(super) fn commit(&mut self, pulled: &[f64], h: f64) {
        let n_terms = self.spec.prony.n_terms();
        for s in 0..self.spec.n_sections {
            for a in 0..4 {
                let increment = self.work.trial_strains[s][a] - self.strains[s][a];
                let y = &mut self.elastic[(4 * s + a) * n_terms..(4 * s + a + 1) * n_terms];
                for (k, y) in y.iter_mut().enumerate() {
                    let before = *y;
                    *y = self.work.prony.decay[k] * before + self.work.prony.gain[k] * increment;
                    let mean = 0.5 * (before + *y);
                    let flowed = increment - (*y - before);
                    self.creep_heat += self.stiffness[s][a] * self.work.prony.weights[k] * mean * flowed;
                }
            }
        }
        self.last_strains.copy_from_slice(&self.strains);
        self.last_step = h;
        self.strains.copy_from_slice(&self.work.trial_strains);
        self.pulled.copy_from_slice(pulled);
        for (tendon, trial) in self.tendons.iter_mut().zip(&self.work.trials) {
            tendon.commit(trial);
        }
    }

    /// Trial strains back to the present ones, with everything that hangs on them.
    pub(super) fn restore(&mut self) {
        self.place(true);
    }
}

/// ½ Σ f·(ω_a × (ω_b × g) + ω_b × (ω_a × g)) from `outer` = Σ g fᵀ.
fn turned_twice(outer: &M3, omega: &[V3; 3]) -> [[f64; 3]; 3] {
    let trace = outer[0][0] + outer[1][1] + outer[2][2];
    // (ω_b·f)(ω_a·g) - (f·g)(ω_a·ω_b)
    let half = |a: usize, b: usize| dot(omega[a], apply(outer, omega[b]));
    std::array::from_fn(|a| {
        std::array::from_fn(|b| 0.5 * (half(a, b) + half(b, a)) - trace * dot(omega[a], omega[b]))
    })
}
