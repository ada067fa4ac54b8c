//! A network: plain arrays of weights.

use hysteron_base::{BadInput, rng};
use rand::RngExt;

use crate::architecture::Part;
use crate::{Architecture, Head, Normaliser};

/// The weights of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    architecture: Architecture,
    /// For each layer W_ih (4H × inputs), W_hh (4H × H), bias (4H) in one vector, row-major, gates in the order
    /// input, forget, cell, output; then the head, weight (outputs × H) and bias (outputs).
    pub(crate) parameters: Vec<Vec<f32>>,
}

impl Network {
    /// Moves every weight by `part` of the way to that of a network of the same shape: a running mean of the weights of
    /// a training, which does better than each of them.
    ///
    /// # Panics
    /// If the shapes differ.
    ///
    /// # Reference
    /// Polyak, Juditsky (1992), Acceleration of stochastic approximation by averaging.
    pub fn approach(&mut self, other: &Self, part: f32) {
        assert_eq!(self.architecture, other.architecture, "networks of one shape");
        for (own, other) in self.parameters.iter_mut().flatten().zip(other.parameters.iter().flatten()) {
            *own += part * (other - *own);
        }
    }

    /// One network that gives the mean of what these give: their layers side by side, with nothing between them.
    ///
    /// # Errors
    /// `BadInput` if there is none, if their shapes differ, or if their head is not linear.
    pub fn mean_of(members: &[Self]) -> Result<Self, BadInput> {
        let bad = |expected: &str, found: String| BadInput::new("networks to join", expected, found);
        let one = &members.first().ok_or_else(|| bad("at least one", "none".to_owned()))?.architecture;
        if one.head != Head::Linear || members.iter().any(|member| member.architecture != *one) {
            let found = members.iter().map(|member| format!("{:?}", member.architecture)).collect::<Vec<_>>();
            return Err(bad("one shape, with a linear head", found.join("; ")));
        }
        let (n, h) = (members.len(), one.hidden);
        let architecture = Architecture { hidden: n * h, ..one.clone() };
        let mut parameters: Vec<Vec<f32>> =
            architecture.parts().iter().map(|parts| vec![0.0; parts.iter().map(Part::len).sum()]).collect();
        for (m, member) in members.iter().enumerate() {
            for (layer, joined) in parameters[..one.layers].iter_mut().enumerate() {
                let inputs = one.layer_inputs(layer);
                let own = LayerWeights::new(&member.parameters[layer], inputs, h);
                // The first layers see the same inputs, the others those of their own member.
                let all_inputs = architecture.layer_inputs(layer);
                let shift = if layer == 0 { 0 } else { m * h };
                let (ih, rest) = joined.split_at_mut(4 * n * h * all_inputs);
                let (hh, bias) = rest.split_at_mut(4 * n * h * n * h);
                for row in 0..4 * h {
                    let to = row / h * n * h + m * h + row % h;
                    let at = to * all_inputs + shift;
                    ih[at..at + inputs].copy_from_slice(&own.ih[row * inputs..(row + 1) * inputs]);
                    let at = to * n * h + m * h;
                    hh[at..at + h].copy_from_slice(&own.hh[row * h..(row + 1) * h]);
                    bias[to] = own.bias[row];
                }
            }
            let (weight, bias) = parameters[one.layers].split_at_mut(one.outputs * n * h);
            let (own, own_bias) = member.parameters[one.layers].split_at(one.outputs * h);
            let part = 1.0 / n as f32;
            for (k, (row, own)) in weight.chunks_exact_mut(n * h).zip(own.chunks_exact(h)).enumerate() {
                row[m * h..(m + 1) * h].iter_mut().zip(own).for_each(|(to, from)| *to = part * from);
                bias[k] += part * own_bias[k];
            }
        }
        Ok(Self { architecture, parameters })
    }

