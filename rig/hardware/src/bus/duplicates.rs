//! Two servos with one id, distinguished from one that is silent and from a cable that damages answers.
//!
//! Both answer an instruction at once, and their answers collide. A ping gives the same for two servos
//! alike and may come through whole; so each servo is also asked for what no two have alike: its tick, position and
//! heat.

use std::time::Duration;

use super::wire::{Census, instruction, range};
use super::{Error, Result, ServoBus, xl430};

/// From the tick to the temperature.
const OWN: (u16, u16) = (xl430::REALTIME_TICK.address, 27);
/// Questions to a servo whose first answer was damaged.
const QUESTIONS: usize = 5;
/// Of so many answers this many count as every one: chance leaves a collision whole, and a busy computer an answer late.
const MAX_DAMAGED: usize = 4;
/// Beyond the usual time of an answer: who is there is asked once, of a computer that may be busy.
const PATIENCE: Duration = Duration::from_millis(50);

/// Kind of answer to a question that only one servo should answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Presence {
    /// One answer, whole.
    Alone,
    /// More than one whole answer to one question.
    Several,
    /// Answers, every one of them damaged.
    Damaged,
    /// Nothing.
    Silent,
}

impl ServoBus {
    /// How many servos have this id.
    ///
    /// # Errors
    /// `Bus` if the port is gone.
    pub(super) fn presence(&mut self, id: u8) -> Result<Presence> {
        let (mut n_several, mut n_damaged, mut n_silent) = (0, 0, 0);
        for n in 0..QUESTIONS {
            let parameters = range(OWN.0, OWN.1);
            let length = usize::from(OWN.1);
            let asked = self.with_wire(|wire| {
                let census = wire.census(id, instruction::READ, &parameters, (length, PATIENCE))?;
                // An answer that is late must not be counted with those to the next question.
                if census != Census::ONE {
                    wire.settle();
                }
                Ok(census)
            });
            match asked.map_err(|failure| Error::Bus(failure.to_string()))? {
                Census::ONE if n == 0 => return Ok(Presence::Alone),
                Census::ONE => {}
                Census { whole: 0, damaged: 0 } => n_silent += 1,
                Census { whole: 2.., damaged: 0 } => n_several += 1,
                _ => n_damaged += 1,
            }
        }
        Ok(match (n_several, n_damaged, n_silent) {
            (MAX_DAMAGED.., ..) => Presence::Several,
            (several, damaged, _) if several + damaged >= MAX_DAMAGED => Presence::Damaged,
            (.., QUESTIONS) => Presence::Silent,
            _ => Presence::Alone,
        })
    }

    /// Faults in the answers to each id, other than silence: one line each.
    pub(super) fn describe_duplicates(&self, found: &[(u8, Presence)]) -> Vec<String> {
        let is_damaged = |(_, presence): &&(u8, Presence)| *presence == Presence::Damaged;
        let n_damaged = found.iter().filter(is_damaged).count();
        let n_heard = found.iter().filter(|(_, presence)| *presence != Presence::Silent).count();
        let silent: Vec<String> = found
            .iter()
            .filter(|(_, presence)| *presence == Presence::Silent)
            .map(|(id, _)| id.to_string())
            .collect();
        let lost = match silent.len() {
            0 => String::new(),
            _ => format!("; no servo {} answers, so it may be that one", silent.join(", ")),
        };
        let hint = "hint: plug the servos in one by one, and give each a unique id";
        let mut lines = Vec::new();
        for (id, presence) in found {
            match presence {
                Presence::Several => lines.push(format!(
                    "servo {id}: two servos have this id: one question had several answers{lost} ({hint})"
                )),
                Presence::Damaged if n_damaged < n_heard || n_heard == 1 && !silent.is_empty() => {
                    lines.push(format!(
                        "servo {id}: two servos seem to have this id: its answers alone are damaged, every one{lost} ({hint}; \
                         if it is alone, its plug or cable)"
                    ));
                }
                Presence::Damaged => lines.push(format!(
                    "servo {id}: every answer is damaged, as those of all servos (hint: cable, plug or baud)"
                )),
                Presence::Alone | Presence::Silent => {}
            }
        }
        lines
    }
}
