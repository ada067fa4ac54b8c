//! Strokes over time.

use crate::lines::{PanelScale, TimeChart};
use crate::series::numbered_panels;

/// Strokes of auxiliary tendons over time [s], by tendon, then by sample [mm]; all panels have one scale.
pub fn auxiliary_strokes(time: &[f64], strokes: Vec<Vec<f64>>) -> TimeChart {
    let panels = numbered_panels("stroke [mm]", "auxiliary", strokes);
    let caption = "Strokes of the auxiliary tendons [mm], which correct the twin; zero is no correction. All panels have \
                   one scale.";
    let chart = TimeChart::over_time("auxiliary-strokes", "Auxiliary strokes", caption, time, panels);
    TimeChart { scale: PanelScale::Common, ..chart }
}
