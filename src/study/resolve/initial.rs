//! How a transient begins: as stated, at its first readings, and whether these agree.

use crate::document::{Diagnostic, Map, Place, Sense, code, suggest};
use crate::expression::{Dimension, Unit};
use crate::math::sort::sort_by;
use crate::measurement::{Initial, Sensor, Uncertain};
use crate::random::Distribution;
use crate::study::pass::measurement::{InitialForm, MeasuredStartForm, OtherNodesForm};
use crate::study::pass::uncertain::UncertainForm;
use crate::thermal::{Network, NodeKind, isolated_nodes_beside};

use super::clocks;
use super::parts::belongs_to;
use super::plausible::short;
use super::scope::Scope;

/// The name that stands for all nodes.
const ALL: &str = "all";
/// Room temperature, K, where a model has no node that stores heat.
const ROOM_K: f64 = 293.15;
/// A start so many standard deviations of a sensor from its first reading is doubtful ...
const DOUBTFUL_SIGMAS: f64 = 5.0;
/// ... where it is this share of the range of the sensor's readings too.
const DOUBTFUL_SHARE: f64 = 0.02;
/// The share where the sensor's noise is not stated.
const DOUBTFUL_SHARE_ALONE: f64 = 0.1;
/// A line through two readings is carried back over so many times the time between them.
const FARTHEST_BACK: f64 = 2.0;
/// Probability of each tail of a prior that a start is not expected in.
const TAIL: f64 = 0.0005;
/// Sensors named in a message.
const NAMED: usize = 4;
/// Standard deviation of a start at a reading, in those of the reading. Wide, as the reading itself takes part in the fit too.
const START_SIGMAS: f64 = 5.0;
/// Standard deviation of a reading whose noise is not stated, K.
const UNSTATED_SIGMA_K: f64 = 1.0;
/// Least standard deviation of a start without a reading, K.
const LEAST_SPREAD_K: f64 = 1.0;
/// Standard deviations between a start without a reading and 0 K, at least.
const ABOVE_ZERO: f64 = 4.0;
/// Starts without a reading that are fitted unasked, at most: each is one more direction of derivatives in every transient.
const MOST_FITTED: usize = 40;

/// A start as far as it is known without the data.
pub enum Stated<'a> {
    /// Without the data.
    Known(Initial),
    /// From the first readings.
    Measured(&'a MeasuredStartForm),
}

/// The readings that a start is held against.
pub struct FirstRows<'a> {
    /// Value of every input of the model in the first row, SI.
    pub inputs: &'a [f64],
    /// Instants, s.
    pub times_s: &'a [f64],
    /// Rows that are left out, with the reason.
    pub ignored: &'a [Option<String>],
    /// Row by row, `rows x sensors`, SI, by the time of the inputs; without those of rows that are left out.
    pub readings: &'a [Option<f64>],
}

impl FirstRows<'_> {
    /// Whether no row is left.
    pub fn are_all_ignored(&self) -> bool {
        self.ignored.iter().all(Option::is_some)
    }

    /// Rows, instants and readings of a sensor.
    fn of(&self, sensor: usize, sensors: usize) -> impl Iterator<Item = (usize, f64, f64)> {
        (self.times_s.iter().enumerate())
            .filter_map(move |(row, time_s)| Some((row, *time_s, self.readings[row * sensors + sensor]?)))
    }

    /// The first reading of a sensor, carried back to the first instant along the line to its second where it comes late;
    /// `None` where it comes so late that the line tells nothing of the start.
    fn at_start(&self, sensor: usize, sensors: usize) -> Option<f64> {
        let begin_s = self.times_s.first().copied().unwrap_or(0.0);
        let mut readings = self.of(sensor, sensors);
        let (_, time_s, reading) = readings.next()?;
        let late_s = time_s - begin_s;
        let Some((_, later_s, later)) = readings.next().filter(|_| late_s > 0.0) else { return Some(reading) };
        let step_s = later_s - time_s;
        (late_s <= FARTHEST_BACK * step_s).then(|| reading - (later - reading) / step_s * late_s)
    }
}

