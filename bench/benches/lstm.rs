//! Training and stepping an LSTM: fused layers compared with candle's own cells; stepping a Transformer.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use criterion::{Criterion, criterion_group, criterion_main};
use hysteron_bench::learn::{Stepped, TransformerPasses, WaveTraining, runner, transformer};
use hysteron_learn::{HeadOutputs, TemporalForm, WeightFormat};

fn training(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lstm/step/2x512");
    group.sample_size(10);
    for (name, mut training) in [
        ("fused/64x20", WaveTraining::fused(20, HeadOutputs::All).unwrap()),
        ("candle/64x20", WaveTraining::unrolled(20).unwrap()),
        ("fused/64x200", WaveTraining::fused(200, HeadOutputs::All).unwrap()),
        ("fused/64x200, loss at the last sample", WaveTraining::fused(200, HeadOutputs::Last).unwrap()),
    ] {
        // From the same weights: the proof of equal work.
        println!("    loss of {name} at first {:.6}", training.step().unwrap());
        group.bench_function(name, |bencher| bencher.iter(|| training.step().unwrap()));
    }
    group.finish();
}

fn rollout(criterion: &mut Criterion) {
    for (name, stepped, inputs) in [
        ("lstm/sample/2x128", Stepped::Residual, &[0.1; 7][..]),
        ("lstm/sample/2x512", Stepped::Controller, &[0.1; 2]),
    ] {
        let mut runner = runner(stepped).unwrap();
        criterion.bench_function(name, |bencher| bencher.iter(|| runner.step(inputs)[0]));
        println!("    output {:.6}", runner.step(inputs)[0]);
    }
}

fn transformers(criterion: &mut Criterion) {
    for (name, form, format) in [
        ("transformer/sample/published", TemporalForm::Window, WeightFormat::Float32),
        ("transformer/sample/streaming", TemporalForm::Streaming, WeightFormat::Float32),
        ("transformer/sample/streaming, 16 bits", TemporalForm::Streaming, WeightFormat::Int16),
    ] {
        let mut runner = transformer(form, format).unwrap();
        criterion.bench_function(name, |bencher| bencher.iter(|| runner.step(&[0.1; 36])[0]));
        println!("    output {:.6}", runner.step(&[0.1; 36])[0]);
    }
    for (name, form) in [("published", TemporalForm::Window), ("streaming", TemporalForm::Streaming)] {
        let mut one = TransformerPasses::new(form, 1).unwrap();
        let window = format!("transformer/window/{name}");
        criterion.bench_function(&format!("{window}/fused"), |bencher| bencher.iter(|| one.fused()[0]));
        criterion
            .bench_function(&format!("{window}/candle"), |bencher| bencher.iter(|| one.by_candle().unwrap()));
        let mut many = TransformerPasses::new(form, 64).unwrap();
        println!("    derivatives apart by {:.1e}", many.apart().unwrap());
        let mut group = criterion.benchmark_group(format!("transformer/64 windows and back/{name}"));
        group.sample_size(10);
        group.bench_function("fused", |bencher| bencher.iter(|| many.fused_and_back()[0][0]));
        group.bench_function("candle", |bencher| bencher.iter(|| many.by_candle_and_back().unwrap()));
        group.finish();
    }
}

criterion_group!(benches, training, rollout, transformers);
criterion_main!(benches);
