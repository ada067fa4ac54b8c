//! Named arrays and JSON in one `.safetensors` file with a checksum; alone knows `safetensors`.
//!
//! The metadata of the format are texts: each holds one JSON value. `sha256` is over the whole file with
//! zeros in its place, so that any change is found. Written here byte by byte, in the order of names: the same
//! content gives the same file.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{BadInput, file, json};
use safetensors::{Dtype, SafeTensors};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::{Float, Result, TensorShape};

/// Stands for the checksum while it is computed.
const NO_CHECKSUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// Largest weight that a reader accepts [-]: networks get inputs of the order of one, a training moves a
/// weight by the step size in an update (thousandths, some ten thousand times), and a weight beyond this has
/// so large a rounding in single precision (6 % of one) that its products are meaningless.
const MAX_WEIGHT: f64 = 1e6;
/// Largest number that a reader accepts in the metadata of a file, in any unit.
const MAX_NUMBER: f64 = 1e12;

/// Numbers of a tensor, as they were stored.
#[derive(Debug, Clone)]
enum TensorNumbers {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

/// The content of a file.
#[derive(Debug, Default)]
pub(crate) struct TensorFile {
    metadata: BTreeMap<String, Value>,
    tensors: BTreeMap<String, (Vec<usize>, TensorNumbers)>,
}

impl TensorFile {
    pub fn put(&mut self, name: &str, value: Value) {
        self.metadata.insert(name.to_owned(), value);
    }

    /// Puts vectors of parameters, each as the tensors that it consists of, with a prefix to their names.
    pub fn put_tensors<'a, T: Float>(
        &mut self,
        prefix: &str,
        tensors: &[Vec<TensorShape>],
        vectors: impl IntoIterator<Item = &'a Vec<T>>,
    ) {
        for (tensors, values) in tensors.iter().zip(vectors) {
            let mut rest = &values[..];
            for tensor in tensors {
                let (values, after) = rest.split_at(tensor.len());
                rest = after;
                let numbers = if size_of::<T>() == size_of::<f32>() {
                    TensorNumbers::Single(values.iter().map(|v| v.to_f64() as f32).collect())
                } else {
                    TensorNumbers::Double(values.iter().map(|v| v.to_f64()).collect())
                };
                self.tensors.insert(format!("{prefix}{}", tensor.name), (tensor.shape.clone(), numbers));
            }
        }
    }

    /// # Errors
    /// If it is missing or not of the type that is asked for.
    pub fn take<T: DeserializeOwned>(&mut self, name: &str) -> std::result::Result<T, BadInput> {
        let Some(value) = self.metadata.remove(name) else {
            return Err(BadInput::new(name, "an entry in the metadata", "nothing"));
        };
        json::from_value(&value).map_err(|e| BadInput::new(name, "a valid entry", e.to_string()))
    }

    /// As [`TensorFile::take_tensors`], of weights that are used as they are.
    ///
    /// # Errors
    /// As there, and for a weight above the accepted maximum.
    pub fn take_weights<T: Float>(
        &mut self,
        tensors: &[Vec<TensorShape>],
    ) -> std::result::Result<Vec<Vec<T>>, BadInput> {
        let vectors = self.take_tensors("", tensors)?;
        for (shapes, values) in tensors.iter().zip(&vectors) {
            let mut values = values.iter();
            for shape in shapes {
                let own = values.by_ref().take(shape.len()).map(|v: &T| v.to_f64());
                // `max` of NaN and a number is the number; there is no NaN here.
                let largest = own.fold(0.0, |largest: f64, weight| largest.max(weight.abs()));
                if largest > MAX_WEIGHT {
                    return Err(beyond_belief(&shape.name, largest));
                }
            }
        }
        Ok(vectors)
    }

