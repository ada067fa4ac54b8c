//! A trained network with all that is needed to use it, in one file.

use std::path::Path;

use hysteron_base::{BadInput, json};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::TensorFile;
use super::tensor_file::{check_numbers, details};
use crate::{Network, Normaliser, Result, TrainableModel};

const FORMAT: &str = "hysteron-checkpoint";
const VERSION: u64 = 1;

/// A trained network, what its inputs and outputs mean, and where it comes from.
///
/// One `.safetensors` file, laid out in `docs/learn.md`. Tensors are found by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint<D> {
    /// Purpose of the network; a reader asks for one kind.
    pub kind: String,
    /// The weights.
    pub network: Network,
    /// The channels that enter, in order.
    pub inputs: Normaliser,
    /// The channels that leave, in order.
    pub outputs: Normaliser,
    /// Whatever else its user must know: data, seed, scores.
    pub details: D,
}

impl<D> Checkpoint<D> {
    /// Writes the file; a half-written one never has this name.
    ///
    /// # Errors
    /// `BadInput` if the normalisers have not the channels of the network, `File` if the file system refuses.
    pub fn write(&self, path: &Path) -> Result<()>
    where
        D: Serialize,
    {
        self.check_channels()?;
        let mut file = TensorFile::default();
        file.put("kind", json!(self.kind));
        file.put("architecture", json!(self.network.architecture()));
        file.put("inputs", json!(self.inputs.channels));
        file.put("outputs", json!(self.outputs.channels));
        file.put("details", json!(self.details));
        file.put(
            "provenance",
            json!({ "package": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") }),
        );
        file.put_tensors("", &self.network.tensors(), self.network.parameters());
        file.write(path, FORMAT, VERSION)
    }

    /// Reads a checkpoint of this kind.
    ///
    /// # Errors
    /// `BadInput` naming the file and what is wrong: not a checkpoint, another version, another kind, cut short
    /// or damaged, a tensor missing or of another shape, a weight that is not finite, a weight or another number
    /// above the accepted maximum, a range upside down, details of another type.
    pub fn read(path: &Path, kind: &str) -> Result<Self>
    where
        D: DeserializeOwned,
    {
        let mut file = TensorFile::read(path, FORMAT, VERSION)?;
        Ok(Self::from_file(&mut file, kind).map_err(|bad| bad.within(path.display()))?)
    }

    /// Metadata of a checkpoint of any kind, see [`Checkpoint::details`].
    ///
    /// # Errors
    /// As [`Checkpoint::read`], but for the weights.
    pub fn read_details(path: &Path) -> Result<D>
    where
        D: DeserializeOwned,
    {
        Ok(TensorFile::read(path, FORMAT, VERSION)?
            .take("details")
            .map_err(|bad| bad.within(path.display()))?)
    }

    fn from_file(file: &mut TensorFile, kind: &str) -> std::result::Result<Self, BadInput>
    where
        D: DeserializeOwned,
    {
        let found: String = file.take("kind")?;
        if found != kind {
            return Err(BadInput::new("kind", kind, found).hint("a network made for something else"));
        }
        let architecture = file.take("architecture")?;
        let checkpoint = Self {
            kind: found,
            network: Network::take_from(file, architecture)?,
            inputs: Normaliser::new(file.take("inputs")?).map_err(|bad| bad.within("inputs"))?,
            outputs: Normaliser::new(file.take("outputs")?).map_err(|bad| bad.within("outputs"))?,
            details: details(file, kind)?,
        };
        for (place, side) in [("inputs", &checkpoint.inputs), ("outputs", &checkpoint.outputs)] {
            check_numbers(place, &json!(side.channels))?;
        }
        checkpoint.check_channels()?;
        Ok(checkpoint)
    }

    fn check_channels(&self) -> std::result::Result<(), BadInput> {
        let architecture = self.network.architecture();
        let sides =
            [("inputs", architecture.inputs, &self.inputs), ("outputs", architecture.outputs, &self.outputs)];
        for (place, expected, normaliser) in sides {
            let found = normaliser.channels.len();
            if found != expected {
                return Err(BadInput::new(place, format!("{expected} channels"), found.to_string()));
            }
        }
        Ok(())
    }
}
