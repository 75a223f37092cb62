//! Arrays as netCDF-4 (Unidata's data model on HDF5): a group each, with a coordinate variable a dimension. Nothing in it
//! depends on when it was written.

use netcdf_writer::{DimensionId, Error, NcAttrValue, NcFileBuilder, NcWriteFormat, NcWriteOptions};

use crate::batch::BatchError;
use crate::job::dataset::{Attribute, Dataset, Dimension, Group, Labels, Values};

/// The file.
///
/// # Errors
/// What the format cannot hold, such as a NUL in a text.
pub(super) fn bytes(dataset: &Dataset) -> Result<Vec<u8>, BatchError> {
    build(dataset).map_err(|error| BatchError::job(format!("no netCDF file can hold this: {error}")))
}

fn build(dataset: &Dataset) -> Result<Vec<u8>, Error> {
    let mut builder = NcFileBuilder::new();
    for (name, value) in &dataset.attributes {
        builder.add_attribute(*name, attribute(value))?;
    }
    for group in &dataset.groups {
        // Programs read the attributes of a group, not those of the file.
        for (name, value) in dataset.attributes.iter().chain(&group.attributes) {
            builder.add_group_attribute(group.name, *name, attribute(value))?;
        }
        add(&mut builder, group)?;
    }
    let (_, bytes) = builder.to_vec(NcWriteOptions { format: NcWriteFormat::Nc4 })?;
    Ok(bytes)
}

fn add(builder: &mut NcFileBuilder, group: &Group) -> Result<(), Error> {
    let rows =
        group.rows.iter().map(|dimension| coordinate(builder, group, dimension)).collect::<Result<Vec<_>, _>>()?;
    // Dimensions of single variables, each once.
    let mut further: Vec<(&'static str, DimensionId)> = Vec::new();
    for variable in &group.variables {
        let mut dimensions = rows.clone();
        if let Some(across) = &variable.across {
            let known = further.iter().find(|(name, _)| *name == across.name).map(|(_, id)| *id);
            let id = match known {
                Some(id) => id,
                None => {
                    let id = coordinate(builder, group, across)?;
                    further.push((across.name, id));
                    id
                }
            };
            dimensions.push(id);
        }
        let path = format!("{}/{}", group.name, variable.name);
        let id = match &variable.values {
            Values::Numbers(values) => {
                let id = builder.add_variable_path::<f64>(path, &dimensions)?;
                builder.write_variable(id, values)?;
                id
            }
            Values::Texts(values) => {
                let id = builder.add_string_variable_path(path, &dimensions)?;
                builder.write_string_variable(id, values)?;
                id
            }
        };
        builder.add_variable_attribute(id, "long_name", NcAttrValue::Chars(variable.about.clone()))?;
        if let Some(unit) = &variable.unit {
            builder.add_variable_attribute(id, "units", NcAttrValue::Chars(unit.clone()))?;
        }
    }
    Ok(())
}

/// A dimension with its coordinate variable.
fn coordinate(builder: &mut NcFileBuilder, group: &Group, dimension: &Dimension) -> Result<DimensionId, Error> {
    let path = format!("{}/{}", group.name, dimension.name);
    let id = builder.add_dimension_path(path.clone(), dimension.labels.len() as u64)?;
    match &dimension.labels {
        Labels::Places(places) => {
            let variable = builder.add_variable_path::<i64>(path, &[id])?;
            let places: Vec<i64> = places.iter().map(|&place| i64::try_from(place).unwrap_or(i64::MAX)).collect();
            builder.write_variable(variable, &places)?;
        }
        Labels::Names(names) => {
            let variable = builder.add_string_variable_path(path, &[id])?;
            builder.write_string_variable(variable, names)?;
        }
    }
    Ok(id)
}

fn attribute(value: &Attribute) -> NcAttrValue {
    match value {
        Attribute::Text(text) => NcAttrValue::Chars(text.clone()),
        Attribute::Whole(number) => NcAttrValue::Int64s(vec![i64::try_from(*number).unwrap_or(i64::MAX)]),
        Attribute::Numbers(numbers) => NcAttrValue::Doubles(numbers.clone()),
    }
}
