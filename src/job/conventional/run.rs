//! The conventional analysis as a job of one block.

use super::{Basis, Correlation, Output, Size, Spec, WorstEnd};
use crate::math::sort::sort_by;
use crate::study::rule::{Margin, Rule};
use std::sync::Arc;

use serde_json::{Value, json};

use crate::math::root;
use crate::random::Distribution;
use crate::thermal::{Model, Network, Start, Workspace};

use crate::job::fault::listed;
use crate::job::prior_ends::ends;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::study::requirement::{Environment, Requirement};
use crate::study::variable::Variable;

/// Design values tried to find where a rule begins to pass.
pub(super) const GRID: usize = 65;
/// Relative precision of a size.
pub(super) const PRECISION: f64 = 1e-10;
/// Most steps to find a size.
pub(super) const ROOT_ITERATIONS: usize = 100;

/// A conventional analysis, ready to run.
#[derive(Debug)]
pub struct Conventional {
    spec: Spec,
    pub(super) model: Arc<Model>,
    pub(super) priors: Vec<Distribution>,
    /// The network, compiled.
    pub network: Network,
    /// The correlation whose values stand, and these by parameter.
    correlation: Option<(Correlation, Vec<Option<f64>>)>,
    /// Whether ends of priors are those of draws.
    pub(super) from_draws: bool,
}

/// Parameters and inputs at which the model is asked.
#[derive(Clone, Debug)]
pub struct Point {
    /// Values of the parameters, SI.
    pub parameters: Vec<f64>,
    /// Values of the inputs, SI.
    pub inputs: Vec<f64>,
}

impl Point {
    pub(super) fn get(&self, variable: Variable) -> f64 {
        match variable {
            Variable::Parameter(index) => self.parameters[index],
            Variable::Input(index) => self.inputs[index],
        }
    }

    pub(super) fn set(&mut self, variable: Variable, value: f64) {
        match variable {
            Variable::Parameter(index) => self.parameters[index] = value,
            Variable::Input(index) => self.inputs[index] = value,
        }
    }
}

/// How far a value is inside a requirement, in the quantity's unit: negative where it fails.
pub(super) fn inside(requirement: &Requirement, value: f64) -> f64 {
    let below = requirement.below.map_or(f64::INFINITY, |limit| limit - value);
    let above = requirement.above.map_or(f64::INFINITY, |limit| value - limit);
    below.min(above)
}

impl Conventional {
    /// Prepares the job. `priors` has one entry a parameter of the model.
    ///
    /// # Errors
    /// A network that cannot be compiled.
    pub fn new(spec: Spec, model: Arc<Model>, priors: Vec<Distribution>) -> Result<Self, JobError> {
        let network = Network::compile(&model, &[]).map_err(|e| JobError::Failed(e.to_string()))?;
        Ok(Self { spec, model, priors, network, correlation: None, from_draws: false })
    }

    /// The same, with whether ends of priors are those of draws.
    pub fn from_draws(self, from_draws: bool) -> Self {
        Self { from_draws, ..self }
    }

    /// The same with the values of a correlation, which stand as if they were known.
    ///
    /// # Errors
    /// A parameter that this model lacks.
    pub fn with_correlation(self, correlation: Correlation) -> Result<Self, JobError> {
        let mut standing = vec![None; self.priors.len()];
        for (name, value) in &correlation.values {
            let index = self.model.parameters.iter().position(|parameter| parameter.name == *name);
            let index = index.ok_or_else(|| JobError::Failed(format!("this model has no parameter `{name}`")))?;
            standing[index] = Some(*value);
        }
        Ok(Self { correlation: Some((correlation, standing)), ..self })
    }

    /// The value at which a parameter stands after a correlation.
    fn correlated(&self, index: usize) -> Option<f64> {
        self.correlation.as_ref().and_then(|(_, standing)| standing.get(index).copied().flatten())
    }

    /// The nominal value that an earlier pass gave a parameter, where its knowledge is taken.
    fn known_before(&self, index: usize) -> Option<f64> {
        let knowledge = self.spec.knowledge.as_ref()?;
        knowledge.parameters.iter().find(|(own, ..)| *own == index).map(|(_, nominal, _)| *nominal)
    }

    pub(super) fn nominal(&self, environment: &Environment) -> Point {
        let parameters = self
            .model
            .parameters
            .iter()
            .zip(&self.priors)
            .enumerate()
            .map(|(index, (parameter, prior))| match (self.correlated(index), prior) {
                (Some(value), _) | (None, &Distribution::Fixed(value)) => value,
                (None, _) => self.known_before(index).unwrap_or(parameter.nominal),
            })
            .collect();
        Point { parameters, inputs: environment.inputs.clone() }
    }

    /// Where the search for a size starts, and the end towards which rules pass.
    pub(super) fn design_range(&self) -> Result<(f64, f64), JobError> {
        let values = &self.spec.design.values;
        let ends = values.first().copied().zip(values.last().copied());
        ends.ok_or_else(|| JobError::Failed("the design variable has no range".to_owned()))
    }

