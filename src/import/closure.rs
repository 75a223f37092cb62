//! The proof of an import: the temperatures that the other tool computed, put into the network that was made of its
//! deck. What was read whole balances; what was left out shows as heat that is missing, at its node.
//!
//! Steady results, and arithmetic nodes at every instant, balance by themselves. A node that stores heat in a transient
//! balances with `C dT/dt`, whose slope is known from the rows alone: half the difference between the slopes before and
//! behind a row is allowed for there, and what the rounding of the printed temperatures does to the slope.

use serde::Serialize;

use crate::math::sort::sort_by;
use crate::measurement::Rows;
use crate::study::Pass;
use crate::thermal::{Model, Network, NetworkError, NodeKind};

use super::DECK_RESULT;
use super::study::{DeckResult, ImportedStudy};

/// Most rows that are put into the network.
const MOST_ROWS: usize = 2000;
/// What a node may miss in any case, K: the tolerance to which thermal solvers iterate where nothing else is said (ESATAN's
/// RELXCA, 0.01).
const SOLVERS_K: f64 = 0.01;
/// Nodes that are printed.
const MOST_PRINTED: usize = 20;

/// How well a record balances in the network.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Closure {
    /// Whether the rows are steady results.
    pub is_steady: bool,
    /// Rows that were put into the network.
    pub rows: usize,
    /// The step of the printed temperatures, K: what rounding alone leaves of a node's imbalance is no larger.
    pub step_k: f64,
    /// What a node may miss, K: that step, or what solvers iterate to where it is finer.
    pub tolerance_k: f64,
    /// Nodes, the worst first.
    pub nodes: Vec<NodeClosure>,
    /// Nodes that cannot be judged: the record lacks their temperature or that of a neighbour.
    pub not_judged: Vec<String>,
    /// The boundary whose temperature differs most from the record's, with the largest difference, K.
    pub worst_boundary: Option<(String, f64)>,
}

/// How well a node balances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NodeClosure {
    /// The node.
    pub node: String,
    /// Net heat into it at the worst row, W; of a node that stores heat in a transient less `C dT/dt`.
    pub imbalance_w: f64,
    /// The same divided by the conductances that meet at the node, radiation linearised, K: how far the node is from its
    /// balance with its neighbours. `None` where nothing conducts.
    pub imbalance_k: Option<f64>,
    /// Mean of the net heat over the rows, W.
    pub mean_w: f64,
    /// The worst row: a phase, or an instant in s.
    pub at: String,
    /// What the uncertain slope over time explains of it, W.
    pub allowed_w: f64,
    /// What is probably left out there.
    pub hint: Option<String>,
}

impl NodeClosure {
    /// Whether a tolerance explains the imbalance: half a step of the printed temperatures at the node and half a step at
    /// its neighbours move the balance by at most a step times the conductances that meet at the node.
    pub fn closes(&self, tolerance_k: f64) -> bool {
        match self.unexplained_k() {
            Some(kelvin) => kelvin <= tolerance_k,
            None => self.imbalance_w == 0.0,
        }
    }

    /// What an uncertain slope does not explain of the imbalance, K.
    fn unexplained_k(&self) -> Option<f64> {
        let share = (1.0 - self.allowed_w / self.imbalance_w.abs()).max(0.0);
        self.imbalance_k.map(|kelvin| if self.imbalance_w == 0.0 { 0.0 } else { kelvin.abs() * share })
    }
}

/// A node on the way through the rows.
#[derive(Clone, Copy, Default)]
struct Tally {
    worst_w: f64,
    worst_k: Option<f64>,
    allowed_w: f64,
    row: usize,
    sum_w: f64,
    rows: usize,
}

impl Tally {
    fn add(&mut self, heat_w: f64, allowed_w: f64, conductance: f64, row: usize) {
        let kelvin = (conductance > 0.0).then(|| heat_w / conductance);
        // Conductances change little from row to row: what is worst in W is so in K.
        if self.rows == 0 || heat_w.abs() - allowed_w > self.worst_w.abs() - self.allowed_w {
            (self.worst_w, self.worst_k, self.allowed_w, self.row) = (heat_w, kelvin, allowed_w, row);
        }
        self.sum_w += heat_w;
        self.rows += 1;
    }
}

/// The rows of the measurement: the inputs of each, SI, and what it is called.
struct InputRows {
    is_steady: bool,
    inputs: Vec<Vec<f64>>,
    labels: Vec<String>,
}

impl InputRows {
    /// Those of the measurement of the deck's results.
    fn of(pass: &Pass) -> Option<Self> {
        let measurement = pass.measurements.iter().find(|measurement| measurement.name == DECK_RESULT)?;
        Some(match &measurement.rows {
            Rows::Steady(phases) => Self {
                is_steady: true,
                inputs: phases.iter().map(|phase| phase.inputs.clone()).collect(),
                labels: phases.iter().map(|phase| phase.name.clone()).collect(),
            },
            Rows::Transient { inputs: table, .. } => {
                let row = |position: usize| {
                    let mut row = table.base.clone();
                    for column in &table.columns {
                        row[column.input] = column.values[position];
                    }
                    row
                };
                Self {
                    is_steady: false,
                    inputs: (0..table.times_s.len()).map(row).collect(),
                    labels: table.times_s.iter().map(|time_s| format!("{time_s} s")).collect(),
                }
            }
        })
    }
}

