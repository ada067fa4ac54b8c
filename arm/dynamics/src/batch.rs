//! Many states at once: one state in each lane of a register, registers shared among threads.
//!
//! The lanes of a register do not see each other, and a state's lane follows from its number alone: results are the same
//! bytes on any number of threads.

use std::any::Any;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use hysteron_base::lanes::{Isa, LANES, Lanes, Pack, Packs, Simd, WithSimd};
use rayon::prelude::*;

use crate::{Data, Model, Scalar};

/// States that a thread takes at a time; a multiple of [`LANES`].
const BLOCK: usize = 32 * LANES;

/// Something to compute for every state, for any kind of number.
pub trait StateKernel: Sync {
    /// Numbers of a state in every input; q, q̇ and a third of the same size by default.
    fn inputs(&self, model: &Model) -> Vec<usize> {
        vec![model.n_joints(); 3]
    }

    /// Numbers of a state in every output; one for each joint by default.
    fn outputs(&self, model: &Model) -> Vec<usize> {
        vec![model.n_joints()]
    }

    /// Computes one state in every lane.
    fn run<T: Scalar>(&self, model: &Model, data: &mut Data<T>, inputs: &[&[T]], outputs: &mut [&mut [T]]);
}

/// Runs kernels over many states of one model, with scratch that is allocated once for each thread.
#[derive(Debug)]
pub struct Batch<'m> {
    model: &'m Model,
    isa: Isa,
    /// One for each thread: `Scratch<S>` of the instruction set.
    scratch: Vec<Mutex<Option<Box<dyn Any + Send>>>>,
}

/// Scratch in registers of one instruction set.
struct Scratch<S: Simd> {
    data: Data<Lanes<S>>,
    inputs: Vec<Lanes<S>>,
    outputs: Vec<Lanes<S>>,
}

impl<'m> Batch<'m> {
    /// On the widest registers of this processor.
    pub fn new(model: &'m Model) -> Self {
        Self::on(model, Isa::detect())
    }

    /// On registers of one instruction set.
    pub fn on(model: &'m Model, isa: Isa) -> Self {
        let threads = rayon::current_num_threads() + 1;
        Self { model, isa, scratch: (0..threads).map(|_| Mutex::new(None)).collect() }
    }

    /// Runs `kernel` for `n_states` states on all threads: every input and output has a row for each state.
    ///
    /// # Panics
    /// Where an input or output has another number of rows or columns.
    pub fn run<K: StateKernel>(
        &self,
        kernel: &K,
        n_states: usize,
        inputs: &[&[f64]],
        outputs: &mut [&mut [f64]],
    ) {
        let widths = kernel.outputs(self.model);
        check_shapes("input", n_states, &kernel.inputs(self.model), inputs.iter().map(|rows| rows.len()));
        check_shapes("output", n_states, &widths, outputs.iter().map(|rows| rows.len()));
        // Parts of all outputs that belong to the same states go together.
        let n_blocks = n_states.div_ceil(BLOCK);
        let mut blocks: Vec<Vec<&mut [f64]>> =
            (0..n_blocks).map(|_| Vec::with_capacity(widths.len())).collect();
        for (rows, width) in outputs.iter_mut().zip(&widths) {
            for (block, part) in blocks.iter_mut().zip(rows.chunks_mut(BLOCK * width)) {
                block.push(part);
            }
        }
        blocks.into_par_iter().enumerate().for_each(|(b, mut outputs)| {
            let states = b * BLOCK..n_states.min((b + 1) * BLOCK);
            let thread =
                rayon::current_thread_index().map_or(self.scratch.len() - 1, |t| t % self.scratch.len());
            let mut scratch = self.scratch[thread].lock().unwrap_or_else(PoisonError::into_inner);
            let model = self.model;
            self.isa.run(StateBlock {
                kernel,
                model,
                states,
                inputs,
                outputs: &mut outputs,
                scratch: &mut scratch,
            });
        });
    }
}

fn check_shapes(what: &str, n_states: usize, widths: &[usize], lengths: impl Iterator<Item = usize>) {
    let lengths: Vec<usize> = lengths.collect();
    let expected: Vec<usize> = widths.iter().map(|width| width * n_states).collect();
    assert_eq!(lengths, expected, "numbers in every {what} for {n_states} states");
}

