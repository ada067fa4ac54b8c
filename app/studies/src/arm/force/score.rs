//! Errors of estimated forces compared with labels, and false contacts.

use hysteron_base::statistics::upper_quantile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ServoForceTelemetry;

/// Errors of one method on the trajectories of a task [N].
#[derive(Debug, Clone, Serialize, Deserialize, PartialEq)]
pub struct LoadedRow {
    /// Mean of three axes over all rows; a row without a label counts as 0 N, as the authors read their data.
    pub mean_n: f64,
    /// Mean of three axes over rows with a label.
    pub labelled_n: f64,
    /// z over rows with a label.
    pub z_n: f64,
    /// Norm of the error over rows with a label.
    pub norm_n: f64,
}

/// One method on contact-free trajectories.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema, PartialEq)]
pub struct FreeRow {
    /// Mean norm of the force [N].
    pub norm_n: f64,
    /// Rows with a contact that is none.
    pub contacts: FalseContacts,
}

/// Share of contact-free rows in which a force is above a threshold [-].
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema, PartialEq)]
pub struct FalseContacts {
    /// Above 0.5 N, the paper's noise floor.
    pub above_half_n: f64,
    /// Above what 99 % of the training rows stay below.
    pub above_learned: f64,
    /// That threshold [N].
    pub learned_n: f64,
}

/// A trajectory for a figure.
#[derive(Debug, Clone, Serialize, Deserialize, PartialEq)]
pub struct Trace {
    /// Its task.
    pub task: String,
    /// [s].
    pub time_s: Vec<f64>,
    /// Label of the force along z, 0 where there is none [N].
    pub label_n: Vec<f64>,
    /// Estimates along z, method by method [N].
    pub estimates_n: Vec<Vec<f64>>,
}

/// Norm above which a force is a contact [N].
const FLOOR: f64 = 0.5;
/// Share of training rows that a fitted threshold lets pass.
const QUANTILE: f64 = 0.99;

fn norm(force: &[f64; 3]) -> f64 {
    force.iter().map(|f| f * f).sum::<f64>().sqrt()
}

/// Sums of errors.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Errors {
    all: [f64; 2],
    labelled: f64,
    z: f64,
    norm: f64,
    n_labelled: f64,
}

impl Errors {
    pub fn add(&mut self, trajectory: &ServoForceTelemetry, forces: &[[f64; 3]]) {
        for ((label, is_labelled), force) in trajectory.force.iter().zip(&trajectory.is_labelled).zip(forces)
        {
            let error = [0, 1, 2].map(|axis| force[axis] - label[axis]);
            let mean = error.iter().map(|e| e.abs()).sum::<f64>() / 3.0;
            self.all[0] += mean;
            self.all[1] += 1.0;
            if *is_labelled {
                self.labelled += mean;
                self.z += error[2].abs();
                self.norm += norm(&error);
                self.n_labelled += 1.0;
            }
        }
    }

    pub fn row(&self) -> LoadedRow {
        let n = self.n_labelled.max(1.0);
        LoadedRow {
            mean_n: self.all[0] / self.all[1].max(1.0),
            labelled_n: self.labelled / n,
            z_n: self.z / n,
            norm_n: self.norm / n,
        }
    }
}

/// Threshold that [`QUANTILE`] of these forces stay below [N].
pub(super) fn learned_threshold(forces: &[[f64; 3]]) -> f64 {
    let mut norms: Vec<f64> = forces.iter().map(norm).collect();
    upper_quantile(&mut norms, QUANTILE).unwrap_or(0.0)
}

/// Counts over contact-free forces.
pub(super) fn free_row(forces: &[[f64; 3]], learned: f64) -> FreeRow {
    let n = forces.len().max(1) as f64;
    let share = |least: f64| forces.iter().filter(|force| norm(force) > least).count() as f64 / n;
    FreeRow {
        norm_n: forces.iter().map(norm).sum::<f64>() / n,
        contacts: FalseContacts {
            above_half_n: share(FLOOR),
            above_learned: share(learned),
            learned_n: learned,
        },
    }
}