/// The closure of a record in the study that was made of its deck, as it was loaded; nothing without a record.
///
/// # Errors
/// A model that cannot be compiled.
pub fn closure(study: &ImportedStudy, pass: &Pass) -> Result<Option<Closure>, NetworkError> {
    let (Some(result), Some(rows)) = (&study.result, InputRows::of(pass)) else { return Ok(None) };
    let model = &pass.model;
    let network = Network::compile(model, &[])?;
    let mut workspace = network.workspace();
    // By node of the model, the position in the result.
    let positions: Vec<Option<usize>> = (model.nodes.iter())
        .map(|node| result.nodes.iter().position(|entry| entry.name == node.name))
        .map(|position| position.filter(|&entry| is_complete(&result.nodes[entry].temperatures_k)))
        .collect();
    let judged = judged(model, &positions);
    let temperature = |node: usize, row: usize| {
        positions[node].and_then(|entry| result.nodes[entry].temperatures_k.get(row).copied())
    };
    let count = rows.inputs.len().min(result.times_s.len());
    let stride = count.div_ceil(MOST_ROWS).max(1);
    let mut tallies = vec![Tally::default(); model.nodes.len()];
    let mut worst_boundary: Option<(usize, f64)> = None;
    let mut rows_done = 0;
    for row in (0..count).step_by(stride) {
        rows_done += 1;
        let of_row: Vec<f64> = (0..model.nodes.len()).map(|node| temperature(node, row).unwrap_or(f64::NAN)).collect();
        network.set_time(&mut workspace, if rows.is_steady { 0.0 } else { result.times_s[row] });
        network.set_inputs(&mut workspace, &rows.inputs[row]);
        network.set_temperatures(&mut workspace, &of_row);
        for (node, entry) in model.nodes.iter().enumerate() {
            let NodeKind::Boundary { .. } = entry.kind else { continue };
            let difference = (workspace.temperatures()[node] - of_row[node]).abs();
            if worst_boundary.map_or(difference > 0.0, |(_, worst)| difference > worst) {
                worst_boundary = Some((node, difference));
            }
        }
        let conductances = network.node_conductances(&mut workspace);
        let now = network.node_heat(&mut workspace);
        // A held input jumps at its row: the slope there is between those before and behind it.
        let before = (result.held && row > 0).then(|| {
            network.set_inputs(&mut workspace, &rows.inputs[row - 1]);
            network.set_temperatures(&mut workspace, &of_row);
            network.node_heat(&mut workspace)
        });
        for (position, entry) in now.iter().enumerate().filter(|(_, entry)| judged[entry.node]) {
            let (heat_w, allowed_w) = match entry.capacity_j_per_k.filter(|_| !rows.is_steady) {
                None => (entry.heat_w, 0.0),
                Some(capacity) => {
                    let instants = |row: usize| Some((*result.times_s.get(row)?, temperature(entry.node, row)?));
                    let neighbours = [row.checked_sub(1).and_then(instants), instants(row), instants(row + 1)];
                    let Some((slope, uncertainty)) = slope(neighbours, result.step_k) else { continue };
                    let mean =
                        before.as_ref().map_or(entry.heat_w, |before| 0.5 * (entry.heat_w + before[position].heat_w));
                    (mean - capacity * slope, capacity * uncertainty)
                }
            };
            tallies[entry.node].add(heat_w, allowed_w, conductances[entry.node], row);
        }
    }
    let name = |node: usize| model.nodes[node].name.clone();
    let is_inner = |node: &usize| !matches!(model.nodes[*node].kind, NodeKind::Boundary { .. });
    let has_rows = |node: &usize| tallies[*node].rows > 0;
    let mut nodes: Vec<NodeClosure> = (0..model.nodes.len())
        .filter(|node| is_inner(node) && has_rows(node))
        .map(|node| {
            let tally = tallies[node];
            NodeClosure {
                node: name(node),
                imbalance_w: tally.worst_w,
                imbalance_k: tally.worst_k,
                mean_w: tally.sum_w / tally.rows as f64,
                at: rows.labels[tally.row].clone(),
                allowed_w: tally.allowed_w,
                hint: None,
            }
        })
        .collect();
    let size = |entry: &NodeClosure| entry.unexplained_k().unwrap_or(f64::INFINITY);
    sort_by(&mut nodes, |a, b| size(b).total_cmp(&size(a)).then(b.imbalance_w.abs().total_cmp(&a.imbalance_w.abs())));
    let tolerance_k = result.step_k.max(SOLVERS_K);
    for entry in nodes.iter_mut().filter(|entry| !entry.closes(tolerance_k)) {
        entry.hint = hint(entry, result);
    }
    Ok(Some(Closure {
        is_steady: rows.is_steady,
        rows: rows_done,
        step_k: result.step_k,
        tolerance_k,
        nodes,
        not_judged: (0..model.nodes.len()).filter(|node| is_inner(node) && !has_rows(node)).map(name).collect(),
        worst_boundary: worst_boundary.map(|(node, difference)| (name(node), difference)),
    }))
}

