# Every recipe is one plain line; nothing depends on `just`.

# render the case-study reports
report:
    cargo run --release -- report

# the quick tier of tests
test:
    cargo test

# the gate
ci:
    .ci/run

# slow statistical checks, large cases, regression of archived results, all studies' reports
nightly:
    cargo run --release -- report && cargo test --release -- --include-ignored

# benchmarks of everything that has a speed target
bench:
    cargo build --release && cargo bench --package bmv-benches

# the documentation of the library
doc:
    cargo doc --no-deps --open
