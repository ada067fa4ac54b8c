//! Shape of a Transformer: sizes, kind of blocks, form in time; layout of its parameters.

use std::ops::Range;

use hysteron_base::BadInput;
use hysteron_base::size::check_count;
use serde::{Deserialize, Serialize};

use crate::{MAX_HIDDEN, TensorShape};

/// How a layer is put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BlockKind {
    /// As NeuralActuator's authors released it: normalisation before attention and feed-forward network, GELU, and a sigmoid gate
    /// for each number of the attention's output, from a query projection of twice the width.
    GatedPreNorm,
    /// As the paper prints it, equations (4) and (5): normalisation after each sum, SiLU, trainable scalars
    /// γ.
    ScaledPostNorm,
    /// A gated recurrent unit for each number: no attention, no normalisation, no feed-forward network. Its
    /// state does not end with the window, and an output comes from the last token alone. Streaming only.
    Gru,
    /// As [`BlockKind::Gru`], a long short-term memory.
    Lstm,
}

impl BlockKind {
    /// Gates of a unit, of a recurrent layer.
    pub(super) fn gates(self) -> Option<usize> {
        match self {
            Self::GatedPreNorm | Self::ScaledPostNorm => None,
            Self::Gru => Some(3),
            Self::Lstm => Some(4),
        }
    }
}

/// How the network meets time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TemporalForm {
    /// A window of tokens at trainable positions, each attending to all; one output for the window, from the
    /// mean of its tokens.
    Window,
    /// One token a step, attending to itself and those before it in the window by their lag; one output a step, from the mean of
    /// the tokens in the window. What a token was does not change any more: keys and values are kept.
    Streaming,
}

/// Sizes and kind of a Transformer encoder with one small perceptron for each group of outputs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransformerShape {
    /// Numbers of a token before the first projection.
    pub inputs: usize,
    /// Outputs of each head.
    pub heads: Vec<usize>,
    /// d: numbers of a token within the network.
    pub width: usize,
    /// Layers.
    pub layers: usize,
    /// Heads of the attention; they share the width.
    pub attention_heads: usize,
    /// Units of a feed-forward network.
    pub feed_forward: usize,
    /// Hidden units of each head.
    pub latent: usize,
    /// Tokens of a window, the current one among them.
    pub tokens: usize,
    /// How a layer is put together.
    pub block: BlockKind,
    /// How the network meets time.
    pub form: TemporalForm,
}

/// More layers than any network here has.
const MAX_LAYERS: usize = 64;
/// More heads, of attention or of outputs.
const MAX_HEADS: usize = 64;
/// The longest window.
const MAX_TOKENS: usize = 1024;

impl TransformerShape {
    /// The sizes of NeuralActuator's release for `inputs` numbers a token and these heads.
    pub fn published(inputs: usize, heads: &[usize], form: TemporalForm) -> Self {
        Self {
            inputs,
            heads: heads.to_vec(),
            width: 192,
            layers: 4,
            attention_heads: 4,
            feed_forward: 384,
            latent: 96,
            tokens: 9,
            block: BlockKind::GatedPreNorm,
            form,
        }
    }

    /// # Errors
    /// `BadInput` for a size of zero or beyond what a network here has, or a width that the attention's heads do not share evenly.
    pub fn check(&self) -> Result<(), BadInput> {
        let sizes = [
            ("inputs", self.inputs, MAX_HIDDEN),
            ("heads", self.heads.len(), MAX_HEADS),
            ("width", self.width, MAX_HIDDEN),
            ("layers", self.layers, MAX_LAYERS),
            ("attention_heads", self.attention_heads, MAX_HEADS),
            ("feed_forward", self.feed_forward, MAX_HIDDEN),
            ("latent", self.latent, MAX_HIDDEN),
            ("tokens", self.tokens, MAX_TOKENS),
        ];
        let outputs = self.heads.iter().map(|n| ("outputs of a head", *n, MAX_HIDDEN));
        sizes.into_iter().chain(outputs).try_for_each(|(name, n, most)| check_count(name, n, most))?;
        if !self.width.is_multiple_of(self.attention_heads) {
            let expected = format!("a multiple of the {} attention heads", self.attention_heads);
            return Err(BadInput::new("width", expected, self.width.to_string()));
        }
        if self.block.gates().is_some() && self.form == TemporalForm::Window {
            return Err(BadInput::new("form", "streaming for a recurrent layer", "window"));
        }
        Ok(())
    }

    /// Outputs of all heads together.
    pub fn outputs(&self) -> usize {
        self.heads.iter().sum()
    }

    /// Numbers of all parameters.
    pub fn n_parameters(&self) -> usize {
        self.tensors().iter().flatten().map(TensorShape::len).sum()
    }

    /// Queries, gates where there are any, keys and values of a token; the gates of a recurrent unit.
    pub(super) fn projected(&self) -> usize {
        match self.block {
            BlockKind::GatedPreNorm => 4 * self.width,
            BlockKind::ScaledPostNorm | BlockKind::Gru => 3 * self.width,
            BlockKind::Lstm => 4 * self.width,
        }
    }

    /// Tokens, up to the last one, whose mean an output comes from.
    pub(super) fn pooled(&self) -> usize {
        if self.block.gates().is_some() { 1 } else { self.tokens }
    }

