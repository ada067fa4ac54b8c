//! The exact tangent of a chain: the second variation of its potential along constant spins of the interfaces.
//!
//! Of a section the variations are written by z = (D, p, δw_a, δw_b, ω): D = R_eᵀ (δc_b - δc_a), p = δψ, ω the spin of its
//! frame. With N̂, M̂ and τ̂ what the net stresses and moments of a section are, η = ψ/2, g and κ the functions of [`HalfAngle`],
//! m = M̂ - ½ κ (N̂ × v + τ̂) × η and b = H⁻¹ m, differentiation of δv = D + v × ω, of H p = β - α and of
//! ω = ½ (α + β) - ½ κ η × p with constant spins in space gives
//!
//! N̂·δ²v + τ̂·δω + M̂·δp = 2 N̂·(D × ω) + (N̂·ω)(v·ω) - (N̂·v)|ω|²
//!     - ½ κ (N̂ × v + τ̂)·(ω × (η × p)) - ½ κ' (N̂ × v + τ̂)·(η × p)
//!     - b·(ω × (H p)) - g' b·(η × (η × p)) - ½ g ((b·η) |p|² - (b·p)(p·η))
//!
//! with g' and κ' their changes along p. A force f at lever r, both in the section's frame, adds (f·r) |ω|² - (f·ω)(r·ω) and
//! 2 ω·(f × (Ψ δε)); a cable segment of length ℓ and tension T adds T/ℓ (1 - t tᵀ) between the moves of its ends.
//!
//! [`HalfAngle`]: super::rotation::HalfAngle

use hysteron_base::lanes::{Simd, WithSimd};
use nalgebra::{Matrix3, Vector3};

use super::balance::ChainBalance;
use super::band::{Block, BlockSkyline, BlockVector};
use super::body::{Chain, ChainPart, PartSum};
use super::section::{Site, StrainedPose, head, middle};
use super::{BLOCK, PADDED, POSE, STRAIN, Strain, WARPINGS};
use crate::cable::direction;

/// Numbers of z: a strain, in which D takes the place of δv, and a spin.
const VARIATION: usize = STRAIN + 3;
/// Rows of z that move with the poses of the interfaces, in the order D, p, ω.
const BY_POSE: [usize; 9] = [0, 1, 2, 3, 4, 5, STRAIN, STRAIN + 1, STRAIN + 2];
/// Unknowns of a section: both interfaces.
const BOTH: usize = 2 * BLOCK;

/// Numbers by z, padded, or by the unknowns of both interfaces.
type Variation = [f64; BOTH];
const _: () = assert!(VARIATION <= BOTH && PADDED == BOTH);

/// Rows [`BY_POSE`] of z by the unknowns of both interfaces.
type PoseMap = [Variation; 9];

/// The tangent's pattern, and what its assembly needs.
#[derive(Debug, Clone)]
pub(crate) struct TangentAssembly {
    /// Of each section, D, p and ω by the poses of its interfaces.
    maps: Vec<PoseMap>,
    /// Of each part, its move by both interfaces of its section.
    moves: Vec<[Variation; 3]>,
    /// Move of a segment's end against its start, by free interfaces from its first on.
    segment: Vec<[BlockVector; 3]>,
}

impl TangentAssembly {
    pub fn new(chain: &Chain) -> Self {
        let spans =
            chain.segments.iter().map(|segment| span(chain, segment.first)).map(|(low, high)| high - low + 1);
        Self {
            maps: vec![[[0.0; BOTH]; 9]; chain.n_sections()],
            moves: vec![[[0.0; BOTH]; 3]; chain.parts.len()],
            segment: vec![[[0.0; BLOCK]; 3]; spans.max().unwrap_or(1)],
        }
    }

