//! Hand-made outputs of the three kinds of study that reports are written for. The numbers are simple formulas, so
//! that a test can say what a report must show.

use bmv::expression::{Graph, Symbol};
use bmv::job::compare::{
    self, Deviation, HeatBalance, PhaseSummary, Row, SensorSummary, StabilisationCheck, Trend, Verdict,
};
use bmv::job::conventional::{self, Basis, Size, WorstEnd};
use bmv::job::kind::{self, JobKind};
use bmv::job::propagate::{self, Case, Conditional, Distributed, Joint, Met, Probability, Quantile, Reached};
use bmv::math::functions::{exp, ln, sin};
use bmv::measurement::{Initial, InputTable, Measurement, Phase, Rows, Sensor, Uncertain};
use bmv::random::Distribution;
use bmv::report::view::Siblings;
use bmv::report::{FileHash, JobEntry, ParameterChange, PassReport};
use bmv::study::profile::Criteria;
use bmv::study::requirement::{Environment, Requirement};
use bmv::study::rule::{Margin, Rule};
use bmv::study::{Closing, StudyDocument};
use bmv::thermal::element::cooler::Drive;
use bmv::thermal::element::{Conductor, Cooler, Element, ElementKind, Load, Radiation};
use bmv::thermal::{Input, Limits, Model, Node, NodeKind, Parameter, Quantity, QuantityValue};

/// A report with what it borrows.
pub struct Sample {
    pub model: Model,
    pub measurements: Vec<Measurement>,
    pub priors: Vec<(String, Distribution)>,
    pub requirements: Vec<Requirement>,
    pub environments: Vec<Environment>,
    pub results: Vec<JobEntry>,
    pub title: String,
    pub reconstructed: Option<String>,
    pub document: Option<StudyDocument>,
    pub closing: Option<Closing>,
}

impl Sample {
    pub fn report(&self) -> PassReport<'_> {
        PassReport {
            title: self.title.clone(),
            pass_file: "pass-1.json".into(),
            study: "sample".into(),
            description: "A study made for the tests of the report.\n\nIts second paragraph says no more.".into(),
            reconstructed: self.reconstructed.clone(),
            document: self.document.clone(),
            siblings: Some(Siblings { previous: None, next: Some("pass-2".into()) }),
            origin_sha256: Some("cd".repeat(32)),
            closing: self.closing.clone(),
            figures: Vec::new(),
            model: &self.model,
            groups: &[],
            priors: self.priors.clone(),
            posterior_priors: vec![],
            requirements: self.requirements.clone(),
            statements: Vec::new(),
            environments: self.environments.clone(),
            measurements: &self.measurements,
            tested: Vec::new(),
            changes: vec![ParameterChange {
                what: "G_bi".into(),
                before: "uniform, 0.4 to 1.2 W/K".into(),
                after: "uniform, 0.1 to 1.2 W/K".into(),
                because: "bottom view: less contact than assumed".into(),
            }],
            adopted: Vec::new(),
            results: self.results.clone(),
            history: None,
            files: vec![FileHash {
                path: "model.json".into(),
                sha256: "ab".repeat(32),
                role: "model".into(),
                entries: Vec::new(),
            }],
            engine_version: "1".into(),
            command: "bmv report studies/sample/pass-1.json".into(),
            warnings: Vec::new(),
        }
    }
}

fn parameter(name: &str, unit: &str, nominal: f64, description: &str) -> Parameter {
    Parameter {
        name: name.into(),
        unit: unit.into(),
        nominal,
        description: description.into(),
        source: "engineering judgement".into(),
    }
}

fn input(name: &str, unit: &str, nominal: f64) -> Input {
    Input { name: name.into(), unit: unit.into(), nominal, range: None, settable: true, description: String::new() }
}

pub fn node(name: &str, kind: NodeKind) -> Node {
    Node { name: name.into(), kind, area: None, alias: None, limits: Limits::default() }
}

fn element(name: &str, kind: ElementKind) -> Element {
    Element { name: name.into(), kind }
}

