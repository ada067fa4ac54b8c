//! A section between two interfaces: its objective strain, the variations of it, and the law that condensation gave it.
//!
//! With frames (c, R) of the interfaces a and b, ψ = log(R_aᵀ R_b), R_e = R_a exp(ψ/2), c_e = (c_a + c_b)/2 and
//! v = R_eᵀ (c_b - c_a) the strain is ε = (v - v_0, ψ, w_a, w_b): a rigid motion of both frames changes nothing.
//!
//! # References
//! Simo, Vu-Quoc (1986), A three-dimensional finite-strain rod model, part II; Jelenić, Crisfield (1999), Geometrically exact 3D
//! beam theory: implementation of a strain-invariant finite element.

use hysteron_base::lanes::{Isa, Simd, WithSimd};
use nalgebra::{Matrix3, Vector3};

use super::band::BlockVector;
use super::continuation::Continuation;
use super::cubic::Cubic;
use super::rotation::{HalfAngle, exp, log};
use super::{PADDED, POSE, STRAIN, Strain, WARPINGS};

/// Where an interface is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// Centre [m].
    pub center: Vector3<f64>,
    /// Rotation since rest.
    pub rotation: Matrix3<f64>,
    /// Amplitudes of its warpings [m].
    pub warping: [f64; WARPINGS],
}

/// Law of a section.
#[derive(Debug, Clone)]
pub(crate) struct SectionLaw {
    /// v at rest [m].
    pub rest: Vector3<f64>,
    /// K_e, by rows.
    pub stiffness: [Strain; STRAIN],
    /// A_e.
    pub cubic: Cubic,
    /// Young's modulus times the section's volume [J].
    pub scale: f64,
}

impl SectionLaw {
    /// Stress and energy at a strain.
    pub fn stress(&self, isa: Isa, strain: &Strain) -> Stressed {
        let StressParts { linear, quadratic, of_cubic: mut stress, cubic } = self.parts(isa, strain);
        let (energy, factors) = match Continuation::of(quadratic, cubic) {
            None => (quadratic + cubic, [1.0, 1.0]),
            Some(soft) => (quadratic * soft.energy, [soft.of_quadratic, soft.of_cubic]),
        };
        for (stress, linear) in stress.iter_mut().zip(&linear) {
            *stress = factors[0] * linear + factors[1] * *stress;
        }
        Stressed { stress, energy, size: (2.0 * quadratic / self.scale).sqrt() }
    }

    /// K ε and ½ A[ε, ε] with their energies.
    fn parts(&self, isa: Isa, strain: &Strain) -> StressParts {
        let (mut linear, mut of_cubic) = ([0.0; PADDED], [0.0; PADDED]);
        self.cubic.add_stress(isa, strain, &mut of_cubic);
        isa.run(LinearStrain { stiffness: &self.stiffness, strain, stress: &mut linear });
        let work = |stress: &Strain| stress.iter().zip(strain).map(|(s, e)| s * e).sum::<f64>();
        StressParts { quadratic: 0.5 * work(&linear), cubic: work(&of_cubic) / 3.0, linear, of_cubic }
    }

    /// The quadratic and the cubic part of the energy [J].
    #[cfg(test)]
    pub fn energies(&self, strain: &Strain) -> (f64, f64) {
        let StressParts { quadratic, cubic, .. } = self.parts(Isa::detect(), strain);
        (quadratic, cubic)
    }

    /// Makes the material stiffer by a factor.
    pub fn scale_by(&mut self, factor: f64) {
        self.stiffness.as_flattened_mut().iter_mut().for_each(|entry| *entry *= factor);
        self.cubic.scale_by(factor);
        self.scale *= factor;
    }

    /// ∂σ/∂ε, by rows: K + A ε but where the energy is continued.
    pub fn tangent(&self, isa: Isa, strain: &Strain) -> [Strain; STRAIN] {
        let StressParts { linear, quadratic, of_cubic, cubic } = self.parts(isa, strain);
        let Some(soft) = Continuation::of(quadratic, cubic) else {
            let mut tangent = self.stiffness;
            self.cubic.add_tangent(isa, strain, &mut tangent);
            return tangent;
        };
        let mut tangent = [[0.0; PADDED]; STRAIN];
        self.cubic.add_tangent(isa, strain, &mut tangent);
        // Q ∂c/∂ε; the ratio's own change adds Q g'' ∂c ∂cᵀ.
        let ratio: Strain = std::array::from_fn(|k| of_cubic[k] - soft.ratio * linear[k]);
        for (i, (row, stiffness)) in tangent.iter_mut().zip(&self.stiffness).enumerate() {
            let of_ratio = soft.curvature / quadratic * ratio[i];
            for k in 0..STRAIN {
                row[k] = soft.of_quadratic * stiffness[k] + soft.of_cubic * row[k] + of_ratio * ratio[k];
            }
        }
        tangent
    }
}

/// A section under strain.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stressed {
    /// σ.
    pub stress: Strain,
    /// W [J].
    pub energy: f64,
    /// Root of twice the quadratic energy over E V [-].
    pub size: f64,
}

