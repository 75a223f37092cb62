//! Slopes of a model of a UM-Bridge server, by the product of its Jacobian with weights of outputs (`Gradient`) or with directions
//! of inputs (`ApplyJacobian`): of the two that it offers the one that takes fewer requests.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::call::{Call, Failure};
use super::umbridge::Server;
use crate::study::external::UmBridge;
use crate::thermal::SlopesAt;

/// Slopes by what is asked for, of outputs or of a weighted sum of them.
struct Slopes<'a> {
    call: &'a Call<'a>,
    model: &'a UmBridge,
    by: &'a [usize],
    input: Vec<Vec<f64>>,
}

impl Slopes<'_> {
    /// Positions in an input vector of what is differentiated by: the position there, and the place among `by`.
    fn positions(&self, vector: usize) -> Vec<(usize, usize)> {
        let places = self.model.inputs.get(vector).map_or(&[][..], Vec::as_slice);
        let found = |(position, place): (usize, &usize)| Some((position, self.by.binary_search(place).ok()?));
        places.iter().enumerate().filter_map(found).collect()
    }

    /// Input vectors that hold something that is differentiated by.
    fn vectors(&self) -> Vec<usize> {
        (0..self.model.inputs.len()).filter(|&vector| !self.positions(vector).is_empty()).collect()
    }

    /// Output vectors that hold outputs of the study.
    fn outputs(&self) -> BTreeSet<usize> {
        self.model.outputs.iter().map(|[vector, _]| *vector).collect()
    }

    /// A list of finite numbers, as many as there must be.
    fn asked(&self, server: &Server, path: &str, mut body: Value, length: usize) -> Result<Vec<f64>, Failure> {
        if let Some(fields) = body.as_object_mut() {
            fields.insert("name".to_owned(), json!(self.model.name));
            fields.insert("input".to_owned(), json!(self.input));
            fields.insert("config".to_owned(), self.model.config.clone());
        }
        let value = server.answered(self.call, self.model, path, &body)?;
        let list = value.get("output").and_then(Value::as_array);
        let numbers = list.and_then(|list| list.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>());
        let numbers =
            numbers.filter(|numbers| numbers.len() == length && numbers.iter().all(|slope| slope.is_finite()));
        numbers.ok_or_else(|| {
            Failure::at(
                "the server's answer cannot be read",
                format!("{path}: it has no list of {length} finite numbers"),
            )
        })
    }

    /// The slopes of the sum of outputs with weights (by number of the output), in SI.
    fn weighted(&self, server: &Server, weights: &[(usize, f64)]) -> Result<Vec<f64>, Failure> {
        let mut slopes = vec![0.0; self.by.len()];
        for out in self.outputs() {
            let mut sens = vec![0.0; server.offers.gives.get(out).copied().unwrap_or(0)];
            for &(output, weight) in weights {
                if let Some([vector, place]) = self.model.outputs.get(output)
                    && *vector == out
                    && let Some(slot) = sens.get_mut(*place)
                {
                    *slot += self.call.external.slope_of_output(output, weight);
                }
            }
            if sens.iter().all(|weight| *weight == 0.0) {
                continue;
            }
            for vector in self.vectors() {
                let body = json!({"outWrt": out, "inWrt": vector, "sens": sens});
                let length = self.input.get(vector).map_or(0, Vec::len);
                let gradient = self.asked(server, "/Gradient", body, length)?;
                for (position, by) in self.positions(vector) {
                    slopes[by] += self.call.external.slope_by_given(self.by[by], gradient[position]);
                }
            }
        }
        Ok(slopes)
    }

    /// The slopes of each output (`outputs x by`), in SI, along one direction after the other.
    fn along_directions(&self, server: &Server) -> Result<Vec<f64>, Failure> {
        let columns = self.by.len();
        let mut slopes = vec![0.0; self.model.outputs.len() * columns];
        for vector in self.vectors() {
            for (position, by) in self.positions(vector) {
                let mut direction = vec![0.0; self.input.get(vector).map_or(0, Vec::len)];
                direction[position] = 1.0;
                for out in self.outputs() {
                    let body = json!({"outWrt": out, "inWrt": vector, "vec": direction});
                    let length = server.offers.gives.get(out).copied().unwrap_or(0);
                    let changes = self.asked(server, "/ApplyJacobian", body, length)?;
                    for (output, [_, place]) in
                        self.model.outputs.iter().enumerate().filter(|(_, [vector, _])| *vector == out)
                    {
                        let slope = self.call.external.slope_of_output(output, changes[*place]);
                        slopes[output * columns + by] += self.call.external.slope_by_given(self.by[by], slope);
                    }
                }
            }
        }
        Ok(slopes)
    }
}

impl Server {
    /// The slopes that are asked for, SI.
    pub fn slopes(&self, call: &Call<'_>, model: &UmBridge, asked: &SlopesAt) -> Result<Vec<f64>, Failure> {
        let slopes = Slopes { call, model, by: &asked.by, input: Self::vectors(call, model) };
        let outputs = model.outputs.len();
        let vectors = slopes.vectors();
        let directions: usize = vectors.iter().map(|&vector| slopes.positions(vector).len()).sum();
        let by_directions = directions * slopes.outputs().len();
        // Of a weighted sum a request for each pair of vectors, else one for each output and input vector.
        let sums = if asked.weights.is_some() { slopes.outputs().len() } else { outputs };
        if self.offers.gradient && (!self.offers.apply_jacobian || sums * vectors.len() <= by_directions) {
            return match &asked.weights {
                Some(weights) => {
                    slopes.weighted(self, &weights.iter().copied().enumerate().collect::<Vec<(usize, f64)>>())
                }
                None => {
                    let rows = (0..outputs).map(|output| slopes.weighted(self, &[(output, 1.0)]));
                    Ok(rows.collect::<Result<Vec<_>, _>>()?.concat())
                }
            };
        }
        let each = slopes.along_directions(self)?;
        let Some(weights) = &asked.weights else { return Ok(each) };
        let mut sum = vec![0.0; asked.by.len()];
        for (row, weight) in each.chunks_exact(asked.by.len().max(1)).zip(weights) {
            sum.iter_mut().zip(row).for_each(|(slot, slope)| *slot += weight * slope);
        }
        Ok(sum)
    }
}