    /// The vectors of parameters that consist of these tensors.
    ///
    /// # Errors
    /// If a tensor is missing, of another shape or precision, or holds a number that is not finite.
    pub fn take_tensors<T: Float>(
        &mut self,
        prefix: &str,
        tensors: &[Vec<TensorShape>],
    ) -> std::result::Result<Vec<Vec<T>>, BadInput> {
        let mut vectors = Vec::with_capacity(tensors.len());
        for tensors in tensors {
            let mut values = Vec::new();
            for tensor in tensors {
                values.extend(self.take_tensor::<T>(format!("{prefix}{}", tensor.name), &tensor.shape)?);
            }
            vectors.push(values);
        }
        Ok(vectors)
    }

    fn take_tensor<T: Float>(
        &mut self,
        name: String,
        shape: &[usize],
    ) -> std::result::Result<Vec<T>, BadInput> {
        let values: Vec<T> = match self.tensors.remove(&name) {
            None => return Err(BadInput::new(name, "a tensor of the architecture", "nothing")),
            Some((found, _)) if found != shape => {
                return Err(BadInput::new(name, format!("the shape {shape:?}"), format!("{found:?}")));
            }
            Some((_, TensorNumbers::Single(values))) if size_of::<T>() == size_of::<f32>() => {
                values.into_iter().map(|v| T::of(f64::from(v))).collect()
            }
            Some((_, TensorNumbers::Double(values))) if size_of::<T>() == size_of::<f64>() => {
                values.into_iter().map(T::of).collect()
            }
            Some(_) => {
                let expected = format!("numbers of {} bits", 8 * size_of::<T>());
                return Err(BadInput::new(name, expected, "others"));
            }
        };
        match values.iter().find(|v| !v.to_f64().is_finite()) {
            Some(bad) => Err(BadInput::new(name, "finite weights", bad.to_f64().to_string())),
            None => Ok(values),
        }
    }

    /// # Errors
    /// If the file system refuses.
    pub fn write(&self, path: &Path, format: &str, version: u64) -> Result<()> {
        Ok(file::write_bytes(path, self.to_bytes(format, version))?)
    }

    fn to_bytes(&self, format: &str, version: u64) -> Vec<u8> {
        let mut texts: Map<String, Value> =
            self.metadata.iter().map(|(name, value)| (name.clone(), value.to_string().into())).collect();
        texts.insert("format".to_owned(), format.into());
        texts.insert("version".to_owned(), version.to_string().into());
        texts.insert("sha256".to_owned(), NO_CHECKSUM.into());
        let mut header = Map::from_iter([("__metadata__".to_owned(), Value::from(texts))]);
        let mut data = Vec::new();
        for (name, (shape, numbers)) in &self.tensors {
            let from = data.len();
            let dtype = match numbers {
                TensorNumbers::Single(values) => {
                    data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
                    "F32"
                }
                TensorNumbers::Double(values) => {
                    data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
                    "F64"
                }
            };
            let offsets = [from, data.len()];
            header.insert(name.clone(), json!({ "dtype": dtype, "shape": shape, "data_offsets": offsets }));
        }
        let mut header = Value::from(header).to_string();
        // The data begin at a multiple of 8, as the format asks.
        header.extend(std::iter::repeat_n(' ', header.len().next_multiple_of(8) - header.len()));
        let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        let checksum = file::sha256_hex(&bytes);
        if let Some(place) = checksum_place(&bytes, NO_CHECKSUM) {
            bytes[place..place + checksum.len()].copy_from_slice(checksum.as_bytes());
        }
        bytes
    }

    /// # Errors
    /// `BadInput` if the file is not whole, of another format or version, or holds anything but `f32` and `f64`.
    pub fn read(path: &Path, format: &str, version: u64) -> Result<Self> {
        let bytes = file::read_bytes(path)?;
        Ok(Self::from_bytes(bytes, format, version).map_err(|bad| bad.within(path.display()))?)
    }