/// The probability that grows with the area as in the passive radiator's published kind of result.
fn radiator_probability(area: f64) -> Probability {
    let value = (1.0 / (1.0 + exp(-(area - 0.275) / 0.0085))).min(1.0);
    Probability { value, lower: (value - 0.006).max(0.0), upper: (value + 0.006).min(1.0) }
}

fn bell(x: f64) -> f64 {
    exp(-0.5 * x * x)
}

fn distributed(name: &str, mean: f64, sd: f64, nominal: f64, unit: &str, is_temperature: bool) -> Distributed {
    let z = [-2.326, -1.645, -0.674, 0.0, 0.674, 1.645, 2.326];
    let p = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];
    Distributed {
        name: name.into(),
        unit: unit.into(),
        is_temperature,
        nominal,
        mean,
        mean_standard_error: sd / 90.0,
        sd,
        sd_standard_error: sd / 128.0,
        minimum: mean - 3.6 * sd,
        maximum: mean + 3.6 * sd,
        quantiles: p
            .iter()
            .zip(z)
            .map(|(&probability, z)| Quantile { probability, value: mean + z * sd, standard_error: sd / 40.0 })
            .collect(),
        histogram_edges: (0..=40).map(|i| mean + sd * (f64::from(i) - 20.0) * 0.18).collect(),
        histogram_counts: (0..40).map(|i| (600.0 * bell((f64::from(i) - 19.5) * 0.18)) as u64).collect(),
        // A logistic curve stands in for the normal quantile.
        cdf: (0..100)
            .map(|i| {
                let u = (f64::from(i) + 0.5) / 100.0;
                mean + sd * 0.5513 * ln(u / (1.0 - u))
            })
            .collect(),
    }
}

