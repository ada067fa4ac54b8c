//! Warnings about the locking of linear tetrahedra on a robot.

use hysteron_base::Scene;
use hysteron_base::number::significant;
use hysteron_twin::{LockedMove, LockingComparison, LockingEstimate, LockingEstimator, RunLocking};

/// Share of stiffness, or of the tip's motion, above which a warning is logged [-]: below, friction and material are known
/// no better.
const CONSIDERABLE: f64 = 0.05;
/// How a mesh gets ten-node tetrahedra.
const TO_TEN_NODES: &str = "`hysteron mesh --quadratic`; or `printf 'Merge \"part.msh\"; SetOrder 2; Save \"part-2.msh\";' > \
                            order.geo`, then `gmsh order.geo -parse_and_exit`";

/// Warns of what linear tetrahedra lose on the body of a scene, before something is fitted to it.
///
/// # Errors
/// Those of reading the mesh, and of the twin.
pub(crate) fn warn_before_fit(scene: &Scene) -> anyhow::Result<()> {
    let mesh = hysteron_fem::read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
    warn(&LockingEstimator::new(scene, &mesh)?);
    Ok(())
}

/// Warns of what every verb should know of the robot: the command that loses most.
pub fn warn(estimator: &LockingEstimator) {
    match estimator.estimate() {
        LockingEstimate::TenNode => {}
        LockingEstimate::NotEstimated { nodes } => tracing::warn!(
            "linear tetrahedra, {nodes} nodes: their bending error is not estimated for so many; compare a \
             coarser mesh with its ten-node tetrahedra ({TO_TEN_NODES})",
        ),
        LockingEstimate::Estimated(_) => estimator.stiffest().into_iter().for_each(warn_of),
    }
}

/// Warns of what a recording will lose, by the sample that moves the tip farthest.
pub fn warn_of_recording(farthest: &LockedMove) {
    warn_of(&LockingComparison::new("this recording".to_owned(), farthest));
}

/// Warns where a mesh is considerably too stiff.
fn warn_of(comparison: &LockingComparison) {
    let LockingComparison {
        command,
        tip_m,
        tip_ten_node_m,
        tension_n,
        tension_ten_node_n,
        stiffness_ratio,
        ..
    } = comparison;
    if *stiffness_ratio <= 1.0 + CONSIDERABLE {
        return;
    }
    let with = |tension: f64| match tension {
        0.0 => String::new(),
        tension => format!(" with {} N", significant(tension, 3)),
    };
    tracing::warn!(
        "linear tetrahedra make this body {} times as stiff as ten-node tetrahedra: {command} moves the tip {} mm{}, \
         with ten nodes {} mm{} (first order, from rest; hint: {TO_TEN_NODES})",
        significant(*stiffness_ratio, 3),
        significant(1e3 * tip_m, 3),
        with(*tension_n),
        significant(1e3 * tip_ten_node_m, 3),
        with(*tension_ten_node_n),
    );
}

/// Warns where the tip of a run stayed considerably nearer to rest than with ten-node tetrahedra.
pub fn warn_of_run(moved: &RunLocking) {
    if moved.tip_m < (1.0 - CONSIDERABLE) * moved.tip_ten_node_m {
        tracing::warn!(
            "the tip went {} mm from rest; with ten-node tetrahedra it would have gone about {} mm (linear tetrahedra \
             make this body too stiff)",
            significant(1e3 * moved.tip_m, 3),
            significant(1e3 * moved.tip_ten_node_m, 3),
        );
    }
}