    /// The same function of physical values for inputs and outputs that are normalised by `other` ranges instead of its `own`.
    ///
    /// # Errors
    /// `BadInput` if the head is not linear.
    ///
    /// # Panics
    /// If there are not as many channels as the network has.
    pub fn for_ranges(&self, own: [&Normaliser; 2], other: [&Normaliser; 2]) -> Result<Self, BadInput> {
        let Architecture { inputs, hidden, layers, outputs, head, .. } = self.architecture;
        if head != Head::Linear {
            return Err(BadInput::new("network", "a linear head", format!("{head:?}")));
        }
        let [to_own, to_other] = [own[0].from_normalised(other[0]), other[1].from_normalised(own[1])];
        assert_eq!([to_own.len(), to_other.len()], [inputs, outputs], "channels");
        let mut network = self.clone();
        let (ih, rest) = network.parameters[0].split_at_mut(4 * hidden * inputs);
        let bias = &mut rest[4 * hidden * hidden..];
        for (row, bias) in ih.chunks_exact_mut(inputs).zip(bias) {
            let shifted: f64 = row.iter().zip(&to_own).map(|(w, [_, shift])| f64::from(*w) * shift).sum();
            *bias = (f64::from(*bias) + shifted) as f32;
            row.iter_mut().zip(&to_own).for_each(|(w, [scale, _])| *w = (f64::from(*w) * scale) as f32);
        }
        let (weight, bias) = network.parameters[layers].split_at_mut(outputs * hidden);
        for ((row, bias), [scale, shift]) in weight.chunks_exact_mut(hidden).zip(bias).zip(to_other) {
            row.iter_mut().for_each(|w| *w = (f64::from(*w) * scale) as f32);
            *bias = (f64::from(*bias) * scale + shift) as f32;
        }
        Ok(network)
    }

    /// A network with random weights: all from U(-1/√H, 1/√H), the defaults of PyTorch.
    ///
    /// The one bias of a layer is the sum of two such numbers, as it is where `bias_ih` and `bias_hh` are apart.
    /// Nothing is added to the bias of the forget gate. Each tensor has its own random stream.
    ///
    /// # Errors
    /// `BadInput` if a size is zero or beyond belief, or the dropout not in [0, 1).
    pub fn new(architecture: &Architecture, seed: u64) -> crate::Result<Self> {
        architecture.check()?;
        let bound = 1.0 / (architecture.hidden as f32).sqrt();
        let draw = |part: &Part| -> Vec<f32> {
            let mut stream = rng(seed, &format!("learn/weights/{}", part.name));
            let mut uniform = || stream.random_range(-bound..bound);
            match part.name.starts_with("lstm.bias") {
                true => (0..part.len()).map(|_| uniform() + uniform()).collect(),
                false => (0..part.len()).map(|_| uniform()).collect(),
            }
        };
        let parts = architecture.parts();
        let parameters = parts.iter().map(|parts| parts.iter().flat_map(draw).collect()).collect();
        Ok(Self { architecture: architecture.clone(), parameters })
    }

    /// A network with these parameters, as [`Network::parameters`] are laid out.
    ///
    /// # Errors
    /// `BadInput` if the architecture is invalid or a value not finite, naming its tensor.
    ///
    /// # Panics
    /// If the lengths are not those of the architecture.
    pub(crate) fn from_parameters(
        architecture: Architecture,
        parameters: Vec<Vec<f32>>,
    ) -> Result<Self, BadInput> {
        architecture.check()?;
        let parts = architecture.parts();
        assert_eq!(parts.len(), parameters.len(), "vectors of parameters");
        for (parts, values) in parts.iter().zip(&parameters) {
            let mut rest = &values[..];
            for part in parts {
                let (tensor, after) = rest.split_at(part.len());
                if let Some(bad) = tensor.iter().find(|v| !v.is_finite()) {
                    return Err(BadInput::new(&part.name, "finite weights", bad.to_string()));
                }
                rest = after;
            }
            assert!(rest.is_empty(), "{} parameters too many", rest.len());
        }
        Ok(Self { architecture, parameters })
    }

    /// The shape of the network.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// Numbers that training changes.
    pub fn n_parameters(&self) -> usize {
        self.parameters.iter().map(Vec::len).sum()
    }
}

/// The parameters of a layer, apart.
#[derive(Clone, Copy)]
pub(crate) struct LayerWeights<'a> {
    /// 4H × inputs, row-major.
    pub ih: &'a [f32],
    /// 4H × H, row-major.
    pub hh: &'a [f32],
    /// 4H.
    pub bias: &'a [f32],
}

impl<'a> LayerWeights<'a> {
    pub fn new(parameters: &'a [f32], inputs: usize, hidden: usize) -> Self {
        let (ih, rest) = parameters.split_at(4 * hidden * inputs);
        let (hh, bias) = rest.split_at(4 * hidden * hidden);
        assert_eq!(bias.len(), 4 * hidden, "bias of a layer");
        Self { ih, hh, bias }
    }
}
