//! Files of networks, `.safetensors` with a checksum, changed so that the checksum is right again: what is tried is then the
//! reader, and not its checksum.

use hysteron_base::file;
use proptest::prelude::*;
use proptest::sample::Index;

/// Stands for the checksum while it is computed.
const NO_CHECKSUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Replacements of weights.
const WEIGHTS: [f64; 10] =
    [1e30, -1e30, 3e38, 1e7, 1e6, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 1e-40];

/// Changes of the weights in a file: from where on, of what part of those that follow, and to what.
#[derive(Debug, Clone)]
pub struct OtherWeights {
    from: Index,
    part: Index,
    to: usize,
}

/// One such change.
pub fn other_weights() -> impl Strategy<Value = OtherWeights> {
    (any::<Index>(), any::<Index>(), 0..WEIGHTS.len()).prop_map(|(from, part, to)| OtherWeights {
        from,
        part,
        to,
    })
}

/// Length of the header, and where the data begin.
fn header_of(bytes: &[u8]) -> usize {
    let (length, _) = bytes.split_at(8);
    u64::from_le_bytes(length.try_into().unwrap()) as usize
}

/// The file with slips in its header, one line a value, and the checksum of what it then holds.
pub fn resealed(bytes: &[u8], slip: impl Fn(&str) -> String) -> Vec<u8> {
    let rest = &bytes[8..];
    let n = header_of(bytes);
    let header = String::from_utf8(rest[..n].to_vec()).unwrap();
    let stated = header.split("\"sha256\":\"").nth(1).unwrap()[..NO_CHECKSUM.len()].to_owned();
    let header = slip(&header.replace(',', ",\n").replace(':', " = "));
    let mut header = header.replace(" = ", ":").replace('\n', "").replace(&stated, NO_CHECKSUM);
    header.extend(std::iter::repeat_n(' ', header.len().next_multiple_of(8) - header.len()));
    let mut sealed = (header.len() as u64).to_le_bytes().to_vec();
    sealed.extend(header.as_bytes());
    sealed.extend(&rest[n..]);
    let checksum = file::sha256_hex(&sealed);
    if let Some(at) = sealed.windows(NO_CHECKSUM.len()).position(|window| window == NO_CHECKSUM.as_bytes()) {
        sealed[at..at + checksum.len()].copy_from_slice(checksum.as_bytes());
    }
    sealed
}

/// The file with other weights, single or double as they are in it, under a checksum that is right.
pub fn reweighted(bytes: &[u8], change: &OtherWeights) -> Vec<u8> {
    let begin = 8 + header_of(bytes);
    let is_single = String::from_utf8_lossy(&bytes[..begin]).contains("\"F32\"");
    let weight = WEIGHTS[change.to];
    let word = if is_single { (weight as f32).to_le_bytes().to_vec() } else { weight.to_le_bytes().to_vec() };
    let mut changed = bytes.to_vec();
    let words = (bytes.len() - begin) / word.len();
    if words > 0 {
        let from = change.from.index(words);
        let to = from + 1 + change.part.index(words - from);
        for at in from..to {
            let at = begin + at * word.len();
            changed[at..at + word.len()].copy_from_slice(&word);
        }
    }
    resealed(&changed, str::to_owned)
}
