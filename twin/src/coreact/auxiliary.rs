//! The auxiliary tendons as residual actuation.

use hysteron_base::{BadInput, Bounds};

use crate::model::{Target, Twin};
use crate::stepper::Stepper;
use crate::{Result, TwinTendon};

/// Limits of the auxiliary tendons of a twin, in strokes.
#[derive(Debug, Clone, PartialEq)]
pub struct AuxiliaryLimits {
    /// Stroke that one newton makes on the straight body, other tensions unchanged (n_aux) [m/N].
    pub compliances: Vec<f64>,
    /// Bounds of stroke and tension together (n_aux) [m]; zero is allowed.
    pub bounds: Vec<Bounds>,
    /// Fastest change of a stroke [m/s].
    pub rate: f64,
    /// Bounds of the tensions (n_aux) [N].
    tensions: Vec<Bounds>,
}

impl AuxiliaryLimits {
    /// The auxiliary tendons of `twin`.
    ///
    /// # Errors
    /// There are none, or their bounds leave out zero, where they do nothing.
    pub fn new(twin: &Twin) -> Result<Self> {
        let tendons = &twin.tendons[twin.n_primary..];
        if tendons.is_empty() {
            return Err(BadInput::new("scene: auxiliary", "auxiliary tendons", "none")
                .hint("meshes/tpu80/scene-coreact.toml has a layout of them")
                .into());
        }
        let delassus = Stepper::new(twin).delassus(twin)?;
        let compliance = |j: usize| delassus[j * (twin.tendons.len() + 1)];
        let compliances: Vec<f64> = (twin.n_primary..twin.tendons.len()).map(compliance).collect();
        let bounds = tendons.iter().zip(&compliances).map(|(tendon, &compliance)| within(tendon, compliance));
        Ok(Self {
            bounds: bounds.collect::<std::result::Result<_, BadInput>>()?,
            compliances,
            rate: twin.auxiliary_rate,
            tensions: tendons.iter().map(|tendon| tendon.tension).collect(),
        })
    }

    /// Number of auxiliary tendons.
    pub fn len(&self) -> usize {
        self.compliances.len()
    }

    /// False: there is at least one.
    pub fn is_empty(&self) -> bool {
        self.compliances.is_empty()
    }

    /// Writes the target of every tendon: the primary strokes, and the tensions of auxiliary strokes (n_aux)
    /// [m].
    pub fn targets_into(&self, primary: &[f64], strokes: &[f64], targets: &mut Vec<Target>) {
        targets.clear();
        targets.extend(primary.iter().map(|&stroke| Target::Stroke(stroke)));
        let tension = |j: usize| self.tensions[j].clamp(strokes[j] / self.compliances[j]);
        targets.extend((0..self.len()).map(|j| Target::Tension(tension(j))));
    }
}

/// Strokes that keep stroke and tension of a tendon within its bounds.
fn within(tendon: &TwinTendon, compliance: f64) -> std::result::Result<Bounds, BadInput> {
    let bounds = Bounds {
        min: tendon.stroke.min.max(tendon.tension.min * compliance),
        max: tendon.stroke.max.min(tendon.tension.max * compliance),
    };
    if bounds.contains(0.0) {
        return Ok(bounds);
    }
    let found = format!("{:.4} to {:.4} mm", 1e3 * bounds.min, 1e3 * bounds.max);
    Err(BadInput::new(format!("scene: auxiliary: strokes of {}", tendon.name), "bounds around zero", found)
        .hint(
            "at zero a auxiliary tendon does nothing; stroke_min_mm and tension_min_n must not be above it",
        ))
}