    /// Zeros in the tangent's pattern.
    pub fn pattern(chain: &Chain) -> BlockSkyline {
        let mut first: Vec<usize> = (0..chain.n_sections()).map(|e| e.saturating_sub(1)).collect();
        for segment in &chain.segments {
            let (low, high) = span(chain, segment.first);
            for column in low..=high.min(chain.n_sections()) {
                if column > 0 {
                    first[column - 1] = first[column - 1].min(low.saturating_sub(1));
                }
            }
        }
        BlockSkyline::zeros(chain.isa, first)
    }

    /// Writes the tangent at the configuration that `balance` has evaluated with these tensions.
    pub fn assemble_into(
        &mut self,
        chain: &Chain,
        balance: &ChainBalance,
        tensions: &[f64],
        tangent: &mut BlockSkyline,
    ) {
        chain.isa.run(Assemble { assembly: self, chain, balance, tensions, tangent });
    }

    /// Writes the derivatives of a sum of parts' positions by the unknowns, three rows, at the configuration assembled last.
    pub fn rows_into(&self, chain: &Chain, sum: &PartSum, rows: &mut [Vec<BlockVector>; 3]) {
        rows.iter_mut().for_each(|row| row.fill([0.0; BLOCK]));
        for &(part, weight) in &sum.parts {
            let (site, moves) = (chain.parts[part as usize].site, &self.moves[part as usize]);
            for interface in site.first().max(1)..=site.section() + 1 {
                let first = BLOCK * (interface - site.section());
                for (row, moves) in rows.iter_mut().zip(moves) {
                    for (row, moved) in row[interface - 1].iter_mut().zip(&moves[first..]) {
                        *row += weight * moved;
                    }
                }
            }
        }
    }

    /// Adds T/ℓ (1 - t tᵀ) between the two ends of a segment.
    #[inline(always)]
    fn add_segment(
        &mut self,
        chain: &Chain,
        balance: &ChainBalance,
        first: usize,
        tension: f64,
        tangent: &mut BlockSkyline,
    ) {
        let (low, high) = span(chain, first);
        let rows = &mut self.segment[..=high - low];
        rows.fill([[0.0; BLOCK]; 3]);
        for (point, sign) in [(first, -1.0), (first + 1, 1.0)] {
            for &(part, weight) in chain.cables.carriers(point) {
                let (site, moves) = (chain.parts[part as usize].site, &self.moves[part as usize]);
                for interface in site.first()..=site.section() + 1 {
                    let first = BLOCK * (interface - site.section());
                    for c in 0..3 {
                        for (row, moved) in rows[interface - low][c].iter_mut().zip(&moves[c][first..]) {
                            *row += sign * weight * moved;
                        }
                    }
                }
            }
        }
        let (t, length) = direction(&balance.shape.positions[first], &balance.shape.positions[first + 1]);
        let across: [[f64; 3]; 3] = std::array::from_fn(|a| {
            std::array::from_fn(|b| tension / length * (f64::from(u8::from(a == b)) - t[a] * t[b]))
        });
        // Interface 0 is clamped.
        for column in low.max(1)..=high {
            let mut pulled = [[0.0; BLOCK]; 3];
            for (pulled, across) in pulled.iter_mut().zip(&across) {
                let [x, y, z] = &rows[column - low];
                for k in 0..BLOCK {
                    pulled[k] = across[0] * x[k] + across[1] * y[k] + across[2] * z[k];
                }
            }
            let [x, y, z] = &pulled;
            for row in low.max(1)..=column {
                let block = tangent.block(row - 1, column - 1);
                let [a, b, c] = &rows[row - low];
                for (s, line) in block.iter_mut().enumerate() {
                    for k in 0..BLOCK {
                        line[k] += a[s] * x[k] + b[s] * y[k] + c[s] * z[k];
                    }
                }
            }
        }
    }
}

/// The whole assembly in one function: what it calls is inlined and compiled for the widest registers.
struct Assemble<'a> {
    assembly: &'a mut TangentAssembly,
    chain: &'a Chain,
    balance: &'a ChainBalance,
    tensions: &'a [f64],
    tangent: &'a mut BlockSkyline,
}

