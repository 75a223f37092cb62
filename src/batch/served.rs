//! A model as the UM-Bridge protocol sees it (Seelinger et al. 2023, J. Open Source Software 8, 4748; version 1.0): `/Info`,
//! `/ModelInfo`, `/InputSizes`, `/OutputSizes`, `/Evaluate`, `/Gradient`, `/ApplyJacobian`. Bodies are JSON, a wrong request
//! is answered by `{"error": {"type", "message"}}`.

use serde_json::{Value, json};

use crate::document::counted;
use crate::job::JobError;
use crate::job::steady_model::{Entry, SteadyModel};
use crate::runner::http::{Handler, Request, Response};

/// The protocol's version.
const PROTOCOL: f64 = 1.0;
/// Name of the model.
pub const NAME: &str = "forward";
/// Names shown at most.
const MOST_SHOWN: usize = 12;

/// A model that is served.
pub struct Served {
    /// The model.
    pub model: SteadyModel,
}

/// Why a request has no answer: status, type of the error, message.
struct Refused(u16, &'static str, String);

impl Refused {
    fn input(message: impl Into<String>) -> Self {
        Self(400, "InvalidInput", message.into())
    }
}

impl From<JobError> for Refused {
    fn from(error: JobError) -> Self {
        Self(500, "EvaluationFailed", error.to_string())
    }
}

impl Handler for Served {
    fn answer(&self, request: &Request) -> Response {
        let (status, body) = match self.answered(request) {
            Ok(body) => (200, body),
            Err(Refused(status, kind, message)) => (status, json!({"error": {"type": kind, "message": message}})),
        };
        Response::json(status, body.to_string().into_bytes())
    }

    fn refusal(&self, status: u16, reason: &str) -> Response {
        let body = json!({"error": {"type": "InvalidRequest", "message": reason}});
        Response::json(status, body.to_string().into_bytes())
    }
}

impl Served {
    fn answered(&self, request: &Request) -> Result<Value, Refused> {
        let posted: fn(&Self, &Value) -> Result<Value, Refused> = match (request.method.as_str(), request.path.as_str())
        {
            ("GET", "/Info" | "/info") => return Ok(json!({"protocolVersion": PROTOCOL, "models": [NAME]})),
            (_, "/ModelInfo") => Self::model_info,
            (_, "/InputSizes") => |own, _| Ok(json!({"inputSizes": own.input_sizes()})),
            (_, "/OutputSizes") => |own, _| Ok(json!({"outputSizes": [own.model.outputs().len()]})),
            (_, "/Evaluate") => Self::evaluate,
            (_, path @ ("/Gradient" | "/ApplyJacobian")) if !self.model.has_derivatives() => {
                let message =
                    format!("`{path}` is not offered: the model is asked outside and has no exact derivatives");
                return Err(Refused(400, "UnsupportedFeature", message));
            }
            (_, "/Gradient") => Self::gradient,
            (_, "/ApplyJacobian") => Self::apply_jacobian,
            (_, "/ApplyHessian") => {
                return Err(Refused(400, "UnsupportedFeature", "ApplyHessian is not offered".to_owned()));
            }
            (_, path) => {
                return Err(Refused(404, "UnsupportedFeature", format!("there is no `{path}`: ask /Info first")));
            }
        };
        if request.method != "POST" {
            return Err(Refused(405, "InvalidRequest", format!("`{}` is asked by POST", request.path)));
        }
        let asked: Value = serde_json::from_slice(&request.body)
            .map_err(|error| Refused::input(format!("the body is no JSON: {error}")))?;
        match asked.get("name").and_then(Value::as_str) {
            Some(NAME) => {}
            Some(other) => {
                let message = format!("there is no model `{other}`, only `{NAME}`");
                return Err(Refused(400, "ModelNotFound", message));
            }
            None => return Err(Refused::input(format!("the body has no `name`: \"name\": \"{NAME}\""))),
        }
        match asked.get("config") {
            None | Some(Value::Null) => {}
            Some(Value::Object(settings)) if settings.is_empty() => {}
            Some(_) => return Err(Refused::input("the model takes no `config`: leave it empty")),
        }
        posted(self, &asked)
    }

    fn input_sizes(&self) -> Vec<usize> {
        self.model.inputs().iter().map(Vec::len).collect()
    }

    fn model_info(&self, _: &Value) -> Result<Value, Refused> {
        Ok(json!({
            "support": {
                "Evaluate": true,
                "Gradient": self.model.has_derivatives(),
                "ApplyJacobian": self.model.has_derivatives(),
                "ApplyHessian": false,
            },
            // Beyond the protocol: what the places of the vectors are.
            "inputs": self.model.inputs(),
            "outputs": [self.model.outputs()],
        }))
    }

    fn evaluate(&self, asked: &Value) -> Result<Value, Refused> {
        Ok(json!({"output": [self.model.evaluate(&self.at(asked)?)?]}))
    }

    fn gradient(&self, asked: &Value) -> Result<Value, Refused> {
        let (at, input) = (self.at(asked)?, self.chosen(asked)?);
        let weights = vector(asked.get("sens"), "sens", self.model.outputs())?;
        Ok(json!({"output": self.model.gradient(&at, input, &weights)?}))
    }

    fn apply_jacobian(&self, asked: &Value) -> Result<Value, Refused> {
        let (at, input) = (self.at(asked)?, self.chosen(asked)?);
        let entries = self.model.inputs().get(input).map_or(&[][..], Vec::as_slice);
        let direction = vector(asked.get("vec"), "vec", entries)?;
        Ok(json!({"output": self.model.apply_jacobian(&at, input, &direction)?}))
    }

    /// The vectors at which the model is asked.
    fn at(&self, asked: &Value) -> Result<Vec<Vec<f64>>, Refused> {
        let given = asked.get("input").and_then(Value::as_array);
        let given = given.ok_or_else(|| Refused::input("the body has no `input`, a list of lists of numbers"))?;
        let sizes = self.input_sizes();
        if given.len() != sizes.len() {
            return Err(Refused::input(format!(
                "`input` has {}, expected {}",
                counted(given.len() as u64, "vector"),
                sizes.len()
            )));
        }
        let entries = given.iter().zip(self.model.inputs()).enumerate();
        entries.map(|(place, (given, entries))| vector(Some(given), &format!("input[{place}]"), entries)).collect()
    }

    /// The vector by whose entries is differentiated.
    fn chosen(&self, asked: &Value) -> Result<usize, Refused> {
        let index = |field: &str, count: usize| {
            let given = asked.get(field).and_then(Value::as_u64).and_then(|given| usize::try_from(given).ok());
            given.filter(|&given| given < count).ok_or_else(|| {
                Refused::input(format!("`{field}` is no whole number from 0 to {}", count.saturating_sub(1)))
            })
        };
        index("outWrt", 1)?;
        index("inWrt", self.model.inputs().len())
    }
}

/// A vector with a number for each entry.
fn vector(given: Option<&Value>, what: &str, entries: &[Entry]) -> Result<Vec<f64>, Refused> {
    let list = given.and_then(Value::as_array);
    let list = list.ok_or_else(|| Refused::input(format!("`{what}` is no list of numbers")))?;
    if list.len() != entries.len() {
        let names: Vec<&str> = entries.iter().take(MOST_SHOWN).map(|entry| entry.name.as_str()).collect();
        let more = if entries.len() > MOST_SHOWN { ", ..." } else { "" };
        return Err(Refused::input(format!(
            "`{what}` has {}, expected {}: {}{more}",
            counted(list.len() as u64, "number"),
            entries.len(),
            names.join(", ")
        )));
    }
    let number = |(given, entry): (&Value, &Entry)| {
        let finite = given.as_f64().filter(|value| value.is_finite());
        finite.ok_or_else(|| Refused::input(format!("`{what}`: the value of {} is no finite number", entry.name)))
    };
    list.iter().zip(entries).map(number).collect()
}
