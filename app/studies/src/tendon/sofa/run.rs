//! The run of `study sofa`.

use hysteron_base::MaterialLaw;
use hysteron_workflow::{Context, WorkflowError};

use super::curve::{Curve, Difference, compare};
use super::outcome::{Comparison, SAME_LAW};
use crate::tendon::scenes::sofa_mesh;
use crate::tendon::{Options, Outcome, session};

/// Comparisons: name, law of the twin, curve of the reference and its last row.
const CASES: [(&str, MaterialLaw, &str, usize); 4] = [
    (SAME_LAW, MaterialLaw::CorotationalEdges, "ref_A_qs_aux0_polar_one.csv", 38),
    ("polar factor against SOFA polar", MaterialLaw::Corotational, "ref_A_qs_aux0_polar_one.csv", 38),
    ("polar factor against SOFA large", MaterialLaw::Corotational, "ref_A_qs_aux0_one.csv", 50),
    ("edges against SOFA large", MaterialLaw::CorotationalEdges, "ref_A_qs_aux0_one.csv", 50),
];

/// Runs the study.
///
/// # Errors
/// The reference cannot be read, or a step fails.
pub fn run(options: &Options, context: &Context) -> Result<Outcome<Vec<Comparison>>, WorkflowError> {
    session::run("sofa", &options.out, context, || comparisons(options))
}

fn comparisons(options: &Options) -> anyhow::Result<Vec<Comparison>> {
    let mesh = sofa_mesh(&options.repository)?;
    let mut found = Vec::new();
    for (name, law, file, last) in CASES {
        let curve = Curve::read(&options.repository, file)?;
        let differences = compare(&options.repository, &mesh, (law, &curve, last))?;
        for end in [5, 10, 35, last] {
            let worst = |of: fn(&Difference) -> f64| differences[..end].iter().map(of).fold(0.0, f64::max);
            found.push(Comparison {
                comparison: name.to_owned(),
                to_stroke_mm: 1e3 * curve.strokes[end],
                worst_tip: worst(|d| d.tip),
                worst_deflection: worst(|d| d.deflection),
                worst_tension: worst(|d| d.tension),
            });
        }
    }
    Ok(found)
}
