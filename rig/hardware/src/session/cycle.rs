//! One cycle: wait for its time, command, read, check.

use super::{FrozenPose, LOST_AFTER, LOST_MOTION, RigSession, SLOW_EVERY, Stop, Torque, TorqueAtEnd};
use crate::{Error, EventKind, Quality, ShutdownAction, Violation};

impl RigSession<'_> {
    /// Runs one cycle that commands these strokes (n) [m], less where a tendon is limited.
    ///
    /// # Errors
    /// The reason of the stop. If that forbids further motion, the torque is off when this returns.
    pub(super) fn cycle(&mut self, strokes: &[f64]) -> Result<(), Stop> {
        if self.torque != Torque::On {
            return Err(Error::Bus("the session has ended, and the torque is off".into()).into());
        }
        self.run_cycle(strokes).map_err(|stop| self.stopped(stop))
    }

    /// Logs what ends a motion, and switches the torque off where it forbids to move on.
    pub(super) fn stopped(&mut self, stop: Stop) -> Stop {
        self.log_stop(&stop);
        if stop.forbids_motion() {
            self.end(TorqueAtEnd::Off);
        }
        stop
    }

    fn run_cycle(&mut self, strokes: &[f64]) -> Result<(), Stop> {
        self.limit_load(strokes)?;
        self.rig.limits.check_command(&self.commanded, &self.target, self.period)?;
        for ((goal, channel), stroke) in
            self.goals.iter_mut().zip(&self.calibration.channels).zip(&self.target)
        {
            *goal = channel.ticks(*stroke);
        }
        self.hardware.wait_until(self.next);
        let begun = self.hardware.now();
        self.hardware.write_goals(&self.goals)?;
        self.commanded.copy_from_slice(&self.target);
        self.hardware.read_servos(&mut self.samples)?;
        let late = begun - self.next;
        self.stats.add_cycle(late, self.hardware.bus_time());
        if late > self.period {
            self.note(EventKind::Late, None, format!("a cycle began {:.1} ms late", 1e3 * late));
            // What was missed is not made up for in a rush.
            let n_missed = (late / self.period).floor();
            self.stats.n_missed += n_missed as u64;
            self.next += n_missed * self.period;
        }
        self.cycle_time = self.next;
        self.next += self.period;
        self.n_cycles += 1;

        for ((sample, channel), stroke) in
            self.samples.iter().zip(&self.calibration.channels).zip(&mut self.measured)
        {
            if let Some(sample) = sample {
                *stroke = channel.stroke(sample.position);
            }
        }
        self.take_poses();
        self.hardware.take_events(&mut self.events);
        match self.check_standstill(late).and_then(|()| self.check()) {
            Err(Stop::Limit(Violation { shutdown: ShutdownAction::ToRest, .. })) if self.is_going_to_rest => {
                Ok(())
            }
            checked => checked,
        }
    }

    /// Servos that the bus watchdog has stopped ignore commands without an error.
    fn check_standstill(&self, late: f64) -> Result<(), Stop> {
        let watchdog = self.rig.servos.bus_watchdog;
        if watchdog == 0.0 || late + self.period < watchdog {
            return Ok(());
        }
        let message = format!(
            "standstill: expected a cycle every {:.0} ms, got none for {:.0} ms, and the servos' watchdog of {:.0} ms has \
             stopped them (hint: close other programs)",
            1e3 * self.period,
            1e3 * (late + self.period),
            1e3 * watchdog
        );
        Err(Violation { tendon: None, message, shutdown: ShutdownAction::TorqueOff }.into())
    }

    fn check(&mut self) -> Result<(), Stop> {
        self.check_silence()?;
        self.note_resets();
        let limits = &self.rig.limits;
        limits.check_servos(&self.samples, &self.measured, &self.commanded, &self.radii)?;
        if self.n_cycles.is_multiple_of(SLOW_EVERY) {
            self.hardware.read_slow(&mut self.slow)?;
            self.stats.heat.add(self.cycle_time, &self.slow);
            limits.check_slow(&self.slow)?;
        }
        let Some(tracker) = &self.rig.tracker else { return Ok(()) };
        if self.calibration.registration.is_none() {
            return Ok(());
        }
        for pose in self.poses.iter().filter(|pose| pose.quality == Quality::Good) {
            limits.check_tip(pose)?;
        }
        let silence = self.hardware.now() - self.last_tracked;
        if silence > tracker.stale {
            let message = format!("tracker: no pose to trust for {:.0} ms", 1e3 * silence);
            return Err(Violation { tendon: None, message, shutdown: ShutdownAction::ToRest }.into());
        }
        Ok(())
    }

    /// Notes servos that are back from a loss of their supply, without torque and settings.
    fn note_resets(&mut self) {
        for k in 0..self.samples.len() {
            if self.samples[k].is_some_and(|sample| !sample.torque_on && sample.hardware_error == 0) {
                let id = self.calibration.channels[k].servo_id;
                self.note(EventKind::Reset, Some(id), "its torque is off without an error of its own".into());
            }
        }
    }

    /// Counts the cycles since each servo answered.
    fn check_silence(&mut self) -> Result<(), Stop> {
        for k in 0..self.samples.len() {
            self.silent[k] = if self.samples[k].is_some() { 0 } else { self.silent[k] + 1 };
            if self.silent[k] == LOST_AFTER {
                let id = self.calibration.channels[k].servo_id;
                let message = format!("servo {id} has not answered for {LOST_AFTER} cycles");
                self.note(EventKind::ServoLost, Some(id), message.clone());
                return Err(Error::Bus(message).into());
            }
        }
        Ok(())
    }

    /// Takes over the poses of this cycle, into the robot's frame.
    fn take_poses(&mut self) {
        self.poses.clear();
        self.hardware.take_poses(&mut self.poses);
        if let Some(registration) = &self.calibration.registration {
            for pose in &mut self.poses {
                *pose = registration.apply(pose);
            }
        }
        self.check_motion();
        let now = self.hardware.now();
        for pose in &self.poses {
            if pose.quality == Quality::Good {
                self.last_tracked = self.last_tracked.max(pose.time);
                self.stats.pose_age.add(now - pose.time);
            } else {
                self.stats.n_doubtful += 1;
            }
        }
    }

    /// Marks poses that stay the same to the last bit although the servos have moved on: of a tracker that rounds to
    /// more than its noise, only this distinguishes a frozen one from a tip at rest.
    fn check_motion(&mut self) {
        for i in 0..self.poses.len() {
            let pose = self.poses[i];
            if pose.quality != Quality::Good {
                continue;
            }
            let is_same = |still: &FrozenPose| {
                still.pose.position == pose.position && still.pose.orientation == pose.orientation
            };
            let Some(still) = self.still.as_mut().filter(|still| is_same(still)) else {
                self.still = Some(FrozenPose { pose, strokes: self.measured.clone(), is_logged: false });
                continue;
            };
            let moved = self.measured.iter().zip(&still.strokes).map(|(now, then)| (now - then).abs());
            let furthest = moved.fold(0.0, f64::max);
            if furthest > LOST_MOTION {
                self.poses[i].quality = Quality::Frozen;
                if !std::mem::replace(&mut still.is_logged, true) {
                    let message = format!(
                        "the tip has not moved by a bit while a tendon moved by {:.1} mm: its poses are not used",
                        1e3 * furthest
                    );
                    self.note(EventKind::TrackerQuality, None, message);
                }
            }
        }
    }
}