impl WithSimd for Assemble<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { assembly, chain, balance, tensions, tangent } = self;
        tangent.clear();
        for (map, pose) in assembly.maps.iter_mut().zip(&balance.poses) {
            *map = pose_map(pose, chain.lever);
        }
        for (e, pose) in balance.poses.iter().enumerate() {
            let law = chain.laws[e].tangent(chain.isa, &pose.strain);
            let mut form = with_spin(&law, pose);
            add_geometric(&mut form, pose, &balance.net[e].stress, &balance.net[e].moment);
            for (p, part) in chain.parts.iter().enumerate().filter(|(_, part)| part.site == Site::Within(e)) {
                add_lever(&mut form, pose, part, &balance.levers[p], &balance.forces[p]);
            }
            add_section(e, &assembly.maps[e], &form, tangent);
        }
        for (p, part) in chain.parts.iter().enumerate() {
            assembly.moves[p] = match part.site {
                Site::Within(e) => part_move(part, &balance.poses[e], &balance.levers[p], &assembly.maps[e]),
                Site::End(e) => {
                    let lever = balance.ends[e] * balance.levers[p];
                    let moves = end_move(part, &balance.ends[e], &lever, chain.lever);
                    add_end_lever(tangent.block(e, e), &moves, &lever, &balance.forces[p], chain.lever);
                    moves
                }
            };
        }
        for segment in &chain.segments {
            let tension: f64 = segment.cables.iter().map(|&j| tensions[j]).sum();
            if tension != 0.0 {
                assembly.add_segment(chain, balance, segment.first, tension, tangent);
            }
        }
    }
}

/// First and last interface that carry the segment from point `first` on; the same where nothing carries it.
fn span(chain: &Chain, first: usize) -> (usize, usize) {
    let carriers = [first, first + 1].into_iter().flat_map(|point| chain.cables.carriers(point));
    let sites = carriers.map(|(part, _)| chain.parts[*part as usize].site);
    let (low, high) = sites
        .fold((usize::MAX, 0), |(low, high), site| (low.min(site.first()), high.max(site.section() + 1)));
    if low > high { (0, 0) } else { (low, high) }
}

#[inline(always)]
fn pose_map(pose: &StrainedPose, lever: f64) -> PoseMap {
    let back = pose.rotation.transpose();
    let turned = pose.spread_inverse * back / lever;
    let skewed = 0.5 * pose.coefficients.kappa * pose.half.cross_matrix() * turned;
    let half = 0.5 / lever * back;
    let mut map = [[0.0; BOTH]; 9];
    set(&mut map, 0, 0, &-back);
    set(&mut map, 0, BLOCK, &back);
    set(&mut map, 3, 3, &-turned);
    set(&mut map, 3, BLOCK + 3, &turned);
    set(&mut map, 6, 3, &(half + skewed));
    set(&mut map, 6, BLOCK + 3, &(half - skewed));
    map
}

/// Sets a block of some rows.
#[inline(always)]
fn set(rows: &mut [Variation], row: usize, column: usize, block: &Matrix3<f64>) {
    for i in 0..3 {
        for j in 0..3 {
            rows[row + i][column + j] = block[(i, j)];
        }
    }
}

/// The quadratic form of the strain by z: δv = D + v × ω.
#[inline(always)]
fn with_spin(law: &[Strain; STRAIN], pose: &StrainedPose) -> [Variation; VARIATION] {
    let mut form = [[0.0; BOTH]; VARIATION];
    let turn = pose.chord.cross_matrix();
    for i in 0..STRAIN {
        form[i] = law[i];
        for c in 0..3 {
            form[i][STRAIN + c] = (0..3).map(|k| law[i][k] * turn[(k, c)]).sum();
        }
    }
    for c in 0..3 {
        for j in 0..VARIATION {
            form[STRAIN + c][j] = (0..3).map(|k| turn[(k, c)] * form[k][j]).sum();
        }
    }
    form
}

