//! Recordings: channels as numpy arrays over the memory of Rust.

use std::collections::BTreeMap;
use std::path::PathBuf;

use hysteron_base::{BadInput, Channel, Metadata, Recording};
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList};

use crate::arrays::{ArrayRowValues, borrowed};
use crate::errors::exception;

/// Time-aligned channels in SI with their provenance: a mapping from channel name to a read-only numpy array (n_samples,).
///
/// Names end in their unit: `stroke_1_m`, `tension_1_n`, `tip_x_m`. Arrays show the memory of the recording, without a copy. Never
/// changes.
#[pyclass(name = "Recording", module = "pyhysteron", frozen, mapping)]
pub struct PyRecording {
    pub(crate) recording: Recording,
}

#[pymethods]
impl PyRecording {
    /// Reads a recording: .parquet, .csv, or the .journal of a rig.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = py.detach(|| Recording::read(path));
        Ok(Self { recording: read.map_err(|error| exception(py, error))? })
    }

    /// Puts a recording together from arrays (n_samples,), which are copied once and checked.
    ///
    /// `channels` maps names that end in an SI unit to arrays. Times are a channel `time_s` [s], or follow from `rate_hz`,
    /// samples a second. `metadata` are texts by key: `scene_hash`, `seed`, `commit`, `source`, `command`, and others of
    /// lower-case letters.
    #[staticmethod]
    #[pyo3(signature = (channels, *, rate_hz=None, metadata=None))]
    fn from_arrays(
        py: Python<'_>,
        channels: &Bound<'_, PyAny>,
        rate_hz: Option<f64>,
        metadata: Option<BTreeMap<String, String>>,
    ) -> PyResult<Self> {
        let (mut time, mut columns) = (None, Vec::new());
        for item in channels.call_method0("items")?.try_iter()? {
            let (name, values): (String, Bound<'_, PyAny>) = item?.extract()?;
            let numbers = py.import("numpy")?.call_method1("asarray", (values, "float64"))?;
            let ArrayRowValues(values) = numbers.extract()?;
            match name.as_str() {
                "time_s" => time = Some(values),
                _ => columns.push(Channel::new(name, values)),
            }
        }
        let made = py.detach(|| {
            let n_samples = columns.first().map_or(0, |channel| channel.values.len());
            let time = times(time, rate_hz, n_samples)?;
            Recording::new(time, columns, Vec::new(), provenance(metadata.unwrap_or_default())?)
        });
        Ok(Self { recording: made.map_err(|bad| exception(py, bad))? })
    }

    /// Writes the recording: .parquet, or .csv for people, which holds lengths in mm. An existing file is replaced.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.recording.write(path)).map_err(|error| exception(py, error))
    }

    /// Times (n_samples,) [s], strictly increasing; read-only.
    #[getter]
    fn time<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        borrowed(slf.get().recording.time(), slf.as_any())
    }

    /// True where the sample was missing and has been filled in (n_samples,); read-only.
    #[getter]
    fn gap<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<bool>> {
        borrowed(slf.get().recording.gap(), slf.as_any())
    }

    /// Number of samples.
    #[getter]
    fn n_samples(&self) -> usize {
        self.recording.n_samples()
    }

    /// Samples a second, where all time steps are equal within 1 % [Hz].
    #[getter]
    fn rate_hz(&self) -> Option<f64> {
        self.recording.rate_hz()
    }

    /// Provenance: texts by key.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Metadata { scene_hash, seed, commit, source, command, extra } = self.recording.meta();
        let pairs = PyDict::new(py);
        let own = [("scene_hash", scene_hash), ("commit", commit), ("source", source), ("command", command)];
        for (key, value) in own.into_iter().filter(|(_, value)| !value.is_empty()) {
            pairs.set_item(key, value)?;
        }
        if let Some(seed) = seed {
            pairs.set_item("seed", seed.to_string())?;
        }
        for (key, value) in extra {
            pairs.set_item(key, value)?;
        }
        Ok(pairs)
    }

    /// Names of the channels, in the order of the file.
    fn keys<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, self.recording.channels().iter().map(|channel| channel.name.as_str()))
    }

    /// The channels, in the order of the file.
    fn values<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyList>> {
        let channels = slf.get().recording.channels().iter();
        PyList::new(slf.py(), channels.map(|channel| borrowed(&channel.values, slf.as_any())))
    }

    /// Pairs of name and channel, in the order of the file.
    fn items<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyList>> {
        let channels = slf.get().recording.channels().iter();
        PyList::new(
            slf.py(),
            channels.map(|channel| (&channel.name, borrowed(&channel.values, slf.as_any()))),
        )
    }

    /// The channel of that name, or `default`.
    #[pyo3(signature = (name, default=None))]
    fn get<'py>(
        slf: &Bound<'py, Self>,
        name: &str,
        default: Option<Bound<'py, PyAny>>,
    ) -> Option<Bound<'py, PyAny>> {
        let values = slf.get().recording.channel(name);
        values.map(|values| borrowed(values, slf.as_any()).into_any()).or(default)
    }

    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        match slf.get().recording.channel(name) {
            Some(values) => Ok(borrowed(values, slf.as_any())),
            None => Err(PyKeyError::new_err(name.to_owned())),
        }
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> bool {
        name.extract::<&str>().is_ok_and(|name| self.recording.channel(name).is_some())
    }

    fn __len__(&self) -> usize {
        self.recording.channels().len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.keys(py)?.try_iter()
    }

    /// True for a recording with the same times, channels, gaps and metadata.
    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| self.recording == other.get().recording)
    }

    /// A pandas data frame, one column a channel, its index the times. Needs pandas.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pyhysteron._convert")?.call_method1("to_pandas", (slf,))
    }

    /// A polars data frame, its first column `time_s`. Needs polars.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pyhysteron._convert")?.call_method1("to_polars", (slf,))
    }

    /// An xarray data set over the coordinate `time_s`, with metadata and units as attributes. Needs xarray.
    fn to_xarray<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pyhysteron._convert")?.call_method1("to_xarray", (slf,))
    }

    fn __repr__(&self) -> String {
        let (n_samples, n_channels) = (self.recording.n_samples(), self.recording.channels().len());
        format!("<Recording: {n_channels} channels, {n_samples} samples>")
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pyhysteron._html")?.call_method1("recording", (slf,))
    }
}

