//! Spatial vectors and inertias.
//!
//! Motions and wrenches are taken about a common origin, in common axes (those of the world, unless a function states
//! otherwise), so that they add without transforms.
//!
//! # Reference
//! Featherstone (2008), Rigid Body Dynamics Algorithms, ch. 2.

use crate::Scalar;

/// x, y, z.
pub type Vec3<T> = [T; 3];
/// A 3×3 matrix, row by row.
pub type Mat3<T> = [[T; 3]; 3];

#[inline(always)]
pub(crate) fn add3<T: Scalar>(a: Vec3<T>, b: Vec3<T>) -> Vec3<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub3<T: Scalar>(a: Vec3<T>, b: Vec3<T>) -> Vec3<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + s b.
#[inline(always)]
pub(crate) fn add_scaled3<T: Scalar>(a: Vec3<T>, s: T, b: Vec3<T>) -> Vec3<T> {
    [s.mul_add(b[0], a[0]), s.mul_add(b[1], a[1]), s.mul_add(b[2], a[2])]
}

#[inline(always)]
pub(crate) fn scale3<T: Scalar>(s: T, a: Vec3<T>) -> Vec3<T> {
    [s * a[0], s * a[1], s * a[2]]
}

/// a · b.
#[inline(always)]
pub fn dot3<T: Scalar>(a: Vec3<T>, b: Vec3<T>) -> T {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// a · b + c.
#[inline(always)]
pub(crate) fn dot3_add<T: Scalar>(a: Vec3<T>, b: Vec3<T>, c: T) -> T {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2].mul_add(b[2], c)))
}

/// a × b.
#[inline(always)]
pub fn cross<T: Scalar>(a: Vec3<T>, b: Vec3<T>) -> Vec3<T> {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

/// a × b + c.
#[inline(always)]
pub(crate) fn cross_add<T: Scalar>(a: Vec3<T>, b: Vec3<T>, c: Vec3<T>) -> Vec3<T> {
    [
        a[1].mul_add(b[2], (-a[2]).mul_add(b[1], c[0])),
        a[2].mul_add(b[0], (-a[0]).mul_add(b[2], c[1])),
        a[0].mul_add(b[1], (-a[1]).mul_add(b[0], c[2])),
    ]
}

/// M a.
#[inline(always)]
pub fn mul3<T: Scalar>(m: &Mat3<T>, a: Vec3<T>) -> Vec3<T> {
    [dot3(m[0], a), dot3(m[1], a), dot3(m[2], a)]
}

/// M a + b.
#[inline(always)]
pub(crate) fn mul3_add<T: Scalar>(m: &Mat3<T>, a: Vec3<T>, b: Vec3<T>) -> Vec3<T> {
    [dot3_add(m[0], a, b[0]), dot3_add(m[1], a, b[1]), dot3_add(m[2], a, b[2])]
}

/// Mᵀ a.
#[inline(always)]
pub(crate) fn mul3_transposed<T: Scalar>(m: &Mat3<T>, a: Vec3<T>) -> Vec3<T> {
    add_scaled3(add_scaled3(scale3(a[0], m[0]), a[1], m[1]), a[2], m[2])
}

/// Mᵀ a + b.
#[inline(always)]
pub(crate) fn mul3_transposed_add<T: Scalar>(m: &Mat3<T>, a: Vec3<T>, b: Vec3<T>) -> Vec3<T> {
    add_scaled3(add_scaled3(add_scaled3(b, a[0], m[0]), a[1], m[1]), a[2], m[2])
}

/// A B, of which B is constant.
#[inline(always)]
pub(crate) fn mul3_constant<T: Scalar>(a: &Mat3<T>, b: &Mat3<f64>) -> Mat3<T> {
    let like = a[0][0];
    let b = [splat3(like, b[0]), splat3(like, b[1]), splat3(like, b[2])];
    [mul3_transposed(&b, a[0]), mul3_transposed(&b, a[1]), mul3_transposed(&b, a[2])]
}

/// The constant vector `a`, as numbers of the kind of `like`.
#[inline(always)]
pub(crate) fn splat3<T: Scalar>(like: T, a: Vec3<f64>) -> Vec3<T> {
    [like.splat(a[0]), like.splat(a[1]), like.splat(a[2])]
}

/// Symmetric 3×3 matrix: xx, xy, yy, xz, yz, zz.
pub type Sym3<T> = [T; 6];

/// S a.
#[inline(always)]
pub(crate) fn sym3_mul<T: Scalar>(s: &Sym3<T>, a: Vec3<T>) -> Vec3<T> {
    [dot3([s[0], s[1], s[3]], a), dot3([s[1], s[2], s[4]], a), dot3([s[3], s[4], s[5]], a)]
}

/// S a + b.
#[inline(always)]
pub(crate) fn sym3_mul_add<T: Scalar>(s: &Sym3<T>, a: Vec3<T>, b: Vec3<T>) -> Vec3<T> {
    [
        dot3_add([s[0], s[1], s[3]], a, b[0]),
        dot3_add([s[1], s[2], s[4]], a, b[1]),
        dot3_add([s[3], s[4], s[5]], a, b[2]),
    ]
}

/// R S Rᵀ.
#[inline(always)]
pub(crate) fn sym3_rotated<T: Scalar>(s: &Sym3<T>, r: &Mat3<T>) -> Sym3<T> {
    let [x, y, z] = [sym3_mul(s, r[0]), sym3_mul(s, r[1]), sym3_mul(s, r[2])];
    [dot3(r[0], x), dot3(r[0], y), dot3(r[1], y), dot3(r[0], z), dot3(r[1], z), dot3(r[2], z)]
}

/// Angular and linear velocity, or acceleration, of the point of a body that lies at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpatialMotion<T> {
    /// [rad/s], [rad/s²].
    pub angular: Vec3<T>,
    /// [m/s], [m/s²].
    pub linear: Vec3<T>,
}