/// Adds a block at (row, column), and its transpose across where it is off the diagonal; on it the block is made symmetric.
#[inline(always)]
fn add_block(form: &mut [Variation; VARIATION], row: usize, column: usize, block: &Matrix3<f64>) {
    for i in 0..3 {
        for j in 0..3 {
            form[row + i][column + j] += 0.5 * block[(i, j)];
            form[column + j][row + i] += 0.5 * block[(i, j)];
        }
    }
}

/// Adds the terms of the module's documentation that N̂, M̂ and τ̂ make.
#[inline(always)]
fn add_geometric(
    form: &mut [Variation; VARIATION],
    pose: &StrainedPose,
    stress: &Strain,
    moment: &Vector3<f64>,
) {
    let (n, v, eta) = (head(stress), pose.chord, pose.half);
    let coefficients = pose.coefficients;
    let couple = n.cross(&v) + moment;
    let b = pose.spread_inverse * (middle(stress) - 0.5 * coefficients.kappa * couple.cross(&eta));
    let eta_cross = eta.cross_matrix();
    let (d, p, spin) = (0, 3, STRAIN);
    // x·(a × b) with x fixed is aᵀ [b × x], a bilinear form with the matrix -[x]× between a and b.
    add_block(form, d, spin, &(-2.0 * n.cross_matrix()));
    add_block(form, spin, spin, &(n * v.transpose() - Matrix3::from_diagonal_element(n.dot(&v))));
    let of_spin =
        0.5 * coefficients.kappa * couple.cross_matrix() * eta_cross + b.cross_matrix() * pose.spread();
    add_block(form, spin, p, &of_spin);
    // κ' = ½ κ_slope (η·p), and the same of g.
    let twisted = couple.cross(&eta);
    let bent = eta.cross(&eta.cross(&b));
    let of_curvature = -0.25 * coefficients.kappa_slope * eta * twisted.transpose()
        - 0.5 * coefficients.g_slope * eta * bent.transpose()
        - 0.5 * coefficients.g * (Matrix3::from_diagonal_element(b.dot(&eta)) - b * eta.transpose());
    add_block(form, p, p, &of_curvature);
}

/// Adds the terms of a force at a part's lever.
#[inline(always)]
fn add_lever(
    form: &mut [Variation; VARIATION],
    pose: &StrainedPose,
    part: &ChainPart,
    lever: &Vector3<f64>,
    force: &[f64; 4],
) {
    let force = Vector3::new(force[0], force[1], force[2]);
    if force == Vector3::zeros() {
        return;
    }
    let f = pose.rotation.tr_mul(&force);
    let outer = Matrix3::from_diagonal_element(f.dot(lever)) - f * lever.transpose();
    add_block(form, STRAIN, STRAIN, &outer);
    // 2 ω·([f]× Ψ δε), and δε has v × ω in it.
    let cross = f.cross_matrix();
    let mut of_spin = Matrix3::zeros();
    for i in 0..3 {
        for k in 0..STRAIN {
            let entry: f64 = (0..3).map(|c| cross[(i, c)] * part.shape[c][k]).sum();
            form[STRAIN + i][k] += entry;
            form[k][STRAIN + i] += entry;
            if k < 3 {
                of_spin[(i, k)] = entry;
            }
        }
    }
    add_block(form, STRAIN, STRAIN, &(2.0 * of_spin * pose.chord.cross_matrix()));
}

