//! What is said of a whole specification.

use serde_json::Value as Json;

use crate::deck::Note;

use super::assembly::Assembly;
use super::network;

impl Assembly<'_> {
    /// Adds what an engineer should know of the file before using the deck.
    pub fn general_notes(&mut self) {
        let specification = self.specification;
        let mut messages = vec![
            "xija has no heat capacities: every node is given 1000 J/K, so that 1/tau in 1/ks is a conductance in W/K and \
             1 K/ks is 1 W; only ratios to that capacity mean something"
                .to_owned(),
            "t counts seconds from 1998-01-01 in days of 86400 s: no leap seconds; Chandra's own seconds are ahead by 63 to \
             69 s, which no heat here can tell"
                .to_owned(),
        ];
        if self.deck.inputs.iter().any(|input| input.unit == "1") {
            let message = "inputs without a unit are states (0 or 1, counts, positions) and keep a value until the next; \
                           xija with evolve_method 2 instead takes heats linear between its instants";
            messages.push(message.to_owned());
        }
        if self.renamed > 0 {
            messages.push(format!(
                "{} parameters stand in `pars` under a name of another version of the model; as in xija their place in the \
                 list counts (see their descriptions)",
                self.renamed
            ));
        }
        let text = |key: &str| specification.document.get(key).and_then(Json::as_str);
        if let Some((start, stop)) = text("datestart").zip(text("datestop")) {
            messages.push(format!("the file was last fitted or run over {start} to {stop}"));
        }
        if let Some(times) =
            specification.document.get("bad_times").and_then(Json::as_array).filter(|list| !list.is_empty())
        {
            let ends = |value: Option<&Json>| value.map(Json::to_string).unwrap_or_default().replace('"', "");
            let (first, last) = (ends(times.first()), ends(times.last()));
            messages.push(format!(
                "the file leaves {} intervals (`bad_times`, from {first} to {last}) out of its fit: leave their readings out",
                times.len()
            ));
        }
        for (sensor, limits) in specification.document.get("limits").and_then(Json::as_object).into_iter().flatten() {
            messages.push(format!(
                "limits of {sensor}: {}",
                limits.to_string().replace(['"', '{', '}'], "").replace(',', ", ")
            ));
        }
        self.deck.notes.push(specification.method.note(self.capacity_j_per_k));
        self.deck.notes.extend(messages.into_iter().map(Note::new));
        let rates = network::rates_per_ks(&self.deck, &self.taus_ks, &self.heater_rates_per_ks).into_iter();
        let errors = rates.map(|rate| specification.method.relative_error(rate / 1000.0, specification.step_s));
        for (node, error) in self.deck.nodes.iter().zip(errors).filter(|(_, error)| *error > 0.05) {
            let size = if error < 0.5 { format!("about {:.0} %", 100.0 * error) } else { "more than half".to_owned() };
            let message = format!(
                "node {} is fast for the file's step of {} s: xija's own transients of it are off by {size}, so that an exact \
                 solution differs from them",
                node.name, specification.step_s,
            );
            self.deck.notes.push(Note::new(message).of_node(&node.name));
        }
    }
}
