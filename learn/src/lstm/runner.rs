//! One sample at a time, without tensors or allocation.

use serde::{Deserialize, Serialize};

use super::gates::{Forward, PANEL, multiply_add_panels, multiply_add_short_panels};
use super::network::LayerWeights;
use crate::{Head, Network};

/// How a [`Runner`] keeps the weights of its matrices. A network that does not stay in a core's own cache takes as long for a
/// sample as its weights take to come from memory: half as many bits come in half the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WeightFormat {
    /// As they were trained, `f32`.
    #[default]
    Float32,
    /// Whole numbers of 16 bits in the unit of their row, a 32767th of its largest; sums in `f32`.
    Int16,
}

/// A matrix in panels of [`PANEL`] rows: for each panel, for each column, the entries of its rows.
#[derive(Debug, Clone)]
enum Panels {
    Single(Vec<[f32; PANEL]>),
    /// Whole numbers, and the unit of each row.
    Short(Vec<[i16; PANEL]>, Vec<[f32; PANEL]>),
}

impl Panels {
    /// From a row-major matrix; the last panel is filled up with zeros.
    fn new(matrix: &[f32], n_columns: usize, format: WeightFormat) -> Self {
        let panel = |rows: &[f32], column: usize| -> [f32; PANEL] {
            std::array::from_fn(|r| rows.get(r * n_columns + column).copied().unwrap_or(0.0))
        };
        let panels = matrix.chunks(PANEL * n_columns);
        if format == WeightFormat::Float32 {
            return Self::Single(
                panels.flat_map(|rows| (0..n_columns).map(move |c| panel(rows, c))).collect(),
            );
        }
        let unit = |rows: &[f32]| -> [f32; PANEL] {
            let mut rows = rows.chunks_exact(n_columns);
            let largest = |row: &[f32]| row.iter().fold(0.0f32, |max, value| max.max(value.abs()));
            // A row of zeros has a unit too.
            std::array::from_fn(|_| {
                rows.next().map_or(1.0, |row| (largest(row) / f32::from(i16::MAX)).max(f32::MIN_POSITIVE))
            })
        };
        let units: Vec<[f32; PANEL]> = panels.clone().map(unit).collect();
        let whole = |(rows, units): (&[f32], &[f32; PANEL])| -> Vec<[i16; PANEL]> {
            let column = |c: usize| {
                let values = panel(rows, c);
                std::array::from_fn(|r| (values[r] / units[r]).round() as i16)
            };
            (0..n_columns).map(column).collect()
        };
        Self::Short(panels.zip(&units).flat_map(whole).collect(), units)
    }

    /// out += A x.
    fn multiply_add(&self, x: &[f32], out: &mut [f32]) {
        match self {
            Self::Single(panels) => multiply_add_panels(panels, x, out),
            Self::Short(panels, units) => multiply_add_short_panels(panels, units, x, out),
        }
    }
}

/// `n` zeros, and more up to whole panels.
fn padded(n: usize) -> Vec<f32> {
    vec![0.0; n.next_multiple_of(PANEL)]
}

#[derive(Debug, Clone)]
struct Layer {
    from_input: Panels,
    from_memory: Panels,
    /// 4H, padded.
    bias: Vec<f32>,
    h: Vec<f32>,
    c: Vec<f32>,
}

/// A network with its memory, stepped one sample at a time, for rollouts and controllers.
///
/// Steps as [`crate::Backprop::predict`] does for one row, to the round-off of `f32`; with [`WeightFormat::Int16`], to that of
/// its weights.
#[derive(Debug, Clone)]
pub struct Runner {
    inputs: usize,
    hidden: usize,
    layers: Vec<Layer>,
    head: Panels,
    /// As many as outputs, padded.
    head_bias: Vec<f32>,
    kind: Head,
    /// 4H, padded.
    gates: Vec<f32>,
    /// H; cells before the step.
    c_before: Vec<f32>,
    /// As many as outputs, padded.
    output: Vec<f32>,
    n_outputs: usize,
}

impl Runner {
    /// A runner with nothing remembered and weights as they were trained. Dropout does not act.
    pub fn new(network: &Network) -> Self {
        Self::with_weights(network, WeightFormat::Float32)
    }