/// Adds a section's form to the blocks of its interfaces.
#[inline(always)]
fn add_section(e: usize, map: &PoseMap, form: &[Variation; VARIATION], tangent: &mut BlockSkyline) {
    // Every row of the form by the unknowns, then every unknown.
    let mut by_unknown = [[0.0; BOTH]; VARIATION];
    for (line, form) in by_unknown.iter_mut().zip(form) {
        let mut sum = warpings_of(form);
        for (map, &row) in map.iter().zip(&BY_POSE) {
            for k in 0..BOTH {
                sum[k] += form[row] * map[k];
            }
        }
        *line = sum;
    }
    let row = |side: usize, k: usize| {
        if k >= POSE {
            return by_unknown[WARPINGS * side + k];
        }
        let mut sum = [0.0; BOTH];
        for (map, &row) in map.iter().zip(&BY_POSE) {
            let factor = map[BLOCK * side + k];
            for (sum, number) in sum.iter_mut().zip(&by_unknown[row]) {
                *sum += factor * number;
            }
        }
        sum
    };
    for k in 0..BLOCK {
        add_line(&mut tangent.block(e, e)[k], &row(1, k)[BLOCK..]);
        if e > 0 {
            let line = row(0, k);
            add_line(&mut tangent.block(e - 1, e - 1)[k], &line[..BLOCK]);
            add_line(&mut tangent.block(e - 1, e)[k], &line[BLOCK..]);
        }
    }
}

/// Numbers by z as numbers by the unknowns, of the warpings alone.
#[inline(always)]
fn warpings_of(by_variation: &Variation) -> Variation {
    let mut by_unknown = [0.0; BOTH];
    by_unknown[POSE..BLOCK].copy_from_slice(&by_variation[POSE..BLOCK]);
    by_unknown[BLOCK + POSE..].copy_from_slice(&by_variation[BLOCK..STRAIN]);
    by_unknown
}

#[inline(always)]
fn add_line(line: &mut BlockVector, numbers: &[f64]) {
    for (line, number) in line.iter_mut().zip(numbers) {
        *line += number;
    }
}

/// Move of a part in space by the unknowns of both interfaces: ½ share (δc_a + δc_b) + R_e (ω × r + Ψ δε).
#[inline(always)]
fn part_move(part: &ChainPart, pose: &StrainedPose, lever: &Vector3<f64>, map: &PoseMap) -> [Variation; 3] {
    let shape = |first: usize| Matrix3::from_fn(|c, k| part.shape[c][first + k]);
    let by_chord = pose.rotation * shape(0);
    let by_spin = by_chord * pose.chord.cross_matrix() - pose.rotation * lever.cross_matrix();
    let by_curvature = pose.rotation * shape(3);
    let mut moves = [[0.0; BOTH]; 3];
    for c in 0..3 {
        let mut turned = [0.0; PADDED];
        for i in 0..3 {
            for k in 0..PADDED {
                turned[k] += pose.rotation[(c, i)] * part.shape[i][k];
            }
        }
        let mut sum = warpings_of(&turned);
        for (first, block) in [(0, &by_chord), (3, &by_curvature), (6, &by_spin)] {
            for i in 0..3 {
                for k in 0..BOTH {
                    sum[k] += block[(c, i)] * map[first + i][k];
                }
            }
        }
        sum[c] += 0.5 * part.share;
        sum[BLOCK + c] += 0.5 * part.share;
        moves[c] = sum;
    }
    moves
}

/// Move of a part of an end interface in space by the unknowns of that: share δc + δθ × r + R Φ δw, the lever r in space.
#[inline(always)]
fn end_move(part: &ChainPart, rotation: &Matrix3<f64>, lever: &Vector3<f64>, unit: f64) -> [Variation; 3] {
    let turn = lever.cross_matrix() / -unit;
    let mut moves = [[0.0; BOTH]; 3];
    for c in 0..3 {
        let own = &mut moves[c][BLOCK..];
        own[c] = part.share;
        for k in 0..3 {
            own[3 + k] = turn[(c, k)];
        }
        for k in 0..WARPINGS {
            own[POSE + k] = (0..3).map(|i| rotation[(c, i)] * part.shape[i][POSE + WARPINGS + k]).sum();
        }
    }
    moves
}

