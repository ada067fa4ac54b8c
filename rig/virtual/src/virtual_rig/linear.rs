//! Small linear algebra of the rod: 3-vectors, rotations by rows, and one dense LU factor.

pub(crate) type V3 = [f64; 3];
/// A 3 × 3 matrix by rows.
pub(crate) type M3 = [V3; 3];

pub(crate) const IDENTITY: M3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[inline]
pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub(crate) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(crate) fn scale(s: f64, a: V3) -> V3 {
    [s * a[0], s * a[1], s * a[2]]
}

#[inline]
pub(crate) fn apply(m: &M3, a: V3) -> V3 {
    [dot(m[0], a), dot(m[1], a), dot(m[2], a)]
}

/// mᵀ a.
#[inline]
pub(crate) fn apply_transposed(m: &M3, a: V3) -> V3 {
    add(add(scale(a[0], m[0]), scale(a[1], m[1])), scale(a[2], m[2]))
}

#[inline]
pub(crate) fn product(a: &M3, b: &M3) -> M3 {
    [apply_transposed(b, a[0]), apply_transposed(b, a[1]), apply_transposed(b, a[2])]
}

/// Rotation about z [rad].
pub(crate) fn about_z(angle: f64) -> M3 {
    let (s, c) = angle.sin_cos();
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}

/// Unit quaternion w, x, y, z of a rotation, w >= 0.
pub(crate) fn quaternion(m: &M3) -> [f64; 4] {
    // The largest component first: Shepperd (1978).
    let trace = m[0][0] + m[1][1] + m[2][2];
    let squares = [trace, m[0][0], m[1][1], m[2][2]];
    let largest = (0..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let mut q = [0.0; 4];
    if largest == 0 {
        let w = 0.5 * (1.0 + trace).max(0.0).sqrt();
        let f = 0.25 / w;
        q = [w, f * (m[2][1] - m[1][2]), f * (m[0][2] - m[2][0]), f * (m[1][0] - m[0][1])];
    } else {
        let (i, j, k) = (largest - 1, largest % 3, (largest + 1) % 3);
        let x = 0.5 * (1.0 + m[i][i] - m[j][j] - m[k][k]).max(0.0).sqrt();
        let f = 0.25 / x;
        q[0] = f * (m[k][j] - m[j][k]);
        q[1 + i] = x;
        q[1 + j] = f * (m[i][j] + m[j][i]);
        q[1 + k] = f * (m[i][k] + m[k][i]);
    }
    if q[0] < 0.0 { q.map(|x| -x) } else { q }
}

/// Product of two quaternions w, x, y, z: the rotation `a` after `b`.
pub(crate) fn quaternion_product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let (v, w) = ([a[1], a[2], a[3]], [b[1], b[2], b[3]]);
    let c = cross(v, w);
    [
        a[0] * b[0] - dot(v, w),
        a[0] * w[0] + b[0] * v[0] + c[0],
        a[0] * w[1] + b[0] * v[1] + c[1],
        a[0] * w[2] + b[0] * v[2] + c[2],
    ]
}

/// Rotation by a vector of small or large angle [rad].
pub(crate) fn quaternion_of(rotation: V3) -> [f64; 4] {
    let angle = dot(rotation, rotation).sqrt();
    let f = if angle > 1e-12 { (0.5 * angle).sin() / angle } else { 0.5 };
    [(0.5 * angle).cos(), f * rotation[0], f * rotation[1], f * rotation[2]]
}

/// `a` turned by the quaternion `q`.
pub(crate) fn turn(q: [f64; 4], a: V3) -> V3 {
    let v = [q[1], q[2], q[3]];
    let t = scale(2.0, cross(v, a));
    add(a, add(scale(q[0], t), cross(v, t)))
}

/// LU factor with partial pivoting of a dense matrix by rows (n × n).
#[derive(Debug, Clone)]
pub(crate) struct Lu {
    n: usize,
    pub(crate) a: Vec<f64>,
    pivots: Vec<usize>,
    row: Vec<f64>,
}

impl Lu {
    pub(crate) fn new(n: usize) -> Self {
        Self { n, a: vec![0.0; n * n], pivots: vec![0; n], row: vec![0.0; n] }
    }

