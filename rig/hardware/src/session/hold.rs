//! A tendon near the load limit is pulled no further.
//!
//! A load beyond its limit ends a run. A path that needs a little more than the limit at its furthest point would be
//! lost for that; so below the limit a tendon is released and pulled again so that the load stays where it is, until
//! the command comes back to it. What stays behind by more than a servo may lag is blocked, and ends the run.

use super::RigSession;
use crate::{EventKind, ShutdownAction, Violation};

/// Cycles after which a command shows in the load: it is written, the servo moves, and the load is read.
const AHEAD: f64 = 3.0;
/// Distance from the load to be held at which a tendon moves at the rig's slew, and nearer to it in proportion [-].
/// At full speed both ways the load of the preset's servos swings by three per cent either way.
const BAND: f64 = 0.03;

/// Load state of one tendon.
#[derive(Debug, Clone, Default)]
pub(super) struct LoadGuard {
    /// Load that was read last, positive where the tendon pulls [-].
    load: Option<f64>,
    hold: Option<LimitedTendon>,
}

/// A tendon whose stroke is limited.
#[derive(Debug, Clone)]
struct LimitedTendon {
    /// Largest stroke for now [m].
    ceiling: f64,
    /// Since when [s].
    begun: f64,
    /// Furthest that it has stayed behind its command [m].
    shortfall: f64,
}

impl LoadGuard {
    /// Load to be expected when the next command shows, after this one was read [-].
    fn expect(&mut self, load: f64) -> f64 {
        let before = self.load.replace(load).unwrap_or(load);
        load + AHEAD * (load - before).max(0.0)
    }
}

impl RigSession<'_> {
    /// Limits the commanded strokes (n) [m] to `target`.
    ///
    /// # Errors
    /// A tendon that is limited too far.
    pub(super) fn limit_load(&mut self, strokes: &[f64]) -> Result<(), Violation> {
        self.target.copy_from_slice(strokes);
        let Some(load_limiting) = self.rig.limits.load_limiting else { return Ok(()) };
        let now = self.hardware.now();
        for (k, &stroke) in strokes.iter().enumerate() {
            let channel = &self.calibration.channels[k];
            let (id, sign) = (channel.servo_id, channel.winds.sign());
            let guard = &mut self.guards[k];
            // Of a servo that did not answer nothing new is known.
            let load = self.samples[k].map(|sample| guard.expect(sign * sample.load));
            let is_high = load.is_some_and(|load| load > load_limiting);
            let mut hold = match guard.hold.take() {
                None if is_high && stroke > self.commanded[k] => {
                    let message =
                        format!("load: near {:.0} %; its tendon is pulled no further", 100.0 * load_limiting);
                    self.note(EventKind::Hold, Some(id), message);
                    LimitedTendon { ceiling: self.commanded[k], begun: now, shortfall: 0.0 }
                }
                None => continue,
                Some(hold) => hold,
            };
            // The servo still catches up with its last commands: to keep the stroke would not keep the load.
            if let Some(load) = load {
                let part = ((load_limiting - load) / BAND).clamp(-1.0, 1.0);
                hold.ceiling += part * self.rig.motion.slew * self.period;
            }
            if stroke <= hold.ceiling {
                let message = format!(
                    "its tendon was held back for {:.2} s, by {:.2} mm at most",
                    now - hold.begun,
                    1e3 * hold.shortfall
                );
                self.note(EventKind::Hold, Some(id), message);
                continue;
            }
            let shortfall = stroke - hold.ceiling;
            if shortfall > self.rig.limits.lag_max {
                let message = format!(
                    "load: expected a tendon near {:.0} % to be held back by {:.2} mm at most, got {:.2} mm",
                    100.0 * load_limiting,
                    1e3 * self.rig.limits.lag_max,
                    1e3 * shortfall
                );
                return Err(Violation { tendon: Some(k), message, shutdown: ShutdownAction::TorqueOff });
            }
            hold.shortfall = hold.shortfall.max(shortfall);
            self.target[k] = hold.ceiling;
            self.guards[k].hold = Some(hold);
        }
        Ok(())
    }
}
