//! A comparison for other programs: rows, and statistics by the name of the sensor.

use serde_json::{Map, Value, json};

use super::deviation::deviation;
use super::deviation::noise_rmse;
use super::output::{Deviation, Output, SensorSummary};
use super::readings::Row;

/// The document of `compare --json`: everything in SI, deviations are measured minus predicted.
///
/// `sensors` goes by name. A name that occurs in several measurements is one sensor: its statistics are over the rows of
/// all of them, as whoever groups `rows` by sensor finds them; where its readings have different units it cannot be one,
/// and each stands apart as `MEASUREMENT/NAME`. `measurements` has the same for each measurement alone. What has no
/// readings is null. The readings themselves, `rows`, are not in it.
pub fn view(output: &Output) -> Value {
    json!({
        "state": output.state,
        "parameters": output.parameters.iter().map(|(name, unit, value)| {
            // The value is SI, the unit the one in which the study writes it.
            (name.clone(), json!({ "value": value, "written_unit": unit }))
        }).collect::<Map<_, _>>(),
        "sensors": by_name(output),
        "measurements": by_measurement(output),
        "phases": output.phases,
        "train": filled(&output.train),
        "held_out": filled(&output.held_out),
        "chi2_per_reading": output.chi2_per_reading,
        "criteria": output.criteria,
        "verdicts": output.verdicts,
        "heat": output.heat.iter().map(|heat| json!({
            "measurement": heat.measurement,
            "phase": heat.phase,
            "sources_w": heat.sources_w,
            "into_boundaries_w": heat.into_boundaries_w.iter().map(|(node, w)| (node.clone(), json!(w))).collect::<Map<_, _>>(),
            "stored_w": heat.stored_w,
            "imbalance_w": heat.imbalance_w,
        })).collect::<Vec<_>>(),
        "trends": output.trends,
        "stabilisation": output.stabilisation,
        "tuned": output.tuned,
        "fails": output.fails,
        "failed": output.failed,
        "unused_columns": output.unused_columns,
        "warnings": output.warnings,
    })
}

/// Statistics of some readings, null where there are none.
fn filled(deviation: &Deviation) -> Value {
    if deviation.count == 0 { Value::Null } else { json!(deviation) }
}

fn by_name(output: &Output) -> Map<String, Value> {
    let mut entries = Map::new();
    for sensor in &output.sensors {
        let same: Vec<&SensorSummary> = output.sensors.iter().filter(|other| other.sensor == sensor.sensor).collect();
        if same.iter().all(|other| other.unit == sensor.unit) {
            if !entries.contains_key(&sensor.sensor) {
                entries.insert(sensor.sensor.clone(), statistics(output, &same));
            }
        } else {
            entries.insert(format!("{}/{}", sensor.measurement, sensor.sensor), statistics(output, &[sensor]));
        }
    }
    entries
}

fn by_measurement(output: &Output) -> Map<String, Value> {
    let mut entries = Map::new();
    for sensor in &output.sensors {
        let entry = entries.entry(sensor.measurement.clone()).or_insert_with(|| json!({}));
        entry[sensor.sensor.as_str()] = statistics(output, &[sensor]);
    }
    entries
}

/// The readings of one sensor in its measurements.
fn rows<'o>(output: &'o Output, same: &'o [&SensorSummary]) -> impl Iterator<Item = Row<&'o str>> {
    same.iter().flat_map(|sensor| output.rows.of(&sensor.measurement, &sensor.sensor))
}

/// Statistics of one sensor over its measurements.
fn statistics(output: &Output, same: &[&SensorSummary]) -> Value {
    let of = |pick: fn(&SensorSummary) -> &Deviation, held_out: bool| -> Deviation {
        if let [only] = same {
            return *pick(only);
        }
        let rows = rows(output, same).filter(|row| row.held_out == held_out);
        deviation(&rows.map(|row| row.deviation()).collect::<Vec<_>>(), output.criteria.each_k)
    };
    let (train, held_out) = (of(|sensor| &sensor.train, false), of(|sensor| &sensor.held_out, true));
    // The range belongs to the readings of `rmse`; it needs one noise, known and white, for all of them.
    let sigma = same.first().and_then(|first| first.sigma);
    let has_one_noise = same.iter().all(|sensor| sensor.sigma == sigma && sensor.noise_rmse.is_some());
    let noise = sigma.filter(|_| has_one_noise && train.count > 0).map(|sigma| {
        let [low, high] = noise_rmse(sigma, train.count);
        json!({ "rmse_low": low, "rmse_high": high, "sigma": sigma })
    });
    json!({
        "unit": same.first().map(|sensor| &sensor.unit),
        "delivered": both(&train, &held_out),
        "tuned": tuned(output, same),
        "noise": noise,
        "missing": same.iter().map(|sensor| sensor.missing).sum::<u64>(),
    })
}

/// Statistics of measured minus tuned prediction; empty before a calibration.
fn tuned(output: &Output, same: &[&SensorSummary]) -> Value {
    if same.iter().any(|sensor| sensor.tuned.is_none()) {
        return json!({});
    }
    let of = |held_out: bool| -> Deviation {
        let rows = rows(output, same).filter(|row| row.held_out == held_out);
        deviation(&rows.filter_map(|row| row.tuned_deviation()).collect::<Vec<_>>(), output.criteria.each_k)
    };
    let mut document = both(&of(false), &of(true));
    document["sigma"] = json!(same.first().and_then(|sensor| sensor.tuned.as_ref()?.sigma));
    document
}

/// Statistics of the readings that a fit may use and of those held out; null where there are none.
fn both(train: &Deviation, held_out: &Deviation) -> Value {
    let number = |deviation: &Deviation, value: f64| (deviation.count > 0).then_some(value);
    json!({
        "count": train.count,
        "mean": number(train, train.mean),
        "sd": number(train, train.sd),
        "rmse": number(train, train.rmse),
        "max": number(train, train.max),
        "within_limit": number(train, train.within_limit),
        "count_held_out": held_out.count,
        "mean_held_out": number(held_out, held_out.mean),
        "sd_held_out": number(held_out, held_out.sd),
        "rmse_held_out": number(held_out, held_out.rmse),
        "max_held_out": number(held_out, held_out.max),
        "within_limit_held_out": number(held_out, held_out.within_limit),
    })
}
