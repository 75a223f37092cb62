//! How a transient begins: as stated, at its first readings, and whether these agree.

use crate::document::{Amount, Diagnostic, Map, Place, Sense, code, suggest};
use crate::expression::Dimension;
use crate::inference::measurement::{Initial, Sensor, Uncertain};
use crate::random::Distribution;
use crate::study::pass::measurement::{InitialForm, MeasuredStartForm, OtherNodesForm};
use crate::study::pass::uncertain::UncertainForm;
use crate::thermal::{NodeKind, island_beside, joined};

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
/// Probability of each tail of a prior that a start is not expected in.
const TAIL: f64 = 0.0005;
/// Sensors named in a message.
const NAMED: usize = 4;

/// A start as far as it is known without the data.
pub enum Stated<'a> {
    /// Without the data.
    Known(Initial),
    /// From the first readings.
    Measured(&'a MeasuredStartForm),
}

/// The readings that a start is held against.
pub struct FirstRows<'a> {
    /// Instants, s.
    pub times_s: &'a [f64],
    /// Rows that are left out, with the reason.
    pub ignored: &'a [Option<String>],
    /// Row by row, `rows x sensors`, SI.
    pub readings: &'a [Option<f64>],
}

impl FirstRows<'_> {
    /// Instants and readings of a sensor in the rows that are not left out.
    fn of(&self, sensor: usize, sensors: usize) -> impl Iterator<Item = (usize, f64, f64)> {
        (self.times_s.iter().enumerate())
            .filter(|(row, _)| self.ignored[*row].is_none())
            .filter_map(move |(row, time_s)| Some((row, *time_s, self.readings[row * sensors + sensor]?)))
    }
}

/// The start as written. `None` after an error.
pub fn stated<'a>(scope: &mut Scope, form: &'a InitialForm, place: &Place) -> Option<Stated<'a>> {
    match form {
        InitialForm::Steady(_) => Some(Stated::Known(Initial::Steady)),
        InitialForm::Periodic(_) => Some(Stated::Known(Initial::Periodic)),
        InitialForm::Temperatures(map) => temperatures(scope, map, place).map(Stated::Known),
        InitialForm::Measured(form) => Some(Stated::Measured(form)),
    }
}

