//! The conventional way: nominal and stacked worst-case analysis with margins by rule, and the size each leads to.
//!
//! The stack takes for each uncertain parameter the end of its prior that is worse for the requirement when tried
//! alone, the others nominal; priors without bounds are cut at 3 sigma. A size is the smallest design value from which
//! on the rule passes. A heat-load margin multiplies the heat loads of the case, nominal or stacked.

mod output;

use std::sync::Arc;

use serde_json::{Value, json};

use crate::math::root;
use crate::random::Distribution;
use crate::thermal::{Model, Network, Start, Workspace};

pub use output::{Basis, Margin, Output, Rule, Size, Spec, WorstEnd};

use super::propagate::Variable;
use super::requirement::{Environment, Requirement};
use super::{Job, JobError, Step};

/// Design values tried to find where a rule begins to pass.
const GRID: usize = 65;
/// Relative precision of a size.
const PRECISION: f64 = 1e-10;
/// Most steps to find a size.
const ROOT_ITERATIONS: usize = 100;
/// Share of a prior without bounds that lies beyond each of its ends: 3 sigma of a normal.
const BEYOND: f64 = 1.349_898_031_630_094_6e-3;

/// A conventional analysis, ready to run.
#[derive(Debug)]
pub struct Conventional {
    spec: Spec,
    model: Arc<Model>,
    priors: Vec<Distribution>,
    network: Network,
}

/// Parameters and inputs at which the model is asked.
#[derive(Clone, Debug)]
struct Point {
    parameters: Vec<f64>,
    inputs: Vec<f64>,
}

impl Point {
    fn get(&self, variable: Variable) -> f64 {
        match variable {
            Variable::Parameter(index) => self.parameters[index],
            Variable::Input(index) => self.inputs[index],
        }
    }

    fn set(&mut self, variable: Variable, value: f64) {
        match variable {
            Variable::Parameter(index) => self.parameters[index] = value,
            Variable::Input(index) => self.inputs[index] = value,
        }
    }
}

/// How far a value is inside a requirement, in the quantity's unit: negative where it fails.
fn inside(requirement: &Requirement, value: f64) -> f64 {
    let below = requirement.below.map_or(f64::INFINITY, |limit| limit - value);
    let above = requirement.above.map_or(f64::INFINITY, |limit| value - limit);
    below.min(above)
}

/// The ends of a prior that a worst case looks at: its bounds where it has them, else 3 sigma.
fn ends(prior: &Distribution) -> [f64; 2] {
    let (lower, upper) = prior.support();
    let open_below = match prior {
        Distribution::LogNormal { .. } => true,
        Distribution::Normal { lower, .. } => lower.is_none(),
        _ => false,
    };
    [
        if open_below { prior.quantile(BEYOND) } else { lower },
        if upper.is_finite() { upper } else { prior.quantile(1.0 - BEYOND) },
    ]
}

impl Conventional {
    /// Prepares the job. `priors` has one entry a parameter of the model.
    ///
    /// # Errors
    /// A network that cannot be compiled.
    pub fn new(spec: Spec, model: Arc<Model>, priors: Vec<Distribution>) -> Result<Self, JobError> {
        let network = Network::compile(&model, &[]).map_err(|e| JobError::Failed(e.to_string()))?;
        Ok(Self { spec, model, priors, network })
    }

    fn nominal(&self, environment: &Environment) -> Point {
        let parameters = self
            .model
            .parameters
            .iter()
            .zip(&self.priors)
            .map(|(parameter, prior)| if let Distribution::Fixed(value) = prior { *value } else { parameter.nominal })
            .collect();
        Point { parameters, inputs: environment.inputs.clone() }
    }

    /// The quantity of a requirement at a point.
    fn ask(&self, workspace: &mut Workspace, point: &Point, requirement: &Requirement) -> Result<f64, JobError> {
        self.network.set_parameters(workspace, &point.parameters);
        self.network.set_inputs(workspace, &point.inputs);
        self.network
            .solve_steady(workspace, Start::Default)
            .map_err(|e| JobError::Failed(format!("requirement `{}`: {e}", requirement.name)))?;
        Ok(self.network.quantity(workspace, requirement.quantity))
    }

    /// The worse end of each uncertain parameter, and the point where all are at it.
    fn stack(
        &self,
        workspace: &mut Workspace,
        nominal: &Point,
        requirement: &Requirement,
    ) -> Result<(Point, Vec<WorstEnd>), JobError> {
        let reference = self.ask(workspace, nominal, requirement)?;
        let mut stacked = nominal.clone();
        let mut worst_ends = Vec::new();
        for (index, prior) in self.priors.iter().enumerate() {
            if prior.is_fixed() || self.spec.design.variable == Variable::Parameter(index) {
                continue;
            }
            let mut worst: Option<(f64, f64)> = None;
            for end in ends(prior) {
                let mut point = nominal.clone();
                point.parameters[index] = end;
                let value = self.ask(workspace, &point, requirement)?;
                let is_worse = worst.is_none_or(|(_, other)| inside(requirement, value) < inside(requirement, other));
                if is_worse {
                    worst = Some((end, value));
                }
            }
            if let Some((end, value)) = worst {
                stacked.parameters[index] = end;
                let parameter = &self.model.parameters[index];
                worst_ends.push(WorstEnd {
                    requirement: requirement.name.clone(),
                    parameter: parameter.name.clone(),
                    unit: parameter.unit.clone(),
                    nominal: nominal.parameters[index],
                    worst: end,
                    effect: value - reference,
                });
            }
        }
        worst_ends.sort_by(|a, b| b.effect.abs().total_cmp(&a.effect.abs()));
        Ok((stacked, worst_ends))
    }

