//! Cases of the laboratory: a baseline model, a test of a truth that differs from it, and the truth.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::campaign::{TestKind, measurement};
use super::draw::{Draw, decimals};
use super::folder;
use super::inject::{Hidden, InjectError, InjectionRequest, inject};
use super::noise::noise;
use super::rivals;
use super::specification::NetworkSpecification;
use super::topology::{Topology, network};
use super::truth::{Rival, Truth};
use crate::diagnosis::Problem;
use crate::document::hash::sha256_hex;
use crate::effect::{Catalogue, Effect, GroupPlace, SensorChange, SensorPlace, candidates, thermometers};
use crate::measurement::{Rows, Uncertain};
use crate::random::StreamKey;

/// What a case of a drawn network is to be.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Kind of network; drawn if `None`.
    pub topology: Option<Topology>,
    /// Kind of test; drawn if `None`.
    pub test: Option<TestKind>,
    /// What is to be hidden.
    pub request: InjectionRequest,
    /// Whether rivals of the truth are looked for.
    pub rivals: bool,
    /// Stated standard deviations of the noise, as multiples of the true ones; 1 if `None`.
    pub stated_noise: Option<f64>,
}

impl Recipe {
    /// Of a network and a test of these kinds, without rivals, the noise stated as it is.
    pub fn of(topology: Topology, test: TestKind, request: InjectionRequest) -> Self {
        Self { topology: Some(topology), test: Some(test), request, ..Self::default() }
    }
}

/// A case with a network of its own.
#[derive(Clone, Debug)]
pub struct Case {
    /// Kind of network.
    pub topology: Topology,
    /// Kind of test.
    pub test: TestKind,
    /// The baseline network.
    pub specification: NetworkSpecification,
    /// The baseline model with the test's readings.
    pub problem: Problem,
    /// What is true.
    pub truth: Truth,
}

/// Decimals of the readings, K: far below any noise.
const DECIMALS: usize = 4;
/// Networks tried before giving up.
const TRIES: u64 = 20;

/// The case of a recipe, a seed and a number: the same for the same three.
///
/// # Errors
/// The last [`InjectError`] where no drawn network takes what is asked for.
pub fn case(catalogue: &Arc<Catalogue>, recipe: &Recipe, seed: u64, number: u64) -> Result<Case, InjectError> {
    let mut last = InjectError::NoPlace;
    for attempt in 0..TRIES {
        let stream = number * TRIES + attempt;
        match attempted(catalogue, recipe, seed, stream) {
            Ok(case) => return Ok(case),
            Err(error) => last = error,
        }
    }
    Err(last)
}

fn attempted(catalogue: &Arc<Catalogue>, recipe: &Recipe, seed: u64, stream: u64) -> Result<Case, InjectError> {
    let mut draw = Draw::new(seed, "network", stream);
    let drawn = Topology::ALL[draw.position(Topology::ALL.len())];
    let topology = recipe.topology.unwrap_or(drawn);
    let tests: &[TestKind] = match topology {
        Topology::Satellite => &[TestKind::Orbit, TestKind::Orbit, TestKind::Flight, TestKind::Steady],
        _ => {
            &[TestKind::Steady, TestKind::Steps, TestKind::Steady, TestKind::Steps, TestKind::Steady, TestKind::Flight]
        }
    };
    let drawn = tests[draw.position(tests.len())];
    let test = recipe.test.unwrap_or(drawn);
    let specification = network(topology, &mut draw);
    let mut problem = baseline(catalogue, &specification, test, &mut Draw::new(seed, "test", stream))?;
    let mut hidden = inject(&problem, &recipe.request, &mut Draw::new(seed, "truth", stream))?;
    if recipe.rivals {
        hidden.truth.rivals = Some(match recipe.request.finer {
            Some(error) => within(error, &problem, &hidden)?,
            None => rivals::rivals(&problem, &hidden)?,
        });
    }
    let key = StreamKey::new(seed, "laboratory", "noise");
    read(&mut problem, &hidden.clean, &hidden.truth, &key, stream);
    for measurement in &mut problem.measurements {
        if let Some(factor) = recipe.stated_noise {
            let stated = measurement.sensors.iter_mut().filter_map(|sensor| sensor.sigma.as_mut());
            stated.for_each(|sigma| *sigma = Uncertain::Known(factor * sigma.nominal()));
        }
        for reading in measurement.readings.iter_mut().flatten() {
            *reading = decimals(*reading, DECIMALS);
        }
        measurement.sha256 = sha256_hex(folder::table(folder::written(&problem.model), measurement).as_bytes());
    }
    Ok(Case { topology, test, specification, problem, truth: hidden.truth })
}

