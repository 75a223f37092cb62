//! Tests of `core/src/measurement/clock.rs`.

use bmv::measurement::{Initial, InputTable, Measurement, Phase, Rows};
use bmv::thermal::{Clock, Model};

fn measurement(name: &str, rows: Rows, follows_gap: bool) -> Measurement {
    Measurement {
        name: name.to_owned(),
        rows,
        sensors: Vec::new(),
        readings: Vec::new(),
        file: String::new(),
        sha256: String::new(),
        unused_columns: Vec::new(),
        follows_gap,
        doubts: Vec::new(),
        time_zero_s: None,
    }
}

fn run(name: &str, times_s: &[f64]) -> Measurement {
    let rows = times_s.len();
    let inputs = InputTable { times_s: times_s.to_vec(), columns: Vec::new(), base: Vec::new() };
    let (held_out, ignored) = (vec![false; rows], vec![None; rows]);
    measurement(name, Rows::Transient { inputs, initial: Initial::Steady, held_out, ignored }, false)
}

/// The times since the start of the rows, where they are sought.
fn elapsed(mut measurements: Vec<Measurement>) -> Option<Vec<f64>> {
    let mut model = Model::default();
    model.set_clocks(&measurements.clone(), &mut measurements);
    let input = model.clocks.get(Clock::Elapsed)?;
    assert_eq!(model.inputs[input].unit, "s");
    let rows = measurements.iter().flat_map(|own| (0..own.len()).map(move |row| (own, row)));
    rows.map(|(own, row)| own.level(&model, row, input)).collect()
}

#[test]
fn the_time_since_the_start_begins_anew_in_every_run() {
    let runs = vec![run("a", &[5.0, 15.0, 105.0]), run("b", &[1000.0, 1060.0])];
    assert_eq!(elapsed(runs), Some(vec![0.0, 10.0, 100.0, 0.0, 60.0]));
}

#[test]
fn what_follows_a_gap_is_of_the_same_run() {
    let part = Measurement { follows_gap: true, ..run("a (part 2)", &[80.0, 100.0]) };
    assert_eq!(elapsed(vec![run("a", &[0.0, 40.0]), part.clone()]), None, "one run");
    let runs = vec![run("a", &[0.0, 40.0]), part, run("b", &[20.0, 100.0])];
    assert_eq!(elapsed(runs), Some(vec![0.0, 40.0, 80.0, 100.0, 0.0, 80.0]));
}

#[test]
fn steady_phases_come_before_any_change_into_a_run() {
    let phase =
        Phase { name: "cold".to_owned(), inputs: Vec::new(), held_out: false, ignored: None, stabilisation: None };
    let steady = measurement("steady", Rows::Steady(vec![phase.clone(), phase]), false);
    assert_eq!(
        elapsed(vec![steady, run("a", &[0.0, 9.0]), run("b", &[0.0, 8.0])]),
        Some(vec![0.0, 0.0, 0.0, 9.0, 0.0, 8.0])
    );
}

#[test]
fn changes_into_a_run_are_sought_in_runs_of_like_length_up_to_where_there_are_two() {
    assert_eq!(elapsed(vec![run("a", &[0.0, 100.0])]), None);
    assert_eq!(elapsed(vec![run("a", &[0.0, 100.0]), run("b", &[0.0, 24.0])]), None);
    let mut runs = [run("a", &[0.0, 100.0]), run("b", &[0.0, 50.0]), run("c", &[0.0, 10.0])];
    let mut model = Model::default();
    model.set_clocks(&runs.clone(), &mut runs);
    let input = model.clocks.get(Clock::Elapsed).expect("sought");
    assert_eq!(model.inputs[input].range, Some([0.0, 50.0]));
    // One of them alone has none, whatever else the pass has measured.
    let mut alone = Model::default();
    alone.set_clocks(&runs.clone(), &mut runs[..1]);
    assert_eq!(alone.clocks.get(Clock::Elapsed), None);
    // An adopted effect has its clock in any pass.
    let mut adopted = Model::default();
    adopted.clock_input(Clock::Elapsed);
    assert_eq!(adopted.set_clock(Clock::Elapsed, &runs[..1], &mut []), Some(0));
    assert_eq!(adopted.inputs[0].range, Some([0.0, 100.0]));
}