    /// Names and shapes: embedding, every layer, heads.
    pub(super) fn tensors(&self) -> Vec<Vec<TensorShape>> {
        let (d, f) = (self.width, self.feed_forward);
        let tensor = |name: &str, shape: &[usize]| TensorShape::new(name, shape);
        let mut embedding = vec![tensor("input.weight", &[self.inputs, d]), tensor("input.bias", &[d])];
        if self.form == TemporalForm::Window {
            embedding.push(tensor("position", &[self.tokens, d]));
        }
        let layer = |l: usize| {
            let own = |name: &str, shape: &[usize]| tensor(&format!("layer.{l}.{name}"), shape);
            if self.block.gates().is_some() {
                let wide = self.projected();
                return vec![
                    own("cell.weight", &[d, wide]),
                    own("cell.bias", &[wide]),
                    own("cell.state.weight", &[d, wide]),
                    own("cell.state.bias", &[wide]),
                ];
            }
            let mut all = vec![
                own("norm1.weight", &[d]),
                own("norm1.bias", &[d]),
                own("attention.weight", &[d, self.projected()]),
                own("attention.bias", &[self.projected()]),
                own("attention.out.weight", &[d, d]),
                own("attention.out.bias", &[d]),
                own("norm2.weight", &[d]),
                own("norm2.bias", &[d]),
                own("feed_forward.weight", &[d, f]),
                own("feed_forward.bias", &[f]),
                own("feed_forward.out.weight", &[f, d]),
                own("feed_forward.out.bias", &[d]),
            ];
            if self.block == BlockKind::ScaledPostNorm {
                all.push(own("scales", &[2]));
            }
            if self.form == TemporalForm::Streaming {
                all.push(own("attention.lags", &[self.attention_heads, self.tokens]));
            }
            all
        };
        let hidden = self.heads.len() * self.latent;
        let mut head = Vec::new();
        if self.block == BlockKind::GatedPreNorm {
            head.extend([tensor("norm.weight", &[d]), tensor("norm.bias", &[d])]);
        }
        head.extend([tensor("latent.weight", &[d, hidden]), tensor("latent.bias", &[hidden])]);
        for (k, n) in self.heads.iter().enumerate() {
            head.push(tensor(&format!("head.{k}.weight"), &[self.latent, *n]));
            head.push(tensor(&format!("head.{k}.bias"), &[*n]));
        }
        std::iter::once(embedding).chain((0..self.layers).map(layer)).chain([head]).collect()
    }
}

/// Ranges of the arrays in a vector of parameters, in the order of [`TransformerShape::tensors`].
fn ranges(tensors: &[TensorShape]) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut next = |tensor: &TensorShape| {
        start += tensor.len();
        start - tensor.len()..start
    };
    tensors.iter().map(&mut next).collect()
}

/// Ranges of the arrays of a layer in its vector.
#[derive(Debug, Clone)]
pub(super) struct LayerLayout {
    pub norm: [[Range<usize>; 2]; 2],
    /// Weight and bias of the projections, the attention's output, and the two layers of the feed-forward network; of a recurrent layer, of
    /// the token and of the state before. What a layer does not have is empty.
    pub linear: [[Range<usize>; 2]; 4],
    pub scales: Option<Range<usize>>,
    pub lags: Option<Range<usize>>,
}

/// Ranges of all arrays.
#[derive(Debug, Clone)]
pub(super) struct ParameterLayout {
    pub input: [Range<usize>; 2],
    pub positions: Option<Range<usize>>,
    pub layer: LayerLayout,
    pub norm: Option<[Range<usize>; 2]>,
    pub latent: [Range<usize>; 2],
    pub heads: Vec<[Range<usize>; 2]>,
}

impl ParameterLayout {
    pub fn new(shape: &TransformerShape) -> Self {
        let tensors = shape.tensors();
        let of = |vector: usize| ranges(&tensors[vector]);
        let pair = |all: &[Range<usize>], k: usize| [all[k].clone(), all[k + 1].clone()];
        let embedding = of(0);
        let own = of(1);
        let named = |name: &str| {
            let found = tensors[1].iter().position(|tensor| tensor.name.ends_with(name));
            found.map(|k| own[k].clone())
        };
        let head = of(shape.layers + 1);
        let first = usize::from(shape.block == BlockKind::GatedPreNorm) * 2;
        let is_recurrent = shape.block.gates().is_some();
        let nothing = [(); 2].map(|()| [0..0, 0..0]);
        Self {
            input: pair(&embedding, 0),
            positions: embedding.get(2).cloned(),
            layer: LayerLayout {
                norm: if is_recurrent { nothing.clone() } else { [pair(&own, 0), pair(&own, 6)] },
                linear: if is_recurrent {
                    let [none, no] = nothing;
                    [pair(&own, 0), pair(&own, 2), none, no]
                } else {
                    [pair(&own, 2), pair(&own, 4), pair(&own, 8), pair(&own, 10)]
                },
                scales: named(".scales"),
                lags: named(".lags"),
            },
            norm: (first > 0).then(|| pair(&head, 0)),
            latent: pair(&head, first),
            heads: (0..shape.heads.len()).map(|k| pair(&head, first + 2 + 2 * k)).collect(),
        }
    }
}
