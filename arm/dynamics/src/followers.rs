//! Joints that follow others: q = G u + o with one row of G for each joint and u the joints that follow none.

use crate::{Joint, Model, Scalar};

/// G and o of a model.
#[derive(Debug, Clone)]
pub(crate) struct Followers {
    /// Of every joint: which independent one leads it, by its place among them, with ratio and offset.
    pub leaders: Vec<(usize, f64, f64)>,
    /// The joints that follow none.
    pub independent: Vec<usize>,
    /// Range of every independent joint, with those of its followers.
    pub ranges: Vec<Option<[f64; 2]>>,
}

impl Followers {
    /// Those of `model`.
    pub fn new(model: &Model) -> Self {
        let independent: Vec<usize> =
            (0..model.n_joints()).filter(|i| model.joints[*i].follows.is_none()).collect();
        let place = |joint: usize| independent.iter().position(|i| *i == joint).unwrap_or(0);
        let leader = |(i, joint): (usize, &Joint)| match joint.follows {
            Some(follower) => (place(follower.joint), follower.ratio, follower.offset),
            None => (place(i), 1.0, 0.0),
        };
        let leaders: Vec<_> = model.joints.iter().enumerate().map(leader).collect();
        let mut ranges = vec![None; independent.len()];
        for (joint, &(u, ratio, offset)) in model.joints.iter().zip(&leaders) {
            ranges[u] = common_range(ranges[u], joint.drive.range, (ratio, offset));
        }
        Self { leaders, independent, ranges }
    }

    /// Puts the joints that follow where their leaders want them.
    #[inline(always)]
    pub fn follow<T: Scalar>(&self, q: &mut [T], dq: &mut [T]) {
        for (i, &(u, ratio, offset)) in self.leaders.iter().enumerate() {
            let leader = self.independent[u];
            if leader != i {
                q[i] = q[leader].mul_add(q[i].splat(ratio), q[i].splat(offset));
                dq[i] = dq[leader].scale(ratio);
            }
        }
    }

    /// Gradients by all joints after [`Self::follow`] to those before it, in place.
    #[inline(always)]
    pub fn follow_back<T: Scalar>(&self, q: &mut [T], dq: &mut [T]) {
        for (i, &(u, ratio, _)) in self.leaders.iter().enumerate() {
            let leader = self.independent[u];
            if leader != i {
                for by in [&mut *q, &mut *dq] {
                    by[leader] = by[i].mul_add(by[i].splat(ratio), by[leader]);
                    by[i] = by[i].splat(0.0);
                }
            }
        }
    }

    /// Gᵀ A G of `whole` and Gᵀ p of `whole_pull` into `mass` and `pull`.
    #[inline(always)]
    pub fn reduce<T: Scalar>(&self, [whole, whole_pull]: [&[T]; 2], [mass, pull]: [&mut [T]; 2]) {
        let (n, m) = (self.leaders.len(), self.independent.len());
        if m == n {
            mass.copy_from_slice(whole);
            pull.copy_from_slice(whole_pull);
            return;
        }
        for x in mass.iter_mut().chain(pull.iter_mut()) {
            *x = x.splat(0.0);
        }
        for (i, &(u, ratio, _)) in self.leaders.iter().enumerate() {
            pull[u] = whole_pull[i].mul_add(whole_pull[i].splat(ratio), pull[u]);
            for (j, &(w, other, _)) in self.leaders.iter().enumerate() {
                let a = whole[n * i + j];
                mass[m * u + w] = a.mul_add(a.splat(ratio * other), mass[m * u + w]);
            }
        }
    }
}

/// Where a joint may be that has one range of its own and another by a follower, q = ratio · u + offset.
fn common_range(
    own: Option<[f64; 2]>,
    followers: Option<[f64; 2]>,
    (ratio, offset): (f64, f64),
) -> Option<[f64; 2]> {
    let Some(range) = followers.filter(|_| ratio != 0.0) else { return own };
    let mut ends = range.map(|end| (end - offset) / ratio);
    if ratio < 0.0 {
        ends.swap(0, 1);
    }
    match own {
        // Ranges without a place in common: that of the leader.
        Some([low, high]) if ends[0].max(low) > ends[1].min(high) => Some([low, high]),
        Some([low, high]) => Some([ends[0].max(low), ends[1].min(high)]),
        None => Some(ends),
    }
}