    fn from_bytes(mut bytes: Vec<u8>, format: &str, version: u64) -> std::result::Result<Self, BadInput> {
        let not_whole = |e: safetensors::SafeTensorError| {
            BadInput::new("", "a whole safetensors file", e.to_string()).hint("was it cut short?")
        };
        let (_, header) = SafeTensors::read_metadata(&bytes).map_err(not_whole)?;
        let texts = header.metadata().clone().unwrap_or_default();
        let text = |name: &str| texts.get(name).map_or("nothing", |text| &text[..]);
        if text("format") != format {
            return Err(BadInput::new("format", format, text("format")));
        }
        if text("version") != version.to_string() {
            return Err(BadInput::new("version", version.to_string(), text("version"))
                .hint("written by another version of the program"));
        }
        clear_checksum(&mut bytes, text("sha256"))?;
        let content = SafeTensors::deserialize(&bytes).map_err(not_whole)?;
        let mut found = Self::default();
        for (name, text) in texts.iter().collect::<BTreeMap<_, _>>() {
            if !["format", "version", "sha256"].contains(&&name[..]) {
                let value = json::from_text(text);
                let value = value.map_err(|e| BadInput::new(name, "JSON", e.to_string()))?;
                found.metadata.insert(name.clone(), value);
            }
        }
        for (name, tensor) in content.iter() {
            let numbers = match tensor.dtype() {
                Dtype::F32 => TensorNumbers::Single(
                    tensor.data().as_chunks().0.iter().map(|v| f32::from_le_bytes(*v)).collect(),
                ),
                Dtype::F64 => TensorNumbers::Double(
                    tensor.data().as_chunks().0.iter().map(|v| f64::from_le_bytes(*v)).collect(),
                ),
                _ => return Err(BadInput::new(name, "numbers of 32 or 64 bits (F32, F64)", "another kind")),
            };
            found.tensors.insert(name.to_owned(), (tensor.shape().to_vec(), numbers));
        }
        Ok(found)
    }
}

fn beyond_belief(tensor: &str, size: f64) -> BadInput {
    let expected = format!("weights between -{MAX_WEIGHT:e} and {MAX_WEIGHT:e}");
    BadInput::new(tensor, expected, format!("one of size {size:e}"))
        .hint("no training leads there: the file was damaged or made by hand")
}

/// The entry `details` of a file of this kind.
///
/// # Errors
/// `BadInput` without it, of a number that is not finite or above the accepted maximum, of another type.
pub(crate) fn details<D: DeserializeOwned>(
    file: &mut TensorFile,
    kind: &str,
) -> std::result::Result<D, BadInput> {
    let found: Value = file.take("details")?;
    check_numbers("details", &found)?;
    json::from_value(&found)
        .map_err(|e| BadInput::new("details", format!("those of kind {kind}"), e.to_string()))
}

/// Accepts the metadata of a file: every number in it is at most [`MAX_NUMBER`]. Entries that only describe
/// the training are not checked.
///
/// # Errors
/// `BadInput` naming the entry.
pub(crate) fn check_numbers(place: &str, value: &Value) -> std::result::Result<(), BadInput> {
    match value {
        Value::Number(number) if number.is_f64() => match number.as_f64() {
            Some(number) if number.abs() > MAX_NUMBER => {
                let expected = format!("a number between -{MAX_NUMBER:e} and {MAX_NUMBER:e}");
                Err(BadInput::new(place, expected, format!("{number:e}")))
            }
            _ => Ok(()),
        },
        Value::Array(items) => {
            let mut items = items.iter().enumerate();
            items.try_for_each(|(k, item)| check_numbers(&format!("{place}[{k}]"), item))
        }
        Value::Object(entries) => {
            let mut entries = entries.iter().filter(|(key, _)| *key != "training");
            entries.try_for_each(|(key, entry)| check_numbers(&format!("{place}.{key}"), entry))
        }
        _ => Ok(()),
    }
}

/// Offset of the checksum. Inside the text of another entry its quotes would be escaped.
fn checksum_place(bytes: &[u8], checksum: &str) -> Option<usize> {
    let key = "\"sha256\":\"";
    let entry = format!("{key}{checksum}\"");
    let place = bytes.windows(entry.len()).position(|window| window == entry.as_bytes());
    place.map(|place| place + key.len())
}

