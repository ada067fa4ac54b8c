//! Health of a rig's servos, as verbs print it and pages show it.

mod page;

use hysteron_actuator::health::{Estimate, Health, Quantity, ServoHealth};

use crate::Context;
pub(crate) use page::section;

/// Prints one line per servo, and who is worn.
pub fn print(health: &Health, context: &Context) {
    let headings =
        ["servo", "pulling [%]", "releasing [%]", "lost [mm]", "max [degC]", "change [%]", "condition"];
    let line = |cells: &[String]| cells.iter().map(|cell| format!("{cell:>16}")).collect::<String>();
    context.print(line(&headings.map(String::from)));
    health.servos.iter().for_each(|servo| context.print(line(&cells(servo))));
    for servo in health.alarms() {
        tracing::warn!(
            "servo {servo}: friction or lost motion has grown by more than a quarter of the baseline"
        );
    }
}

/// A row for people.
pub fn cells(servo: &ServoHealth) -> Vec<String> {
    let number = |quantity: Quantity| {
        let text = |it: Estimate| format!("{:.3} ± {:.3}", it.value, it.standard_error);
        servo.now.get(quantity).map_or("-".to_owned(), text)
    };
    let changes = Quantity::ALL.into_iter().filter_map(|quantity| servo.change?.get(quantity));
    let largest = changes.max_by(|a, b| a.value.total_cmp(&b.value));
    let mut cells = vec![servo.servo.to_string()];
    cells.extend(Quantity::ALL.map(number));
    cells.push(servo.temperature_max_degc.map_or("-".to_owned(), |hot| format!("{hot:.0}")));
    cells.push(
        largest.map_or("-".to_owned(), |it| {
            format!("{:+.0} ± {:.0}", 100.0 * it.value, 100.0 * it.standard_error)
        }),
    );
    cells.push(servo.condition.map_or("-".to_owned(), |condition| format!("{condition:.3}")));
    cells
}
