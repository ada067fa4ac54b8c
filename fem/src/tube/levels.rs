//! Heights of a tube's sections: division of the profile along z.

use hysteron_base::BadInput;
use hysteron_base::size::check_at_most;

use super::{FEWER, Layers, MAX_LAYERS, mm};

type ProfileCorner = [f64; 2];

/// How fast layers grow away from the end of a link: height per length \[-\].
const GROWTH: f64 = 0.25;

/// Layers of the least height next to the end of a link.
const FINE_LAYERS: f64 = 3.0;

/// Steps of a link in which its graded layers are counted.
const STEPS: usize = 4096;

/// Height z \[m\] and scale \[-\] of every section, the scale 1 at the base.
pub(super) fn levels(profile: &[ProfileCorner], layers: Layers) -> Result<Vec<[f64; 2]>, BadInput> {
    let links: Vec<(ProfileCorner, ProfileCorner)> = profile.windows(2).map(|w| (w[0], w[1])).collect();
    let shares: Vec<Vec<f64>> = match layers {
        Layers::Height(height) => {
            let counts = by_height(&links, height)?;
            counts.into_iter().map(|n| (1..=n).map(|k| k as f64 / n as f64).collect()).collect()
        }
        Layers::Count(n) => {
            if (n as usize) < links.len() || n as usize > MAX_LAYERS {
                return Err(BadInput::new(
                    "tube: layers",
                    format!("{} to {MAX_LAYERS}, one for every link", links.len()),
                    n.to_string(),
                ));
            }
            let counts = counts_by_radius(&links, n as usize);
            let of = |((low, high), n): (&(ProfileCorner, ProfileCorner), usize)| {
                (1..=n).map(|k| share_of_link(low[1], high[1], k as f64 / n as f64)).collect()
            };
            links.iter().zip(counts).map(of).collect()
        }
        Layers::Graded { height, end } => graded(profile, height, end)?,
    };
    let base = profile[0][1];
    let mut levels = vec![[0.0, 1.0]];
    for ((low, high), shares) in links.iter().zip(shares) {
        let n = shares.len();
        for (k, s) in (1..).zip(shares) {
            // The last section is the corner itself.
            let z = if k == n { high[0] } else { low[0] + s * (high[0] - low[0]) };
            let radius = if k == n { high[1] } else { low[1] + s * (high[1] - low[1]) };
            levels.push([z, radius / base]);
        }
    }
    Ok(levels)
}

/// Layers per link, none higher than `height`.
fn by_height(links: &[(ProfileCorner, ProfileCorner)], height: f64) -> Result<Vec<usize>, BadInput> {
    let mut counts = Vec::new();
    for (low, high) in links {
        counts.push(counted(height, (high[0] - low[0]) / height * (1.0 - 1e-12))?);
    }
    check_at_most("tube: layers", counts.iter().sum(), MAX_LAYERS)?;
    Ok(counts)
}

/// `n` rounded up, at least one.
fn counted(height: f64, n: f64) -> Result<usize, BadInput> {
    let n = n.ceil().max(1.0);
    // Not a number fails here too.
    if !(height > 0.0 && n <= MAX_LAYERS as f64) {
        let expected = format!("at most {MAX_LAYERS}");
        return Err(BadInput::new("tube: layers", expected, format!("{n:.0}")).hint(FEWER));
    }
    Ok(n as usize)
}

/// Shares of every link below its sections, the layers at most `height` high, `end` high near the corners above the base.
fn graded(profile: &[ProfileCorner], height: f64, end: f64) -> Result<Vec<Vec<f64>>, BadInput> {
    if !(end > 0.0 && end <= height) {
        let expected = format!("above 0 and at most the height of the others, {}", mm(height));
        return Err(BadInput::new("tube: layers at the ends", expected, mm(end)));
    }
    let wanted = |z: f64| {
        let to_corner = profile[1..].iter().map(|corner| (z - corner[0]).abs()).fold(f64::INFINITY, f64::min);
        (end + GROWTH * (to_corner - FINE_LAYERS * end).max(0.0)).min(height)
    };
    let mut out = Vec::new();
    for pair in profile.windows(2) {
        let length = pair[1][0] - pair[0][0];
        let step = length / STEPS as f64;
        // Number of layers between the lower corner and every step.
        let mut below = vec![0.0; STEPS + 1];
        for k in 0..STEPS {
            below[k + 1] = below[k] + step / wanted(pair[0][0] + (k as f64 + 0.5) * step);
        }
        let n = counted(height, below[STEPS] * (1.0 - 1e-9))?;
        let share = |layer: usize| {
            let target = below[STEPS] * layer as f64 / n as f64;
            let k = below.partition_point(|layers| *layers <= target).clamp(1, STEPS);
            ((k - 1) as f64 + (target - below[k - 1]) / (below[k] - below[k - 1])) / STEPS as f64
        };
        out.push((1..=n).map(share).collect());
    }
    check_at_most("tube: layers", out.iter().map(Vec::len).sum(), MAX_LAYERS)?;
    Ok(out)
}

/// Part of a link below which lies the share `t` of its layers, when their heights follow the radius.
fn share_of_link(low: f64, high: f64, t: f64) -> f64 {
    let growth = high / low - 1.0;
    if growth.abs() < 1e-9 { t } else { ((high / low).powf(t) - 1.0) / growth }
}

/// Layers per link: in proportion to ∫ dz / r, at least one each, `n` in all.
fn counts_by_radius(links: &[([f64; 2], [f64; 2])], n: usize) -> Vec<usize> {
    let weight: Vec<f64> = links
        .iter()
        .map(|(low, high)| {
            let growth = high[1] / low[1] - 1.0;
            let mean = if growth.abs() < 1e-9 { 1.0 } else { growth.ln_1p() / growth };
            (high[0] - low[0]) / low[1] * mean
        })
        .collect();
    let mut counts = vec![1; links.len()];
    for _ in links.len()..n {
        // The link whose layers are now the highest gets the next one.
        let highest = (0..links.len())
            .max_by(|&a, &b| {
                (weight[a] / counts[a] as f64).total_cmp(&(weight[b] / counts[b] as f64)).then(b.cmp(&a))
            })
            .unwrap_or(0);
        counts[highest] += 1;
    }
    counts
}
