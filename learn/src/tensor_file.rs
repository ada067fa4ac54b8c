//! Named arrays and JSON in one `.safetensors` file with a checksum; alone knows `safetensors`.
//!
//! The metadata of the format are texts: each holds one JSON value. `sha256` is over the whole file with
//! zeros in its place, so that any change is found. Written here byte by byte, in the order of names: the same
//! content gives the same file.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{BadInput, file};
use safetensors::{Dtype, SafeTensors};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use crate::architecture::Part;
use crate::{Architecture, Result};

/// Stands for the checksum while it is computed.
const NO_CHECKSUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// The content of a file.
#[derive(Debug, Default)]
pub(crate) struct TensorFile {
    metadata: BTreeMap<String, Value>,
    tensors: BTreeMap<String, (Vec<usize>, Vec<f32>)>,
    /// Vectors in double precision; their names are none of the tensors'.
    vectors: BTreeMap<String, Vec<f64>>,
}

impl TensorFile {
    pub fn put(&mut self, name: &str, value: Value) {
        self.metadata.insert(name.to_owned(), value);
    }

    /// Puts a vector in double precision.
    pub fn put_vector(&mut self, name: &str, values: Vec<f64>) {
        self.vectors.insert(name.to_owned(), values);
    }

    /// # Errors
    /// If it is missing, of another length, or not finite.
    pub fn take_vector(&mut self, name: &str, len: usize) -> std::result::Result<Vec<f64>, BadInput> {
        let found = self.vectors.remove(name).unwrap_or_default();
        if found.len() != len {
            return Err(BadInput::new(name, format!("{len} numbers"), found.len().to_string()));
        }
        match found.iter().find(|v| !v.is_finite()) {
            Some(v) => Err(BadInput::new(name, "finite numbers", v.to_string())),
            None => Ok(found),
        }
    }

    /// Puts the tensors of a network, or of something of its shape, with a prefix to their names.
    pub fn put_network(&mut self, prefix: &str, architecture: &Architecture, parameters: &[Vec<f32>]) {
        for (parts, values) in architecture.parts().into_iter().zip(parameters) {
            let mut rest = &values[..];
            for part in parts {
                let (tensor, after) = rest.split_at(part.len());
                rest = after;
                self.tensors.insert(format!("{prefix}{}", part.name), (part.shape, tensor.to_vec()));
            }
        }
    }

    /// # Errors
    /// If it is missing or not of the type that is asked for.
    pub fn take<T: DeserializeOwned>(&mut self, name: &str) -> std::result::Result<T, BadInput> {
        let Some(value) = self.metadata.remove(name) else {
            return Err(BadInput::new(name, "an entry in the metadata", "nothing"));
        };
        serde_json::from_value(value).map_err(|e| BadInput::new(name, "a valid entry", e.to_string()))
    }

    /// # Errors
    /// If the architecture is invalid, or a tensor is missing or of another shape.
    pub fn take_network(
        &mut self,
        prefix: &str,
        architecture: &Architecture,
    ) -> std::result::Result<Vec<Vec<f32>>, BadInput> {
        architecture.check()?;
        if architecture.layers > self.tensors.len() {
            let found = format!("{} in all", self.tensors.len());
            let expected = format!("tensors of {} layers", architecture.layers);
            return Err(BadInput::new("architecture: layers", expected, found));
        }
        let mut tensor = |part: Part| {
            let name = format!("{prefix}{}", part.name);
            match self.tensors.remove(&name) {
                Some((shape, values)) if shape == part.shape => Ok(values),
                Some((shape, _)) => {
                    Err(BadInput::new(name, format!("the shape {:?}", part.shape), format!("{shape:?}")))
                }
                None => Err(BadInput::new(name, "a tensor of the architecture", "nothing")),
            }
        };
        let mut all = Vec::new();
        for parts in architecture.parts() {
            let mut values = Vec::new();
            for part in parts {
                values.extend(tensor(part)?);
            }
            all.push(values);
        }
        Ok(all)
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
        for (name, (shape, values)) in &self.tensors {
            let from = data.len();
            data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
            let offsets = [from, data.len()];
            header.insert(name.clone(), json!({ "dtype": "F32", "shape": shape, "data_offsets": offsets }));
        }
        for (name, values) in &self.vectors {
            let from = data.len();
            data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
            let (offsets, shape) = ([from, data.len()], [values.len()]);
            header.insert(name.clone(), json!({ "dtype": "F64", "shape": shape, "data_offsets": offsets }));
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
                let value = serde_json::from_str(text);
                let value = value.map_err(|e| BadInput::new(name, "JSON", e.to_string()))?;
                found.metadata.insert(name.clone(), value);
            }
        }
        for (name, tensor) in content.iter() {
            if tensor.dtype() == Dtype::F64 {
                let (values, _) = tensor.data().as_chunks::<8>();
                let values = values.iter().map(|v| f64::from_le_bytes(*v)).collect();
                found.vectors.insert(name.to_owned(), values);
                continue;
            }
            if tensor.dtype() != Dtype::F32 {
                return Err(BadInput::new(name, "F32 or F64", format!("{:?}", tensor.dtype())));
            }
            let (values, _) = tensor.data().as_chunks::<4>();
            let values = values.iter().map(|v| f32::from_le_bytes(*v)).collect();
            found.tensors.insert(name.to_owned(), (tensor.shape().to_vec(), values));
        }
        Ok(found)
    }
}

/// Where the checksum stands. Inside the text of another entry its quotes would be escaped.
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
    use crate::{Head, Network};

    fn architecture() -> Architecture {
        Architecture { inputs: 1, hidden: 2, layers: 1, outputs: 1, head: Head::Linear, dropout: 0.0 }
    }

    /// A file with these tensors, read back and taken as a network.
    fn network_of(change: impl FnOnce(&mut TensorFile)) -> String {
        let network = Network::new(&architecture(), 1).unwrap();
        let mut file = TensorFile::default();
        file.put_network("", &architecture(), &network.parameters);
        change(&mut file);
        let mut found = TensorFile::from_bytes(file.to_bytes("f", 2), "f", 2).unwrap();
        let parameters = found.take_network("", &architecture());
        match parameters.and_then(|p| Network::from_parameters(architecture(), p)) {
            Ok(found) => format!("the same: {}", found == network),
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
        let found = network_of(|file| file.tensors.get_mut("lstm.bias_l0").unwrap().1[3] = f32::NAN);
        assert_eq!(found, "lstm.bias_l0: expected finite weights, got NaN");
    }

    #[test]
    fn another_version_is_refused() {
        let bytes = TensorFile::default().to_bytes("f", 2);
        let bad = TensorFile::from_bytes(bytes, "f", 3).unwrap_err();
        assert_eq!((&bad.place[..], &bad.expected[..], &bad.found[..]), ("version", "3", "2"));
    }
}