/// Moment about the origin, and force; or angular and linear momentum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench<T> {
    /// [N m], [N m s].
    pub moment: Vec3<T>,
    /// [N], [N s].
    pub force: Vec3<T>,
}

impl<T: Scalar> SpatialMotion<T> {
    /// Zero, as numbers of the kind of `like`.
    #[inline(always)]
    pub fn zero(like: T) -> Self {
        Self { angular: [like.splat(0.0); 3], linear: [like.splat(0.0); 3] }
    }

    /// self + other.
    #[inline(always)]
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { angular: add3(self.angular, other.angular), linear: add3(self.linear, other.linear) }
    }

    /// self + s · other.
    #[inline(always)]
    pub(crate) fn plus_scaled(&self, s: T, other: &Self) -> Self {
        Self {
            angular: add_scaled3(self.angular, s, other.angular),
            linear: add_scaled3(self.linear, s, other.linear),
        }
    }

    /// s · self.
    #[inline(always)]
    pub(crate) fn scaled(&self, s: T) -> Self {
        Self { angular: scale3(s, self.angular), linear: scale3(s, self.linear) }
    }

    /// self × other.
    #[inline(always)]
    pub(crate) fn cross(&self, other: &Self) -> Self {
        Self {
            angular: cross(self.angular, other.angular),
            linear: cross_add(self.angular, other.linear, cross(self.linear, other.angular)),
        }
    }

    /// self ×* wrench.
    #[inline(always)]
    pub(crate) fn cross_wrench(&self, w: &Wrench<T>) -> Wrench<T> {
        Wrench {
            moment: cross_add(self.angular, w.moment, cross(self.linear, w.force)),
            force: cross(self.angular, w.force),
        }
    }

    /// Power: self · wrench.
    #[inline(always)]
    pub(crate) fn dot(&self, w: &Wrench<T>) -> T {
        dot3_add(self.angular, w.moment, dot3(self.linear, w.force))
    }

    /// Linear velocity of the point of the body at `point`.
    #[inline(always)]
    pub(crate) fn at(&self, point: Vec3<T>) -> Vec3<T> {
        cross_add(self.angular, point, self.linear)
    }
}

impl<T: Scalar> Wrench<T> {
    /// Zero, as numbers of the kind of `like`.
    #[inline(always)]
    pub fn zero(like: T) -> Self {
        Self { moment: [like.splat(0.0); 3], force: [like.splat(0.0); 3] }
    }

