//! The group that the sensors of a test imply.

use crate::thermal::Model;

use super::candidate::{Candidate, GroupPlace};
use super::checked::Effect;
use super::place::{SensorPlace, Site};

/// Name of the group of all thermometers.
const THERMOMETERS: &str = "all thermometers";

/// Whether a sensor is a thermometer.
fn is_thermometer(model: &Model, sensor: &SensorPlace) -> bool {
    model.quantities.get(sensor.quantity).is_some_and(|quantity| quantity.is_temperature)
}

/// The group of all thermometers of a test, which one logger reads and one kind of mounting holds; `None` where there is one
/// only, or one of the groups has them all.
pub fn thermometers(model: &Model, groups: &[GroupPlace], sensors: &[SensorPlace]) -> Option<GroupPlace> {
    let all: Vec<SensorPlace> = sensors.iter().filter(|sensor| is_thermometer(model, sensor)).cloned().collect();
    let has_all = |group: &GroupPlace| matches!(&group.site, Site::Sensors(own) if *own == all);
    let is_there = groups.iter().any(|group| group.name == THERMOMETERS || has_all(group));
    (all.len() > 1 && !is_there).then(|| GroupPlace { name: THERMOMETERS.to_owned(), site: Site::Sensors(all) })
}

/// Whether an effect acts on all thermometers of a test at once, and there are several.
fn is_of_all(candidate: &Candidate, model: &Model, sensors: &[SensorPlace]) -> bool {
    let Site::Sensors(own) = &candidate.site else { return false };
    let has = |sensor: &SensorPlace| own.iter().any(|one| one.name == sensor.name);
    candidate.is_group() && own.len() > 1 && sensors.iter().filter(|sensor| is_thermometer(model, sensor)).all(has)
}

impl Effect {
    /// Its title at the place of a candidate, in a test with these sensors.
    pub fn title_at(&self, candidate: &Candidate, model: &Model, sensors: &[SensorPlace]) -> &str {
        let of_all = self.form.title_of_all_thermometers.as_ref();
        of_all.filter(|_| is_of_all(candidate, model, sensors)).unwrap_or(&self.form.title)
    }
}
