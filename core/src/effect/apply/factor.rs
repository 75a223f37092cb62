//! Additions that change what is there: factors of elements and capacities, offsets of boundaries. Quantities that ask
//! for the heat, current or duty of a changed element follow it.

use std::collections::HashMap;

use crate::document::Spanned;
use crate::expression::ExprId;
use crate::thermal::element::{Contribution, Cooler, ElementKind};
use crate::thermal::{NodeKind, QuantityValue};

use super::{ApplyError, Work};
use crate::effect::checked::REFERENCE;
use crate::effect::place::Site;

impl Work<'_, '_> {
    /// `factor`, `cooler` and `offset`.
    pub(super) fn factors(&mut self) -> Result<(), ApplyError> {
        let adds = &self.instance.effect.form.adds.value;
        if let Some(factor) = &adds.factor {
            if let Site::Nodes(nodes) = &self.instance.site {
                for &(node, _) in nodes.iter() {
                    self.capacity_factor(node, &factor.value)?;
                }
            } else {
                for element in self.place_elements()? {
                    self.change_element(element, |work, kind| work.element_factor(kind, &factor.value))?;
                }
            }
        }
        if let Some(form) = &adds.cooler {
            let factors = [&form.seebeck, &form.resistance, &form.conductance];
            for element in self.place_elements()? {
                self.change_element(element, |work, kind| {
                    let ElementKind::Cooler(cooler) = kind else { return Err(work.misplaced()) };
                    work.cooler_factors(cooler, factors)
                })?;
            }
        }
        if let Some(offset) = &adds.offset {
            let offset = self.expression(&offset.value, &[])?;
            for (node, _, _) in self.place_nodes()? {
                let NodeKind::Boundary { temperature } = self.model.nodes[node].kind else {
                    return Err(self.misplaced());
                };
                let temperature = self.model.graph.add(temperature, offset);
                self.model.nodes[node].kind = NodeKind::Boundary { temperature };
            }
        }
        Ok(())
    }

    fn capacity_factor(&mut self, node: usize, factor: &str) -> Result<(), ApplyError> {
        let NodeKind::Diffusion { capacity } = self.model.nodes[node].kind else { return Err(self.misplaced()) };
        let locals = [("T", self.temperature(node)), self.reference()];
        let factor = self.expression(factor, &locals)?;
        let capacity = self.model.graph.multiply(factor, capacity);
        self.model.nodes[node].kind = NodeKind::Diffusion { capacity };
        Ok(())
    }

    fn element_factor(&mut self, kind: &mut ElementKind, factor: &str) -> Result<(), ApplyError> {
        let physics = kind.physics();
        let mut locals: Vec<(&str, ExprId)> = match (physics.between(), physics.heated()) {
            (Some(between), _) => self.ends(between).to_vec(),
            (None, Some(node)) => vec![("T", self.temperature(node))],
            (None, None) => return Err(self.misplaced()),
        };
        locals.push(self.reference());
        let Some(value) = kind.physics_mut().scaled() else { return Err(self.misplaced()) };
        let factor = self.expression(factor, &locals)?;
        *value = self.model.graph.multiply(factor, *value);
        Ok(())
    }

    fn reference(&mut self) -> (&'static str, ExprId) {
        (REFERENCE, self.model.graph.number(self.instance.reference_k))
    }

    fn cooler_factors(
        &mut self,
        cooler: &mut Cooler,
        factors: [&Option<Spanned<String>>; 3],
    ) -> Result<(), ApplyError> {
        let (Some(&cold), Some(&hot)) = (cooler.nodes.first(), cooler.nodes.last()) else {
            return Err(self.misplaced());
        };
        let locals = self.ends([cold, hot]);
        let values = [&mut cooler.seebeck, &mut cooler.resistance, &mut cooler.conductance];
        for (value, factor) in values.into_iter().zip(factors) {
            if let Some(factor) = factor {
                let factor = self.expression(&factor.value, &locals)?;
                *value = self.model.graph.multiply(factor, *value);
            }
        }
        Ok(())
    }

    /// Changes an element, and with it the quantities that ask for its heat, current or duty.
    pub(super) fn change_element(
        &mut self,
        element: usize,
        change: impl FnOnce(&mut Self, &mut ElementKind) -> Result<(), ApplyError>,
    ) -> Result<(), ApplyError> {
        let before = self.contribution(element);
        let mut kind = self.model.elements[element].kind.clone();
        change(self, &mut kind)?;
        self.model.elements[element].kind = kind;
        let after = self.contribution(element);
        let pairs = [(before.through, after.through), (before.current, after.current), (before.duty, after.duty)];
        // A constant may stand in a quantity for many reasons.
        let replacements: HashMap<ExprId, ExprId> = pairs
            .into_iter()
            .filter_map(|(old, new)| Some((old?, new?)))
            .filter(|(old, _)| self.model.graph.constant(*old).is_none())
            .collect();
        let roots: Vec<ExprId> = self.model.quantities.iter().map(|quantity| quantity.value.expression()).collect();
        let renewed = self.model.graph.substitute(&roots, &replacements);
        for (quantity, expression) in self.model.quantities.iter_mut().zip(renewed) {
            quantity.value = match quantity.value {
                QuantityValue::Instant(_) => QuantityValue::Instant(expression),
                QuantityValue::Maximum(_) => QuantityValue::Maximum(expression),
                QuantityValue::Minimum(_) => QuantityValue::Minimum(expression),
                QuantityValue::TimeMean(_) => QuantityValue::TimeMean(expression),
            };
        }
        Ok(())
    }

    fn contribution(&mut self, element: usize) -> Contribution {
        self.model.elements[element].contribution(&mut self.model.graph, &mut Vec::new(), false)
    }
}
