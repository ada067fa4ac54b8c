//! Bodies identified in the recordings of a public data set.

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::identify::{
    BodyOptions, JointMotion, JointTerm, TorqueResponse, identify_bodies,
};
use hysteron_arm_estimation::{ArmRecording, ColumnMap, ImportOptions, import};
use hysteron_arm_learning::datasets::BAXTER_ARM;
use hysteron_base::Metadata;
use hysteron_fuzz::recorded;

#[test]
fn baxter_is_predicted_with_the_response_of_its_torques() {
    let Some(folder) = recorded("baxter_is_predicted", "arms/baxter") else { return };
    let files = std::fs::read_dir(folder.join("train")).unwrap();
    let read = |path: &std::path::Path| {
        let columns = Some(ColumnMap::named("baxter").unwrap());
        let imported =
            import(path, &ImportOptions { columns, ..ImportOptions::default() }, Metadata::default());
        let recording = imported.unwrap().recording;
        JointMotion::of_recording(&ArmRecording::of(&recording).unwrap(), &[], 4, 10.0).unwrap()
    };
    let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    let runs: Vec<JointMotion> = paths.iter().map(|path| read(path)).collect();
    let mut all = runs[0].clone();
    runs[1..].iter().for_each(|run| all.extend(run));
    let model = Model::from_urdf(BAXTER_ARM, "baxter_arm.urdf").unwrap();
    let terms =
        [JointTerm::Armature, JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset, JointTerm::Spring];
    let options = BodyOptions { terms: &terms, width: 0.02, prior: 1.0 };
    let fit = identify_bodies(&model, &all, &options).unwrap();
    let response = TorqueResponse::identify(&fit, &runs.iter().collect::<Vec<_>>()).unwrap();
    let circle = read(&folder.join("test/circle_XY_T2_r10_ang_vel_torq.csv"));
    // A regressor with friction and springs leaves these mean squares.
    let rms = response.rms_on(&fit, &[&circle]);
    for (rms, most) in rms.iter().zip([0.167, 0.515, 0.153, 0.034, 0.0061, 0.0064, 0.0006]) {
        assert!(rms * rms <= most, "{rms:?} > √{most}");
    }
    assert!(fit.least_pseudo_inertias().iter().all(|least| *least > 0.0));
}
