#![allow(missing_docs, clippy::all, clippy::unwrap_used)]
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let out = std::path::PathBuf::from(&args[1]);
    let arm = hysteron_rig::virtual_arm::VirtualArm::preset("open-manipulator-x").unwrap().individual(0);
    let mut all = hysteron_rig::virtual_arm::fault_set();
    all.extend(hysteron_rig::virtual_arm::data_set().into_iter().filter(|x| x.subset == "motor_condition"));
    for one in all {
        let path = out.join(format!("{}.parquet", one.name()));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let rec = arm.record(&one.trial, 0, &one.name(), Default::default()).unwrap();
        rec.write(&path).unwrap();
    }
}
