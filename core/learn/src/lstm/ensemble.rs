//! Ensembles: several networks as one that gives the mean of what they give.

use hysteron_base::BadInput;

use super::network::LayerWeights;
use crate::{Architecture, HeadActivation, Network, Normaliser, TensorShape};

/// A network and the ranges that it was trained with.
#[derive(Debug, Clone, Copy)]
pub struct Member<'a> {
    /// The network.
    pub network: &'a Network,
    /// Ranges of its inputs.
    pub inputs: &'a Normaliser,
    /// Ranges of its outputs.
    pub outputs: &'a Normaliser,
}

impl Network {
    /// One network that gives the mean of what the members of an ensemble give, with the ranges of all inputs and of all
    /// outputs.
    ///
    /// # Errors
    /// `BadInput` if there is no member, or if their shapes or channels differ, or if their head is not linear.
    pub fn ensemble(members: &[Member<'_>]) -> Result<(Self, Normaliser, Normaliser), BadInput> {
        let inputs = Normaliser::union(&members.iter().map(|member| member.inputs).collect::<Vec<_>>())?;
        let outputs = Normaliser::union(&members.iter().map(|member| member.outputs).collect::<Vec<_>>())?;
        let common = |member: &Member<'_>| {
            member.network.for_ranges([member.inputs, member.outputs], [&inputs, &outputs])
        };
        let networks = members.iter().map(common).collect::<Result<Vec<_>, _>>()?;
        Ok((Self::mean_of(&networks)?, inputs, outputs))
    }

    /// One network that gives the mean of what these give: their layers side by side, with nothing between them.
    ///
    /// # Errors
    /// `BadInput` if there is none, if their shapes differ, or if their head is not linear.
    pub fn mean_of(members: &[Self]) -> Result<Self, BadInput> {
        let bad = |expected: &str, found: String| BadInput::new("networks to join", expected, found);
        let one = &members.first().ok_or_else(|| bad("at least one", "none".to_owned()))?.architecture;
        if one.head != HeadActivation::Linear || members.iter().any(|member| member.architecture != *one) {
            let found = members.iter().map(|member| member.architecture.to_string()).collect::<Vec<_>>();
            return Err(bad("one shape, with a linear head", found.join("; ")));
        }
        let (n, h) = (members.len(), one.hidden);
        let architecture = Architecture { hidden: n * h, ..one.clone() };
        let mut parameters: Vec<Vec<f32>> = architecture
            .tensors()
            .iter()
            .map(|of| vec![0.0; of.iter().map(TensorShape::len).sum()])
            .collect();
        for (m, member) in members.iter().enumerate() {
            for (layer, joined) in parameters[..one.layers].iter_mut().enumerate() {
                let inputs = one.layer_inputs(layer);
                let own = LayerWeights::new(&member.parameters[layer], inputs, h);
                // The first layers get the same inputs, the others those of their own member.
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
        if head != HeadActivation::Linear {
            return Err(BadInput::new("network", "a linear head", head.name()));
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
}