    /// self + other.
    #[inline(always)]
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { moment: add3(self.moment, other.moment), force: add3(self.force, other.force) }
    }

    /// self − other.
    #[inline(always)]
    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self { moment: sub3(self.moment, other.moment), force: sub3(self.force, other.force) }
    }

    /// self + s · other.
    #[inline(always)]
    pub(crate) fn plus_scaled(&self, s: T, other: &Self) -> Self {
        Self {
            moment: add_scaled3(self.moment, s, other.moment),
            force: add_scaled3(self.force, s, other.force),
        }
    }

    /// The force `force` and the torque `torque` that act at `point`, about the origin.
    #[inline(always)]
    pub(crate) fn at(point: Vec3<T>, force: Vec3<T>, torque: Vec3<T>) -> Self {
        Self { moment: cross_add(point, force, torque), force }
    }
}

/// Inertia of a rigid body about the origin: ten numbers in which dynamics are linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia<T> {
    /// Mass m [kg].
    pub mass: T,
    /// First moment m c, c the centre of mass [kg m].
    pub first: Vec3<T>,
    /// Second moment about the origin (not the centre of mass): xx, xy, yy, xz, yz, zz [kg m²].
    pub second: Sym3<T>,
}

impl<T: Scalar> Inertia<T> {
    /// The ten parameters in the order m, m c, xx, xy, yy, xz, yz, zz.
    pub fn parameters(&self) -> [T; 10] {
        let ([hx, hy, hz], [a, b, c, d, e, f]) = (self.first, self.second);
        [self.mass, hx, hy, hz, a, b, c, d, e, f]
    }

    /// The inverse of [`Self::parameters`].
    pub fn from_parameters(p: [T; 10]) -> Self {
        Self { mass: p[0], first: [p[1], p[2], p[3]], second: [p[4], p[5], p[6], p[7], p[8], p[9]] }
    }

    /// The inertia times a motion: momentum of a velocity.
    #[inline(always)]
    pub(crate) fn mul(&self, m: &SpatialMotion<T>) -> Wrench<T> {
        Wrench {
            moment: sym3_mul_add(&self.second, m.angular, cross(self.first, m.linear)),
            force: cross_add(m.angular, self.first, scale3(self.mass, m.linear)),
        }
    }

    #[inline(always)]
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let mut second = self.second;
        for (a, b) in second.iter_mut().zip(other.second) {
            *a = *a + b;
        }
        Self { mass: self.mass + other.mass, first: add3(self.first, other.first), second }
    }

    /// The same body in a frame in which its own frame is at `rotation`, `position`.
    #[inline(always)]
    pub fn placed(&self, rotation: &Mat3<T>, position: Vec3<T>) -> Self {
        let p = position;
        let turned = mul3(rotation, self.first);
        // Parallel axes: R J Rᵀ + 2 (p·u) 1 − p uᵀ − u pᵀ with u = R h + m p / 2.
        let u = add_scaled3(turned, self.mass.scale(0.5), p);
        let [xx, xy, yy, xz, yz, zz] = sym3_rotated(&self.second, rotation);
        let [x, y, z] = [p[0] * u[0], p[1] * u[1], p[2] * u[2]];
        let (yz2, xz2, xy2) = (y + z, x + z, x + y);
        Self {
            mass: self.mass,
            first: add_scaled3(turned, self.mass, p),
            second: [
                xx + yz2 + yz2,
                (-p[0]).mul_add(u[1], (-u[0]).mul_add(p[1], xy)),
                yy + xz2 + xz2,
                (-p[0]).mul_add(u[2], (-u[0]).mul_add(p[2], xz)),
                (-p[1]).mul_add(u[2], (-u[1]).mul_add(p[2], yz)),
                zz + xy2 + xy2,
            ],
        }
    }

    /// Gradient of x · (I y) with respect to the ten parameters.
    #[inline(always)]
    pub(crate) fn gradient(x: &SpatialMotion<T>, y: &SpatialMotion<T>) -> [T; 10] {
        // x·Iy = m x_v·y_v + x_v·(y_ω × h) + x_ω·(h × y_v) + x_ωᵀ J y_ω.
        let h = add3(cross(x.linear, y.angular), cross(y.linear, x.angular));
        let (a, b) = (x.angular, y.angular);
        [
            dot3(x.linear, y.linear),
            h[0],
            h[1],
            h[2],
            a[0] * b[0],
            a[0].mul_add(b[1], a[1] * b[0]),
            a[1] * b[1],
            a[0].mul_add(b[2], a[2] * b[0]),
            a[1].mul_add(b[2], a[2] * b[1]),
            a[2] * b[2],
        ]
    }
}

impl Inertia<f64> {
    /// No mass.
    pub const ZERO: Self = Self { mass: 0.0, first: [0.0; 3], second: [0.0; 6] };

