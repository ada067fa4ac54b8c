//! Deflection, tension and orientation of a robot of `meshes/` on ever finer meshes, its first tendon pulled by 5 mm without
//! gravity: SCENE ANCHOR_MM MESH..., each mesh as ORDER:OUTER/BORE/CHANNEL:HEIGHT_MM:END_MM, ORDER 1 (four nodes) or 2 (ten).
//! ANCHOR_MM 0 keeps the rings or points of the scene; END_MM 0 means layers of equal height.
//!
//! `cargo run --release -p hysteron-twin --example anchor_convergence -- meshes/tpu80/scene.toml 2 1:24/12/8:1:0.6 ...`
#![allow(clippy::print_stdout)] // this program prints a table

use std::time::Instant;

use hysteron_base::Scene;
use hysteron_fem::{Layers, Order, TendonChannel, Tube};
use hysteron_twin::{Stepper, Target, Twin};

type Failure = Box<dyn std::error::Error>;

const MM: f64 = 1e-3;
const STROKE: f64 = 5.0 * MM;
const STEPS: usize = 4;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, anchor, meshes @ ..] = &arguments[..] else { return Err("SCENE ANCHOR_MM MESH...".into()) };
    let mut scene = Scene::read(scene)?;
    scene.gravity = [0.0; 3];
    (scene.auxiliary, scene.friction) = (None, None);
    let anchor: f64 = anchor.parse()?;
    for tendon in &mut scene.tendons {
        (tendon.compliance, tendon.zero) = (0.0, 0.0);
        if anchor > 0.0 {
            (tendon.anchor, tendon.ring) = (Some(anchor * MM), 0.0);
        }
    }
    println!("scene,anchor_mm,mesh,unknowns,deflection_mm,tension_n,turn_deg,residual,seconds");
    let mut last: Option<[f64; 3]> = None;
    for mesh in meshes {
        let start = Instant::now();
        let twin = Twin::new(&scene, &tube(&scene.name, mesh)?.with_circle_areas().mesh()?)?;
        let (found, residual) = pulled(&twin)?;
        let [deflection, tension, turn] = found;
        println!(
            "{},{anchor},{mesh},{},{:.4},{:.4},{:.4},{residual:.1e},{:.1}",
            scene.name,
            twin.body.n_unknowns(),
            deflection / MM,
            tension,
            turn.to_degrees(),
            start.elapsed().as_secs_f64()
        );
        if let Some(last) = last {
            let change = |k: usize| 100.0 * (found[k] / last[k] - 1.0);
            println!("# change: {:+.2} %, {:+.2} %, {:+.2} %", change(0), change(1), change(2));
        }
        last = Some(found);
    }
    Ok(())
}

/// Deflection of the tip [m], tension [N] and rotation of the tip [rad] with the first tendon pulled, and the residual.
fn pulled(twin: &Twin) -> Result<([f64; 3], f64), Failure> {
    let mut stepper = Stepper::new(twin);
    let rest = twin.tip_of(stepper.state());
    let mut targets = vec![Target::Tension(0.0); twin.tendons.len()];
    let mut residual = 0.0;
    for step in 1..=STEPS {
        targets[0] = Target::Stroke(STROKE * step as f64 / STEPS as f64);
        residual = stepper.step(twin, &targets)?.relative_residual;
    }
    let state = stepper.state();
    let tip = twin.tip_of(state);
    let deflection = (0..3).map(|c| (tip[c] - rest[c]).powi(2)).sum::<f64>().sqrt();
    Ok(([deflection, state.tensions[0], twin.tip_rotation_of(state).angle()], residual))
}

/// The body of the scene of this name, its mesh as in ORDER:OUTER/BORE/CHANNEL:HEIGHT_MM:END_MM.
fn tube(name: &str, mesh: &str) -> Result<Tube, Failure> {
    let parts: Vec<&str> = mesh.split(':').collect();
    let [order, sides, height, end] = parts[..] else {
        return Err("ORDER:OUTER/BORE/CHANNEL:HEIGHT_MM:END_MM".into());
    };
    let sides: Vec<u32> = sides.split('/').map(str::parse).collect::<Result<_, _>>()?;
    let [outer, bore, channel] = sides[..] else { return Err("sides as OUTER/BORE/CHANNEL".into()) };
    let (height, end): (f64, f64) = (height.parse()?, end.parse()?);
    let solid = |profile: &[[f64; 2]]| (profile.to_vec(), 0.0, 0);
    let (profile, bore_mm, n_channels) = match name.split('-').next() {
        Some("tpu80") => (vec![[0.0, 6.0], [80.0, 6.0]], 3.0, 4),
        Some("tentacle") => solid(&[[0.0, 15.41], [305.0, 6.42], [360.0, 4.80]]),
        // Corners where segments end.
        Some("ftdcr") => solid(&[[0.0, 5.5], [60.0, 5.5], [120.0, 5.5], [186.5, 5.5]]),
        _ => return Err("a scene of tpu80, tentacle or ftdcr-v4".into()),
    };
    let at = |k: u32| TendonChannel {
        angle: f64::from(k) * std::f64::consts::FRAC_PI_2,
        center_radius: 4.5 * MM,
        radius: 0.75 * MM,
    };
    Ok(Tube {
        profile: profile.iter().map(|corner: &[f64; 2]| corner.map(|v| v * MM)).collect(),
        bore_radius: bore_mm * MM,
        channels: (0..n_channels).map(at).collect(),
        outer_divisions: outer,
        bore_divisions: bore,
        channel_divisions: channel,
        layers: if end > 0.0 {
            Layers::Graded { height: height * MM, end: end * MM }
        } else {
            Layers::Height(height * MM)
        },
        order: if order == "2" { Order::Quadratic } else { Order::Linear },
    })
}