/// Passive radiator: propagation with a sweep of the area, and the conventional sizes of the same radiator.
pub fn radiator() -> Sample {
    let mut graph = Graph::new();
    let q = graph.symbol(Symbol::Parameter(0));
    let eps = graph.symbol(Symbol::Parameter(1));
    let area = graph.symbol(Symbol::Parameter(2));
    let sink = graph.number(3.0);
    let exchange = graph.multiply(eps, area);
    let t = graph.symbol(Symbol::Node(0));
    let model = Model {
        title: "Isothermal radiator".into(),
        graph,
        parameters: vec![
            parameter("Q", "W", 100.0, "heat load"),
            parameter("eps", "1", 0.85, "emissivity of white paint"),
            parameter("A", "m2", 0.30, "area"),
        ],
        inputs: vec![],
        nodes: vec![node("radiator", NodeKind::Arithmetic), node("space", NodeKind::Boundary { temperature: sink })],
        elements: vec![
            element("to space", ElementKind::Radiation(Radiation { between: [0, 1], exchange_area: exchange })),
            element("heat load", ElementKind::Load(Load { into: 0, power: q })),
        ],
        quantities: vec![Quantity {
            name: "T".into(),
            unit: "K".into(),
            is_temperature: true,
            value: QuantityValue::Instant(t),
        }],
        ..Model::default()
    };
    let limit = 308.15;
    let met = |requirement: &str, quantity: &str, probability| Met {
        requirement: requirement.into(),
        probability,
        required: 0.99,
        below: Some(limit),
        above: None,
        unit: "K".into(),
        quantity: quantity.into(),
    };
    let case = |design_value: Option<f64>| {
        let area = design_value.unwrap_or(0.30);
        let shift = (0.30 - area) * 260.0;
        let p = radiator_probability(area);
        Case {
            environment: "hot".into(),
            design_value,
            quantities: vec![distributed("T", 302.06 + shift, 4.19, 301.98 + shift, "K", true)],
            requirements: vec![met("temperature", "T", p)],
            joint: if design_value.is_none() { vec![joint()] } else { vec![] },
            main_effects: Vec::new(),
            failed: 0,
            failures: vec![],
        }
    };
    let mut cases = vec![case(None)];
    cases.extend((0..12).map(|i| case(Some(0.26 + 0.01 * f64::from(i)))));
    let propagate = propagate::Output {
        samples: 8192,
        sampling: "sobol".into(),
        design_variable: Some("A".into()),
        design_unit: "m2".into(),
        cases,
        reached: vec![Reached {
            environment: "hot".into(),
            requirement: "temperature".into(),
            probability: 0.99,
            design_value: Some(0.3144),
            interval: Some([0.3131, 0.3158]),
        }],
        posterior_priors: vec![],
        discrepancy: vec![],
        converged: None,
    };
    let rule = |name: &str, margin, title: &str| Rule {
        name: name.into(),
        margin,
        title: title.into(),
        source: "SMC-S-016 (2014), 4.4.2".into(),
    };
    let rules = [
        rule("none", Margin::TemperatureK(0.0), "no margin"),
        rule("nasa", Margin::TemperatureK(5.0), "5 K"),
        rule("validated", Margin::TemperatureK(11.0), "11 K after correlation"),
        rule("unvalidated", Margin::TemperatureK(17.0), "17 K without balance test"),
    ];
    let nominal = [0.2724, 0.2945, 0.3244, 0.3586];
    let stacked = [0.3422, 0.3729, 0.4152, 0.4649];
    let mut sizes = Vec::new();
    for (basis, values, prediction) in [(Basis::Nominal, nominal, 301.98), (Basis::StackedWorstCase, stacked, 318.3)] {
        for (rule, size) in rules.iter().zip(values) {
            let Margin::TemperatureK(k) = rule.margin else { continue };
            let margin = limit - prediction - k;
            sizes.push(Size {
                rule: rule.clone(),
                basis,
                environment: "hot".into(),
                requirement: "temperature".into(),
                size: Some(size),
                prediction,
                margin,
                passes: margin >= 0.0,
            });
        }
    }
    let conventional = conventional::Output {
        design_variable: "A".into(),
        design_unit: "m2".into(),
        design_nominal: 0.30,
        design_range: [0.2, 0.6],
        unit: "K".into(),
        is_temperature: true,
        limits: vec![("temperature".into(), limit)],
        sizes,
        correlation: None,
        priors_of: None,
        from_draws: false,
        worst_case: vec![WorstEnd {
            requirement: "temperature".into(),
            parameter: "eps".into(),
            unit: "1".into(),
            nominal: 0.85,
            worst: 0.78,
            effect: 6.1,
        }],
    };
    Sample {
        model,
        measurements: vec![],
        priors: vec![
            ("Q".into(), Distribution::Uniform { lower: 95.0, upper: 105.0 }),
            ("eps".into(), Distribution::Normal { mean: 0.85, sd: 0.03, lower: None, upper: Some(1.0) }),
        ],
        requirements: vec![Requirement {
            name: "temperature".into(),
            quantity: 0,
            below: Some(limit),
            above: None,
            probability: 0.99,
        }],
        environments: vec![Environment { name: "hot".into(), inputs: vec![] }],
        results: vec![
            entry::<propagate::Kind>("uncertainty", "12", propagate),
            entry::<conventional::Kind>("margins", "34", conventional),
        ],
        title: "Passive radiator, pass 1".into(),
        document: None,
        closing: None,
        reconstructed: Some(
            "All numbers of this case are reconstructed; none is taken from the thesis that it follows.".into(),
        ),
    }
}

fn joint() -> Joint {
    let edge = |i: i32| f64::from(i) - 10.0;
    Joint {
        x: "T".into(),
        y: "flux".into(),
        units: ["K".into(), "W/m2".into()],
        correlation: Some(0.71),
        x_edges: (0..=20).map(|i| 302.0 + edge(i)).collect(),
        y_edges: (0..=20).map(|i| 330.0 + 4.0 * edge(i)).collect(),
        counts: (0..20)
            .map(|i| {
                (0..20).map(|j| (90.0 * bell(edge(i) / 4.0) * bell((edge(j) - 0.7 * edge(i)) / 2.5)) as u64).collect()
            })
            .collect(),
        conditional: (0..20)
            .map(|i| Conditional {
                x: 302.5 + edge(i),
                mean: 332.0 + 2.8 * edge(i),
                q05: 316.0 + 2.8 * edge(i),
                q95: 348.0 + 2.8 * edge(i),
                samples: 40,
            })
            .collect(),
    }
}