    /// A body from its mass [kg], centre of mass [m] and second moment about the centre of mass [kg m²].
    pub fn about_centre(mass: f64, centre: Vec3<f64>, second: Sym3<f64>) -> Self {
        const UNIT: Mat3<f64> = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { mass, first: [0.0; 3], second }.placed(&UNIT, centre)
    }

    /// Centre of mass [m]; the origin where there is no mass.
    pub fn centre(&self) -> Vec3<f64> {
        if self.mass == 0.0 { [0.0; 3] } else { self.first.map(|h| h / self.mass) }
    }

    /// Second moment about the centre of mass [kg m²].
    pub fn second_about_centre(&self) -> Sym3<f64> {
        let (c, h, s) = (self.centre(), self.first, self.second);
        let trace = dot3(c, h);
        [
            s[0] - trace + c[0] * h[0],
            s[1] + c[0] * h[1],
            s[2] - trace + c[1] * h[1],
            s[3] + c[0] * h[2],
            s[4] + c[1] * h[2],
            s[5] - trace + c[2] * h[2],
        ]
    }
}

/// Inertia of a body that carries joints which give way: a symmetric 6×6 matrix, [J H; Hᵀ M].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Articulated<T> {
    pub second: Sym3<T>,
    pub coupling: Mat3<T>,
    pub mass: Sym3<T>,
}

impl<T: Scalar> Articulated<T> {
    #[inline(always)]
    pub fn rigid(i: &Inertia<T>) -> Self {
        let (z, [x, y, w]) = (i.mass.splat(0.0), i.first);
        Self {
            second: i.second,
            coupling: [[z, -w, y], [w, z, -x], [-y, x, z]],
            mass: [i.mass, z, i.mass, z, z, i.mass],
        }
    }

    #[inline(always)]
    pub fn mul(&self, m: &SpatialMotion<T>) -> Wrench<T> {
        Wrench {
            moment: sym3_mul_add(&self.second, m.angular, mul3(&self.coupling, m.linear)),
            force: mul3_transposed_add(&self.coupling, m.angular, sym3_mul(&self.mass, m.linear)),
        }
    }

    /// self + other − s · u uᵀ.
    #[inline(always)]
    pub fn plus_reduced(&self, other: &Self, s: T, u: &Wrench<T>) -> Self {
        let (m, f) = (scale3(-s, u.moment), scale3(-s, u.force));
        let (h, g) = (&self.coupling, &other.coupling);
        Self {
            second: sym3_sum_with(&self.second, &other.second, m, u.moment),
            coupling: [
                add_scaled3(add3(h[0], g[0]), m[0], u.force),
                add_scaled3(add3(h[1], g[1]), m[1], u.force),
                add_scaled3(add3(h[2], g[2]), m[2], u.force),
            ],
            mass: sym3_sum_with(&self.mass, &other.mass, f, u.force),
        }
    }
}

/// p + q + x yᵀ, which is symmetric.
#[inline(always)]
fn sym3_sum_with<T: Scalar>(p: &Sym3<T>, q: &Sym3<T>, x: Vec3<T>, y: Vec3<T>) -> Sym3<T> {
    [
        x[0].mul_add(y[0], p[0] + q[0]),
        x[0].mul_add(y[1], p[1] + q[1]),
        x[1].mul_add(y[1], p[2] + q[2]),
        x[0].mul_add(y[2], p[3] + q[3]),
        x[1].mul_add(y[2], p[4] + q[4]),
        x[2].mul_add(y[2], p[5] + q[5]),
    ]
}

/// A frame in another: where its axes point (columns) and where its origin is [m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose<T> {
    /// Columns: the axes of the frame.
    pub rotation: Mat3<T>,
    /// Origin [m].
    pub position: Vec3<T>,
}

impl Pose<f64> {
    /// The same frame.
    pub const IDENTITY: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], position: [0.0; 3] };
}

impl<T: Scalar> Pose<T> {
    /// The frame at the constant pose `inner` in this one.
    #[inline(always)]
    pub(crate) fn times(&self, inner: &Pose<f64>) -> Self {
        let like = self.position[0];
        Self {
            rotation: mul3_constant(&self.rotation, &inner.rotation),
            position: mul3_add(&self.rotation, splat3(like, inner.position), self.position),
        }
    }
}
