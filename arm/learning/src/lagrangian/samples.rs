//! Samples of motions with their torques, in trajectories.

use std::ops::Range;

use hysteron_base::BadInput;

use hysteron_arm_dynamics::JointKind;

/// A length of one that hardly moves [m].
const SHORTEST: f64 = 1e-6;

/// States and torques of an arm, trajectory after trajectory. Arrays are [sample][joint].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ArmSamples {
    /// Joints.
    pub n_joints: usize,
    /// Which of them turn, and which slide.
    pub kinds: Vec<JointKind>,
    /// Positions [rad or m].
    pub q: Vec<f64>,
    /// Velocities.
    pub dq: Vec<f64>,
    /// Accelerations.
    pub ddq: Vec<f64>,
    /// Torques [N m or N].
    pub tau: Vec<f64>,
    /// Generalised momenta and their rates, where they are known; else empty.
    pub momenta: [Vec<f64>; 2],
    /// Samples of every trajectory, in order.
    pub trajectories: Vec<Range<usize>>,
}

impl ArmSamples {
    /// No samples yet, of joints that turn.
    pub fn new(n_joints: usize) -> Self {
        Self::of_joints(vec![JointKind::Revolute; n_joints])
    }

    /// No samples yet.
    pub fn of_joints(kinds: Vec<JointKind>) -> Self {
        Self { n_joints: kinds.len(), kinds, ..Self::default() }
    }

