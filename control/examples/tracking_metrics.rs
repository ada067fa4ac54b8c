//! Metrics of pairs of curves, for other programs to check (`tests/peers/tracking_metrics_peer.py`): one JSON object
//! `{"a": [[x, y], …], "b": …}` a line comes in, one with the metrics goes out.

use hysteron_base::json;
use std::io::{BufRead, Write};

use hysteron_control::tracking::{PlanarPoint, chamfer, frechet, frechet_closed, hausdorff, iou};

#[derive(serde::Deserialize)]
struct Pair {
    a: Vec<PlanarPoint>,
    b: Vec<PlanarPoint>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let Pair { a, b } = json::from_text(&line?)?;
        let metrics = hysteron_base::json!({
            "iou": iou(&a, &b), "hausdorff": hausdorff(&a, &b), "chamfer": chamfer(&a, &b), "frechet": frechet(&a, &b),
            "frechet_closed": frechet_closed(&a, &b),
        });
        writeln!(out, "{metrics}")?;
    }
    Ok(())
}