    /// Factorises `a`; returns false where it is singular or not finite.
    pub(crate) fn factorize(&mut self) -> bool {
        let n = self.n;
        for k in 0..n {
            let mut p = k;
            for i in k + 1..n {
                if self.a[i * n + k].abs() > self.a[p * n + k].abs() {
                    p = i;
                }
            }
            self.pivots[k] = p;
            let pivot = self.a[p * n + k];
            if !(pivot.abs() > 1e-30 && pivot.is_finite()) {
                return false;
            }
            if p != k {
                let (upper, lower) = self.a.split_at_mut(p * n);
                upper[k * n..k * n + n].swap_with_slice(&mut lower[..n]);
            }
            let (upper, lower) = self.a.split_at_mut((k + 1) * n);
            let pivot_row = &upper[k * n + k + 1..];
            for row in lower.chunks_exact_mut(n) {
                let factor = row[k] / pivot;
                row[k] = factor;
                if factor != 0.0 {
                    for (x, p) in row[k + 1..].iter_mut().zip(pivot_row) {
                        *x -= factor * p;
                    }
                }
            }
        }
        true
    }

    /// Solves for `b` in place (n).
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let n = self.n;
        for k in 0..n {
            b.swap(k, self.pivots[k]);
        }
        for i in 0..n {
            self.row[..i].copy_from_slice(&b[..i]);
            b[i] -= product_of(&self.a[i * n..i * n + i], &self.row[..i]);
        }
        for i in (0..n).rev() {
            let after = &b[i + 1..n];
            b[i] = (b[i] - product_of(&self.a[i * n + i + 1..(i + 1) * n], after)) / self.a[i * n + i];
        }
    }
}

/// Dot product in four sums: the order is fixed, and the processor can add in parallel.
fn product_of(a: &[f64], b: &[f64]) -> f64 {
    let (mut sums, mut rest) = ([0.0; 4], 0.0);
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    for (x, y) in a4.remainder().iter().zip(b4.remainder()) {
        rest += x * y;
    }
    for (x, y) in a4.zip(b4) {
        for i in 0..4 {
            sums[i] += x[i] * y[i];
        }
    }
    sums[0] + sums[1] + sums[2] + sums[3] + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_base::rng;
    use rand::RngExt;

    #[test]
    fn factor_solves_what_needs_pivots() {
        let (n, mut rng) = (13, rng(3, "virtual-rig/test/lu"));
        let mut matrix: Vec<f64> = (0..n * n).map(|_| rng.random_range(-1.0..1.0)).collect();
        matrix[0] = 0.0;
        let x: Vec<f64> = (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| matrix[i * n + j] * x[j]).sum()).collect();
        let mut lu = Lu::new(n);
        lu.a.copy_from_slice(&matrix);
        assert!(lu.factorize());
        lu.solve(&mut b);
        for (b, x) in b.iter().zip(&x) {
            assert!((b - x).abs() < 1e-11, "{b} {x}");
        }
        lu.a.fill(0.0);
        assert!(!lu.factorize());
    }

    #[test]
    fn quaternion_turns_like_its_matrix() {
        for rotation in [[0.1, -0.2, 0.3], [3.0, 0.5, 0.1], [0.1, -3.1, 0.0], [0.0, 0.2, 3.1]] {
            let q = quaternion_of(rotation);
            let columns = [turn(q, [1.0, 0.0, 0.0]), turn(q, [0.0, 1.0, 0.0]), turn(q, [0.0, 0.0, 1.0])];
            let matrix: M3 = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
            let back = quaternion(&matrix);
            let sign = if q[0] < 0.0 { -1.0 } else { 1.0 };
            assert!((0..4).all(|i| (back[i] - sign * q[i]).abs() < 1e-12), "{q:?} {back:?}");
            let twice = quaternion_product(q, q);
            let a = [0.3, -0.4, 0.5];
            let (once, other) = (turn(q, turn(q, a)), turn(twice, a));
            assert!((0..3).all(|i| (once[i] - other[i]).abs() < 1e-12));
        }
    }
}
