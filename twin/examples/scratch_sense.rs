//! scratch
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]
use hysteron_base::{Recording, Scene};
use hysteron_twin::coreact::{Auxiliary, FrictionPoints};
use hysteron_twin::residual::{ResidualModel, Rollout};
use hysteron_twin::{Plant, Twin, settle};
use std::io::Write;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let scene = Scene::read(std::path::Path::new(&a[1])).unwrap();
    let twin = Twin::from_scene(&scene).unwrap();
    let model = ResidualModel::read(std::path::Path::new(&a[2])).unwrap();
    let aux = Auxiliary::new(&twin).unwrap();
    let rec = Recording::read(&a[3]).unwrap();
    let every: usize = a[5].parse().unwrap();
    let mut plant = Rollout::new(&twin, &aux, &model, 0.01).unwrap();
    let s = rec.strokes();
    let row = |i: usize| s.iter().map(|c| c[i]).collect::<Vec<f64>>();
    settle(&twin, &mut plant, &row(0)).unwrap();
    let mut out = std::io::BufWriter::new(std::fs::File::create(&a[4]).unwrap());
    let mut dump = |v: &[f64]| {
        for x in v {
            out.write_all(&x.to_le_bytes()).unwrap();
        }
    };
    let n = rec.n_samples();
    let (mut c, mut t, mut c2) = ([[0.0; 3]; 3], vec![[0.0; 3]; 4], [[0.0; 3]; 3]);
    let (mut spent, mut calls) = (0.0, 0);
    for i in 0..n {
        let step = plant.step(&row(i)).unwrap();
        if i % every == 0 {
            let start = std::time::Instant::now();
            if let Some(r) = plant.tip_response(FrictionPoints::AsTheyAre) {
                c = r.per_force;
                t = r.tensions_per_force();
            }
            spent += start.elapsed().as_secs_f64();
            calls += 1;
            if let Some(r) = plant.tip_response(FrictionPoints::Slipping) {
                c2 = r.per_force;
            }
        }
        dump(&step.tip);
        let q = twin.tip_rotation_of(plant.state());
        dump(&[q.w, q.i, q.j, q.k]);
        dump(&plant.state().tensions[..4]);
        for r in &c {
            dump(r);
        }
        for r in &c2 {
            dump(r);
        }
        for r in &t {
            dump(r);
        }
    }
    println!("response {:.3} ms", 1e3 * spent / calls as f64);
}
