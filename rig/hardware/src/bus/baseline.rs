//! The registers of every servo against what they are expected to hold, before a motor is driven; and writing back.

use super::model::ServoModel;
use super::registers::{RegisterImage, RegisterRole, RegisterSpec, StoredRegisters, TABLE, stored};
use super::wire::{instruction, range};
use super::{Error, ReplyPatience, Result, ServoBus, at, xl430};
use crate::EventKind;
use std::collections::BTreeMap;

/// Bytes of one read of the control table.
const READ_BYTES: u16 = 64;

/// Reference with which the stored registers of servos are compared.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum RegisterBaseline {
    /// The factory's values.
    #[default]
    Factory,
    /// Known stored registers of every servo, in the order of the bus; a register that is not known is
    /// compared with the factory's value.
    Known {
        /// Whose knowledge it is, for people.
        of: String,
        /// One per servo.
        servos: Vec<StoredRegisters>,
    },
    /// The present values in the servos are accepted, because the servos are being calibrated with them.
    AsFound,
}

impl RegisterBaseline {
    /// Expected stored registers of servo `k` of the bus; `None` where any value is accepted.
    fn expected(&self, k: usize, model: &ServoModel) -> Option<StoredRegisters> {
        let factory = StoredRegisters::factory(model);
        match self {
            Self::Factory => Some(factory),
            Self::Known { servos, .. } => Some(match servos.get(k) {
                Some(known) => factory.with(known),
                None => factory,
            }),
            Self::AsFound => None,
        }
    }

    /// For people.
    fn name(&self) -> &str {
        match self {
            Self::Factory => "as from the factory",
            Self::Known { of, .. } => of,
            Self::AsFound => "as found",
        }
    }
}

/// A register that does not hold what it should.
#[derive(Debug, Clone)]
pub struct RegisterDifference {
    /// Id of the servo.
    pub servo: u8,
    /// Which register.
    pub spec: &'static RegisterSpec,
    /// Expected value; for a banned value, the one that is expected to replace it.
    pub expected: i64,
    /// Value found in the register.
    pub found: i64,
    /// Effect of the difference.
    pub effect: String,
}

impl std::fmt::Display for RegisterDifference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { servo, spec, expected, found, effect } = self;
        let address = spec.register.address;
        write!(
            f,
            "servo {servo}: {} (register {address}): expected {expected}, got {found}: {effect}",
            spec.name
        )
    }
}

/// A servo whose registers were read.
#[derive(Debug, Clone)]
pub(super) struct Examined {
    pub model: &'static ServoModel,
    pub image: RegisterImage,
}

/// How the registers of a servo differ from what was expected, and the values that no servo is driven with.
pub fn differences(
    servo: u8,
    model: &ServoModel,
    found: &StoredRegisters,
    expected: Option<&StoredRegisters>,
) -> Vec<RegisterDifference> {
    let differs = |(spec, factory): (&'static RegisterSpec, fn(&ServoModel) -> Option<i64>)| {
        let found = found.value(spec)?;
        let difference = |expected, effect| Some(RegisterDifference { servo, spec, expected, found, effect });
        if let Some(ban) = spec.ban(found) {
            return difference(factory(model)?, ban.to_owned());
        }
        let expected = expected?.value(spec).filter(|expected| *expected != found)?;
        difference(expected, spec.consequence(expected, found))
    };
    stored().filter_map(differs).collect()
}

impl ServoBus {
    /// Reads the lower part of the control table of a servo.
    ///
    /// # Errors
    /// `Bus` naming the servo.
    pub(super) fn read_image(&mut self, id: u8) -> Result<RegisterImage> {
        let mut bytes = Vec::with_capacity(usize::from(RegisterImage::LEN));
        for first in (0..RegisterImage::LEN).step_by(usize::from(READ_BYTES)) {
            let count = READ_BYTES.min(RegisterImage::LEN - first);
            let parameters = range(first, count);
            let read = self.persist((id, ReplyPatience::Register), |wire| {
                let read = wire
                    .ask(id, instruction::READ, &parameters, usize::from(count))
                    .map(|answer| answer.parameters.to_vec());
                wire.settle_after(&read);
                read
            });
            bytes.extend(
                read.map_err(|failure| at(id, xl430::ControlRegister { address: first, size: 1 }, &failure))?,
            );
        }
        Ok(RegisterImage(bytes))
    }

    /// Compares the registers that the last self-check read with what they are expected to hold.
    ///
    /// # Errors
    /// `Bus` if there was no self-check.
    pub fn register_differences(&self, baseline: &RegisterBaseline) -> Result<Vec<RegisterDifference>> {
        if self.examined.is_empty() {
            return Err(Error::Bus("the servos' registers have not been read".into()));
        }
        let servos = self.examined.iter().enumerate().zip(self.ids());
        Ok(servos
            .flat_map(|((k, Examined { model, image }), id)| {
                differences(*id, model, &image.stored(model), baseline.expected(k, model).as_ref())
            })
            .collect())
    }