/// Whether a node has a temperature in every row.
fn is_complete(temperatures_k: &[f64]) -> bool {
    !temperatures_k.is_empty() && temperatures_k.iter().all(|value| value.is_finite() && *value > 0.0)
}

/// Nodes whose own temperature is known and that of all others that their elements touch.
fn judged(model: &Model, positions: &[Option<usize>]) -> Vec<bool> {
    let is_known: Vec<bool> = (model.nodes.iter().zip(positions))
        .map(|(node, position)| position.is_some() || matches!(node.kind, NodeKind::Boundary { .. }))
        .collect();
    let mut judged = is_known.clone();
    for element in &model.elements {
        let nodes = element.nodes();
        if nodes.iter().any(|&node| !is_known[node]) {
            nodes.into_iter().for_each(|node| judged[node] = false);
        }
    }
    judged
}

/// The slope of a parabola through three points at the one in the middle, and half the difference of the slopes before and
/// behind it, with what half a step of the printed temperatures at each of the points does to it; nothing where a point is
/// missing.
fn slope(points: [Option<(f64, f64)>; 3], step_k: f64) -> Option<(f64, f64)> {
    let [Some((t0, y0)), Some((t1, y1)), Some((t2, y2))] = points else { return None };
    let (before, after) = (t1 - t0, t2 - t1);
    let (rise_before, rise_after) = ((y1 - y0) / before, (y2 - y1) / after);
    let whole = before + after;
    let slope = (rise_before * after + rise_after * before) / whole;
    let weights = [after / (before * whole), (before - after).abs() / (before * after), before / (after * whole)];
    let rounding = 0.5 * step_k * (weights[0] + weights[1] + weights[2]);
    Some((slope, 0.5 * (rise_after - rise_before).abs() + rounding))
}

/// What is probably left out at a node: what the reader noted of it, else what the sign says.
fn hint(entry: &NodeClosure, result: &DeckResult) -> Option<String> {
    let node = result.nodes.iter().find(|node| node.name == entry.node)?;
    if let Some(note) = &node.note {
        return Some(note.clone());
    }
    Some(if entry.imbalance_w > 0.0 {
        "a path that takes heat out, such as a fluid node or a user-defined conductor".to_owned()
    } else {
        "heat that comes in, such as a load, a fluid node, a heater or a user-defined conductor".to_owned()
    })
}

impl Closure {
    /// Nodes that balance within the rounding of the printed temperatures.
    pub fn closing(&self) -> usize {
        self.nodes.iter().filter(|entry| entry.closes(self.tolerance_k)).count()
    }

    /// Rows of a table: heading first, the nodes that do not close, the worst first.
    pub fn table(&self) -> Vec<Vec<String>> {
        let mut rows = vec![["node", "imbalance [W]", "[K]", "at", "probably left out"].map(str::to_owned).to_vec()];
        for entry in self.nodes.iter().filter(|entry| !entry.closes(self.tolerance_k)).take(MOST_PRINTED) {
            let kelvin = entry.imbalance_k.map_or("-".to_owned(), |value| format!("{value:+.3e}"));
            rows.push(vec![
                entry.node.clone(),
                format!("{:+.3e}", entry.imbalance_w),
                kelvin,
                entry.at.clone(),
                entry.hint.clone().unwrap_or_default(),
            ]);
        }
        rows
    }

    /// What stands before the table, in sentences.
    pub fn in_words(&self) -> String {
        let (of, closing) = (self.nodes.len(), self.closing());
        let kind = if self.is_steady { "steady result" } else { "instant" };
        let mut text = format!(
            "Closure: with the record's temperatures {closing} of {of} nodes balance within {} K ({}), over {}.\n",
            self.tolerance_k,
            if self.step_k < self.tolerance_k { "what solvers iterate to" } else { "the rounding of the print" },
            crate::document::counted(self.rows, kind)
        );
        if !self.is_steady {
            text.push_str(
                "  Nodes that store heat balance with C dT/dt, whose slope comes from neighbouring rows: half the \
                 difference between the slopes before and behind a row is allowed for, and the rounding of the print.\n",
            );
        }
        if let Some((boundary, difference)) =
            self.worst_boundary.as_ref().filter(|(_, worst)| *worst > self.tolerance_k)
        {
            text.push_str(&format!(
                "  The boundary `{boundary}` is given another temperature than the record has, by up to {difference:.3e} K.\n"
            ));
        }
        if !self.not_judged.is_empty() {
            text.push_str(&format!(
                "  {} cannot be judged: the record lacks temperatures there.\n",
                crate::document::counted(self.not_judged.len(), "node")
            ));
        }
        let open = of - closing;
        if open > 0 {
            text.push_str(&format!("  The worst of {open} that do not balance:\n"));
        }
        text
    }
}