    /// What a rule leads to at a basis' point.
    fn size(
        &self,
        workspace: &mut Workspace,
        rule: &Rule,
        basis: Basis,
        point: &Point,
        (environment, requirement): (&Environment, &Requirement),
    ) -> Result<Size, JobError> {
        let mut point = point.clone();
        let mut demanded = 0.0;
        match rule.margin {
            Margin::TemperatureK(margin) => demanded = margin,
            Margin::HeatLoad(share) => {
                for &load in &self.spec.heat_loads {
                    let value = point.get(load);
                    point.set(load, value * (1.0 + share));
                }
            }
        }
        let prediction = self.ask(workspace, &point, requirement)?;
        let left = inside(requirement, prediction) - demanded;
        let design = self.spec.design.variable;
        let mut margin_at = |value: f64| -> Result<f64, JobError> {
            let mut at = point.clone();
            at.set(design, value);
            Ok(inside(requirement, self.ask(workspace, &at, requirement)?) - demanded)
        };
        let (Some(&from), Some(&to)) = (self.spec.design.values.first(), self.spec.design.values.last()) else {
            return Err(JobError::Failed("the design variable has no range".to_owned()));
        };
        let grid: Vec<f64> = (0..GRID).map(|i| from + (to - from) * i as f64 / (GRID - 1) as f64).collect();
        let mut margins = Vec::with_capacity(GRID);
        for &value in &grid {
            margins.push(margin_at(value)?);
        }
        let size = match margins.iter().rposition(|&m| m < 0.0) {
            None => Some(from),
            Some(index) if index + 1 == GRID => None,
            Some(index) => {
                let mut broken = None;
                let found = root::brent(
                    |value| {
                        margin_at(value).unwrap_or_else(|error| {
                            broken = Some(error);
                            f64::NAN
                        })
                    },
                    grid[index],
                    grid[index + 1],
                    PRECISION * to.abs().max(from.abs()),
                    ROOT_ITERATIONS,
                );
                if let Some(error) = broken {
                    return Err(error);
                }
                Some(found.map_err(|e| JobError::Failed(format!("rule `{}`: {e}", rule.name)))?)
            }
        };
        Ok(Size {
            rule: rule.clone(),
            basis,
            environment: environment.name.clone(),
            requirement: requirement.name.clone(),
            size,
            prediction,
            margin: left,
            passes: left >= 0.0,
        })
    }

    fn run(&self) -> Result<Output, JobError> {
        let mut workspace = self.network.workspace();
        let mut sizes = Vec::new();
        let mut worst_case = Vec::new();
        for environment in &self.spec.environments {
            for requirement in &self.spec.requirements {
                let nominal = self.nominal(environment);
                let (stacked, ends) = self.stack(&mut workspace, &nominal, requirement)?;
                for (basis, point) in [(Basis::Nominal, &nominal), (Basis::StackedWorstCase, &stacked)] {
                    for rule in &self.spec.rules {
                        sizes.push(self.size(&mut workspace, rule, basis, point, (environment, requirement))?);
                    }
                }
                worst_case.extend(ends);
            }
        }
        let quantity = self.spec.requirements.first().map(|r| &self.model.quantities[r.quantity]);
        let design_nominal = match self.spec.design.variable {
            Variable::Parameter(index) => self.model.parameters[index].nominal,
            Variable::Input(index) => self.model.inputs[index].nominal,
        };
        Ok(Output {
            design_variable: self.spec.design.name.clone(),
            design_unit: self.spec.design.unit.clone(),
            design_nominal,
            unit: quantity.map(|q| q.unit.clone()).unwrap_or_default(),
            is_temperature: quantity.is_some_and(|q| q.is_temperature),
            limits: self
                .spec
                .requirements
                .iter()
                .filter_map(|r| r.below.or(r.above).map(|limit| (r.name.clone(), limit)))
                .collect(),
            sizes,
            worst_case,
        })
    }
}

impl Job for Conventional {
    fn kind(&self) -> &'static str {
        "conventional"
    }

    fn algorithm_version(&self) -> u32 {
        1
    }

    fn identity(&self) -> Value {
        json!({"settings": self.spec, "model": self.model.identity(), "priors": self.priors})
    }

    fn begin(&self) -> Result<Step, JobError> {
        Ok(Step::Blocks { stage: "sizes".to_owned(), inputs: vec![Vec::new()] })
    }

    fn block(&self, _stage: &str, _input: &[u8]) -> Result<Vec<u8>, JobError> {
        serde_json::to_vec(&self.run()?).map_err(|e| JobError::Failed(e.to_string()))
    }

    fn reduce(&self, stage: &str, _inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        let unreadable = |reason: String| JobError::Unreadable { stage: stage.to_owned(), reason };
        let bytes = outputs.first().ok_or_else(|| unreadable("there is no block".to_owned()))?;
        serde_json::from_slice(bytes).map(Step::Done).map_err(|e| unreadable(e.to_string()))
    }
}
