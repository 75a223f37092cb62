//! Tests of `diagnosis/src/diagnosis/channel.rs`.

use bmv::diagnosis::channel::{frozen, input_steps, resolution, spikes, stuck};
use bmv::math::functions::{exp, sin};
use bmv::random::StreamKey;
use bmv::thermal::{InputColumn, InputTable};

/// A slow error of 3 K, noise of 0.1 K.
fn errors(n: usize) -> Vec<f64> {
    let mut stream = StreamKey::new(4, "test", "spikes").stream(0);
    (0..n).map(|k| 3.0 * sin(k as f64 / 40.0) + 0.1 * stream.normal()).collect()
}

#[test]
fn spikes_and_drop_outs_are_found_and_nothing_else() {
    let clean = errors(600);
    let readings: Vec<f64> = clean.iter().map(|error| 300.0 + error).collect();
    assert!(spikes(&clean, &readings).is_empty());
    let (mut bad, mut shown) = (clean.clone(), readings.clone());
    for (row, off) in [(50, 5.0), (200, -4.0), (201, -3.0)] {
        bad[row] += off;
        shown[row] += off;
    }
    // Ten rows of exact zeros.
    for row in 400..410 {
        bad[row] -= shown[row];
        shown[row] = 0.0;
    }
    let expected: Vec<usize> = [50, 200, 201].into_iter().chain(400..410).collect();
    assert_eq!(spikes(&bad, &shown), expected);
    // The same errors of a model that jumps: the channel is right.
    assert!(spikes(&bad, &readings).is_empty());
}

/// Quiet nights, and days on which clouds move the channel by kelvins from row to row.
#[test]
fn a_channel_that_moves_more_at_times_has_no_spikes_there_but_a_spike_stands_out() {
    let mut stream = StreamKey::new(9, "test", "days").stream(0);
    let mut errors: Vec<f64> =
        (0..900).map(|k| if (k / 100) % 3 == 1 { 2.0 * stream.normal() } else { 0.05 * stream.normal() }).collect();
    let readings = |errors: &[f64]| -> Vec<f64> { errors.iter().map(|error| 300.0 + error).collect() };
    assert!(spikes(&errors, &readings(&errors)).is_empty());
    errors[450] += 40.0;
    errors[250] += 4.0;
    assert_eq!(spikes(&errors, &readings(&errors)), [250, 450]);
}

#[test]
fn an_input_that_switches_steps_and_one_that_always_changes_does_not() {
    let mut stream = StreamKey::new(10, "test", "steps").stream(0);
    let column = |values: Vec<f64>| InputColumn { input: 0, values, hold: true };
    let of = |values: Vec<f64>| {
        let times_s = (0..values.len()).map(|row| row as f64).collect();
        input_steps(&InputTable { times_s, columns: vec![column(values)], base: vec![0.0] })
    };
    let switched = (0..100).map(|row| if (40..43).contains(&row) { 1.0 } else { 0.0 }).collect();
    assert_eq!(of(switched), [40, 43]);
    assert!(of((0..100).map(|_| stream.normal()).collect()).is_empty());
    assert!(of((0..100).map(f64::from).collect()).is_empty());
}

#[test]
fn a_channel_that_freezes_is_found_and_a_coarse_one_at_rest_is_not() {
    let mut stream = StreamKey::new(5, "test", "frozen").stream(0);
    let truth: Vec<f64> = (0..400).map(|k| 300.0 + 10.0 * sin(f64::from(k) / 40.0)).collect();
    let readings: Vec<f64> = truth.iter().map(|temperature| temperature + 0.1 * stream.normal()).collect();
    let against =
        |shown: &[f64]| -> Vec<f64> { shown.iter().zip(&truth).map(|(reading, truth)| reading - truth).collect() };
    assert!(frozen(&against(&readings), &readings).is_empty());
    let mut stuck = readings.clone();
    (301..400).for_each(|row| stuck[row] = stuck[300]);
    assert_eq!(frozen(&against(&stuck), &stuck), (301..400).collect::<Vec<_>>());
    // Steps of 2 K: long stretches at the turns, where the model rests as well.
    let coarse: Vec<f64> = truth.iter().map(|temperature| (temperature / 2.0).round() * 2.0).collect();
    assert!(frozen(&against(&coarse), &coarse).is_empty());
    // Means over forty readings in whole steps of half a kelvin, of a node that comes to rest: it stays at them.
    let rest = |row: f64| -> f64 { 300.0 + 40.0 * (1.0 - exp(-row / 60.0)) };
    let mean = |row: u32| {
        let parts = (0..40).map(|part| (rest(f64::from(row) + f64::from(part) / 40.0) / 0.5).round() * 0.5);
        parts.sum::<f64>() / 40.0
    };
    let averaged: Vec<f64> = (0..400).map(mean).collect();
    let errors: Vec<f64> = (0..400).map(|row| mean(row) - rest(f64::from(row) + 0.5)).collect();
    assert!(frozen(&errors, &averaged).is_empty());
    assert!(frozen(&[], &[]).is_empty() && frozen(&[0.0], &[300.0]).is_empty());
}

