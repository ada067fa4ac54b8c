//! The tracker's clock on the host's: when a pose was measured, from its time stamp and its arrival.
//!
//! A message that left at device time d arrives at host time a = d + θ + L + j: offset θ of the clocks, fixed
//! latency L, jitter j ≥ 0. So every message bounds θ + L from above, and with clocks that drift apart by at most
//! D it still does later, by D per second less tightly. The estimate is the lowest of these bounds over a window:
//!
//! m(now) = min over i of (aᵢ − dᵢ + D (now − aᵢ)), and the pose was measured at d + m − L.
//!
//! With a true drift ρ, |ρ| ≤ D, that is late by min over i of (jᵢ + (D + ρ)(now − aᵢ)) and never early: one message
//! in the window that travelled fast is enough. At 40 Hz with exponential jitter of 3 ms that is 0.24 ms on average and
//! less than 1 ms always. No drift is estimated, so none can be estimated wrongly. (A convex hull would save the
//! D · age; the tip moves less than its noise in that time.)

use std::collections::VecDeque;

/// Largest drift of two clocks [-]: what NTP allows itself when it slews one; quartz alone drifts by 1e-4.
pub const MAX_DRIFT: f64 = 500e-6;
/// Length of the window [s]: 200 messages of a tracker at 40 Hz. A clock that jumped back by less than [`GATE`] is
/// followed after that time.
pub const WINDOW: f64 = 5.0;
/// Deviation from the estimate that jitter no longer explains [s]: the time stamp is damaged or the clock was set.
pub const GATE: f64 = 1.0;
/// Messages that must deviate equally before the clock counts as reset.
const AGREE: usize = 5;
/// Time over which they must arrive [s]: what was held up in the network arrives all at once.
const SETTLE: f64 = 0.1;
/// Most messages kept in the window.
const MAX_MESSAGES: usize = 4096;

/// Maps one clock to the other.
#[derive(Debug, Clone)]
pub struct ClockMap {
    latency: f64,
    /// Arrival aᵢ [s] and aᵢ − dᵢ − D aᵢ [s], the latter rising: what is below all later ones.
    lowest: VecDeque<(f64, f64)>,
    aside: Option<Aside>,
}

/// Messages in a row that deviate equally: arrival of the first [s], its delay [s], how many.
#[derive(Debug, Clone, Copy)]
struct Aside {
    begin: f64,
    delay: f64,
    n: usize,
}

impl ClockMap {
    /// A map that knows nothing yet. `latency` [s]: from the measurement to the arrival, at best.
    pub fn new(latency: f64) -> Self {
        Self { latency, lowest: VecDeque::new(), aside: None }
    }

    /// When the host's clock showed `device` [s], the time stamp of what arrived at `arrival` [s]; arrivals do not
    /// decrease. `None` if the time stamp cannot be trusted: it fits none of the latest messages.
    pub fn map(&mut self, device: f64, arrival: f64) -> Option<f64> {
        let delay = arrival - device;
        if let Some(estimate) = self.estimate(arrival)
            && (delay - estimate).abs() > GATE
        {
            let aside = match self.aside {
                Some(aside) if (delay - aside.delay).abs() <= GATE => Aside { n: aside.n + 1, ..aside },
                _ => Aside { begin: arrival, delay, n: 1 },
            };
            self.aside = Some(aside);
            if aside.n < AGREE || arrival - aside.begin < SETTLE {
                return None;
            }
            self.lowest.clear();
        }
        self.aside = None;
        let key = delay - MAX_DRIFT * arrival;
        while self.lowest.back().is_some_and(|&(_, later)| later >= key) {
            self.lowest.pop_back();
        }
        self.lowest.push_back((arrival, key));
        while self.lowest.len() > MAX_MESSAGES
            || self.lowest.front().is_some_and(|&(at, _)| at < arrival - WINDOW)
        {
            self.lowest.pop_front();
        }
        self.estimate(arrival).map(|estimate| device + estimate - self.latency)
    }

    /// Time of measurement of what arrived at `arrival` [s] without a time stamp; late by its jitter.
    pub fn without_stamp(&self, arrival: f64) -> f64 {
        arrival - self.latency
    }

    /// θ + L at a time [s].
    fn estimate(&self, now: f64) -> Option<f64> {
        self.lowest.front().map(|&(_, key)| key + MAX_DRIFT * now)
    }
}

#[cfg(test)]
mod tests;