/// The start as written. `None` after an error.
pub fn stated<'a>(
    scope: &mut Scope,
    form: &'a InitialForm,
    (measurement, place): (&str, &Place),
) -> Option<Stated<'a>> {
    let follows = matches!(form, InitialForm::Steady(_) | InitialForm::Periodic(_));
    if follows && scope.starts.iter().any(|start| start.0 == measurement) {
        let message = format!(
            "an adopted effect has a start temperature in `{measurement}`, whose start follows from its inputs"
        );
        scope.error(&code::INITIAL, place, message, "no `starts` for it, or another `initial`");
        return None;
    }
    match form {
        InitialForm::Steady(_) => Some(Stated::Known(Initial::Steady)),
        InitialForm::Periodic(_) => Some(Stated::Known(Initial::Periodic)),
        InitialForm::Temperatures(map) => temperatures(scope, map, (measurement, place)).map(Stated::Known),
        InitialForm::Measured(form) => Some(Stated::Measured(form)),
    }
}

/// The start at the first readings. Nodes with a reading are fitted about it, nodes without one that store heat about where
/// they are expected; what stores nothing is in balance with the others. `None` after an error.
pub fn measured(
    scope: &mut Scope,
    form: &MeasuredStartForm,
    first: &FirstRows,
    sensors: &[Sensor],
    (measurement, place): (&str, &Place),
) -> Option<Initial> {
    let mut given = readings(scope, form, first, sensors)?;
    let before = scope.diagnostics.errors();
    for entry in &form.temperatures {
        let value = scope.uncertain(&entry.value, Dimension::TEMPERATURE, Sense::Absolute, true);
        match scope.resolved.node(&entry.name) {
            Some(node) => given[node] = value,
            None => unknown_node(scope, &entry.name, &entry.name_place, &[]),
        }
    }
    for sensor in sensors {
        // One whose clock is off may show nothing of so short a record.
        if !clocks::is_off(sensor) && stored_node(scope, sensor).is_some_and(|node| given[node].is_none()) {
            let message = format!("`{}` has no reading in the first rows to start at", sensor.name);
            let expected = "more `rows`, a longer `over`, or the node under `temperatures`";
            scope.error(&code::INITIAL, place, message, expected);
        }
    }
    let spread = match &form.others_sd {
        Some(amount) => amount.si(Dimension::TEMPERATURE, None, Sense::Difference, scope.diagnostics),
        None => None,
    };
    if let (Some(amount), Some(spread)) = (&form.others_sd, spread)
        && spread < 0.0
    {
        scope.error(&code::OUT_OF_RANGE, &amount.place, format!("a standard deviation of {spread} K"), "0 K or more");
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    if given.iter().all(Option::is_none) {
        let message = "no sensor measures the temperature of a node to start at";
        scope.error(&code::INITIAL, place, message, "`temperatures`, `steady` or `periodic`");
        return None;
    }
    let expected = without_reading(scope, form, first, &given, place)?;
    let stores = |node: usize| {
        matches!(scope.resolved.model.nodes[node].kind, NodeKind::Diffusion { .. })
            && !scope.given_storage.contains(&node)
    };
    let others: Vec<usize> = (0..given.len()).filter(|&node| given[node].is_none() && stores(node)).collect();
    let is_asked = spread.is_some();
    let spread = spread.unwrap_or_else(|| half_range(scope, &expected, first));
    let is_fitted = spread > 0.0 && (is_asked || others.len() <= MOST_FITTED);
    if !is_fitted && !is_asked {
        let message = format!(
            "{} nodes of `{measurement}` store heat and have no reading at the start: they begin where they are expected, and \
             are not fitted",
            others.len()
        );
        let help = "`\"others_sd\": {\"value\": 5, \"unit\": \"K\"}` fits them within so many kelvin";
        scope.doubts.push(Diagnostic::warning(&code::START_ASSUMED, place, message).help(help));
    }
    let is_near = matches!(form.others, Some(OtherNodesForm::Nearest(_)));
    let mut balanced = Vec::new();
    let mut values = Vec::with_capacity(given.len());
    for (node, value) in given.into_iter().enumerate() {
        let at = expected[node];
        let sd = spread.min(at / ABOVE_ZERO);
        values.push(match value.or_else(|| of_effect(scope, measurement, node)) {
            Some(value) => value,
            None if others.contains(&node) && is_fitted => Uncertain::Inferred(normal(at, sd)),
            None => {
                if !(is_near && others.contains(&node)) {
                    balanced.push(node);
                }
                Uncertain::Known(at)
            }
        });
    }
    Some(Initial::Temperatures { values, shared: Vec::new(), balanced })
}

/// By node the start about its first reading. `None` after an error.
fn readings(
    scope: &mut Scope,
    form: &MeasuredStartForm,
    first: &FirstRows,
    sensors: &[Sensor],
) -> Option<Vec<Option<Uncertain>>> {
    let is_first = first_rows(scope, form, first)?;
    // By node: mean over its sensors, their number, the widest standard deviation.
    let mut means: Vec<(f64, f64, f64)> = vec![(0.0, 0.0, 0.0); scope.resolved.model.nodes.len()];
    for (position, sensor) in sensors.iter().enumerate() {
        let Some(node) = stored_node(scope, sensor) else { continue };
        let readings: Vec<f64> = (first.of(position, sensors.len()))
            .filter(|(row, time_s, _)| is_first(*row, *time_s))
            .map(|(_, _, reading)| reading)
            .collect();
        if readings.is_empty() {
            continue;
        }
        let nominal = |value: &Option<Uncertain>| value.as_ref().map(Uncertain::nominal);
        let reading = readings.iter().sum::<f64>() / readings.len() as f64 - nominal(&sensor.bias).unwrap_or(0.0);
        // A mean over rows that move is not the first of them, and a late reading is not the start.
        let start = first.at_start(position, sensors.len()).unwrap_or(readings[0]);
        let moved = readings.iter().fold(0.0, |most: f64, other| most.max((other - start).abs()));
        let bias_sd = match &sensor.bias {
            Some(bias) => bias.prior().map_or(0.0, |prior| prior.quantile(0.84) - prior.quantile(0.5)),
            None => 0.0,
        };
        let sigma = match nominal(&sensor.sigma) {
            Some(sigma) => root_of_squares(&[sigma, nominal(&sensor.white).unwrap_or(0.0)]),
            None => UNSTATED_SIGMA_K,
        };
        let unknown = clocks::unknown_at_start(first.times_s, sensors, first.readings, position);
        let sd = root_of_squares(&[START_SIGMAS * sigma, bias_sd, moved, unknown]);
        let (mean, count, widest) = &mut means[node];
        *count += 1.0;
        *mean += (reading - *mean) / *count;
        *widest = widest.max(sd);
    }
    let start = |(mean, count, sd): (f64, f64, f64)| {
        let sd = sd.min(mean / ABOVE_ZERO);
        let value = if sd > 0.0 { Uncertain::Inferred(normal(mean, sd)) } else { Uncertain::Known(mean) };
        (count > 0.0).then_some(value)
    };
    Some(means.into_iter().map(start).collect())
}

fn root_of_squares(parts: &[f64]) -> f64 {
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn normal(mean: f64, sd: f64) -> Distribution {
    Distribution::Normal { mean, sd, lower: None, upper: None }
}

/// Where every node is expected at the start, K: those given as given, the others nearest to them or in balance with them at
/// the nominal parameters. `None` after an error.
fn without_reading(
    scope: &mut Scope,
    form: &MeasuredStartForm,
    first: &FirstRows,
    given: &[Option<Uncertain>],
    place: &Place,
) -> Option<Vec<f64>> {
    let nominal: Vec<Option<f64>> = given.iter().map(|value| value.as_ref().map(Uncertain::nominal)).collect();
    let filled = nearest(scope, &nominal);
    if matches!(form.others, Some(OtherNodesForm::Nearest(_))) {
        let stores = |node: usize| matches!(scope.resolved.model.nodes[node].kind, NodeKind::Diffusion { .. });
        let lost: Vec<String> = (0..filled.len())
            .filter(|&node| filled[node].is_none() && stores(node))
            .map(|node| scope.resolved.model.nodes[node].name.clone())
            .collect();
        without_path(scope, lost, place)?;
        return Some(filled.into_iter().map(|value| value.unwrap_or(ROOM_K)).collect());
    }
    let held: Vec<bool> = nominal.iter().map(Option::is_some).collect();
    let lost = isolated_nodes_beside(&scope.resolved.model, &held);
    without_path(scope, lost.unwrap_or_default(), place)?;
    let nominal_temperatures = || nominal.iter().flatten();
    let mean = nominal_temperatures().sum::<f64>() / nominal_temperatures().count().max(1) as f64;
    let guesses: Vec<f64> = filled.into_iter().map(|value| value.unwrap_or(mean)).collect();
    Some(balance(scope, &guesses, &held, first.inputs).unwrap_or(guesses))
}

/// The balance of the nodes that are not held with those that are, at nominal parameters; none where it cannot be found.
fn balance(scope: &Scope, guesses: &[f64], held: &[bool], inputs: &[f64]) -> Option<Vec<f64>> {
    let network = Network::compile(&scope.resolved.model, &[]).ok()?;
    let mut workspace = network.workspace();
    network.set_inputs(&mut workspace, inputs);
    network.solve_held(&mut workspace, guesses, held).ok()?;
    Some(workspace.temperatures().to_vec())
}

/// Half of the range of the start temperatures and of the boundaries that inputs set, K.
fn half_range(scope: &Scope, expected: &[f64], first: &FirstRows) -> f64 {
    let set = (scope.resolved.model.inputs.iter().zip(first.inputs)).filter_map(|(input, value)| {
        let is_temperature = Unit::parse(&input.unit).is_ok_and(|unit| unit.dimension == Dimension::TEMPERATURE);
        is_temperature.then_some(*value)
    });
    let stored = (scope.resolved.model.nodes.iter().zip(expected))
        .filter(|(node, _)| !matches!(node.kind, NodeKind::Boundary { .. }))
        .map(|(_, value)| *value);
    let (low, high) = (stored.chain(set))
        .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), value| (low.min(value), high.max(value)));
    (0.5 * (high - low)).max(LEAST_SPREAD_K)
}

