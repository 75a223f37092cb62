//! Additions that are elements: heat flows, loads and unknown functions.

use crate::expression::{ExprId, Table};
use crate::thermal::NodeKind;
use crate::thermal::element::{ElementKind, Flow, Load};

use super::{ApplyError, Work};
use crate::effect::checked::KNOT;
use crate::effect::form::CurveForm;
use crate::effect::place::Site;

impl Work<'_, '_> {
    /// `flow`, `load` and `curve`.
    pub(super) fn elements(&mut self) -> Result<(), ApplyError> {
        let adds = &self.instance.effect.form.adds.value;
        match (&adds.flow, &adds.ambient) {
            (Some(flow), Some(ambient)) => {
                let temperature = self.expression(&ambient.temperature.value, &[])?;
                let surroundings = self.add_node("ambient", None, NodeKind::Boundary { temperature })?;
                for (node, weight, member) in self.place_nodes()? {
                    let ends = [node, surroundings];
                    let locals = self.ends(ends);
                    let heat = self.expression(&flow.value, &locals)?;
                    let heat = self.weighted(heat, weight);
                    self.add_element(member, ElementKind::Flow(Flow { between: ends, heat, one_way: false }));
                }
            }
            (Some(flow), None) => {
                let Site::Pair(between) = self.instance.site else { return Err(self.misplaced()) };
                let locals = self.ends(between);
                let heat = self.expression(&flow.value, &locals)?;
                self.add_element(None, ElementKind::Flow(Flow { between, heat, one_way: false }));
            }
            (None, _) => {}
        }
        if let Some(load) = &adds.load {
            for (into, weight, member) in self.place_nodes()? {
                let temperature = self.temperature(into);
                let power = self.expression(&load.value, &[("T", temperature)])?;
                let power = self.weighted(power, weight);
                self.add_element(member, ElementKind::Load(Load { into, power }));
            }
        }
        if let Some(curve) = &adds.curve {
            let heat = self.curve(curve)?;
            for (into, weight, member) in self.place_nodes()? {
                let power = self.weighted(heat, weight);
                self.add_element(member, ElementKind::Load(Load { into, power }));
            }
        }
        Ok(())
    }

    /// A sum of hat functions, each a table, times the knots' values.
    fn curve(&mut self, curve: &CurveForm) -> Result<ExprId, ApplyError> {
        let bound = |name: &str| {
            let position = self.instance.effect.input(name)?;
            self.instance.bound.get(position).copied()
        };
        let Some(of) = bound(&curve.of.value) else { return Err(self.misplaced()) };
        let [lower, upper] = of.range(self.model);
        let knots = curve.knots.value;
        let last = (knots - 1) as f64;
        let at: Vec<f64> = (0..knots).map(|knot| lower + (upper - lower) * (knot as f64 / last)).collect();
        let x = self.model.graph.symbol(of.symbol());
        let mut terms = Vec::new();
        for knot in 0..knots {
            let y = (0..knots).map(|other| f64::from(u8::from(other == knot))).collect();
            let table = self.model.graph.table(Table { x: at.clone(), y });
            let hat = self.model.graph.interpolate(table, x);
            let value = self.expression(&format!("{KNOT}_{}", knot + 1), &[])?;
            terms.push(self.model.graph.multiply(value, hat));
        }
        let sum = self.model.graph.sum(&terms);
        match &curve.times {
            Some(times) => {
                let times = self.expression(&times.value, &[])?;
                Ok(self.model.graph.multiply(times, sum))
            }
            None => Ok(sum),
        }
    }
}