    /// Scale of every joint's coordinate for networks ([`super::NetworkShape::lengths`]): `None` of an angle,
    /// the standard deviation [m] of a length.
    pub fn lengths(&self) -> Vec<Option<f64>> {
        let spreads = self.deviations(&self.q);
        let of = |(kind, spread): (&JointKind, f64)| match kind {
            JointKind::Revolute => None,
            JointKind::Prismatic => Some(spread.max(SHORTEST)),
        };
        self.kinds.iter().zip(spreads).map(of).collect()
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.tau.len() / self.n_joints.max(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.tau.is_empty()
    }

    /// Adds one trajectory: q, q̇, q̈, τ, each [sample][joint]; p and ṗ may be empty.
    ///
    /// # Errors
    /// `BadInput` naming the array and row that has another number of joints, or is not finite.
    pub fn push(&mut self, motion: [&[f64]; 4], momenta: [&[f64]; 2]) -> Result<(), BadInput> {
        let names = ["q", "dq", "ddq", "tau", "p", "pdot"];
        let n = self.n_joints;
        let expected = motion[0].len();
        for (name, values) in names.iter().zip(motion.iter().chain(&momenta)) {
            let may_be_empty = name.starts_with('p') && values.is_empty();
            if (values.len() != expected || values.len() % n != 0 || values.is_empty()) && !may_be_empty {
                let rows = format!("{} samples of {n} joints", expected / n);
                return Err(BadInput::new(*name, rows, format!("{} numbers", values.len())));
            }
            if let Some(at) = values.iter().position(|v| !v.is_finite()) {
                let place = format!("{name}: sample {}, joint {}", at / n + 1, at % n + 1);
                return Err(BadInput::new(place, "a finite number", values[at].to_string()));
            }
        }
        let start = self.len();
        let all = [&mut self.q, &mut self.dq, &mut self.ddq, &mut self.tau];
        for (all, values) in all.into_iter().zip(motion) {
            all.extend_from_slice(values);
        }
        for (all, values) in self.momenta.iter_mut().zip(momenta) {
            all.extend_from_slice(values);
        }
        self.trajectories.push(start..self.len());
        Ok(())
    }

    /// Adds all trajectories of `other`.
    ///
    /// # Errors
    /// `BadInput` where it has another number of joints, or one slides that turns here.
    pub fn append(&mut self, other: &Self) -> Result<(), BadInput> {
        if other.n_joints != self.n_joints {
            let expected = format!("{} joints, as in the others", self.n_joints);
            return Err(BadInput::new("recording", expected, other.n_joints.to_string()));
        }
        if let Some(j) = (0..self.n_joints).find(|j| self.kinds[*j] != other.kinds[*j]) {
            let unit = |kind| if kind == JointKind::Revolute { "rad" } else { "m" };
            let expected = format!("q_{}_{}, as in the others", j + 1, unit(self.kinds[j]));
            return Err(BadInput::new(
                "recording",
                expected,
                format!("q_{}_{}", j + 1, unit(other.kinds[j])),
            ));
        }
        let first = self.len();
        for (all, values) in [
            (&mut self.q, &other.q),
            (&mut self.dq, &other.dq),
            (&mut self.ddq, &other.ddq),
            (&mut self.tau, &other.tau),
        ] {
            all.extend_from_slice(values);
        }
        for (all, values) in self.momenta.iter_mut().zip(&other.momenta) {
            all.extend_from_slice(values);
        }
        self.trajectories.extend(other.trajectories.iter().map(|t| first + t.start..first + t.end));
        Ok(())
    }

    /// The same samples, every trajectory in `parts` of equal length.
    ///
    /// # Errors
    /// `BadInput` where a trajectory is shorter than that.
    pub fn parted(mut self, parts: usize) -> Result<Self, BadInput> {
        let short = self.trajectories.iter().find(|t| t.len() < parts);
        if let Some(short) = short {
            let expected = format!("{parts} samples or more");
            return Err(BadInput::new("recording", expected, short.len().to_string()));
        }
        let part = |t: &Range<usize>, k: usize| t.start + k * t.len() / parts;
        let of = |t: &Range<usize>| (0..parts).map(|k| part(t, k)..part(t, k + 1)).collect::<Vec<_>>();
        self.trajectories = self.trajectories.iter().flat_map(of).collect();
        Ok(self)
    }

    /// The trajectories of these numbers, in this order.
    pub fn select(&self, trajectories: impl IntoIterator<Item = usize>) -> Self {
        let mut found = Self::of_joints(self.kinds.clone());
        for t in trajectories {
            let Range { start, end } = self.trajectories[t];
            let part = self.n_joints * start..self.n_joints * end;
            let first = found.len();
            found.q.extend_from_slice(&self.q[part.clone()]);
            found.dq.extend_from_slice(&self.dq[part.clone()]);
            found.ddq.extend_from_slice(&self.ddq[part.clone()]);
            found.tau.extend_from_slice(&self.tau[part.clone()]);
            for (all, values) in found.momenta.iter_mut().zip(&self.momenta) {
                all.extend_from_slice(values.get(part.clone()).unwrap_or_default());
            }
            found.trajectories.push(first..first + (end - start));
        }
        found
    }

    /// Every `stride`-th sample of every trajectory.
    pub fn thinned(&self, stride: usize) -> Self {
        let selected: Vec<usize> = self.trajectories.iter().flat_map(|t| t.clone().step_by(stride)).collect();
        let mut start = 0;
        let trajectories = self.trajectories.iter().map(|t| {
            start += t.len().div_ceil(stride);
            start - t.len().div_ceil(stride)..start
        });
        Self { trajectories: trajectories.collect(), ..self.rows(&selected) }
    }

    /// Samples of these numbers, as one trajectory.
    pub fn rows(&self, rows: &[usize]) -> Self {
        let n = self.n_joints;
        let take = |values: &Vec<f64>| -> Vec<f64> {
            rows.iter()
                .flat_map(|i| values.get(n * i..n * (i + 1)).unwrap_or_default().iter().copied())
                .collect()
        };
        Self {
            n_joints: n,
            kinds: self.kinds.clone(),
            trajectories: std::iter::once(0..rows.len()).collect(),
            q: take(&self.q),
            dq: take(&self.dq),
            ddq: take(&self.ddq),
            tau: take(&self.tau),
            momenta: [take(&self.momenta[0]), take(&self.momenta[1])],
        }
    }

    /// Standard deviations of every joint of an array [sample][joint] about its mean.
    pub fn deviations(&self, values: &[f64]) -> Vec<f64> {
        self.variances(values).into_iter().map(f64::sqrt).collect()
    }

    /// Variances of every joint of an array [sample][joint] about its mean.
    pub fn variances(&self, values: &[f64]) -> Vec<f64> {
        let rows = (values.len() / self.n_joints) as f64;
        (0..self.n_joints)
            .map(|j| {
                let column = || values.iter().skip(j).step_by(self.n_joints);
                let mean = column().sum::<f64>() / rows;
                column().map(|v| (v - mean).powi(2)).sum::<f64>() / rows
            })
            .collect()
    }

    /// # Errors
    /// `BadInput` naming a joint whose torque or position never changes: nothing can be learned of it, and errors cannot be
    /// measured in units of its variance.
    pub fn check_variation(&self) -> Result<(), BadInput> {
        for (name, values) in [("q", &self.q), ("tau", &self.tau)] {
            if let Some(j) = self.variances(values).iter().position(|v| *v <= 1e-20) {
                return Err(BadInput::new(
                    format!("{name}: joint {}", j + 1),
                    "values that change",
                    "a constant",
                )
                .hint("leave out joints that do not move"));
            }
        }
        Ok(())
    }
}