/// Which rows, at which instants, are the first; reported where that is not well said.
fn first_rows(
    scope: &mut Scope,
    form: &MeasuredStartForm,
    first: &FirstRows,
) -> Option<Box<dyn Fn(usize, f64) -> bool>> {
    let begin_s = first.times_s.first().copied().unwrap_or(0.0);
    match (&form.rows, &form.over) {
        (Some(rows), Some(_)) => {
            let message = "a start at the first readings has `rows` and `over`";
            scope.error(&code::INITIAL, &rows.place, message, "one of the two");
            None
        }
        (Some(rows), None) => {
            let most = first.times_s.len() as u64;
            if rows.value == 0 || rows.value > most {
                let message = format!("{} of {most} rows", rows.value);
                scope.error(&code::OUT_OF_RANGE, &rows.place, message, &format!("from 1 to {most}"));
                return None;
            }
            let rows = rows.value;
            Some(Box::new(move |row, _| (row as u64) < rows))
        }
        (None, Some(over)) => {
            let over_s = scope.seconds(over)?;
            if over_s < 0.0 {
                scope.error(&code::OUT_OF_RANGE, &over.place, format!("a time of {over_s} s"), "0 s or more");
                return None;
            }
            Some(Box::new(move |_, time_s| time_s - begin_s <= over_s))
        }
        (None, None) => Some(Box::new(|row, _| row == 0)),
    }
}

