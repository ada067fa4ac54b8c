//! The outcomes of all studies: `docs/outcomes.md` is made from them and from those of the other verbs.

use hysteron_workflow::shared::outcome::{self, VERBS, VerbOutcome, verb};

use crate::{arm, chain, tendon};

/// The outcomes of all studies, in the order of the document.
static STUDIES: [VerbOutcome; 22] = [
    verb::<chain::Outcome>(&["study run", "demo"]),
    verb::<tendon::Outcome<Vec<tendon::sofa::Comparison>>>(&["study sofa"]),
    verb::<tendon::Outcome<Vec<tendon::convergence::MeshResolution>>>(&["study convergence"]),
    verb::<tendon::Outcome<Vec<tendon::sorosim::RodResolution>>>(&["study sorosim"]),
    verb::<tendon::Outcome<tendon::tentacle::TentacleMetrics>>(&["study tentacle"]),
    verb::<tendon::Outcome<tendon::ftdcr::FtdcrMetrics>>(&["study ftdcr"]),
    verb::<tendon::Outcome<tendon::inverse::InverseMetrics>>(&["study inverse"]),
    verb::<tendon::Outcome<tendon::coreact::CoreactMetrics>>(&["study coreact"]),
    verb::<tendon::Outcome<tendon::robots::RobotsMetrics>>(&["study robots"]),
    verb::<tendon::Outcome<tendon::ablation::AblationMetrics>>(&["study ablation"]),
    verb::<tendon::Outcome<tendon::population::PopulationMetrics>>(&["study population"]),
    verb::<tendon::Outcome<tendon::layouts::LayoutMetrics>>(&["study layouts"]),
    verb::<tendon::Outcome<tendon::adaptation::AdaptationMetrics>>(&["study adaptation"]),
    verb::<tendon::Outcome<tendon::sensing::SensingMetrics>>(&["study sensing"]),
    verb::<tendon::Outcome<tendon::edic::EdicMetrics>>(&["study edic"]),
    verb::<arm::learned::Outcome>(&[
        "study simulated",
        "study characters",
        "study baxter-circle",
        "study baxter-helical",
        "study kuka",
        "study panda",
        "study recorded",
    ]),
    verb::<arm::scara::Outcome>(&["study scara"]),
    verb::<arm::wrist::Outcome>(&["study wrist"]),
    verb::<arm::identification::Outcome>(&["study identification"]),
    verb::<arm::force::Outcome>(&["study force"]),
    verb::<arm::neural::Outcome>(&["study neural", "study neural-networks"]),
    verb::<arm::cloning::Outcome>(&["study cloning"]),
];

/// The outcomes of all verbs, in the order of the document.
#[inline]
pub fn all() -> impl Iterator<Item = &'static VerbOutcome> {
    VERBS.iter().chain(&STUDIES)
}

/// The keys of all outcomes, as Markdown.
// Inlined, so that the schemas and readers of all outcomes are built where the document is made, not in the program.
#[inline]
pub fn document() -> String {
    outcome::document(all())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_workflow::shared::outcome::MARK;

    use super::*;

    #[test]
    fn the_document_is_that_of_the_types() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/outcomes.md");
        let text = std::fs::read_to_string(path).unwrap();
        let (_, there) = text.split_once(MARK).unwrap();
        let made = document();
        let differs = there.lines().zip(made.lines()).find(|(there, made)| there != made);
        assert!(there == made, "docs/outcomes.md is out of date: {MARK}{differs:?}");
    }
}
