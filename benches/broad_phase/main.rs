//! Benchmarks of the broad phase through its public API, on the library's own stress scenes.
//!
//! `cargo bench -p study` measures, `cargo bench -p study -- --test` runs everything once; an
//! argument such as `pairs/brownian` picks benchmarks by name. Names are
//! `what/scene/method/objects`.

mod build;
mod insert;
mod lifetime;
mod maintain;
mod pairs;
mod queries;
mod setup;

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};

/// Short times: all of it takes a few minutes, and ratios are told apart from some per cent on.
fn short() -> Criterion {
    Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .without_plots()
}

criterion_group! {
    name = broad_phase;
    config = short();
    targets = insert::bench, build::bench, maintain::bench, pairs::bench, queries::bench, lifetime::bench
}
criterion_main!(broad_phase);