    /// The quantity of a requirement at a point.
    pub(super) fn ask(
        &self,
        workspace: &mut Workspace,
        point: &Point,
        requirement: &Requirement,
    ) -> Result<f64, JobError> {
        self.network.set_parameters(workspace, &point.parameters);
        self.network.set_inputs(workspace, &point.inputs);
        self.network
            .solve_steady(workspace, Start::Default)
            .map_err(|e| JobError::Failed(format!("requirement `{}`: {e}", requirement.name)))?;
        let value = self.network.quantity(workspace, requirement.quantity);
        match self.model.quantities[requirement.quantity].fault(value) {
            None => Ok(value),
            Some(fault) => {
                let names = self.model.parameters.iter().map(|parameter| parameter.name.clone());
                let point: Vec<(String, f64)> = names.zip(point.parameters.iter().copied()).collect();
                Err(JobError::Failed(format!("requirement `{}`: {fault} at {}", requirement.name, listed(&point))))
            }
        }
    }

    /// The worse end of each uncertain parameter, and the point where all are at it.
    pub fn stack(
        &self,
        workspace: &mut Workspace,
        nominal: &Point,
        requirement: &Requirement,
    ) -> Result<(Point, Vec<WorstEnd>), JobError> {
        let reference = self.ask(workspace, nominal, requirement)?;
        let mut stacked = nominal.clone();
        let mut worst_ends = Vec::new();
        for (index, prior) in self.priors.iter().enumerate() {
            if prior.is_fixed()
                || self.correlated(index).is_some()
                || self.spec.design.variable == Variable::Parameter(index)
            {
                continue;
            }
            // Nominal stays where it is worse than both ends.
            let mut worst = (nominal.parameters[index], reference);
            for end in ends(prior) {
                let mut point = nominal.clone();
                point.parameters[index] = end;
                let value = self.ask(workspace, &point, requirement)?;
                if inside(requirement, value) < inside(requirement, worst.1) {
                    worst = (end, value);
                }
            }
            let (end, value) = worst;
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
        sort_by(&mut worst_ends, |a, b| b.effect.abs().total_cmp(&a.effect.abs()));
        Ok((stacked, worst_ends))
    }

    /// A point with its heat loads changed by a share, up or down, whichever is worse for the requirement: more heat
    /// is no margin for a limit against cold.
    pub fn loaded(
        &self,
        workspace: &mut Workspace,
        point: &Point,
        requirement: &Requirement,
        share: f64,
    ) -> Result<Point, JobError> {
        let scaled = |factor: f64| {
            let mut scaled = point.clone();
            for &load in &self.spec.heat_loads {
                scaled.set(load, point.get(load) * factor);
            }
            scaled
        };
        let (more, less) = (scaled(1.0 + share), scaled(1.0 - share));
        let margin_more = inside(requirement, self.ask(workspace, &more, requirement)?);
        let margin_less = inside(requirement, self.ask(workspace, &less, requirement)?);
        Ok(if margin_less < margin_more { less } else { more })
    }

    /// What a rule leads to at a basis' point.
    pub(super) fn size(
        &self,
        workspace: &mut Workspace,
        rule: &Rule,
        basis: Basis,
        point: &Point,
        (environment, requirement): (&Environment, &Requirement),
    ) -> Result<Size, JobError> {
        let (point, demanded) = match rule.margin {
            Margin::TemperatureK(margin) => (point.clone(), margin),
            Margin::HeatLoad(share) => (self.loaded(workspace, point, requirement, share)?, 0.0),
        };
        let prediction = self.ask(workspace, &point, requirement)?;
        let left = inside(requirement, prediction) - demanded;
        let design = self.spec.design.variable;
        let mut margin_at = |value: f64| -> Result<f64, JobError> {
            let mut at = point.clone();
            at.set(design, value);
            Ok(inside(requirement, self.ask(workspace, &at, requirement)?) - demanded)
        };
        let (from, to) = self.design_range()?;
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
                let size_root = root::brent(
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
                Some(size_root.map_err(|e| JobError::Failed(format!("rule `{}`: {e}", rule.name)))?)
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

    pub(super) fn run(&self) -> Result<Output, JobError> {
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
        let (from, to) = self.design_range()?;
        let design_nominal = match self.spec.design.variable {
            Variable::Parameter(index) => self.model.parameters[index].nominal,
            Variable::Input(index) => self.model.inputs[index].nominal,
        };
        Ok(Output {
            design_variable: self.spec.design.name.clone(),
            design_unit: self.spec.design.unit.clone(),
            design_nominal,
            design_range: [from, to],
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
            correlation: self.correlation.as_ref().map(|(correlation, _)| correlation.clone()),
            from_draws: self.from_draws,
            priors_of: self.spec.knowledge.as_ref().map(|knowledge| knowledge.pass.clone()),
        })
    }
}

impl Job for Conventional {
    type State = ();
    type Input = ();
    type Partial = Output;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "conventional"
    }

    fn algorithm_version(&self) -> u32 {
        4
    }

    fn identity(&self) -> Value {
        json!({"settings": self.spec, "model": self.model.identity(), "priors": self.priors})
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: "sizes".to_owned(), state: (), inputs: vec![()] })
    }

    fn block(&self, (): &(), (): (), _parts: &dyn Parts) -> Result<Output, JobError> {
        self.run()
    }

    fn is_last(&self, (): &()) -> bool {
        true
    }

    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let finished = blocks.into_iter().next().map(|(_, output)| Step::Done(Box::new(output)));
        finished.ok_or_else(|| JobError::Failed("there are no sizes".to_owned()))
    }
}
