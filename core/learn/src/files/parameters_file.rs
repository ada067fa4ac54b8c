//! One vector of parameters with what is needed to use it, in a file.

use std::path::Path;

use hysteron_base::{BadInput, json};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::TensorFile;
use super::tensor_file::details;
use crate::{ParameterVector, Result, TensorShape, TrainableModel};

const FORMAT: &str = "hysteron-parameters";
const VERSION: u64 = 1;

/// Writes parameters of a model of this `kind`; `details` describes the model. A half-written file never
/// has this name.
///
/// # Errors
/// If the file system refuses.
pub fn write_parameters(path: &Path, kind: &str, details: &impl Serialize, parameters: &[f64]) -> Result<()> {
    let model = ParameterVector::new(parameters.to_vec());
    let mut file = TensorFile::default();
    file.put("kind", json!(kind));
    file.put("count", json!(parameters.len()));
    file.put("details", json!(details));
    file.put_tensors("", &model.tensors(), model.parameters());
    file.write(path, FORMAT, VERSION)
}

/// The details and parameters of a file by [`write_parameters`].
///
/// # Errors
/// `BadInput` naming the file: not such a file, of another kind or version, damaged, a parameter or another number that is
/// not finite or above the accepted maximum, details of another type.
pub fn read_parameters<D: DeserializeOwned>(path: &Path, kind: &str) -> Result<(D, Vec<f64>)> {
    let mut file = TensorFile::read(path, FORMAT, VERSION)?;
    let mut take = || -> std::result::Result<(D, Vec<f64>), BadInput> {
        let found: String = file.take("kind")?;
        if found != kind {
            return Err(BadInput::new("kind", kind, found).hint("a model made for something else"));
        }
        let shape = TensorShape::new("parameters", &[file.take("count")?]);
        let [parameters] = file.take_weights(&[vec![shape]])?.try_into().unwrap_or_default();
        Ok((details(&mut file, kind)?, parameters))
    };
    Ok(take().map_err(|bad| bad.within(path.display()))?)
}

/// The kind of a file by [`write_parameters`], of any model.
///
/// # Errors
/// `BadInput` naming the file: not such a file, damaged.
pub fn read_parameters_kind(path: &Path) -> Result<String> {
    header(path, "kind")
}

/// The details of a file by [`write_parameters`], of any model.
///
/// # Errors
/// As [`read_parameters_kind`]; details of another type.
pub fn read_parameters_details<D: DeserializeOwned>(path: &Path) -> Result<D> {
    header(path, "details")
}

fn header<T: DeserializeOwned>(path: &Path, name: &str) -> Result<T> {
    let mut file = TensorFile::read(path, FORMAT, VERSION)?;
    Ok(file.take(name).map_err(|bad| bad.within(path.display()))?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use serde_json::Value;

    use super::*;

    #[test]
    fn parameters_come_back_and_damaged_files_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.safetensors");
        let details = json!({ "n": 2 });
        write_parameters(&path, "a", &details, &[1.5, -1e-300]).unwrap();
        assert_eq!(read_parameters::<Value>(&path, "a").unwrap(), (details.clone(), vec![1.5, -1e-300]));
        assert_eq!(read_parameters_kind(&path).unwrap(), "a");
        assert_eq!(read_parameters_details::<Value>(&path).unwrap(), details);
        assert!(
            read_parameters::<Value>(&path, "b").unwrap_err().to_string().contains("kind: expected b, got a")
        );
        let bytes = std::fs::read(&path).unwrap();
        for end in [0, 8, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..end]).unwrap();
            let error = read_parameters::<Value>(&path, "a").unwrap_err();
            assert!(error.to_string().contains("a whole safetensors file"), "{end}: {error}");
        }
    }
}
