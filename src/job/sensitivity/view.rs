//! A sensitivity analysis for other programs: indices by quantity and parameter.

use serde_json::{Map, Value, json};

use super::output::{Case, Index, OfQuantity, Output};

/// The document of `show --json`: everything in SI.
///
/// `main`, `total` and the others are of the first environment, which `environment` names; `cases` has the same for
/// every environment. A quantity that does not vary has an empty entry.
pub fn view(output: &Output) -> Value {
    let cases: Vec<Value> = output.cases.iter().map(|sensitivity_case| case(output, sensitivity_case)).collect();
    let mut document = cases.first().and_then(Value::as_object).cloned().unwrap_or_default();
    document.insert("samples".into(), json!(output.samples));
    document.insert("scrambles".into(), json!(output.scrambles));
    document.insert("methods".into(), json!(output.methods));
    document.insert("parameters".into(), json!(output.parameters));
    document.insert("precision".into(), json!(output.precision));
    document.insert("cases".into(), json!(cases));
    Value::Object(document)
}

fn case(output: &Output, case: &Case) -> Value {
    let names: Vec<&str> = output.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let by_quantity = |of: &dyn Fn(&OfQuantity) -> Value| -> Map<String, Value> {
        case.quantities.iter().map(|quantity| (quantity.name.clone(), of(quantity))).collect()
    };
    let named = |values: Vec<Value>| -> Value {
        Value::Object(names.iter().map(|name| (*name).to_owned()).zip(values).collect())
    };
    let indices = |list: &[Index]| named(list.iter().map(|index| json!(index)).collect());
    let shares = |of: &dyn Fn(&super::Sobol) -> Value| {
        by_quantity(&|quantity| quantity.sobol.as_ref().map_or_else(|| json!({}), of))
    };
    json!({
        "environment": case.environment,
        "main": shares(&|sobol| indices(&sobol.main)),
        "total": shares(&|sobol| indices(&sobol.total)),
        "second_order": shares(&|sobol| json!(sobol.second_order)),
        "sum_main": shares(&|sobol| json!(sobol.sum_main)),
        "places": shares(&|sobol| named(sobol.places.iter().map(|place| json!(place)).collect())),
        "moments": shares(&|sobol| json!({"mean": sobol.mean, "sd": sobol.sd})),
        "local": by_quantity(&|quantity| named(quantity.local.iter().map(|local| json!(local)).collect())),
        "morris": by_quantity(&|quantity| named(quantity.morris.iter().map(|effect| json!(effect)).collect())),
        "derivative": by_quantity(&|quantity| named(quantity.derivative.iter().map(|bound| json!(bound)).collect())),
        "constant": case.quantities.iter().filter(|q| q.is_constant).map(|q| q.name.as_str()).collect::<Vec<_>>(),
        "solves": case.solves,
        "failed": case.failed,
        "rows": case.rows,
        "rows_left_out": case.rows_left_out,
        "trajectories_left_out": case.trajectories_left_out,
        "failures": case.failures,
    })
}