/// Rivals that come nearer to what is hidden in the believed network than a model error of this size, in standard
/// deviations: it hides the difference.
fn within(error: f64, problem: &Problem, hidden: &Hidden) -> Result<Vec<Rival>, InjectError> {
    let hidden = hidden.without_finer_nodes(problem)?;
    let square = error * error * hidden.refit.readings as f64;
    Ok(rivals::rivals(problem, &hidden)?.into_iter().filter(|rival| rival.delta2 <= square).collect())
}

/// Fills in readings with noise, where there are any: case `number` has the streams from `1e6 number` on. The noise of a
/// sensor goes with it to the channel that it is wired to.
pub fn read(problem: &mut Problem, clean: &[Vec<f64>], truth: &Truth, key: &StreamKey, number: u64) {
    let exchanges = |effect: &str| problem.catalogue.get(effect).is_some_and(Effect::exchanges_channels);
    let exchanged: Vec<SensorChange> = (truth.effects.iter())
        .filter(|hidden| exchanges(&hidden.effect))
        .filter_map(|hidden| Some(SensorChange::Swap { sensors: hidden.place.clone().try_into().ok()? }))
        .collect();
    for (position, (measurement, clean)) in problem.measurements.iter_mut().zip(clean).enumerate() {
        let mut wired = measurement.clone();
        exchanged.iter().for_each(|change| wired.change_sensors(change, 0.0));
        let noise = noise(&wired, number * 1000 + position as u64, truth.noise, key);
        for (reading, (clean, noise)) in measurement.readings.iter_mut().zip(clean.iter().zip(&noise)) {
            *reading = reading.map(|_| clean + noise);
        }
    }
}

/// The baseline model of a specification with a test without readings, and all candidates.
fn baseline(
    catalogue: &Arc<Catalogue>,
    specification: &NetworkSpecification,
    test: TestKind,
    draw: &mut Draw,
) -> Result<Problem, InjectError> {
    let mut model = specification.model().map_err(|error| InjectError::Fit(error.message))?;
    let mut measurements = vec![measurement(test, specification, &mut model, draw)];
    model.set_clocks(&measurements.clone(), &mut measurements);
    let measurement = &measurements[0];
    let transient = matches!(measurement.rows, Rows::Transient { .. });
    let sensors: Vec<SensorPlace> = (measurement.sensors.iter())
        .map(|sensor| SensorPlace {
            name: sensor.name.clone(),
            quantity: sensor.quantity,
            steady: !transient,
            transient,
        })
        .collect();
    let groups: Vec<GroupPlace> = thermometers(&model, &[], &sensors).into_iter().collect();
    let candidates = candidates(&model, &groups, &sensors, catalogue);
    let priors = specification.priors();
    Ok(Problem {
        parameters: (0..priors.len()).filter(|&index| !priors[index].is_fixed()).collect(),
        priors,
        model: Arc::new(model),
        measurements,
        input_errors: Vec::new(),
        catalogue: Arc::clone(catalogue),
        candidates: Arc::new(candidates),
        joint: Vec::new(),
        most_steps: Vec::new(),
        noise_freedom: None,
        is_misspecified: false,
        independent_readings: 0.0,
        considered: Vec::new(),
        working_temperatures_k: Default::default(),
        places: Default::default(),
        missing_probability: Default::default(),
        tolerance: 1.0,
    })
}
