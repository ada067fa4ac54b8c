//! One pass forward and back over stretches of recordings, all samples at once: on the processor, or on a card.

use hysteron_learn::{CardUpdates, Float, TapePool, TemporalForm, Transformer, TransformerShape};

/// Stretches side by side that a network passes over.
#[derive(Clone, Copy)]
pub(super) struct Stretches<'s> {
    pub shape: &'s TransformerShape,
    pub rows: usize,
    /// Samples of each that count, after as many as fill the network's window.
    pub span: usize,
}

impl Stretches<'_> {
    fn before(&self) -> usize {
        self.shape.tokens - 1
    }

    fn steps(&self) -> usize {
        self.before() + self.span
    }

    /// Inputs of the network ([step][row][channel]): `token` writes them for a step (before the stretch below
    /// zero) of a row.
    fn tokens<T: Float>(&self, token: impl Fn(isize, usize, &mut [T])) -> Vec<T> {
        let mut tokens = vec![T::default(); self.steps() * self.rows * self.shape.inputs];
        for (at, to) in tokens.chunks_exact_mut(self.shape.inputs).enumerate() {
            token((at / self.rows) as isize - self.before() as isize, at % self.rows, to);
        }
        tokens
    }

    /// The derivatives of the loss by all outputs: `weigh` takes those at a step of a row and adds the derivatives by them.
    fn weighed<T: Float>(
        &self,
        outputs: &[T],
        mut weigh: impl FnMut(usize, usize, &mut [f64], &mut [f64]),
    ) -> Vec<T> {
        let n = self.shape.outputs();
        // In a window all results belong to its last step.
        let first = if self.shape.form == TemporalForm::Window { 0 } else { self.before() };
        let (mut found, mut by_outputs) = (vec![0.0; n], vec![0.0; n]);
        let mut all = vec![T::default(); outputs.len()];
        for (step, row) in (0..self.span).flat_map(|step| (0..self.rows).map(move |row| (step, row))) {
            let at = ((first + step) * self.rows + row) * n;
            found.iter_mut().zip(&outputs[at..at + n]).for_each(|(to, y)| *to = y.to_f64());
            by_outputs.fill(0.0);
            weigh(step, row, &mut found, &mut by_outputs);
            all[at..at + n].iter_mut().zip(&by_outputs).for_each(|(to, from)| *to = T::of(*from));
        }
        all
    }

    /// One pass by the fused kernels, see [`Self::tokens`] and [`Self::weighed`]. Adds to `gradient`.
    pub fn pass<T: Float>(
        &self,
        (network, tapes): (&Transformer<T>, &TapePool<T>),
        token: impl Fn(isize, usize, &mut [T]),
        weigh: impl FnMut(usize, usize, &mut [f64], &mut [f64]),
        gradient: &mut [Vec<T>],
    ) {
        let (tokens, steps) = (self.tokens(token), self.steps());
        tapes.with(self.shape, (steps, self.rows), |tape| {
            let by_outputs = self.weighed(tape.forward(network, 0..steps, &tokens), weigh);
            tape.clear_gradients();
            tape.backward(network, 0..steps, &by_outputs, gradient);
            tape.weight_gradients(network, steps, gradient);
        });
    }

    /// The way forward on a card; gives the derivatives of the loss by all outputs, for [`CardUpdates::update`].
    ///
    /// # Errors
    /// As [`CardUpdates::forward`].
    pub fn pass_on_card(
        &self,
        updates: &mut CardUpdates,
        token: impl Fn(isize, usize, &mut [f32]),
        weigh: impl FnMut(usize, usize, &mut [f64], &mut [f64]),
    ) -> hysteron_learn::Result<Vec<f32>> {
        let outputs = updates.forward(&self.tokens(token), self.rows)?;
        Ok(self.weighed(&outputs, weigh))
    }
}