fn without_path(scope: &mut Scope, lost: Vec<String>, place: &Place) -> Option<()> {
    if lost.is_empty() {
        return Some(());
    }
    let listed = suggest::listed(lost.iter().map(String::as_str), 8);
    let message = format!("no start temperature of {listed}: no path joins them to a node with a reading");
    scope.error(&code::INITIAL, place, message, "their temperatures under `\"measured\": {\"temperatures\": {...}}`");
    None
}

/// The node that is no boundary and whose temperature a sensor measures.
fn stored_node(scope: &Scope, sensor: &Sensor) -> Option<usize> {
    let model = &scope.resolved.model;
    let node = model.node_of(sensor.quantity)?;
    (!matches!(model.nodes[node].kind, NodeKind::Boundary { .. })).then_some(node)
}

/// The given temperatures, and for the other nodes the mean of those given that are the fewest elements away; none
/// where no path leads to one.
fn nearest(scope: &Scope, given: &[Option<f64>]) -> Vec<Option<f64>> {
    let model = &scope.resolved.model;
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); given.len()];
    for pair in model.elements.iter().flat_map(|element| element.physics().joined().windows(2)) {
        neighbours[pair[0]].push(pair[1]);
        neighbours[pair[1]].push(pair[0]);
    }
    let from = |start: usize| {
        let mut seen = vec![false; given.len()];
        seen[start] = true;
        let mut front = vec![start];
        while !front.is_empty() {
            let given_temperatures: Vec<f64> = front.iter().filter_map(|&node| given[node]).collect();
            if !given_temperatures.is_empty() {
                return Some(given_temperatures.iter().sum::<f64>() / given_temperatures.len() as f64);
            }
            let mut next = Vec::new();
            for &other in front.iter().flat_map(|&node| &neighbours[node]) {
                if !seen[other] {
                    seen[other] = true;
                    next.push(other);
                }
            }
            front = next;
        }
        None
    };
    (0..given.len()).map(from).collect()
}

