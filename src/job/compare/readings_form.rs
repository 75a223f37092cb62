//! Readings in JSON: a list of rows; of many a list of tables, whose numbers are arrays beside the JSON.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::readings::{Channel, Readings, Row, Table, is_long};
use crate::job::array::Array;

/// Many readings.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Tables {
    /// Their tables, in the order of the measurements.
    tables: Vec<TableForm>,
}

/// The readings of a measurement.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Table")]
struct TableForm {
    /// Measurement.
    measurement: String,
    /// Sensors, in the order of the columns.
    sensors: Vec<Channel>,
    /// Phases of a steady measurement, in the order of the rows.
    #[serde(default)]
    phases: Vec<Option<String>>,
    /// Instants of a transient, s, in the order of the rows.
    time_s: Option<Array>,
    /// 1 for each row that is kept from every fit, else 0.
    held_out: Array,
    /// Readings, SI: a row a phase or an instant, a column a sensor; NaN where none was read, or nothing predicted.
    measured: Array,
    /// Predictions, SI, in the same order.
    predicted: Array,
    /// Predictions of the tuned state, SI, in the same order; NaN where it has none.
    predicted_tuned: Option<Array>,
}

impl From<&Table> for TableForm {
    fn from(table: &Table) -> Self {
        Self {
            measurement: table.measurement.clone(),
            sensors: table.channels.clone(),
            phases: table.phases.clone(),
            time_s: table.time_s.clone(),
            held_out: table.held_out.clone(),
            measured: table.measured.clone(),
            predicted: table.predicted.clone(),
            predicted_tuned: table.tuned.clone(),
        }
    }
}

impl From<TableForm> for Table {
    fn from(form: TableForm) -> Self {
        Self {
            measurement: form.measurement,
            channels: form.sensors,
            phases: form.phases,
            time_s: form.time_s,
            held_out: form.held_out,
            measured: form.measured,
            predicted: form.predicted,
            tuned: form.predicted_tuned,
        }
    }
}

impl Serialize for Readings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if is_long(self.len()) {
            Tables { tables: self.tables().iter().map(TableForm::from).collect() }.serialize(serializer)
        } else {
            serializer.collect_seq(self.iter())
        }
    }
}

impl<'de> Deserialize<'de> for Readings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Readings;

            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("a list of readings, or their tables")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<Readings, A::Error> {
                std::iter::from_fn(|| rows.next_element::<Row>().transpose()).collect()
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Readings, A::Error> {
                let form = Tables::deserialize(MapAccessDeserializer::new(map))?;
                Ok(form.tables.into_iter().map(Table::from).collect())
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl JsonSchema for Readings {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Readings".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let [rows, tables] = [generator.subschema_for::<Vec<Row>>(), generator.subschema_for::<Tables>()];
        schemars::json_schema!({ "anyOf": [rows, tables] })
    }
}
