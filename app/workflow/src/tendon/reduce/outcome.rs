//! The outcome of `reduce`: size of the chain, its errors, whether it can stand for the mesh.

use std::path::PathBuf;

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::Twin;
use hysteron_twin::chain::{Chain, Validation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of `reduce`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The file.
    pub out: PathBuf,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// Whether the chain can stand for the mesh.
    pub verdict: Verdict,
    /// Unknowns of the mesh.
    pub mesh_unknowns: usize,
    /// Sections of the chain.
    pub sections: usize,
    /// Unknowns of the chain.
    pub unknowns: usize,
    /// Errors against the mesh.
    pub errors: Validation,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(
        out: PathBuf,
        scene_hash: &str,
        twin: &Twin,
        chain: &Chain,
        errors: Validation,
    ) -> Self {
        Self {
            out,
            scene_sha256: scene_hash.to_owned(),
            verdict: assess(&errors),
            mesh_unknowns: twin.body.n_unknowns(),
            sections: chain.n_sections(),
            unknowns: chain.n_unknowns(),
            errors,
        }
    }
}

/// Whether the chain can stand for the mesh.
fn assess(errors: &Validation) -> Verdict {
    let percent = |part: f64| 100.0 * part;
    let (tip, tensions) = (errors.tip.percentile_99, errors.tensions.percentile_99);
    let [_, refused] = errors.refused;
    let tried = errors.count + refused;
    let share = refused as f64 / tried.max(1) as f64;
    Verdict::on(format!(
        "the chain follows the mesh: tip within {:.2} %, tensions within {:.2} % in half of {} equilibria",
        percent(errors.tip.median),
        percent(errors.tensions.median),
        errors.count
    ))
    .because(
        Criterion::ErrorOverTarget,
        tip.max(tensions),
        format!(
            "99 of 100 equilibria: tip within {:.2} % of its displacement, tensions within {:.2} %, turn within {:.2} deg",
            percent(tip),
            percent(tensions),
            errors.turn.percentile_99.to_degrees()
        ),
    )
    .because(
        Criterion::SolverFailures,
        share,
        format!("{refused} of {tried} targets that the mesh reaches have no equilibrium of the chain"),
    )
    .verdict()
}
