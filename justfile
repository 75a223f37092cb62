# Every recipe is one plain line; nothing depends on `just`.

# render the case-study reports
report:
    cargo run --release -- report

# the quick tier of tests
test:
    cargo test

# tests of a second and more each, which the gate runs too
thorough:
    cargo test -- --ignored --skip nightly::

# the gate
ci:
    .ci/run

# every committed page in a headless Chromium: widths, console, requests, axe-core, print; pictures in target/pages
pages:
    python3 .ci/pages.py

# all studies' reports by a release build, all pages in a browser, results against the baselines with the same seed and with another, exports read with ArviZ, a network asked by the client of UM-Bridge, slow statistical checks, large cases, runs on a real Slurm
nightly seed="$(date +%Y%m%d)":
    cargo run --release -- report && python3 .ci/pages.py && cargo run --release -- check studies && cargo run --release -- check studies --other-seed={{seed}} && python3 tests/clients/arviz_export.py target/release/bmv && python3 tests/clients/umbridge_model.py target/release/bmv && python3 tests/clients/umbridge_server.py target/release/bmv && tests/cluster/check.sh target/release/bmv && cargo test --release -- --include-ignored

# runs on a real three-node Slurm of this machine: lost node, parted network, killed driver, cancelled run, absent controller
cluster:
    cargo build --release && tests/cluster/check.sh target/release/bmv

# the solar X-ray monitor's sensitivity on three nodes, of which one crashes, and on one machine
cluster-demo:
    cargo build --release && tests/cluster/demo.sh target/release/bmv

# the diagnosis on cases of known truth: hours; prints the tables of docs/laboratory.md
laboratory nulls="2000" cases="1000" finer="400" dated="200" seed="1":
    cargo run --release --package bmv-benches --example laboratory -- {{nulls}} {{cases}} {{finer}} {{dated}} {{seed}}

# the diagnosis on campaigns whose truth is written beside them
known-truth +campaigns:
    cargo build --release && python3 tests/known_truth.py target/release/bmv {{campaigns}}

# campaigns of small test benches with unstated noise, one hidden effect and so many minor ones, written (with NumPy) and diagnosed; `shift`: readings that are offset in time
benches seed="1" count="48" minor="0" kinds="":
    cargo build --release && python3 tests/benches/prepare.py {{seed}} {{count}} target/benches {{minor}} {{kinds}} && python3 tests/known_truth.py target/release/bmv target/benches/*

# the campaigns of other people's data in tests/real, from the files of their origins
real building satellite:
    cargo build --release && python3 tests/real/prepare.py {{building}} {{satellite}} target/real && python3 tests/known_truth.py target/release/bmv target/real/building target/real/qb50-p1

# the picture of the second regime in docs/diagnosis.md, after `just real`
pictures:
    cargo build --release && cd target/real && ../release/bmv report building && cp reports/building/pass-1/plots/missing-probabilities.svg ../../docs/second-regime.svg

# benchmarks of everything that has a speed target
bench:
    cargo build --release && cargo bench --package bmv-benches

# studies of grids of nodes with a hidden path, what each verb takes on them, and how that grows
sizes +nodes="10 30 100 300 1000 3000 5000 10000":
    cargo build --release && benches/sizes/run.sh target/release/bmv {{nodes}}

# propagation where every node also radiates to two others anywhere, so that factors fill in
scattered +nodes="100 300 1000":
    cargo build --release && GRID="--scattered 2" VERBS="plan propagate" benches/sizes/run.sh target/release/bmv {{nodes}}

# comparison and report of 10,000 rows of 200 sensors
readings:
    cargo build --release && GRID="--sensors 200 --rows 1000 --noise --jobs compare" VERBS="plan compare report" benches/sizes/run.sh target/release/bmv 300

# a transient of 200 nodes beside LSODA at the same error; PYTHON has numpy and scipy
panel python="python3":
    cargo build --release --package bmv-benches --example panel && {{python}} benches/peers/transient.py target/release/examples/panel

# 64 conductivities of the Poisson benchmark calibrated, and held against an independent sampler of numpy and scipy
poisson:
    cargo build --release && python3 tests/reference/poisson/posterior.py target/release/bmv target/poisson

# the same on one record of 30 nodes: ten phases of so many rows, so many sensors, and by how many kelvin the sink steps in every row
record rows="200" sensors="6" swing="0" sampler="independence-metropolis":
    cargo build --release && GRID="--sensors {{sensors}} --rows {{rows}} --swing {{swing}}" SAMPLER={{sampler}} benches/sizes/run.sh target/release/bmv 30

# how soon reports of 43 phases and of 10 transients of 10,000 rows, 20 sensors each, are painted in a headless Chromium, and how large they are
first-paint:
    cargo build --release && python3 benches/sizes/first_paint.py target/release/bmv

# the documentation of the library
doc:
    cargo doc --no-deps --open