#[test]
fn a_plateau_beside_a_model_that_errs_as_much_elsewhere_is_no_frozen_channel() {
    // Something melts at 290 K for a third of the warm-up, in readings of 0.1 K; the model warms throughout.
    let truth = |row: f64| 280.0 + if row < 100.0 { 0.1 * row } else { f64::max(10.0, 0.1 * (row - 100.0)) };
    let readings: Vec<f64> = (0..300).map(|row| (truth(f64::from(row)) / 0.1).round() * 0.1).collect();
    let against = |model: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..).zip(&readings).map(|(row, reading)| reading - model(f64::from(row))).collect()
    };
    assert!(frozen(&against(&|row| 280.0 + 0.0667 * row), &readings).is_empty());
    // A model that is right but there tells that the channel froze.
    let right_elsewhere = |row: f64| truth(row) + if (100.0..200.0).contains(&row) { 0.1 * (row - 100.0) } else { 0.0 };
    assert!(frozen(&against(&right_elsewhere), &readings).len() > 90);
}

#[test]
fn a_channel_that_sticks_in_steady_phases_is_found_and_one_that_is_held_is_not() {
    let mut stream = StreamKey::new(6, "test", "stuck").stream(0);
    let truth: Vec<f64> = (0..16).map(|k| 280.0 + 20.0 * f64::from(k * 7 % 16) / 16.0).collect();
    let mut shown = |truth: f64| ((truth + 0.2 * stream.normal()) * 100.0).round() / 100.0;
    let right: Vec<f64> = truth.iter().map(|&truth| shown(truth)).collect();
    // A thermostat that the model lacks holds the node, and the noise goes on.
    let held: Vec<f64> = truth.iter().map(|_| shown(300.0)).collect();
    let mut broken = right.clone();
    (9..16).for_each(|phase| broken[phase] = broken[8]);
    let against = |shown: &[f64]| -> Vec<f64> { shown.iter().zip(&truth).map(|(a, b)| a - b).collect() };
    for readings in [&right, &held] {
        assert!(stuck(&against(readings), readings, 0.2, 0.01).is_empty());
    }
    assert_eq!(stuck(&against(&broken), &broken, 0.2, 0.01), (9..16).collect::<Vec<_>>());
    // Whole kelvins are often the same.
    let coarse: Vec<f64> = held.iter().map(|reading| reading.round()).collect();
    assert!(stuck(&against(&coarse), &coarse, 0.2, 1.0).is_empty());
    assert!(stuck(&[], &[], 0.2, 0.01).is_empty() && stuck(&[1.0; 8], &[300.0; 8], 0.0, f64::INFINITY).is_empty());
}

#[test]
fn a_step_that_stays_is_no_spike() {
    let mut bad = errors(300);
    bad.iter_mut().skip(150).for_each(|error| *error += 4.0);
    let shown: Vec<f64> = bad.iter().map(|error| 300.0 + error).collect();
    assert!(spikes(&bad, &shown).is_empty());
    // Nor are whole steps of a coarse channel.
    let coarse: Vec<f64> = (0..300).map(|k| f64::from(k / 50) * 0.5 + if k % 17 == 0 { 0.5 } else { 0.0 }).collect();
    assert!(spikes(&coarse, &coarse).is_empty());
}

#[test]
fn whole_steps_are_the_resolution_of_a_channel_that_repeats_itself() {
    // Two means between whole degrees, of 3/4 and 1/4.
    let whole = [
        20.0, 20.0, 20.0, 20.75, 21.0, 21.0, 21.0, 22.0, 22.0, 22.0, 22.0, 23.0, 23.0, 23.0, 25.0, 25.0, 25.0, 24.0,
        24.0, 24.0,
    ];
    assert_eq!(resolution(&whole), 1.0);
    let fine: Vec<f64> = (0..20).map(|row| 20.0 + 0.1 * f64::from(row * row % 7)).collect();
    assert_eq!(resolution(&fine), 0.0, "it hardly repeats itself");
    // Read three times as often as it is renewed, it moves on by another amount each time.
    let renewed: Vec<f64> = (0..60).map(|row| 20.0 + 0.01 * f64::from((row / 3) * (row / 3))).collect();
    assert!(resolution(&renewed) < 0.1, "{}", resolution(&renewed));
    // Three drop-outs to 0 beside a flicker of a hundredth.
    let mut quiet = vec![20.0; 60];
    [10, 20, 30].into_iter().for_each(|row| quiet[row] = 0.0);
    [40, 45, 50].into_iter().for_each(|row| quiet[row] = 20.01);
    let step = resolution(&quiet);
    assert!((step - 0.01).abs() < 1e-9, "{step}");
    assert_eq!((resolution(&[5.0; 9]), resolution(&[])), (0.0, 0.0), "it shows no step");
}