/// Adds (f·r) |δθ|² - (f·δθ)(r·δθ) + 2 δθ·(f × R Φ δw) of a force on a part of an end interface, all in space.
#[inline(always)]
fn add_end_lever(
    block: &mut Block,
    moves: &[Variation; 3],
    lever: &Vector3<f64>,
    force: &[f64; 4],
    unit: f64,
) {
    let force = Vector3::new(force[0], force[1], force[2]);
    if force == Vector3::zeros() {
        return;
    }
    let outer =
        (Matrix3::from_diagonal_element(force.dot(lever)) - force * lever.transpose()) / (unit * unit);
    let cross = force.cross_matrix() / unit;
    for i in 0..3 {
        for j in 0..3 {
            block[3 + i][3 + j] += 0.5 * (outer[(i, j)] + outer[(j, i)]);
        }
        for k in POSE..BLOCK {
            let entry: f64 = (0..3).map(|c| cross[(i, c)] * moves[c][BLOCK + k]).sum();
            block[3 + i][k] += entry;
            block[k][3 + i] += entry;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::super::tests::{Moved, moved_chain};
    use super::*;
    use crate::chain::Interface;
    use crate::equilibrium_residual::StepTargets;
    use crate::{Target, Twin};

    /// Evaluates the chain after a change of the unknowns, along constant spins.
    fn at(twin: &Twin, moved: &Moved, factor: f64, change: &[BlockVector]) -> ChainBalance {
        let Moved { chain, interfaces, tensions } = moved;
        let mut interfaces = interfaces.clone();
        chain.apply(factor, change, &mut interfaces);
        let control = StepTargets::new(twin, &vec![Target::Free; twin.tendons.len()]);
        let mut balance = ChainBalance::new(chain);
        balance.evaluate(chain, &control, &interfaces, tensions);
        balance
    }

    fn random(n: usize, seed: u64, size: f64) -> Vec<BlockVector> {
        let mut rng = hysteron_base::rng(seed, "chain/change");
        (0..n).map(|_| std::array::from_fn(|_| size * rng.random_range(-1.0..1.0))).collect()
    }

    fn product(a: &[BlockVector], b: &[BlockVector]) -> f64 {
        a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn residual_is_derivative_of_potential() {
        let (twin, moved) = moved_chain();
        let Moved { chain, tensions, .. } = &moved;
        for seed in 1..=4 {
            let change = random(chain.n_sections(), seed, 1e-3);
            // Parts of a change of some millimetres and tenths of a radian: truncation 1e-8, round-off 1e-16 over the step.
            let h = 1e-4;
            let (ahead, behind) = (at(&twin, &moved, h, &change), at(&twin, &moved, -h, &change));
            let here = at(&twin, &moved, 0.0, &change);
            let slope = product(&here.residual, &change);
            let difference =
                (ahead.potential(chain, 1.0, tensions) - behind.potential(chain, 1.0, tensions)) / (2.0 * h);
            assert!((slope - difference).abs() < 1e-6 * slope.abs(), "{slope} and {difference}");
            assert!(slope != difference && slope.abs() > 1e-5);
        }
    }

    #[test]
    fn rows_are_derivatives_of_strokes_where_points_do_not_sink_in() {
        let (twin, mut moved) = moved_chain();
        moved.chain = moved.chain.without_sinks();
        let Moved { chain, tensions, .. } = &moved;
        let change = random(chain.n_sections(), 1, 1e-3);
        let h = 1e-4;
        let (ahead, behind) = (at(&twin, &moved, h, &change), at(&twin, &moved, -h, &change));
        let mut here = at(&twin, &moved, 0.0, &change);
        let mut row = vec![[0.0; BLOCK]; chain.n_sections()];
        for j in 0..tensions.len() {
            here.row_into(chain, j, &mut row);
            let slope = product(&row, &change);
            let difference = (ahead.shape.strokes[j] - behind.shape.strokes[j]) / (2.0 * h);
            assert!((slope - difference).abs() < 1e-6 * slope.abs(), "{j}: {slope} and {difference}");
            assert!(slope != difference && slope.abs() > 1e-6);
        }
    }

    #[test]
    fn tangent_is_second_derivative_of_potential_where_points_do_not_sink_in() {
        let (twin, mut moved) = moved_chain();
        moved.chain = moved.chain.without_sinks();
        let Moved { chain, tensions, .. } = &moved;
        let n = chain.n_sections();
        let here = at(&twin, &moved, 0.0, &random(n, 1, 0.0));
        let mut tangent = TangentAssembly::pattern(chain);
        TangentAssembly::new(chain).assemble_into(chain, &here, tensions, &mut tangent);
        for seed in 1..=6 {
            let change = random(n, seed, 1e-3);
            let mut curvature = 0.0;
            for column in 0..n {
                for row in tangent.rows_of(column) {
                    let block = tangent.block(row, column);
                    let twice = if row == column { 1.0 } else { 2.0 };
                    for s in 0..BLOCK {
                        for t in 0..BLOCK {
                            curvature += twice * change[row][s] * block[s][t] * change[column][t];
                        }
                    }
                }
            }
            // Along constant spins the residual's product with the change is the potential's slope.
            let h = 1e-4;
            let slope = |factor: f64| product(&at(&twin, &moved, factor, &change).residual, &change);
            let difference = (slope(h) - slope(-h)) / (2.0 * h);
            assert!((curvature - difference).abs() < 1e-6 * difference.abs(), "{curvature} and {difference}");
            assert!(curvature != difference && curvature.abs() > 1e-5);
        }
    }

    #[test]
    fn diagonal_blocks_are_symmetric() {
        let (twin, moved) = moved_chain();
        let chain = &moved.chain;
        let here = at(&twin, &moved, 0.0, &random(chain.n_sections(), 1, 0.0));
        let mut tangent = TangentAssembly::pattern(chain);
        TangentAssembly::new(chain).assemble_into(chain, &here, &moved.tensions, &mut tangent);
        for i in 0..chain.n_sections() {
            let block = *tangent.block(i, i);
            let largest = block.as_flattened().iter().fold(0.0f64, |max, b| max.max(b.abs()));
            for s in 0..BLOCK {
                for t in 0..s {
                    assert!((block[s][t] - block[t][s]).abs() < 1e-13 * largest, "{i} {s} {t}");
                }
            }
        }
    }

    #[test]
    fn rigid_motion_of_all_interfaces_changes_no_energy_and_turns_the_residual() {
        let (_, moved) = moved_chain();
        let chain = &moved.chain;
        let turn = super::super::rotation::exp(&Vector3::new(0.7, -1.1, 1.9));
        let shift = Vector3::new(0.3, -0.2, 0.5);
        let rigid = |interface: &Interface| Interface {
            center: turn * interface.center + shift,
            rotation: turn * interface.rotation,
            ..*interface
        };
        for (pair, law) in moved.interfaces.windows(2).zip(&chain.laws) {
            let strain = |a: &Interface, b: &Interface| StrainedPose::new(a, b, &law.rest).strain;
            let (before, after) = (strain(&pair[0], &pair[1]), strain(&rigid(&pair[0]), &rigid(&pair[1])));
            let (here, there) = (law.stress(chain.isa, &before), law.stress(chain.isa, &after));
            let (energy, same) = (here.energy, there.energy);
            assert!((energy - same).abs() < 1e-12 * energy, "{energy} and {same}");
            let size = here.stress.iter().fold(0.0f64, |max, s| max.max(s.abs()));
            assert!(here.stress.iter().zip(&there.stress).all(|(a, b)| (a - b).abs() < 1e-12 * size));
        }
    }
}
