//! Every effect of a catalogue at every place of a model where it could be.
//!
//! `limits`: what of a model is a place, and what of a large one is chosen. `spots`: the places of an effect. `bindings`: what its
//! inputs may stand for there.

mod bindings;
mod limits;
mod spots;

use crate::thermal::Model;

use super::candidate::{Candidate, GroupPlace};
use super::catalogue::Catalogue;
use super::checked::Effect;
use super::form::SeenBy;
use super::place::{Bound, PlaceKind, SensorPlace, Site};
use super::same_law::without_copies;
use bindings::bindings;
use limits::Among;
pub use limits::{Chosen, Limits};
use spots::{Spot, spots};

/// All candidates, in the order of the catalogue, then of the model, within the usual [limits](Limits).
pub fn candidates(
    model: &Model,
    groups: &[GroupPlace],
    sensors: &[SensorPlace],
    catalogue: &Catalogue,
) -> Vec<Candidate> {
    candidates_within(&Limits::default(), model, groups, sensors, catalogue)
}

/// The same; where pairs are to be chosen those between two nodes are not among them, where nodes and elements are to be chosen too
/// only those at groups, boundaries, sensors, and elements of kinds of which the model has few.
pub fn candidates_within(
    limits: &Limits,
    model: &Model,
    groups: &[GroupPlace],
    sensors: &[SensorPlace],
    catalogue: &Catalogue,
) -> Vec<Candidate> {
    let among = Among::of(model, limits);
    let mut candidates = Vec::new();
    for effect in catalogue.effects() {
        for spot in spots(effect, model, groups, sensors, &among) {
            for bound in bindings(effect, model, &spot.nodes) {
                candidates.push(candidate(effect, model, &spot, bound, sensors));
            }
        }
    }
    without_copies(catalogue, candidates)
}

/// The candidates at chosen places, in their order, then that of the catalogue, with effects that are wanted.
pub fn candidates_at(
    model: &Model,
    sensors: &[SensorPlace],
    catalogue: &Catalogue,
    chosen: &[Chosen],
    wanted: impl Fn(&str) -> bool,
) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for &place in chosen {
        let among = Among::from(place);
        let (acts, own): (fn(PlaceKind) -> bool, &[SensorPlace]) = match place {
            Chosen::Pair(_) => (|kind| kind == PlaceKind::Pair, &[]),
            Chosen::Node(_) => (|kind| matches!(kind, PlaceKind::Node | PlaceKind::Capacity), &[]),
            Chosen::Element(_) => (PlaceKind::is_of_elements, &[]),
            Chosen::Surroundings(_) => (|kind| kind == PlaceKind::Sensor, sensors),
        };
        let fits = |effect: &&Effect| wanted(&effect.name) && effect.places.iter().any(|&kind| acts(kind));
        for effect in catalogue.effects().iter().filter(fits) {
            for spot in spots(effect, model, &[], own, &among) {
                for bound in bindings(effect, model, &spot.nodes) {
                    // What does not know the node's temperature is a candidate without it.
                    let is_new = match place {
                        Chosen::Surroundings(node) => bound.contains(&Bound::Node(node)),
                        _ => true,
                    };
                    if is_new {
                        candidates.push(candidate(effect, model, &spot, bound, sensors));
                    }
                }
            }
        }
    }
    without_copies(catalogue, candidates)
}

fn candidate(effect: &Effect, model: &Model, spot: &Spot, bound: Vec<Bound>, sensors: &[SensorPlace]) -> Candidate {
    let of_sensor = effect.places.contains(&PlaceKind::Sensor);
    let mut place = spot.names.clone();
    // When is no name of a place.
    let bound_names = bound.iter().filter(|one| !one.is_clock(model)).map(|one| one.name(model));
    let names: Vec<&str> = bound_names.collect();
    // A node that a sensor's reading depends on is part of the sensor's place.
    let node = of_sensor && matches!(bound.as_slice(), [Bound::Node(_)]);
    if node {
        place.extend(names.iter().map(|name| (*name).to_owned()));
    }
    let input = (!names.is_empty() && !node).then(|| names.join("*"));
    let mut id = effect.name.clone();
    for part in place.iter().chain(&input) {
        id.push(':');
        id.push_str(part);
    }
    let watching: &[SensorPlace] = match &spot.site {
        Site::Sensors(measured) => measured,
        _ => sensors,
    };
    let seen =
        |by: SeenBy, has: fn(&SensorPlace) -> bool| effect.form.seen_by.contains(&by) && watching.iter().any(has);
    Candidate {
        id,
        effect: effect.name.clone(),
        where_kind: spot.kind,
        place,
        input,
        site: spot.site.clone(),
        bound,
        steady: seen(SeenBy::Steady, |sensor| sensor.steady),
        transient: seen(SeenBy::Transient, |sensor| sensor.transient),
    }
}