/// A channel whose noise shows in every row never repeats a value eight times, be the hardware as level as it may. One whose readings are
/// coarse, or follow one another smoothly, does so on a plateau.
#[test]
fn a_channel_with_noise_in_every_row_is_frozen_where_it_shows_one_value() {
    let mut stream = StreamKey::new(6, "test", "level").stream(0);
    let rounded = |value: f64, step: f64| (value / step).round() * step;
    let noise: Vec<f64> = (0..200).map(|_| 0.1 * stream.normal()).collect();
    // The model errs by 2 K and is level.
    let level = |readings: &[f64]| readings.iter().map(|reading| reading - 302.0).collect::<Vec<f64>>();
    let with_stretch = |mut readings: Vec<f64>| {
        let held = readings[120];
        readings[120..140].fill(held);
        readings
    };
    let fine = with_stretch(noise.iter().map(|own| rounded(300.0 + own, 0.001)).collect());
    assert_eq!(frozen(&level(&fine), &fine), (121..140).collect::<Vec<_>>());
    let short: Vec<f64> = fine[..120].iter().chain(&fine[133..]).copied().collect();
    assert!(frozen(&level(&short), &short).is_empty(), "seven readings of one value");
    let coarse = with_stretch(noise.iter().map(|own| rounded(300.0 + own, 0.2)).collect());
    assert!(frozen(&level(&coarse), &coarse).is_empty(), "readings repeat anywhere");
    let smooth = with_stretch((0..200).map(|row| 300.0 + 0.01 * f64::from(row)).collect());
    assert!(frozen(&level(&smooth), &smooth).is_empty(), "a plateau between two ramps, and no noise");
    let rising = |readings: &[f64]| {
        (0..).zip(readings).map(|(row, own)| own - 299.0 - 0.08 * f64::from(row)).collect::<Vec<f64>>()
    };
    let ramp =
        with_stretch((0..).zip(&noise).map(|(row, own)| rounded(300.0 + 0.1 * f64::from(row) + own, 0.001)).collect());
    assert_eq!(
        frozen(&rising(&ramp), &ramp),
        (121..140).collect::<Vec<_>>(),
        "while the hardware warms, and the model less"
    );
    let to_the_end = |mut readings: Vec<f64>, from: usize| {
        let held = readings[from];
        readings[from..].fill(held);
        readings
    };
    let stopped = to_the_end(noise.iter().map(|own| rounded(300.0 + own, 0.001)).collect(), 120);
    assert_eq!(frozen(&level(&stopped), &stopped), (121..200).collect::<Vec<_>>());
}

/// What moves to and fro by itself and comes to rest is no channel with noise: a heater's cycles that die down, days of weather above ground
/// that snow covers, a second logger that repeats each reading.
#[test]
fn what_comes_to_rest_by_itself_is_not_frozen() {
    let mut stream = StreamKey::new(7, "test", "rest").stream(0);
    let rounded = |value: f64, step: f64| (value / step).round() * step;
    let cycles = |row: u32| if row < 120 { 1.2 * f64::from(row % 3) } else { 2.0 * exp(-f64::from(row - 119) / 8.0) };
    let heater: Vec<f64> = (0..240).map(|row| rounded(300.0 + cycles(row), 0.1)).collect();
    let wrong: Vec<f64> = heater.iter().map(|reading| reading - 303.0).collect();
    assert!(frozen(&wrong, &heater).is_empty(), "a model that lacks the heater");
    // The model has the weather, and lacks the snow.
    let weather: Vec<f64> = (0..200).map(|_| 2.0 * stream.normal()).collect();
    let ground: Vec<f64> = weather
        .iter()
        .enumerate()
        .map(|(day, own)| if day < 120 { rounded(275.0 + own, 0.1) } else { 273.2 })
        .collect();
    let snow: Vec<f64> = ground.iter().zip(&weather).map(|(reading, own)| reading - 279.0 - 0.8 * own).collect();
    assert!(frozen(&snow, &ground).is_empty(), "days of weather, then snow");
    let mut slower: Vec<f64> = (0..200).map(|_| rounded(300.0 + 0.1 * stream.normal(), 0.001)).collect();
    for block in slower[100..].chunks_mut(10) {
        let held = block[0];
        block.fill(held);
    }
    let level: Vec<f64> = slower.iter().map(|reading| reading - 300.0).collect();
    assert!(frozen(&level, &slower).is_empty(), "each reading ten times");
}
