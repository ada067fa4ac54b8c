//! An identified recording as training data.

use hysteron_base::{BadInput, Recording, file, json};

use super::StrokeDecoder;

/// Key of a recording's metadata with the decoder of the network that chose its auxiliary strokes.
pub const DECODER: &str = "identify.decoder";

/// One identified trajectory.
#[derive(Debug, Clone)]
pub struct Sequence {
    /// Name in messages.
    pub name: String,
    /// Duration of a sample [s].
    pub step: f64,
    /// Primary strokes (n_samples × n_primary, row-major) [m].
    pub strokes: Vec<f64>,
    /// Number of primary tendons.
    pub n_primary: usize,
    /// Measured tip (n_samples) [m].
    pub measured: Vec<[f64; 3]>,
    /// Twin's tip with the identified strokes (n_samples) [m].
    pub twin: Vec<[f64; 3]>,
    /// Identified auxiliary strokes, one series per tendon [m].
    pub auxiliary: Vec<Vec<f64>>,
    /// True where the tip was filled in (n_samples).
    pub gap: Vec<bool>,
    /// That of the network which chose the strokes, if one did.
    pub decoder: Option<StrokeDecoder>,
    /// Sensitivities, see [`crate::coreact::AuxiliaryIdentification`]; (axis, tendon) series at a lower rate [-].
    sensitivities: [Vec<Vec<f64>>; 3],
    /// Samples per row of the sensitivities.
    every: usize,
}

impl Sequence {
    /// Takes an identified recording and its sensitivities.
    ///
    /// # Errors
    /// Channels that identification writes are missing, or the two do not belong together.
    pub fn new(name: &str, recording: &Recording, sensitivities: &Recording) -> Result<Self, BadInput> {
        let not_identified = |what: &str| {
            BadInput::new(name, format!("a recording by hysteron identify, with {what}"), "none")
                .hint("identify the recordings of the robot first")
        };
        let strokes = recording.strokes();
        let axes = |stem: &str| -> Result<Vec<[f64; 3]>, BadInput> {
            let channel = |axis: &str| recording.channel(&format!("{stem}_{axis}_m"));
            let found = channel("x").zip(channel("y")).zip(channel("z"));
            let ((x, y), z) = found.ok_or_else(|| not_identified(&format!("{stem}_x_m")))?;
            Ok((0..x.len()).map(|i| [x[i], y[i], z[i]]).collect())
        };
        let auxiliary: Vec<Vec<f64>> = recording.aux().into_iter().map(<[f64]>::to_vec).collect();
        if auxiliary.is_empty() {
            return Err(not_identified("aux_01_m"));
        }
        let decoder = recording.meta().extra.get(DECODER).map(json::from_text).transpose();
        let decoder = decoder
            .map_err(|error| BadInput::new(format!("{name}: {DECODER}"), "a decoder", error.to_string()))?;
        if decoder.as_ref().is_some_and(|it: &StrokeDecoder| !it.fits(strokes.len(), auxiliary.len())) {
            return Err(BadInput::new(format!("{name}: {DECODER}"), "that of these tendons", "another")
                .hint("identify the recording again"));
        }
        let step = recording.rate_hz().map(f64::recip).ok_or_else(|| not_identified("a fixed rate"))?;
        let every = recording.n_samples().div_ceil(sensitivities.n_samples());
        let rows = |axis: &str| sensitivities.numbered(&format!("sensitivity_{axis}"), "ratio");
        let rows =
            ["x", "y", "z"].map(|axis| rows(axis).into_iter().map(<[f64]>::to_vec).collect::<Vec<_>>());
        if rows.iter().any(|rows| rows.len() != auxiliary.len()) {
            return Err(not_identified("sensitivities of every auxiliary tendon"));
        }
        let n = recording.n_samples();
        if (sensitivities.n_samples() - 1) * every >= n {
            let found = format!("{} for {n} samples", sensitivities.n_samples());
            return Err(BadInput::new(name, "a row of sensitivities every so many samples", found)
                .hint("identify the recording again"));
        }
        Ok(Self {
            name: name.to_owned(),
            step,
            n_primary: strokes.len(),
            strokes: (0..n).flat_map(|i| strokes.iter().map(move |values| values[i])).collect(),
            measured: axes("tip")?,
            twin: axes("twin")?,
            auxiliary,
            gap: recording.gap().to_vec(),
            decoder,
            sensitivities: rows,
            every,
        })
    }