/// The states that one thread takes.
struct StateBlock<'a, 'o, K> {
    kernel: &'a K,
    model: &'a Model,
    states: Range<usize>,
    inputs: &'a [&'a [f64]],
    /// Of these states only.
    outputs: &'a mut [&'o mut [f64]],
    scratch: &'a mut Option<Box<dyn Any + Send>>,
}

impl<K: StateKernel> WithSimd for StateBlock<'_, '_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { kernel, model, states, inputs, outputs, scratch } = self;
        let zero = Packs::new(simd, 0).splat(0.0);
        let (widths_in, widths_out) = (kernel.inputs(model), kernel.outputs(model));
        let fresh = || -> Box<dyn Any + Send> {
            Box::new(Scratch { data: Data::new(model, zero), inputs: Vec::new(), outputs: Vec::new() })
        };
        let boxed = scratch.get_or_insert_with(fresh);
        let Some(scratch) = boxed.downcast_mut::<Scratch<S>>() else { return };
        scratch.inputs.resize(widths_in.iter().sum(), zero);
        scratch.outputs.resize(widths_out.iter().sum(), zero);
        let start = states.start;
        for register in Register::all(simd, states) {
            let mut at = 0;
            for (rows, width) in inputs.iter().zip(&widths_in) {
                for column in 0..*width {
                    scratch.inputs[at] = register.load(rows, *width, column);
                    at += 1;
                }
            }
            run_kernel(kernel, model, scratch, &widths_in, &widths_out);
            let mut at = 0;
            for (rows, width) in outputs.iter_mut().zip(&widths_out) {
                for column in 0..*width {
                    register.store(scratch.outputs[at], rows, start, *width, column);
                    at += 1;
                }
            }
        }
    }
}

/// The rows of arrays of the lanes of a register; the last register is filled up with the last row.
#[derive(Clone, Copy)]
pub(crate) struct Register<S: Simd> {
    packs: Packs<S>,
    first: usize,
    end: usize,
}

impl<S: Simd> Register<S> {
    /// One after the other until all of `rows` are in one.
    #[inline(always)]
    pub(crate) fn all(simd: S, rows: Range<usize>) -> impl Iterator<Item = Self> {
        let end = rows.end;
        rows.step_by(S::F64_LANES).map(move |first| Self { packs: Packs::new(simd, 0), first, end })
    }

    #[inline(always)]
    pub(crate) fn zero(self) -> Lanes<S> {
        self.packs.splat(0.0)
    }

    /// A column of an array of `width` columns.
    #[inline(always)]
    pub(crate) fn load(self, rows: &[f64], width: usize, column: usize) -> Lanes<S> {
        let mut pack = Pack([0.0; LANES]);
        for lane in 0..S::F64_LANES {
            pack.0[lane] = rows[width * (self.first + lane).min(self.end - 1) + column];
        }
        self.packs.load(&pack)
    }

    /// Into a column of an array of `width` columns that begins with the row `start`.
    #[inline(always)]
    pub(crate) fn store(self, value: Lanes<S>, rows: &mut [f64], start: usize, width: usize, column: usize) {
        let values = value.to_array();
        for lane in 0..S::F64_LANES.min(self.end - self.first) {
            rows[width * (self.first - start + lane) + column] = values[lane];
        }
    }
}

/// Hands the kernel its inputs and outputs as slices, without allocating.
#[inline(always)]
fn run_kernel<S: Simd, K: StateKernel>(
    kernel: &K,
    model: &Model,
    scratch: &mut Scratch<S>,
    widths_in: &[usize],
    widths_out: &[usize],
) {
    let mut inputs: [&[Lanes<S>]; MAX_SLICES] = [&[]; MAX_SLICES];
    let mut rest = &scratch.inputs[..];
    for (slice, width) in inputs.iter_mut().zip(widths_in) {
        (*slice, rest) = rest.split_at(*width);
    }
    let mut outputs: [&mut [Lanes<S>]; MAX_SLICES] = std::array::from_fn(|_| Default::default());
    let mut rest = &mut scratch.outputs[..];
    for (slice, width) in outputs.iter_mut().zip(widths_out) {
        let (part, after) = rest.split_at_mut(*width);
        (*slice, rest) = (part, after);
    }
    let (n_in, n_out) = (widths_in.len(), widths_out.len());
    kernel.run(model, &mut scratch.data, &inputs[..n_in], &mut outputs[..n_out]);
}

/// Inputs or outputs that a kernel may have.
const MAX_SLICES: usize = 8;
