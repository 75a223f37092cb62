//! The parameters of the components, taken from the list in order.

use crate::deck::Parameter;

use super::assembly::Assembly;
use super::component::Component;
use super::specification::Fitted;

/// A fitted time constant.
#[derive(Debug)]
pub struct TimeConstant {
    /// Identifier of its parameter.
    pub name: String,
    /// Its value in the file.
    pub value_ks: f64,
}

impl<'a> Assembly<'a> {
    /// The next parameter of the list, which belongs to this component: its identifier.
    ///
    /// xija gives parameters to components by their place in the list. The names there are often stale, so that only
    /// another kind of name is refused.
    ///
    /// # Errors
    /// The end of the list; a parameter of another kind.
    pub fn parameter(
        &mut self,
        component: &Component<'_>,
        name: &str,
        unit: &str,
        si: impl Fn(f64) -> f64,
    ) -> Result<String, String> {
        let fitted = self.fitted(name)?;
        let stale = if fitted.component == component.name && fitted.name == name { "" } else { ", renamed" };
        self.renamed += usize::from(!stale.is_empty());
        let frozen = if fitted.is_frozen { ", frozen in xija's fit" } else { "" };
        let bounds = fitted.bounds.filter(|[lower, upper]| lower.max(-upper) > -1e30 && upper - lower < 1e30);
        let bounds = bounds.map(|[lower, upper]| format!(", {lower} to {upper} in xija's unit")).unwrap_or_default();
        let description = format!("{}__{}{bounds}{frozen}{stale}", fitted.component, fitted.name);
        let name = self.identifier(&format!("{}__{name}", component.name));
        let nominal = si(fitted.value);
        if !nominal.is_finite() {
            return Err(format!("the parameter `{}` is too large", fitted.name));
        }
        self.deck.parameters.push(Parameter { name: name.clone(), unit: unit.to_owned(), nominal, description });
        Ok(name)
    }

    /// The name of the next parameter of the list.
    pub fn next_name(&self) -> Option<&'a str> {
        self.specification.fitted.get(self.next).map(|fitted| fitted.name)
    }

    /// The value of the next parameter of the list.
    pub fn next_value(&self) -> Option<f64> {
        self.specification.fitted.get(self.next).map(|fitted| fitted.value)
    }

    /// The next parameter's entry of the list.
    ///
    /// # Errors
    /// The end of the list; a parameter of another kind.
    pub fn fitted(&mut self, name: &str) -> Result<&'a Fitted<'a>, String> {
        let specification = self.specification;
        let fitted = specification.fitted.get(self.next).ok_or_else(|| {
            format!("its parameter `{name}` is missing: `pars` ends before it; list the parameters of all components in order")
        })?;
        let kind = |text: &str| match text {
            "factor" => "tau".to_owned(),
            _ => text.split_once('_').map_or(text, |halves| halves.0).to_owned(),
        };
        if kind(fitted.name) != kind(name) {
            return Err(format!(
                "its parameter `{name}` is expected at place {} of `pars`, where `{}` of `{}` stands; xija takes \
                 parameters by their order: list those of each component in the order of `comps`",
                self.next + 1,
                fitted.name,
                fitted.component
            ));
        }
        self.next += 1;
        Ok(fitted)
    }

    /// The next parameter as a time constant in ks, which is a resistance in K/W.
    ///
    /// # Errors
    /// As [`Self::parameter`]; a value not above 0.
    pub fn time_constant(&mut self, component: &Component<'_>) -> Result<TimeConstant, String> {
        let value_ks = self.next_value().unwrap_or(f64::NAN);
        let name = self.parameter(component, "tau", "K/W", |tau| tau)?;
        if value_ks > 0.0 {
            Ok(TimeConstant { name, value_ks })
        } else {
            Err(format!("its time constant `tau` is {value_ks}; it must be above 0 ks"))
        }
    }
}