    /// Accepts the registers that the last self-check read: from here on the servos may be driven.
    ///
    /// # Errors
    /// `Bus` naming everything that differs, what it would do, and the way out.
    pub fn accept_registers(&mut self, baseline: &RegisterBaseline) -> Result<()> {
        self.is_accepted = false;
        let different = self.register_differences(baseline)?;
        if different.is_empty() {
            self.is_accepted = true;
            return Ok(());
        }
        let lines: Vec<String> = different.iter().map(ToString::to_string).collect();
        Err(Error::Bus(format!(
            "{}: registers are not {}, and no torque goes on:\n  {}\n  (hint: `hysteron rig check --rig FILE --restore` writes \
             back what is expected; if they were changed on purpose, say so: docs/rig.md, \"Registers\")",
            self.port().display(),
            baseline.name(),
            lines.join("\n  ")
        )))
    }

    /// Registers that hold something else than they are given before every run, for people: a line for each register and
    /// value.
    pub fn settings_to_change(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for spec in &TABLE {
            let mut ids_of: BTreeMap<(i64, i64), Vec<String>> = BTreeMap::new();
            for (id, servo) in self.ids().iter().zip(&self.examined) {
                let values = servo.image.value(spec).zip(self.required(servo, spec));
                if let Some(values) = values.filter(|(found, required)| found != required) {
                    ids_of.entry(values).or_default().push(id.to_string());
                }
            }
            for ((found, required), ids) in ids_of {
                let (name, address, ids) = (spec.name, spec.register.address, ids.join(", "));
                lines.push(format!(
                    "servo {ids}: {name} (register {address}) is {found}; every run sets it to {required}"
                ));
            }
        }
        lines
    }

    /// Value written to a register of a servo before a run; `None` if none is written.
    pub(super) fn required(&self, servo: &Examined, spec: &RegisterSpec) -> Option<i64> {
        let limit = TABLE.iter().find(|spec| spec.register == xl430::PWM_LIMIT);
        let pwm = limit.and_then(|limit| servo.image.value(limit)).unwrap_or(i64::from(xl430::PWM_MAX));
        spec.setting(&self.config, servo.model, pwm)
    }

    /// Reads the registers again after the settings of a run were written: every one must hold what was written, and
    /// those that are stored what was accepted.
    pub(super) fn confirm_settings(&mut self) -> Result<()> {
        for k in 0..self.examined.len() {
            let (id, servo) = (self.ids()[k], self.examined[k].clone());
            let image = self.read_image(id)?;
            for spec in &TABLE {
                let required = match spec.role {
                    RegisterRole::Stored(_) => servo.image.value(spec),
                    _ => self.required(&servo, spec),
                };
                if let Some((required, found)) = required.zip(image.value(spec))
                    && required != found
                {
                    let (name, address) = (spec.name, spec.register.address);
                    return Err(Error::Bus(format!(
                        "servo {id}: {name} (register {address}): expected {required} after it was written, got {found}"
                    )));
                }
            }
        }
        Ok(())
    }

    /// Writes back what the registers are expected to hold, with the torque off, and reads it again. A secondary id
    /// goes first: until then a write reaches two servos.
    ///
    /// # Errors
    /// `Bus` naming the register that did not take its value, or that cannot be written.
    pub fn restore_registers(&mut self, different: &[RegisterDifference]) -> Result<()> {
        self.disable_torque()?;
        let is_secondary = |one: &&RegisterDifference| one.spec.register == xl430::SECONDARY_ID;
        let (first, then): (Vec<_>, Vec<_>) = different.iter().partition(is_secondary);
        for RegisterDifference { servo, spec, expected, .. } in first.into_iter().chain(then) {
            if !spec.is_writable() {
                return Err(Error::Bus(format!(
                    "servo {servo}: {} (register {}) cannot be written: calibrate again",
                    spec.name, spec.register.address
                )));
            }
            let written = i32::try_from(*expected).unwrap_or(i32::MAX).cast_unsigned();
            self.write(*servo, spec.register, written)?;
            let found = self.read_image(*servo)?.value(spec);
            if found != Some(*expected) {
                return Err(Error::Bus(format!(
                    "servo {servo}: {} (register {}): expected {expected} after it was written, got {}",
                    spec.name,
                    spec.register.address,
                    found.map_or("nothing".into(), |found| found.to_string())
                )));
            }
            self.note_event(
                Some(*servo),
                EventKind::Run,
                format!("{} (register {}) written back: {expected}", spec.name, spec.register.address),
            );
        }
        // What was read before is no longer true.
        self.examined.clear();
        self.is_accepted = false;
        Ok(())
    }
}
