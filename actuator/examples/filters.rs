//! Answers lines of JSON on stdin, each `{"filter": …, "signal": […], …}`, with the filtered signal: what `tests/peers` compares with scipy.
#![allow(clippy::print_stdout)] // this program answers on stdout

use std::error::Error;
use std::io::BufRead;

use hysteron_actuator::filter::{LowPass, Median, SavitzkyGolay, Specification, median_of};
use hysteron_base::json;
use serde_json::Value;

fn main() -> Result<(), Box<dyn Error>> {
    for line in std::io::stdin().lock().lines() {
        println!("{}", answer(&json::from_text(&line?)?)?);
    }
    Ok(())
}

fn answer(asked: &Value) -> Result<Value, Box<dyn Error>> {
    let number = |key: &str| asked[key].as_f64().ok_or_else(|| format!("no number {key}"));
    let count = |key: &str| asked[key].as_u64().map(|n| n as usize).ok_or_else(|| format!("no count {key}"));
    let signal: Vec<f64> = json::from_value(&asked["signal"].clone())?;
    let causal = |filter: &LowPass| {
        let mut state = filter.start(0.0);
        signal.iter().map(|x| state.next(*x)).collect::<Vec<f64>>()
    };
    Ok(match asked["filter"].as_str().unwrap_or_default() {
        "butterworth" => {
            let filter = LowPass::new(count("order")?, number("cutoff")?, number("rate")?)?;
            json!({"causal": causal(&filter), "zero_phase": filter.zero_phase(&signal)})
        }
        "specification" => {
            let specification = Specification {
                pass: number("pass")?,
                pass_db: number("pass_db")?,
                stop: number("stop")?,
                stop_db: number("stop_db")?,
            };
            json!({"causal": causal(&LowPass::meeting(specification, number("rate")?)?)})
        }
        "median" => {
            let half = count("half")?;
            let mut streaming = Median::new(2 * half + 1, signal[0]);
            let causal: Vec<f64> = signal.iter().map(|x| streaming.next(*x)).collect();
            json!({"causal": causal, "centred": median_of(&signal, half)})
        }
        "savitzky-golay" => {
            let filter =
                SavitzkyGolay::new(count("half")?, count("degree")?, count("derivative")?, number("rate")?)?;
            json!({"centred": filter.apply(&signal)})
        }
        other => return Err(format!("no filter {other:?}").into()),
    })
}
