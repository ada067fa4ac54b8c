//! Torques of many robots in one process, for programs that compare them with those of another one:
//!
//!     cargo run --release --example robot_torques < cases.jsonl > torques.jsonl
//!
//! A line of the input is `{"file": …, "rows": [{"q": […], "dq": […], "ddq": […]}, …]}` with the joints in the order of the file; its
//! line of the output is `{"joints": […], "tau": [[…], …]}` or `{"error": …}`. Torques are those of `arm dynamics`: with viscous damping
//! and springs, without dry friction. Numbers in rad, m, s, N m, N. With the argument `--table` the table of MJCF is printed instead.

use std::io::{BufRead, Write};
use std::path::Path;

use hysteron_arm_dynamics::{Data, Model, inverse_dynamics};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    if std::env::args().any(|argument| argument == "--table") {
        out.write_all(Model::mjcf_table().as_bytes())?;
        return Ok(());
    }
    for line in std::io::stdin().lock().lines() {
        let case: Value = serde_json::from_str(&line?)?;
        let found = torques(&case).unwrap_or_else(|error| json!({ "error": error }));
        writeln!(out, "{found}")?;
    }
    Ok(())
}

fn torques(case: &Value) -> Result<Value, String> {
    let file = case["file"].as_str().ok_or("no file")?;
    let model = Model::read(Path::new(file)).map_err(|error| error.to_string())?;
    let (n, mut data) = (model.n_joints(), Data::new(&model, 0.0));
    let mut all = Vec::new();
    for row in case["rows"].as_array().ok_or("no rows")? {
        let of = |name: &str| -> Vec<f64> {
            row[name].as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
        };
        let (q, dq, ddq) = (of("q"), of("dq"), of("ddq"));
        if [&q, &dq, &ddq].iter().any(|values| values.len() != n) {
            let joints: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
            return Ok(json!({ "joints": joints, "tau": Value::Null }));
        }
        let mut tau = vec![0.0; n];
        inverse_dynamics(&model, &mut data, [&q, &dq, &ddq], &[], &mut tau);
        for ((tau, joint), dq) in tau.iter_mut().zip(model.joints()).zip(&dq) {
            *tau += joint.drive.damping * dq;
        }
        all.push(tau);
    }
    let joints: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
    Ok(json!({ "joints": joints, "tau": all }))
}
