//! Readings of sensors whose declared clocks are off, by the time of the inputs.

use crate::measurement::{Sensor, Uncertain};

/// By how much the clock of a sensor is behind, s: known, or the most probable.
fn behind_s(sensor: &Sensor) -> f64 {
    sensor.behind_s.iter().map(Uncertain::nominal).sum()
}

/// Whether the clock of a sensor is off, by the most probable time.
pub fn is_off(sensor: &Sensor) -> bool {
    behind_s(sensor) != 0.0
}

/// Whether the clock of a sensor is behind, by the most probable time: it shows nothing of the start.
pub fn is_behind(sensor: &Sensor) -> bool {
    behind_s(sensor) > 0.0
}

/// Leaves out readings that show what happens before the first row or after the last, by clocks that are known to be off: no row says
/// what the inputs were then.
pub fn leave_out_unknown(times_s: &[f64], sensors: &[Sensor], readings: &mut [Option<f64>]) {
    let (Some(first_s), Some(last_s)) = (times_s.first(), times_s.last()) else { return };
    for (position, sensor) in sensors.iter().enumerate() {
        let is_known = sensor.behind_s.iter().all(|value| matches!(value, Uncertain::Known(_)));
        if !is_known || sensor.behind_s.is_empty() {
            continue;
        }
        let behind_s = behind_s(sensor);
        for (row, time_s) in times_s.iter().enumerate() {
            if !(*first_s..=*last_s).contains(&(time_s + behind_s)) {
                readings[row * sensors.len() + position] = None;
            }
        }
    }
}

/// Readings by row of what happened at its time, without those of rows that are left out: of a sensor whose clock is off the one that
/// shows the nearest instant, if that is no farther than rows are from one another there; where it shows nothing so early, its first.
pub fn by_time_of_inputs(
    times_s: &[f64],
    ignored: &[Option<String>],
    sensors: &[Sensor],
    readings: &[Option<f64>],
) -> Vec<Option<f64>> {
    let mut shown = readings.to_vec();
    for (own, _) in shown.chunks_mut(sensors.len().max(1)).zip(ignored).filter(|(_, reason)| reason.is_some()) {
        own.fill(None);
    }
    for (position, sensor) in sensors.iter().enumerate().filter(|(_, sensor)| is_off(sensor)) {
        let behind_s = behind_s(sensor);
        let read: Vec<(f64, f64)> = (times_s.iter().enumerate())
            .filter_map(|(row, time_s)| Some((time_s + behind_s, shown[row * sensors.len() + position]?)))
            .collect();
        for (row, time_s) in times_s.iter().enumerate() {
            let after = read.partition_point(|(shown_s, _)| shown_s < time_s);
            let near = [after.checked_sub(1), Some(after)].into_iter().flatten().filter_map(|at| read.get(at));
            let away_s = |(shown_s, _): &(f64, f64)| (shown_s - time_s).abs();
            let nearest = near.min_by(|a, b| away_s(a).total_cmp(&away_s(b)));
            let apart_s = apart(times_s, row);
            let found = nearest.filter(|one| after == 0 || away_s(one) <= apart_s);
            shown[row * sensors.len() + position] = found.map(|(_, reading)| *reading);
        }
    }
    shown
}

/// How far a row is from the farther one beside it, s.
fn apart(times_s: &[f64], row: usize) -> f64 {
    let before = row.checked_sub(1).map_or(0.0, |other| times_s[row] - times_s[other]);
    times_s.get(row + 1).map_or(before, |after| before.max(after - times_s[row]))
}

/// By how much a sensor moves in the time by which its clock is behind, where its record begins: what is not known of the start. The
/// readings are those by the time of the inputs.
pub fn unknown_at_start(times_s: &[f64], sensors: &[Sensor], readings: &[Option<f64>], position: usize) -> f64 {
    let behind_s = behind_s(&sensors[position]);
    let Some(first_s) = times_s.first().filter(|_| behind_s > 0.0) else { return 0.0 };
    let at = |row: usize| readings[row * sensors.len() + position];
    let rows = (0..times_s.len()).filter(|&row| times_s[row] - first_s <= 2.0 * behind_s);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for reading in rows.filter_map(at) {
        (least, most) = (least.min(reading), most.max(reading));
    }
    (most - least).max(0.0)
}