/// Compares the checksum and puts zeros in its place.
fn clear_checksum(bytes: &mut [u8], stated: &str) -> std::result::Result<(), BadInput> {
    let place = checksum_place(bytes, stated).filter(|_| stated.len() == NO_CHECKSUM.len());
    if let Some(place) = place {
        bytes[place..place + NO_CHECKSUM.len()].copy_from_slice(NO_CHECKSUM.as_bytes());
    }
    let found = file::sha256_hex(bytes);
    if place.is_none() || found != stated {
        return Err(BadInput::new("sha256", stated, found).hint("the file was damaged or edited"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use crate::{Architecture, HeadActivation, Network, TrainableModel};

    fn architecture() -> Architecture {
        Architecture {
            inputs: 1,
            hidden: 2,
            layers: 1,
            outputs: 1,
            head: HeadActivation::Linear,
            dropout: 0.0,
        }
    }

    /// A file with these tensors, read back and taken as a network.
    fn network_of(change: impl FnOnce(&mut TensorFile)) -> String {
        let network = Network::new(&architecture(), 1).unwrap();
        let mut file = TensorFile::default();
        file.put_tensors("", &network.tensors(), network.parameters());
        change(&mut file);
        let mut found = TensorFile::from_bytes(file.to_bytes("f", 2), "f", 2).unwrap();
        match found.take_weights::<f32>(&network.tensors()) {
            Ok(found) => format!("the same: {}", found == network.parameters()),
            Err(bad) => bad.to_string(),
        }
    }

    #[test]
    fn tensors_are_found_by_name_and_checked() {
        assert_eq!(network_of(|_| ()), "the same: true");
        let found = network_of(|file| drop(file.tensors.remove("head.bias")));
        assert_eq!(found, "head.bias: expected a tensor of the architecture, got nothing");
        let found = network_of(|file| file.tensors.get_mut("lstm.weight_ih_l0").unwrap().0 = vec![1, 8]);
        assert_eq!(found, "lstm.weight_ih_l0: expected the shape [8, 1], got [1, 8]");
        let found = network_of(|file| {
            file.tensors.get_mut("lstm.bias_l0").unwrap().1 = TensorNumbers::Single(vec![f32::NAN; 8]);
        });
        assert_eq!(found, "lstm.bias_l0: expected finite weights, got NaN");
        let found = network_of(|file| {
            file.tensors.get_mut("lstm.bias_l0").unwrap().1 = TensorNumbers::Double(vec![0.0; 8]);
        });
        assert_eq!(found, "lstm.bias_l0: expected numbers of 32 bits, got others");
        let found = network_of(|file| {
            file.tensors.get_mut("lstm.bias_l0").unwrap().1 = TensorNumbers::Single(vec![1e6; 8]);
        });
        assert_eq!(found, "the same: false");
        let found = network_of(|file| {
            file.tensors.get_mut("head.bias").unwrap().1 = TensorNumbers::Single(vec![-1.1e6]);
        });
        assert!(found.starts_with("head.bias: expected weights between -1e6 and 1e6, got one of size 1.1e6"));
    }

    #[test]
    fn numbers_of_the_metadata_are_plausible() {
        let details =
            |x: f64| json!({ "a": [1.0, { "b": x }], "n": u64::MAX, "training": { "worst": 1e300 } });
        assert!(check_numbers("details", &details(-1e12)).is_ok());
        let bad = check_numbers("details", &details(1e13)).unwrap_err();
        assert_eq!((&bad.place[..], &bad.found[..]), ("details.a[1].b", "1e13"));
    }

    #[test]
    fn another_version_is_refused() {
        let bytes = TensorFile::default().to_bytes("f", 2);
        let bad = TensorFile::from_bytes(bytes, "f", 3).unwrap_err();
        assert_eq!((&bad.place[..], &bad.expected[..], &bad.found[..]), ("version", "3", "2"));
    }
}
