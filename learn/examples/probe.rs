//! x
use hysteron_learn::*;
use std::time::Instant;
fn main() {
    let a = Architecture { inputs: 2, hidden: 512, layers: 2, outputs: 4, head: Head::Linear, dropout: 0.0 };
    let (steps, rows) = (200, 64);
    let x: Vec<f32> = (0..steps * rows * 2).map(|k| (k as f32 * 0.1).sin()).collect();
    let b = Batch { inputs: &x, steps, rows, outputs: Outputs::All };
    let mut t = Trainer::new(Network::new(&a, 1).unwrap(), Adam::default(), 1).unwrap();
    for _ in 0..4 {
        let mut m = Memory::zeros(&a, rows);
        let s = Instant::now();
        t.predict(&b, &mut m).unwrap();
        let p = s.elapsed();
        let mut m = Memory::zeros(&a, rows);
        let s = Instant::now();
        let l = t
            .step(&b, &mut m, |o, d| {
                for (d, o) in d.iter_mut().zip(o) {
                    *d = 2.0 * (*o - 1.0) / 51200.0;
                }
                o.iter().map(|o| ((o - 1.0) as f64).powi(2)).sum::<f64>() / o.len() as f64
            })
            .unwrap();
        println!("predict {p:?} step {:?} {l}", s.elapsed());
    }
    let a = Architecture { inputs: 7, hidden: 128, layers: 2, outputs: 36, head: Head::Tanh, dropout: 0.0 };
    let mut r = Runner::new(&Network::new(&a, 1).unwrap());
    let x = [0.1; 7];
    for _ in 0..3 {
        let s = Instant::now();
        for _ in 0..1000 {
            r.step(&x);
        }
        println!("runner {:?}", s.elapsed() / 1000);
    }
}
