//! A server of the UM-Bridge protocol (Seelinger et al. 2023, J. Open Source Software 8, 4748; version 1.0), asked for values;
//! [`super::umbridge_slopes`] asks it for slopes.

use std::net::{IpAddr, SocketAddr, ToSocketAddrs};
use std::time::Duration;

use serde_json::{Value, json};

use super::call::{Call, Failure};
use crate::runner::http::client::{Answer, Client, Silence};
use crate::study::external::{External, UmBridge};
use crate::thermal::{Derivatives, Fault};

/// Characters shown of an answer.
const SHOWN: usize = 200;
/// Errors that every point would give.
const OF_ALL_POINTS: [&str; 3] = ["ModelNotFound", "UnsupportedFeature", "InvalidRequest"];

/// A server that can be asked.
#[derive(Debug)]
pub(super) struct Server {
    client: Client,
    timeout: Duration,
    /// What it offers of slopes.
    pub(super) offers: Offers,
}

/// What a server offers of slopes, once it was asked.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Offers {
    /// Whether it gives products of weights of an output vector with the Jacobian.
    pub gradient: bool,
    /// Whether it gives products of the Jacobian with a direction of an input vector.
    pub apply_jacobian: bool,
    /// Lengths of its output vectors.
    pub gives: Vec<usize>,
}

impl Server {
    /// The server of a model; of this machine alone unless others are allowed.
    ///
    /// # Errors
    /// An address that is not asked.
    pub fn new(external: &External, model: &UmBridge, is_remote_allowed: bool) -> Result<Self, String> {
        let host = &model.host;
        let name = host.rsplit_once(':').map_or(host.as_str(), |(name, _)| name).trim_matches(['[', ']']);
        let is_local = name == "localhost" || name.parse::<IpAddr>().is_ok_and(|address| address.is_loopback());
        if !is_local && !is_remote_allowed {
            return Err(format!(
                "`{name}` is not this machine, and models are asked on this machine alone: give --allow-remote-models if \
                 parameters may go there, unencrypted"
            ));
        }
        let addresses: Vec<SocketAddr> =
            host.to_socket_addrs().map_err(|error| format!("`{host}` has no address: {error}"))?.collect();
        let timeout = Duration::try_from_secs_f64(external.calls.timeout_s).unwrap_or(Duration::MAX / 4);
        Ok(Self { client: Client::new(host, addresses), timeout, offers: Offers::default() })
    }

    /// The server, once the model is there and has the vectors, and the slopes, that the study says.
    ///
    /// # Errors
    /// Nothing answers, or something else.
    pub fn checked(self, external: &External, model: &UmBridge) -> Result<Self, String> {
        let about = self.asked(model, "/ModelInfo", json!({"name": model.name}))?;
        let supports =
            |what: &str| about.pointer(&format!("/support/{what}")).and_then(Value::as_bool).unwrap_or_default();
        if !supports("Evaluate") {
            return Err(format!("the model `{}` of the server cannot be evaluated", model.name));
        }
        let (gradient, apply_jacobian) = (supports("Gradient"), supports("ApplyJacobian"));
        if external.derivatives == Derivatives::Served && !gradient && !apply_jacobian {
            return Err(format!(
                "the study says that the derivatives of the model `{}` are served, and the server offers neither Gradient nor \
                 ApplyJacobian: leave `derivatives` out, and state `steps` of differences where methods need them",
                model.name
            ));
        }
        let sizes = |path: &str, field: &str| -> Result<Vec<usize>, String> {
            let answer = self.asked(model, path, json!({"name": model.name, "config": model.config}))?;
            let list = answer.get(field).and_then(Value::as_array);
            let list = list.and_then(|list| list.iter().map(Value::as_u64).collect::<Option<Vec<u64>>>());
            let list = list.ok_or_else(|| format!("{path} of the server gives no `{field}`"))?;
            Ok(list.into_iter().map(|size| usize::try_from(size).unwrap_or(usize::MAX)).collect())
        };
        let (takes, given) = (sizes("/InputSizes", "inputSizes")?, model.inputs.iter().map(Vec::len));
        let given: Vec<usize> = given.collect();
        if takes != given {
            let names = |places: &Vec<usize>| -> String {
                let names = places.iter().filter_map(|&place| external.given.get(place));
                names.map(|given| given.name.as_str()).collect::<Vec<_>>().join(", ")
            };
            let vectors: Vec<String> = model.inputs.iter().map(|places| format!("[{}]", names(places))).collect();
            return Err(format!(
                "the model `{}` takes vectors of {takes:?} numbers, and the study gives {given:?}: {}; state their order under \
                 `inputs`",
                model.name,
                vectors.join(", ")
            ));
        }
        let gives = sizes("/OutputSizes", "outputSizes")?;
        let missing = model
            .outputs
            .iter()
            .zip(&external.outputs)
            .find(|([vector, place], _)| gives.get(*vector).is_none_or(|size| place >= size));
        if let Some(([vector, place], output)) = missing {
            return Err(format!(
                "the model `{}` gives vectors of {gives:?} numbers, and `{}` would be number {place} of vector {vector} (from 0): \
                 state its place under `at`",
                model.name, output.name
            ));
        }
        Ok(Self { offers: Offers { gradient, apply_jacobian, gives }, ..self })
    }

