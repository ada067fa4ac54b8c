//! Writes QPs of an identification with their answers, one JSON object a line, for other solvers to try
//! (`tests/peers/identification_qp_peer.py`): SCENE RECORDING COUNT.

use std::io::Write;

use hysteron_base::{Recording, Scene};
use hysteron_fit::qp::BoxQp;
use hysteron_twin::coreact::{AuxiliaryLimits, AuxiliaryPolicy, Identifier, IdentifyOptions, TipMeasurement};
use hysteron_twin::{RobotMotion, Twin};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, recording, count] = &arguments[..] else { return Err("SCENE RECORDING COUNT".into()) };
    let count: usize = count.parse()?;
    let twin = Twin::from_scene(&Scene::read(scene)?)?;
    let auxiliary = AuxiliaryLimits::new(&twin)?;
    let motion = RobotMotion::for_identification(&twin, &Recording::read(recording)?, recording)?;
    let every = motion.len() / (count + 1);
    let options = IdentifyOptions { rounds: 1, ..IdentifyOptions::default() };
    let mut identifier = Identifier::new(&twin, &auxiliary, options);
    let mut solver = BoxQp::new(auxiliary.len());
    let mut answer = vec![0.0; auxiliary.len()];
    let mut out = std::io::stdout().lock();
    for i in 0..motion.len() {
        let goal = TipMeasurement { position: motion.tips[i], orientation: None };
        identifier.step(motion.strokes_at(i), Some(&goal), motion.step)?;
        // The first sample brings the twin into balance and has no QP.
        let Some(qp) = identifier.last_qp().filter(|_| i % every == every - 1) else { continue };
        // As the identification itself solves it.
        let right: Vec<f64> = qp.linear.iter().map(|g| -g).collect();
        let [lower, upper] = [0, 1].map(|end| qp.bounds.iter().map(|pair| pair[end]).collect::<Vec<f64>>());
        solver.set_matrix(&qp.hessian);
        let (status, _) = solver.solve(&right, &lower, &upper, &mut answer);
        let line = hysteron_base::json!({
            "hessian": qp.hessian, "linear": qp.linear, "bounds": open(&qp.bounds), "rows": qp.rows,
            "row_bounds": open(&qp.row_bounds), "answer": answer, "status": format!("{status:?}"),
        });
        writeln!(out, "{line}")?;
    }
    Ok(())
}

/// Bounds that JSON can hold: no number where there is none.
fn open(bounds: &[[f64; 2]]) -> Vec<[Option<f64>; 2]> {
    bounds.iter().map(|pair| pair.map(|bound| bound.is_finite().then_some(bound))).collect()
}