    /// As [`Runner::new`], with weights in another format.
    pub fn with_weights(network: &Network, format: WeightFormat) -> Self {
        let architecture = network.architecture();
        let hidden = architecture.hidden;
        let pad = |values: &[f32]| {
            let mut all = padded(values.len());
            all[..values.len()].copy_from_slice(values);
            all
        };
        let layer = |(l, parameters): (usize, &Vec<f32>)| {
            let inputs = architecture.layer_inputs(l);
            let weights = LayerWeights::new(parameters, inputs, hidden);
            Layer {
                from_input: Panels::new(weights.ih, inputs, format),
                from_memory: Panels::new(weights.hh, hidden, format),
                bias: pad(weights.bias),
                h: vec![0.0; hidden],
                c: vec![0.0; hidden],
            }
        };
        let layers = network.parameters[..architecture.layers].iter().enumerate().map(layer).collect();
        let (head, head_bias) =
            network.parameters[architecture.layers].split_at(architecture.outputs * hidden);
        Self {
            inputs: architecture.inputs,
            hidden,
            layers,
            head: Panels::new(head, hidden, format),
            head_bias: pad(head_bias),
            kind: architecture.head,
            gates: padded(4 * hidden),
            c_before: vec![0.0; hidden],
            output: padded(architecture.outputs),
            n_outputs: architecture.outputs,
        }
    }

    /// One sample further: the outputs of the head.
    ///
    /// # Panics
    /// If `input` has not as many channels as the network.
    pub fn step(&mut self, input: &[f32]) -> &[f32] {
        assert_eq!(input.len(), self.inputs, "channels of the input");
        let mut x = input;
        for layer in &mut self.layers {
            self.gates.copy_from_slice(&layer.bias);
            layer.from_input.multiply_add(x, &mut self.gates);
            layer.from_memory.multiply_add(&layer.h, &mut self.gates);
            self.c_before.copy_from_slice(&layer.c);
            Forward {
                gates: &mut self.gates[..4 * self.hidden],
                c_before: &self.c_before,
                c: &mut layer.c,
                h: &mut layer.h,
                hidden: self.hidden,
            }
            .run();
            x = &layer.h;
        }
        self.output.copy_from_slice(&self.head_bias);
        self.head.multiply_add(x, &mut self.output);
        let output = &mut self.output[..self.n_outputs];
        if self.kind == Head::Tanh {
            output.iter_mut().for_each(|v| *v = v.tanh());
        }
        output
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        for layer in &mut self.layers {
            layer.h.fill(0.0);
            layer.c.fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_weights_are_off_by_half_a_unit_of_their_row() {
        // Neither whole panels nor, in row 3, anything but zeros.
        let (n_rows, n_columns) = (PANEL + 6, 33);
        let entry =
            |k: usize| if k / n_columns == 3 { 0.0 } else { (k as f32 * 0.7).sin() / (1 + k % 5) as f32 };
        let matrix: Vec<f32> = (0..n_rows * n_columns).map(entry).collect();
        let x: Vec<f32> = (0..n_columns).map(|k| (k as f32 * 1.3).cos()).collect();
        let product = |format| {
            let mut out = padded(n_rows);
            Panels::new(&matrix, n_columns, format).multiply_add(&x, &mut out);
            out
        };
        let (single, short) = (product(WeightFormat::Float32), product(WeightFormat::Int16));
        let reach: f32 = x.iter().map(|x| x.abs()).sum();
        let mut n_different = 0;
        for (r, row) in matrix.chunks(n_columns).enumerate() {
            let unit = row.iter().fold(0.0f32, |max, value| max.max(value.abs())) / f32::from(i16::MAX);
            // Half a unit for every weight, and the round-off of sums of 33 products.
            let tol = 0.5 * unit * reach + 33.0 * f32::EPSILON * reach;
            assert!((single[r] - short[r]).abs() <= tol, "row {r}: {} {}", single[r], short[r]);
            n_different += usize::from(single[r] != short[r]);
        }
        assert!(n_different > n_rows / 2, "{n_different}");
        assert_eq!([short[3], short[n_rows]], [0.0; 2]);
    }
}