fn deviation(values: &[f64]) -> Deviation {
    if values.is_empty() {
        return Deviation::default();
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|v| v * v).sum::<f64>() / n;
    let sd = (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
    Deviation {
        count: values.len() as u64,
        mean,
        sd,
        rmse: square.sqrt(),
        max: values.iter().fold(0.0, |m, v| v.abs().max(m)),
        within_limit: values.iter().filter(|v| v.abs() <= 3.0).count() as f64 / n,
    }
}

fn criteria() -> Criteria {
    Criteria {
        name: "three-kelvin".into(),
        title: "within 3 K".into(),
        each_k: Some(3.0),
        mean_k: Some(2.0),
        sd_k: Some(3.0),
        share: None,
        stabilisation_k_per_s: Some(0.2 / 3600.0),
        source: "agreed by the project".into(),
    }
}

fn compared(rows: Vec<Row>, sigma: f64, fails: Vec<String>) -> compare::Output {
    let mut sensors: Vec<SensorSummary> = Vec::new();
    for row in &rows {
        if sensors.iter().any(|s| s.sensor == row.sensor) {
            continue;
        }
        let of = |held: bool| -> Vec<f64> {
            rows.iter()
                .filter(|r| r.sensor == row.sensor && r.held_out == held)
                .map(|r| r.measured - r.predicted)
                .collect()
        };
        sensors.push(SensorSummary {
            measurement: row.measurement.clone(),
            sensor: row.sensor.clone(),
            unit: "K".into(),
            sigma: Some(sigma),
            train: deviation(&of(false)),
            held_out: deviation(&of(true)),
            noise_rmse: Some([0.8 * sigma, 1.2 * sigma]),
            missing: 0,
            tuned: None,
        });
    }
    let all = |held: bool| {
        deviation(&rows.iter().filter(|r| r.held_out == held).map(|r| r.measured - r.predicted).collect::<Vec<_>>())
    };
    let (train, held_out) = (all(false), all(true));
    let criteria = criteria();
    compare::Output {
        state: "nominal".into(),
        parameters: vec![],
        sensors,
        phases: vec![],
        chi2_per_reading: Some(train.rmse * train.rmse / sigma / sigma),
        verdicts: vec![
            Verdict {
                criterion: "largest deviation of one reading, K".into(),
                value: train.max,
                limit: 3.0,
                kept: train.max <= 3.0,
            },
            Verdict {
                criterion: "mean deviation, K".into(),
                value: train.mean,
                limit: 2.0,
                kept: train.mean.abs() <= 2.0,
            },
        ],
        criteria,
        heat: vec![],
        trends: vec![],
        stabilisation: vec![],
        fails,
        warnings: vec![],
        failed: vec![],
        unused_columns: vec![],
        tuned: None,
        converged: None,
        train,
        held_out,
        rows: rows.into_iter().collect(),
    }
}

fn temperature_model(names: &[&str]) -> Model {
    let mut graph = Graph::new();
    let ambient = graph.number(295.0);
    let capacity = graph.number(20.0);
    let conductance = graph.symbol(Symbol::Parameter(0));
    let power = graph.symbol(Symbol::Input(0));
    let mut nodes: Vec<Node> = names.iter().map(|n| node(n, NodeKind::Diffusion { capacity })).collect();
    nodes.push(node("ambient", NodeKind::Boundary { temperature: ambient }));
    let quantities = (0..names.len())
        .map(|i| Quantity {
            name: names[i].into(),
            unit: "K".into(),
            is_temperature: true,
            value: QuantityValue::Instant(graph.symbol(Symbol::Node(i as u32))),
        })
        .collect();
    let mut elements: Vec<Element> = (0..names.len())
        .map(|i| {
            element(
                &format!("{} to next", names[i]),
                ElementKind::Conductor(Conductor { between: [i, i + 1], conductance }),
            )
        })
        .collect();
    elements.push(element(
        "glow",
        ElementKind::Radiation(Radiation { between: [0, names.len()], exchange_area: capacity }),
    ));
    elements.push(element("heater power", ElementKind::Load(Load { into: 0, power })));
    if names.len() > 2 {
        elements.push(element(
            "cooler",
            ElementKind::Cooler(Cooler {
                nodes: vec![1, 2],
                couples: vec![capacity],
                drive: Drive::Voltage(power),
                seebeck: conductance,
                resistance: conductance,
                conductance,
                lead_resistance: conductance,
            }),
        ));
    }
    Model {
        title: "Chain".into(),
        graph,
        parameters: vec![parameter("G_bi", "mW/K", 0.8, "bolted joint")],
        inputs: vec![input("P", "W", 2.0)],
        nodes,
        elements,
        quantities,
        ..Model::default()
    }
}

fn sensor(name: &str, quantity: usize, sigma: f64) -> Sensor {
    Sensor {
        name: name.into(),
        quantity,
        unit: "degC".into(),
        sigma: Some(Uncertain::Known(sigma)),
        bias: None,
        lag_s: None,
        behind_s: Vec::new(),
        correlation_time_s: None,
        white: None,
    }
}

/// A job with its output; its key is two digits repeated.
pub fn entry<K: JobKind>(name: &str, digits: &str, output: K::Output) -> JobEntry {
    JobEntry { name: name.into(), key: digits.repeat(32), output: kind::output::<K>(output), has_adopted: false }
}

/// Changes the output of a job, if that is of this kind; whether it is.
pub fn edit<K: JobKind>(job: &mut JobEntry, change: impl FnOnce(&mut K::Output)) -> bool {
    let Some(mut output) = job.output_of::<K>().cloned() else { return false };
    change(&mut output);
    job.output = kind::output::<K>(output);
    true
}

fn compare_sample(title: &str, model: Model, measurement: Measurement, output: compare::Output) -> Sample {
    Sample {
        model,
        measurements: vec![measurement],
        priors: vec![("G_bi".into(), Distribution::Uniform { lower: 0.4, upper: 1.2 })],
        requirements: vec![],
        environments: vec![],
        results: vec![entry::<compare::Kind>("as delivered", "56", output)],
        title: title.into(),
        reconstructed: None,
        document: None,
        closing: None,
    }
}

/// Two sensors over 600 s, the last third held out, a heater step at 20 s and at 300 s.
pub fn transient() -> Sample {
    let times: Vec<f64> = (0..601).map(f64::from).collect();
    let mut rows = Vec::new();
    for &t in &times {
        for (sensor, gain, lag) in [("T1", 38.0, 150.0), ("T2", 14.0, 230.0)] {
            let rise = |from: f64| if t > from { 1.0 - exp(-(t - from) / lag) } else { 0.0 };
            let predicted = 295.0 + gain * rise(20.0) - 0.5 * gain * rise(300.0);
            let missing = 0.06 * gain * rise(20.0);
            let noise = 0.25 * (sin(t * 12.9898) * 43758.5453).fract();
            rows.push(Row {
                measurement: "step test".into(),
                phase: None,
                time_s: Some(t),
                sensor: sensor.into(),
                unit: "K".into(),
                measured: predicted + missing + noise,
                predicted,
                predicted_tuned: None,
                held_out: t >= 400.0,
            });
        }
    }
    let readings = rows.iter().map(|r| (r.time_s != Some(100.0)).then_some(r.measured)).collect();
    let mut output = compared(
        rows,
        0.2,
        vec![
            "T1 reads 1.9 K above the prediction on average; the deviation grows with the temperature above ambient."
                .into(),
        ],
    );
    for (i, stretch) in ["0 to 120 s", "120 to 300 s", "300 to 400 s", "400 to 600 s"].into_iter().enumerate() {
        output.phases.push(PhaseSummary {
            measurement: "step test".into(),
            phase: stretch.into(),
            held_out: i == 3,
            deviation: output.train,
            worst_sensor: "T1".into(),
            worst: 1.2 + 0.3 * i as f64,
        });
    }
    output.trends.push(Trend {
        measurement: "step test".into(),
        sensor: "T1".into(),
        against: "P".into(),
        unit: "W".into(),
        slope: 0.62,
        slope_error: 0.05,
        correlation: 0.91,
        change: 2.2,
    });
    let held_out = times.iter().map(|&t| t >= 400.0).collect();
    let measurement = Measurement {
        name: "step test".into(),
        rows: Rows::Transient {
            ignored: times.iter().map(|&t| (t < 3.0).then(|| "valve moving".to_owned())).collect(),
            inputs: InputTable { times_s: times, columns: vec![], base: vec![2.0] },
            initial: Initial::Steady,
            held_out,
        },
        sensors: vec![sensor("T1", 0, 0.2), sensor("T2", 1, 0.2)],
        readings,
        file: "data/step-test.csv".into(),
        sha256: "cd".repeat(32),
        unused_columns: vec!["Comment".into()],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    compare_sample("Step test of a heater board, pass 1", temperature_model(&["T1", "T2"]), measurement, output)
}

/// Twenty-two steady phases and six sensors; the housing deviates in proportion to the load.
pub fn steady() -> Sample {
    let sensors = ["housing", "bracket", "board", "baseplate", "detector", "strap"];
    let mut rows = Vec::new();
    let mut phases = Vec::new();
    for p in 0..22 {
        let held_out = p % 5 == 4;
        let load = f64::from(p % 7);
        phases.push(Phase {
            name: format!("P{:02}", p + 1),
            inputs: vec![load],
            held_out,
            ignored: (p == 6).then(|| "not stabilised".to_owned()),
            stabilisation: None,
        });
        for (s, sensor) in sensors.iter().enumerate() {
            let predicted = 280.0 + 4.0 * load + 3.0 * s as f64;
            let noise = 0.25 * sin(f64::from(p) * 7.1 + s as f64 * 3.3);
            let missing = if s == 0 {
                0.55 * load
            } else if s == 4 {
                -0.2 * load
            } else {
                0.0
            };
            rows.push(Row {
                measurement: "balance test".into(),
                phase: Some(format!("P{:02}", p + 1)),
                time_s: None,
                sensor: (*sensor).into(),
                unit: "K".into(),
                measured: predicted + missing + noise,
                predicted,
                predicted_tuned: None,
                held_out,
            });
        }
    }
    let readings = rows.iter().map(|r| Some(r.measured)).collect();
    let fails = vec![
        "housing reads up to 3.5 K above the prediction; the deviation goes with input P (0.55 K per W).".to_owned(),
        "detector reads up to 1.4 K below the prediction where P is high.".to_owned(),
    ];
    let mut output = compared(rows, 0.25, fails);
    for p in 0..22 {
        let name = format!("P{:02}", p + 1);
        output.phases.push(PhaseSummary {
            measurement: "balance test".into(),
            phase: name.clone(),
            held_out: p % 5 == 4,
            deviation: output.train,
            worst_sensor: "housing".into(),
            worst: 0.55 * f64::from(p % 7),
        });
        output.heat.push(HeatBalance {
            measurement: "balance test".into(),
            phase: name,
            sources_w: f64::from(p % 7),
            into_boundaries_w: vec![("ambient".into(), f64::from(p % 7))],
            stored_w: 0.0,
            imbalance_w: -1e-12,
        });
    }
    output.stabilisation.push(StabilisationCheck {
        measurement: "balance test".into(),
        phase: "P07".into(),
        sensor: "housing".into(),
        drift_k_per_s: 1.2e-4,
        drift_error_k_per_s: 1e-5,
        stored_w: 0.11,
        stabilised: Some(false),
        unclear: false,
    });
    let measurement = Measurement {
        name: "balance test".into(),
        rows: Rows::Steady(phases),
        sensors: sensors.iter().enumerate().map(|(i, s)| sensor(s, i, 0.25)).collect(),
        readings,
        file: "data/balance-test.csv".into(),
        sha256: "ef".repeat(32),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    compare_sample("Thermal balance test of a detector head, pass 1", temperature_model(&sensors), measurement, output)
}