/// The start at the first readings. `None` after an error.
pub fn measured(
    scope: &mut Scope,
    form: &MeasuredStartForm,
    first: &FirstRows,
    sensors: &[Sensor],
    place: &Place,
) -> Option<Initial> {
    let is_first = first_rows(scope, form, first)?;
    let nodes = scope.resolved.model.nodes.len();
    let mut given: Vec<Option<f64>> = vec![None; nodes];
    let mut counts = vec![0.0; nodes];
    let mut silent: Vec<&str> = Vec::new();
    for (position, sensor) in sensors.iter().enumerate() {
        let Some(node) = stored_node(scope, sensor) else { continue };
        let readings: Vec<f64> = (first.of(position, sensors.len()))
            .filter(|(row, time_s, _)| is_first(*row, *time_s))
            .map(|(_, _, reading)| reading)
            .collect();
        if readings.is_empty() {
            silent.push(&sensor.name);
            continue;
        }
        let bias = sensor.bias.as_ref().map_or(0.0, Uncertain::nominal);
        let reading = readings.iter().sum::<f64>() / readings.len() as f64 - bias;
        // Several sensors of one node: their mean.
        counts[node] += 1.0;
        let before = given[node].unwrap_or(0.0);
        given[node] = Some(before + (reading - before) / counts[node]);
    }
    let before = scope.diagnostics.errors();
    for entry in &form.temperatures {
        let value = entry.value.si(Dimension::TEMPERATURE, None, Sense::Absolute, scope.diagnostics);
        let Some(node) = scope.resolved.node(&entry.name) else {
            unknown_node(scope, &entry.name, &entry.name_place, &[]);
            continue;
        };
        if let Some(value) = value.filter(|value| above_zero(scope, &entry.value, *value)) {
            given[node] = Some(value);
        }
    }
    for sensor in sensors.iter().filter(|sensor| silent.contains(&sensor.name.as_str())) {
        if stored_node(scope, sensor).is_some_and(|node| given[node].is_none()) {
            let message = format!("`{}` has no reading in the first rows to start at", sensor.name);
            let expected = "more `rows`, a longer `over`, or the node under `temperatures`";
            scope.error(&code::INITIAL, place, message, expected);
        }
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    if given.iter().all(Option::is_none) {
        let message = "no sensor measures the temperature of a node to start at";
        scope.error(&code::INITIAL, place, message, "`temperatures`, `steady` or `periodic`");
        return None;
    }
    let held: Vec<bool> = given.iter().map(Option::is_some).collect();
    let filled = nearest(scope, &given);
    if matches!(form.others, Some(OtherNodesForm::Nearest(_))) {
        let stores = |node: usize| matches!(scope.resolved.model.nodes[node].kind, NodeKind::Diffusion { .. });
        let lost: Vec<String> = (0..nodes)
            .filter(|&node| filled[node].is_none() && stores(node))
            .map(|node| scope.resolved.model.nodes[node].name.clone())
            .collect();
        without_path(scope, lost, place)?;
        let values = filled.into_iter().map(|value| Uncertain::Known(value.unwrap_or(ROOM_K))).collect();
        return Some(Initial::Temperatures { values, shared: Vec::new(), balanced: Vec::new() });
    }
    let lost = island_beside(&scope.resolved.model, &held);
    without_path(scope, lost.unwrap_or_default(), place)?;
    let count = given.iter().flatten().count() as f64;
    let mean = given.iter().flatten().sum::<f64>() / count;
    let temperatures = filled.into_iter().map(|value| value.unwrap_or(mean)).collect();
    Some(Initial::Measured { temperatures, held })
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
    for pair in model.elements.iter().flat_map(|element| joined(&element.kind).windows(2)) {
        neighbours[pair[0]].push(pair[1]);
        neighbours[pair[1]].push(pair[0]);
    }
    let from = |start: usize| {
        let mut seen = vec![false; given.len()];
        seen[start] = true;
        let mut front = vec![start];
        while !front.is_empty() {
            let found: Vec<f64> = front.iter().filter_map(|&node| given[node]).collect();
            if !found.is_empty() {
                return Some(found.iter().sum::<f64>() / found.len() as f64);
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
    let begin_s = first.times_s.first().copied().unwrap_or(0.0);
    let mut apart: Vec<(f64, String)> = Vec::new();
    for (position, sensor) in sensors.iter().enumerate() {
        let Some(node) = stored_node(scope, sensor) else { continue };
        if !matches!(scope.resolved.model.nodes[node].kind, NodeKind::Diffusion { .. }) {
            continue;
        }
        let mut readings = first.of(position, sensors.len());
        let Some((_, time_s, mut reading)) = readings.next() else { continue };
        let second = readings.next();
        if let Some((_, later_s, later)) = second.filter(|_| time_s > begin_s) {
            reading -= (later - reading) / (later_s - time_s) * (time_s - begin_s);
        }
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
    apart.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut named: Vec<String> = apart.iter().take(NAMED).map(|(_, words)| words.clone()).collect();
    if apart.len() > NAMED {
        named.push(format!("{} more", apart.len() - NAMED));
    }
    let message =
        format!("the first readings of `{measurement}` lie apart from its start temperatures: {}", named.join(", "));
    let help = "\"initial\": {\"measured\": {}} starts at the first readings; a start temperature may also be fitted, with a \
                `prior`";
    scope.doubts.push(Diagnostic::warning(&code::START_APART, place, message).help(help));
}

/// Where a value is expected: the ends of its prior's interval; nothing is said of a parameter.
fn expected(value: &Uncertain) -> Option<[f64; 2]> {
    match value {
        Uncertain::Known(value) | Uncertain::Inferred(Distribution::Fixed(value)) => Some([*value; 2]),
        Uncertain::Inferred(prior) => Some([prior.quantile(TAIL), prior.quantile(1.0 - TAIL)]),
        Uncertain::Parameter { .. } => None,
    }
}

fn above_zero(scope: &mut Scope, amount: &Amount, value: f64) -> bool {
    if value <= 0.0 {
        scope.error(&code::OUT_OF_RANGE, &amount.place, format!("a start of {value} K"), "a temperature above 0 K");
    }
    value > 0.0
}

fn unknown_node(scope: &mut Scope, name: &str, place: &Place, more: &[&str]) {
    let nodes: Vec<String> = scope.resolved.model.nodes.iter().map(|node| node.name.clone()).collect();
    let known: Vec<&str> = more.iter().copied().chain(nodes.iter().map(String::as_str)).collect();
    scope.unknown(&code::UNKNOWN_NAME, "node", name, place, &known);
}

fn temperatures(scope: &mut Scope, map: &Map<UncertainForm>, place: &Place) -> Option<Initial> {
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
            named[node] = named[host].clone();
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
    let values = named.into_iter().map(|own| own.or_else(|| all.clone()).unwrap_or(Uncertain::Known(start))).collect();
    Some(Initial::Temperatures { values, shared, balanced })
}