/// The two parts of a stress and of its energy.
struct StressParts {
    linear: Strain,
    quadratic: f64,
    of_cubic: Strain,
    cubic: f64,
}

/// Adds K ε.
struct LinearStrain<'a> {
    stiffness: &'a [Strain; STRAIN],
    strain: &'a Strain,
    stress: &'a mut Strain,
}

impl WithSimd for LinearStrain<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let mut sum = *self.stress;
        for (row, strain) in self.stiffness.iter().zip(self.strain) {
            for k in 0..PADDED {
                sum[k] += row[k] * strain;
            }
        }
        *self.stress = sum;
    }
}

/// The section's own frame, its strain, and what their variations need.
#[derive(Debug, Clone)]
pub(crate) struct StrainedPose {
    /// c_e [m].
    pub center: Vector3<f64>,
    /// R_e.
    pub rotation: Matrix3<f64>,
    /// v [m].
    pub chord: Vector3<f64>,
    /// η = ψ/2.
    pub half: Vector3<f64>,
    pub coefficients: HalfAngle,
    /// H⁻¹ in δψ = H⁻¹ (β - α).
    pub spread_inverse: Matrix3<f64>,
    /// ε, padded.
    pub strain: Strain,
}

impl StrainedPose {
    pub fn new(a: &Interface, b: &Interface, rest: &Vector3<f64>) -> Self {
        let psi = log(&(a.rotation.transpose() * b.rotation));
        let half = 0.5 * psi;
        let rotation = a.rotation * exp(&half);
        let chord = rotation.transpose() * (b.center - a.center);
        let coefficients = HalfAngle::new(half.norm_squared());
        let cross = half.cross_matrix();
        let q = -coefficients.g / (1.0 - coefficients.g * half.norm_squared());
        let mut strain = [0.0; PADDED];
        for c in 0..3 {
            strain[c] = chord[c] - rest[c];
            strain[3 + c] = psi[c];
        }
        strain[POSE..POSE + WARPINGS].copy_from_slice(&a.warping);
        strain[POSE + WARPINGS..STRAIN].copy_from_slice(&b.warping);
        Self {
            center: 0.5 * (a.center + b.center),
            rotation,
            chord,
            half,
            coefficients,
            spread_inverse: Matrix3::identity() + q * cross * cross,
            strain,
        }
    }

    /// H.
    pub fn spread(&self) -> Matrix3<f64> {
        let cross = self.half.cross_matrix();
        Matrix3::identity() + self.coefficients.g * cross * cross
    }

    /// Adds the generalised forces on the two interfaces that do the work σ·δε + F·δc_e + τ·ω, with σ and τ in the section's
    /// frame and F in space: per interface force, moment and the forces of its warpings. `None` stands for one that is clamped.
    pub fn add_work(
        &self,
        stress: &Strain,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
        a: Option<&mut BlockVector>,
        b: &mut BlockVector,
    ) {
        let (n, m) = (head(stress), middle(stress));
        let couple = n.cross(&self.chord) + moment;
        let m = m - 0.5 * self.coefficients.kappa * couple.cross(&self.half);
        let bending = self.spread_inverse * m;
        let normal = self.rotation * n;
        add(b, &(normal + 0.5 * force), &(self.rotation * (0.5 * couple + bending)));
        for k in 0..WARPINGS {
            b[POSE + k] += stress[POSE + WARPINGS + k];
        }
        if let Some(a) = a {
            add(a, &(0.5 * force - normal), &(self.rotation * (0.5 * couple - bending)));
            for k in 0..WARPINGS {
                a[POSE + k] += stress[POSE + k];
            }
        }
    }
}

/// σ_1..3.
pub(crate) fn head(stress: &Strain) -> Vector3<f64> {
    Vector3::new(stress[0], stress[1], stress[2])
}

/// σ_4..6.
pub(crate) fn middle(stress: &Strain) -> Vector3<f64> {
    Vector3::new(stress[3], stress[4], stress[5])
}

fn add(block: &mut BlockVector, force: &Vector3<f64>, moment: &Vector3<f64>) {
    for c in 0..3 {
        block[c] += force[c];
        block[3 + c] += moment[c];
    }
}

/// The frame that a part moves with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Site {
    /// With the frame of a section's end interface, that of the section's number: its warping is the last part of the section's
    /// strain.
    End(usize),
    /// With the frame of a section.
    Within(usize),
}

impl Site {
    /// The section.
    pub fn section(self) -> usize {
        match self {
            Self::End(e) | Self::Within(e) => e,
        }
    }

    /// The strains that it moves with, whole registers of them.
    pub fn strain(self, strain: &Strain) -> &[f64] {
        match self {
            Self::End(_) => &strain[POSE + WARPINGS..],
            Self::Within(_) => strain,
        }
    }

    /// The same, to change.
    pub fn strain_mut(self, strain: &mut Strain) -> &mut [f64] {
        match self {
            Self::End(_) => &mut strain[POSE + WARPINGS..],
            Self::Within(_) => strain,
        }
    }

    /// First interface that moves it, counted from the clamp.
    pub fn first(self) -> usize {
        match self {
            Self::End(e) => e + 1,
            Self::Within(e) => e,
        }
    }
}