    /// SHA-256 of all training data in it.
    pub fn hash(&self) -> String {
        let tips = self.measured.iter().chain(&self.twin).flatten();
        let series = self.auxiliary.iter().chain(self.sensitivities.iter().flatten()).flatten();
        let numbers = [self.step].into_iter().chain(self.strokes.iter().chain(tips).chain(series).copied());
        let flags = self.gap.iter().map(|gap| u8::from(*gap));
        let bytes: Vec<u8> = numbers.flat_map(f64::to_le_bytes).chain(flags).collect();
        file::sha256_hex(&bytes)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.measured.len()
    }

    /// False: a recording has samples.
    pub fn is_empty(&self) -> bool {
        self.measured.is_empty()
    }

    /// Primary strokes of a sample [m].
    pub fn strokes_at(&self, sample: usize) -> &[f64] {
        &self.strokes[sample * self.n_primary..(sample + 1) * self.n_primary]
    }

    /// Auxiliary strokes of a sample [m].
    pub fn auxiliary_at(&self, sample: usize) -> impl Iterator<Item = f64> + '_ {
        self.auxiliary.iter().map(move |series| series[sample])
    }

    /// Primary strokes [m] and ∂tip/∂s there (3 × n_aux) [-], where it was written.
    fn sensitivities(&self) -> impl Iterator<Item = (&[f64], [Vec<f64>; 3])> {
        let samples = (0..self.len()).step_by(self.every);
        samples.map(|sample| (self.strokes_at(sample), self.sensitivity_at(sample)))
    }

    /// ∂tip/∂s in a sample, linear between those that were written (3 × n_aux) [-].
    pub fn sensitivity_at(&self, sample: usize) -> [Vec<f64>; 3] {
        let row = sample / self.every;
        let part = (sample % self.every) as f64 / self.every as f64;
        self.sensitivities.each_ref().map(|axis| {
            let between = |series: &Vec<f64>| {
                let next = series[(row + 1).min(series.len() - 1)];
                series[row] + part * (next - series[row])
            };
            axis.iter().map(between).collect()
        })
    }
}

/// The decoder fitted to the sensitivities of `sequences`, which are of one robot.
///
/// # Errors
/// Sensitivities that are not finite.
pub fn fit_decoder(sequences: &[Sequence]) -> Result<StrokeDecoder, BadInput> {
    let sizes = sequences.first().map_or([0; 2], |first| [first.n_primary, first.auxiliary.len()]);
    let strokes = sequences.iter().flat_map(|one| one.strokes.chunks_exact(one.n_primary));
    StrokeDecoder::fit(sizes, strokes, sequences.iter().flat_map(Sequence::sensitivities))
}

/// The first training sequence, after making sure that all are of one robot and identified in one way.
pub(super) fn first_of_one_robot<'a>(
    training: &'a [Sequence],
    held_out: &[Sequence],
) -> Result<&'a Sequence, BadInput> {
    let few = |what: &str| BadInput::new(what, "at least one identified recording", "none");
    let first = training.first().ok_or_else(|| few("training"))?;
    held_out.first().ok_or_else(|| few("held out").hint("early stopping needs validation trajectories"))?;
    for sequence in training.iter().chain(held_out) {
        let sizes = |s: &Sequence| (s.n_primary, s.auxiliary.len());
        if sizes(sequence) != sizes(first) {
            let [expected, found] = [first, sequence].map(|s| {
                let (tendons, auxiliary) = sizes(s);
                format!("{tendons} tendons and {auxiliary} virtual ones")
            });
            return Err(BadInput::new(&sequence.name, expected, found));
        }
        if (sequence.step / first.step - 1.0).abs() > 0.01 {
            let expected = format!("samples of {} s", hysteron_base::number::shown(first.step));
            return Err(BadInput::new(
                &sequence.name,
                expected,
                format!("{} s", hysteron_base::number::shown(sequence.step)),
            ));
        }
        if sequence.decoder != first.decoder {
            let chosen = |s: &Sequence| match s.decoder {
                Some(_) => "auxiliary strokes by a network",
                None => "auxiliary strokes by identification",
            };
            let expected = format!("{}, as in {}", chosen(first), first.name);
            let found = if sequence.decoder.is_some() && first.decoder.is_some() {
                "those of another network"
            } else {
                chosen(sequence)
            };
            return Err(BadInput::new(&sequence.name, expected, found)
                .hint("identify all recordings the same way, into a folder of their own"));
        }
    }
    Ok(first)
}

/// Their names, for the provenance of a training.
pub(super) fn names(sequences: &[Sequence]) -> Vec<String> {
    sequences.iter().map(|sequence| sequence.name.clone()).collect()
}
