//! Arrays of numpy: numbers that come in, and memory that goes out without a copy.

use hysteron_base::BadInput;
use numpy::ndarray::{ArrayView1, ArrayViewD};
use numpy::{AllowTypeChange, Element, PyArray1, PyArrayLikeDyn, PyArrayMethods};
use pyo3::prelude::*;

/// Numbers of one row: a numpy array of f64, or any sequence of numbers.
pub struct ArrayRowValues(pub Vec<f64>);

impl<'py> FromPyObject<'_, 'py> for ArrayRowValues {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.cast::<PyArray1<f64>>() {
            Ok(array) => Ok(Self(array.readonly().as_array().to_vec())),
            Err(_) => Ok(Self(object.extract()?)),
        }
    }
}

/// Numbers in any number of dimensions, of any type that converts to f64.
pub type AnyArray<'py> = PyArrayLikeDyn<'py, f64, AllowTypeChange>;

/// Rows of `width` numbers, one after the other: of an array (n × width), or of one row (width).
pub struct ArrayRows {
    /// Row by row (n × width).
    pub values: Vec<f64>,
    /// Number of rows; none for a single row without a dimension of its own.
    pub n_rows: Option<usize>,
}

impl ArrayRows {
    /// Takes the rows of `array`, called `name` in a message.
    ///
    /// # Errors
    /// `BadInput` for another shape.
    pub fn of(array: ArrayViewD<'_, f64>, width: usize, name: &str) -> Result<Self, BadInput> {
        let n_rows = match *array.shape() {
            [n] if n == width => None,
            [n, m] if m == width => Some(n),
            _ => {
                let expected = format!("an array n × {width}, or {width} numbers");
                return Err(BadInput::new(name, expected, shape_text(array.shape())));
            }
        };
        Ok(Self { values: array.as_standard_layout().iter().copied().collect(), n_rows })
    }

    /// Number of rows; one of a single row.
    pub fn len(&self) -> usize {
        self.n_rows.unwrap_or(1)
    }
}

fn shape_text(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    if sizes.is_empty() { "one number".to_owned() } else { format!("shape {}", sizes.join(" × ")) }
}

/// A read-only numpy array over `values`, which are part of `owner` and never change.
#[allow(unsafe_code)] // numpy cannot know how long the memory lives
pub fn borrowed<'py, T: Element>(values: &[T], owner: &Bound<'py, PyAny>) -> Bound<'py, PyArray1<T>> {
    // SAFETY: the array holds a reference to `owner`, a frozen class whose one value is never changed or moved: `values` stay
    // where they are until both are gone.
    let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner.clone()) };
    array.readwrite().make_nonwriteable();
    array
}