/// The times that were given, or those that follow from the rate.
fn times(time: Option<Vec<f64>>, rate_hz: Option<f64>, n_samples: usize) -> Result<Vec<f64>, BadInput> {
    match (time, rate_hz) {
        (Some(time), None) => Ok(time),
        (None, Some(rate)) if rate.is_finite() && rate > 0.0 => {
            Ok((0..n_samples).map(|row| row as f64 / rate).collect())
        }
        (None, Some(rate)) => Err(BadInput::new("rate_hz", "a number above 0", rate.to_string())),
        (Some(_), Some(_)) => Err(BadInput::new("rate_hz", "times or a rate", "both")),
        (None, None) => Err(BadInput::new("rate_hz", "a channel time_s, or a rate", "neither")),
    }
}

fn provenance(mut pairs: BTreeMap<String, String>) -> Result<Metadata, BadInput> {
    let mut own = |key: &str| pairs.remove(key).unwrap_or_default();
    let [scene_hash, commit, source, command] = ["scene_hash", "commit", "source", "command"].map(&mut own);
    let seed = match own("seed") {
        text if text.is_empty() => None,
        text => {
            let bad = |_| BadInput::new("metadata seed", "a whole number >= 0", text.clone());
            Some(text.parse().map_err(bad)?)
        }
    };
    Ok(Metadata { scene_hash, seed, commit, source, command, extra: pairs })
}
