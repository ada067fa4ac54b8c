//! Masses and inertias of bodies: of shapes of one density, and what the settings of a file do to them.

use std::f64::consts::PI;

use nalgebra::{Matrix3, SymmetricEigen};

use super::settings::Settings;
use crate::spatial::{Inertia, Pose, Sym3, Vec3};

/// Volume [m³] or area [m²] of a shape, its centre [m], and second moment of inertia about it for density one.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShapeMoments {
    pub size: f64,
    pub centre: Vec3<f64>,
    pub second: Sym3<f64>,
}

impl ShapeMoments {
    /// A shape about the origin with axes of symmetry along x, y and z.
    fn centred(size: f64, [x, y, z]: Vec3<f64>) -> Self {
        Self { size, centre: [0.0; 3], second: [x, 0.0, y, 0.0, 0.0, z] }
    }

    /// Solid ellipsoid with half axes `r` [m].
    pub fn ellipsoid(r: Vec3<f64>) -> Self {
        let size = 4.0 / 3.0 * PI * r[0] * r[1] * r[2];
        let [x, y, z] = r.map(|r| r * r);
        Self::centred(size, [y + z, x + z, x + y].map(|s| size * s / 5.0))
    }

    /// Solid box with half edges `h` [m].
    pub fn solid_box(h: Vec3<f64>) -> Self {
        let size = 8.0 * h[0] * h[1] * h[2];
        let [x, y, z] = h.map(|h| h * h);
        Self::centred(size, [y + z, x + z, x + y].map(|s| size * s / 3.0))
    }

    /// Solid cylinder along z with radius and half length [m].
    pub fn cylinder(r: f64, h: f64) -> Self {
        let size = 2.0 * PI * r * r * h;
        let across = size * (3.0 * r * r + 4.0 * h * h) / 12.0;
        Self::centred(size, [across, across, size * r * r / 2.0])
    }

    /// Solid cylinder along z between two half balls, with radius and half length of the cylinder [m].
    pub fn capsule(r: f64, h: f64) -> Self {
        let (tube, balls) = (Self::cylinder(r, h), 4.0 / 3.0 * PI * r * r * r);
        let along = balls * 0.4 * r * r;
        // Half a ball has its centre 3/8 r from its face.
        let across = along + balls * h * (h + 0.75 * r);
        let [x, _, _, _, _, z] = tube.second;
        Self::centred(tube.size + balls, [x + across, x + across, z + along])
    }

    /// Surface of a ball with radius `r` [m].
    pub fn sphere_shell(r: f64) -> Self {
        let size = 4.0 * PI * r * r;
        Self::centred(size, [size * 2.0 / 3.0 * r * r; 3])
    }

    /// Surface of a box with half edges `h` [m].
    pub fn box_shell(h: Vec3<f64>) -> Self {
        let [x, y, z] = h;
        let faces = [8.0 * y * z, 8.0 * x * z, 8.0 * x * y];
        // Sums of the squares of each coordinate over the surface.
        let squares: [f64; 3] = std::array::from_fn(|k| {
            let spread: f64 = (0..3).filter(|f| *f != k).map(|f| faces[f]).sum();
            h[k] * h[k] * (faces[k] + spread / 3.0)
        });
        let [xx, yy, zz] = squares;
        Self::centred(faces.iter().sum(), [yy + zz, xx + zz, xx + yy])
    }

    /// Surface of a cylinder along z with both ends.
    pub fn cylinder_shell(r: f64, h: f64) -> Self {
        let (side, ends) = (4.0 * PI * r * h, 2.0 * PI * r * r);
        let along = side * r * r + ends * r * r / 2.0;
        let across = side * (r * r / 2.0 + h * h / 3.0) + ends * (r * r / 4.0 + h * h);
        Self::centred(side + ends, [across, across, along])
    }

    /// Surface of a capsule along z.
    pub fn capsule_shell(r: f64, h: f64) -> Self {
        let (side, balls) = (4.0 * PI * r * h, 4.0 * PI * r * r);
        let along = side * r * r + balls * 2.0 / 3.0 * r * r;
        // Half a sphere has its centre r/2 from its rim.
        let across = side * (r * r / 2.0 + h * h / 3.0) + balls * (2.0 / 3.0 * r * r + h * h + h * r);
        Self::centred(side + balls, [across, across, along])
    }

    /// The body of this shape with a density, placed at `pose`.
    pub fn body(&self, density: f64, pose: &Pose<f64>) -> Inertia<f64> {
        Inertia::about_centre(self.size * density, self.centre, self.second.map(|s| s * density))
            .placed(&pose.rotation, pose.position)
    }
}

/// A body of a file before its settings are applied, in its own axes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mass {
    /// [kg].
    pub mass: f64,
    /// Centre of mass [m].
    pub centre: Vec3<f64>,
    /// About the centre of mass [kg m²].
    pub second: Sym3<f64>,
    /// Part of its weight that is carried [-].
    pub compensation: f64,
}

impl Mass {
    /// That of a body with this inertia in its own frame.
    pub fn of(inertia: &Inertia<f64>) -> Self {
        let (centre, second) = (inertia.centre(), inertia.second_about_centre());
        Self { mass: inertia.mass, centre, second, compensation: 0.0 }
    }

    /// Its inertia in its own frame.
    pub fn inertia(&self) -> Inertia<f64> {
        Inertia::about_centre(self.mass, self.centre, self.second)
    }

    /// With the least mass and inertia that settings ask for, and balanced where they ask for that.
    fn bound(&mut self, settings: &Settings) {
        self.mass = self.mass.max(settings.least_mass);
        if settings.least_inertia == 0.0 && !settings.balances_inertia {
            return;
        }
        let s = self.second;
        let tensor = Matrix3::new(s[0], s[1], s[3], s[1], s[2], s[4], s[3], s[4], s[5]);
        let SymmetricEigen { eigenvalues: mut values, eigenvectors } = tensor.symmetric_eigen();
        let least = settings.least_inertia;
        let is_low = values.iter().any(|value| *value < least);
        values.iter_mut().for_each(|value| *value = value.max(least));
        let sum = values.sum();
        let is_unbalanced = settings.balances_inertia && values.iter().any(|value| sum - value < *value);
        if is_unbalanced {
            values.fill(sum / 3.0);
        }
        if is_low || is_unbalanced {
            let t = eigenvectors * Matrix3::from_diagonal(&values) * eigenvectors.transpose();
            self.second = [t[(0, 0)], t[(0, 1)], t[(1, 1)], t[(0, 2)], t[(1, 2)], t[(2, 2)]];
        }
    }
}

/// Applies least mass, least inertia and balance to the bodies of documents, and the total mass of the first one to all of them.
/// Every body comes with the number of its link and that of its document.
pub(super) fn apply(settings: &[&Settings], bodies: &mut [(usize, usize, Mass)]) {
    for (_, document, body) in bodies.iter_mut() {
        body.bound(settings[*document]);
    }
    if let Some(total_mass) = settings[0].total_mass {
        let total: f64 = bodies.iter().map(|(_, _, body)| body.mass).sum();
        for (_, _, body) in bodies.iter_mut().filter(|_| total > 0.0) {
            body.mass *= total_mass / total;
            body.second.iter_mut().for_each(|s| *s *= total_mass / total);
        }
    }
}