/// Compares the first readings with the starts of the nodes that they measure: a start far from them is doubtful.
pub fn compare(
    scope: &mut Scope,
    measurement: &str,
    place: &Place,
    initial: &Initial,
    first: &FirstRows,
    sensors: &[Sensor],
) {
    let Initial::Temperatures { values, .. } = initial else { return };
    let mut apart: Vec<(f64, String)> = Vec::new();
    for (position, sensor) in sensors.iter().enumerate() {
        let Some(node) = stored_node(scope, sensor) else { continue };
        if !matches!(scope.resolved.model.nodes[node].kind, NodeKind::Diffusion { .. }) {
            continue;
        }
        // What a clock that is behind shows first is no start.
        if clocks::is_behind(sensor) {
            continue;
        }
        let Some(reading) = first.at_start(position, sensors.len()) else { continue };
        let mut range = (reading, reading);
        for (_, _, value) in first.of(position, sensors.len()) {
            range = (range.0.min(value), range.1.max(value));
        }
        let Some([low, high]) = values.get(node).and_then(expected) else { continue };
        let [low_bias, high_bias] = sensor.bias.as_ref().map_or(Some([0.0; 2]), expected).unwrap_or_default();
        let difference = reading - reading.clamp(low + low_bias, (high + high_bias).max(low + low_bias));
        let noise = |value: &Option<Uncertain>| value.as_ref().map(Uncertain::nominal);
        let (sigma, share) = match noise(&sensor.sigma) {
            Some(sigma) => (sigma + noise(&sensor.white).unwrap_or(0.0), DOUBTFUL_SHARE),
            None => (0.0, DOUBTFUL_SHARE_ALONE),
        };
        if difference.abs() > (DOUBTFUL_SIGMAS * sigma).max(share * (range.1 - range.0)) {
            let side = if difference > 0.0 { "above" } else { "below" };
            apart.push((difference.abs(), format!("`{}` {} K {side}", sensor.name, short(difference.abs()))));
        }
    }
    if apart.is_empty() {
        return;
    }
    sort_by(&mut apart, |a, b| b.0.total_cmp(&a.0));
    let mut named: Vec<String> = apart.iter().take(NAMED).map(|(_, words)| words.clone()).collect();
    if apart.len() > NAMED {
        named.push(format!("{} more", apart.len() - NAMED));
    }
    let message =
        format!("the first readings of `{measurement}` lie apart from its start temperatures: {}", named.join(", "));
    let help = "\"initial\": {\"measured\": {}} starts at the first readings, or a start temperature is fitted, with a `prior`; a sensor \
                that is off looks the same, and then the start stays as it is";
    scope.doubts.push(Diagnostic::warning(&code::START_APART, place, message).help(help));
}