    /// The answer to a question that does not depend on the point.
    fn asked(&self, model: &UmBridge, path: &str, body: Value) -> Result<Value, String> {
        let path = format!("{}{path}", model.path);
        let url = format!("http://{}{}", model.host, model.path);
        let posted = self.client.post(&path, body.to_string().as_bytes(), self.timeout, &|| {
            crate::watch::check();
            false
        });
        let response = posted.map_err(|silence| match silence {
            Silence::Unreachable(why) => format!("nothing answers at {url} ({why}): start the server of the model"),
            Silence::TimedOut => format!("the server at {url} does not answer {path} in time"),
            Silence::Unreadable(why) => format!("{url}: {why}"),
        })?;
        let value: Value = serde_json::from_slice(&response.body).map_err(|_| {
            format!("{url} is no server of the UM-Bridge protocol: {path} is answered by {}", shown(&response))
        })?;
        match value.get("error") {
            None if response.status < 400 => Ok(value),
            _ => Err(format!("the server at {url} refuses {path}: {}", said(&value, &response))),
        }
    }

    /// The input vectors at a point.
    pub(super) fn vectors(call: &Call<'_>, model: &UmBridge) -> Vec<Vec<f64>> {
        let number = |place: &usize| call.given.get(*place).copied().unwrap_or(f64::NAN);
        model.inputs.iter().map(|places| places.iter().map(number).collect()).collect()
    }

    /// The numbers of the outputs at a point.
    pub fn call(&self, call: &Call<'_>, model: &UmBridge) -> Result<Vec<f64>, Failure> {
        let body = json!({"name": model.name, "input": Self::vectors(call, model), "config": model.config});
        let value = self.answered(call, model, "/Evaluate", &body)?;
        let at = |(place, output): (&[usize; 2], &crate::study::external::Output)| {
            let found = value.pointer(&format!("/output/{}/{}", place[0], place[1]));
            found.and_then(Value::as_f64).ok_or_else(|| {
                Failure::at("the server's answer cannot be read", format!("it has no number for `{}`", output.name))
            })
        };
        model.outputs.iter().zip(&call.external.outputs).map(at).collect()
    }

    /// The answer to a question about a point.
    pub(super) fn answered(
        &self,
        call: &Call<'_>,
        model: &UmBridge,
        path: &str,
        body: &Value,
    ) -> Result<Value, Failure> {
        let (path, body) = (format!("{}{path}", model.path), body.to_string());
        let response =
            self.client.post(&path, body.as_bytes(), self.timeout, call.is_over).map_err(|silence| match silence {
                Silence::Unreachable(why) => Failure::Broken(format!("the server at {} is gone: {why}", model.host)),
                Silence::TimedOut => {
                    Failure::at("the server took longer than the timeout", format!("{} s", self.timeout.as_secs_f64()))
                }
                Silence::Unreadable(why) => Failure::at("the server's answer cannot be read", why),
            })?;
        let value: Result<Value, _> = serde_json::from_slice(&response.body);
        match value {
            Ok(value) if response.status < 400 && value.get("error").is_none() => Ok(value),
            Ok(value) => {
                let kind = value.pointer("/error/type").and_then(Value::as_str).unwrap_or_default();
                if OF_ALL_POINTS.contains(&kind) {
                    return Err(Failure::Broken(format!("the server refuses: {}", said(&value, &response))));
                }
                Err(refused(said(&value, &response)))
            }
            Err(_) if response.status >= 400 => Err(refused(shown(&response))),
            Err(error) => Err(Failure::at("the server's answer cannot be read", error.to_string())),
        }
    }
}

/// A point that the model refuses, however often it is asked.
fn refused(detail: String) -> Failure {
    Failure::Refused(Fault { what: "the server has no value at the point", detail })
}

/// What an error says.
fn said(value: &Value, response: &Answer) -> String {
    let text = |field: &str| value.pointer(field).and_then(Value::as_str);
    match (text("/error/type"), text("/error/message")) {
        (Some(kind), Some(message)) => plain(&format!("{kind}: {message}")),
        (None, Some(message)) => plain(message),
        _ => shown(response),
    }
}

/// Status and beginning of an answer.
fn shown(response: &Answer) -> String {
    let text = plain(&String::from_utf8_lossy(&response.body));
    format!("status {}{}", response.status, if text.is_empty() { text } else { format!(", {text}") })
}

fn plain(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(SHOWN).collect()
}
