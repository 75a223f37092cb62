//! The group that the sensors of a test imply.

use crate::thermal::Model;

use super::candidate::GroupPlace;
use super::place::{SensorPlace, Site};

/// Name of the group of all thermometers.
const THERMOMETERS: &str = "all thermometers";

/// The group of all thermometers of a test, which one logger reads and one kind of mounting holds; `None` where there is one
/// only, or one of the groups has them all.
pub fn thermometers(model: &Model, groups: &[GroupPlace], sensors: &[SensorPlace]) -> Option<GroupPlace> {
    let is_thermometer = |sensor: &&SensorPlace| model.quantities[sensor.quantity].is_temperature;
    let all: Vec<SensorPlace> = sensors.iter().filter(is_thermometer).cloned().collect();
    let has_all = |group: &GroupPlace| matches!(&group.site, Site::Sensors(own) if *own == all);
    let is_there = groups.iter().any(|group| group.name == THERMOMETERS || has_all(group));
    (all.len() > 1 && !is_there).then(|| GroupPlace { name: THERMOMETERS.to_owned(), site: Site::Sensors(all) })
}