/// Where a value is expected: the ends of its prior's interval; nothing is said of a parameter.
fn expected(value: &Uncertain) -> Option<[f64; 2]> {
    match value {
        Uncertain::Known(value) | Uncertain::Inferred(Distribution::Fixed(value)) => Some([*value; 2]),
        Uncertain::Inferred(prior) | Uncertain::InferredFrom { prior, .. } => {
            Some([prior.quantile(TAIL), prior.quantile(1.0 - TAIL)])
        }
        Uncertain::Parameter { .. } => None,
    }
}

fn unknown_node(scope: &mut Scope, name: &str, place: &Place, more: &[&str]) {
    let nodes: Vec<String> = scope.resolved.model.nodes.iter().map(|node| node.name.clone()).collect();
    let listed_names: Vec<&str> = more.iter().copied().chain(nodes.iter().map(String::as_str)).collect();
    scope.unknown(&code::UNKNOWN_NAME, "node", name, place, &listed_names);
}

/// The start of a node that an adopted effect adds to a measurement, where the effect states it.
fn of_effect(scope: &Scope, measurement: &str, node: usize) -> Option<Uncertain> {
    let is_here = |start: &&(String, usize, Uncertain)| belongs_to(measurement, &start.0) && start.1 == node;
    scope.starts.iter().find(is_here).map(|start| start.2.clone())
}

fn temperatures(scope: &mut Scope, map: &Map<UncertainForm>, (measurement, place): (&str, &Place)) -> Option<Initial> {
    let before = scope.diagnostics.errors();
    let mut all = None;
    let mut named: Vec<Option<Uncertain>> = vec![None; scope.resolved.model.nodes.len()];
    for entry in map {
        let value = scope.uncertain(&entry.value, Dimension::TEMPERATURE, Sense::Absolute, true);
        if entry.name == ALL {
            all = value;
        } else if let Some(node) = scope.resolved.model.nodes.iter().position(|node| node.name == entry.name) {
            named[node] = value;
        } else {
            unknown_node(scope, &entry.name, &entry.name_place, &[ALL]);
        }
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    for &(node, host) in &scope.hosts {
        if named[node].is_none() {
            named[node] = of_effect(scope, measurement, node).or_else(|| named[host].clone());
        }
    }
    // What stores no heat as the model is written follows from the others at the start, whatever an effect adds to it.
    let mut balanced: Vec<usize> = (0..named.len())
        .filter(|&node| {
            let kind = scope.resolved.model.nodes[node].kind;
            let stores_nothing = matches!(kind, NodeKind::Arithmetic) || scope.given_storage.contains(&node);
            stores_nothing && named[node].is_none() && all.is_none()
        })
        .collect();
    for &(node, host) in &scope.hosts {
        if balanced.contains(&host) && named[node].is_none() && !balanced.contains(&node) {
            balanced.push(node);
        }
    }
    let lacks = |&node: &usize| {
        let stores = matches!(scope.resolved.model.nodes[node].kind, NodeKind::Diffusion { .. });
        stores && named[node].is_none() && all.is_none() && !balanced.contains(&node)
    };
    let lacking: Vec<&str> =
        (0..named.len()).filter(lacks).map(|node| scope.resolved.model.nodes[node].name.as_str()).collect();
    if !lacking.is_empty() {
        let message = format!("no start temperature of {}", suggest::listed(lacking.iter().copied(), 8));
        let place = map.iter().next().map_or(place, |entry| &entry.name_place).clone();
        scope.error(&code::INITIAL, &place, message, "a temperature for each, or `all`");
        return None;
    }
    // Nodes without storage follow from the others at once; what stands here is where their solution starts.
    let any = all.clone().or_else(|| named.iter().flatten().next().cloned());
    let start = any.map_or(ROOM_K, |value| value.nominal());
    let shared = (0..named.len()).filter(|&node| all.is_some() && named[node].is_none()).collect();
    let values = named
        .into_iter()
        .map(|temperature| temperature.or_else(|| all.clone()).unwrap_or(Uncertain::Known(start)))
        .collect();
    Some(Initial::Temperatures { values, shared, balanced })
}
