//! Heats of electronics, switched or from a date on.

use super::assembly::Assembly;
use super::class::Class;
use super::component::Component;
use super::date::seconds_since_1998;
use super::pitch::number;

/// A power by default for each of these states of an `AcisDpaStatePower`.
const STATES: &[&str] = &["0xxx", "1xxx", "2xxx", "3xx0", "3xx1", "4xxx", "5xxx", "66x0", "6611", "6xxx"];

/// What the places of a state mean, with their largest digit.
const PLACES: [(&str, u8); 4] = [("fep_count", 6), ("ccd_count", 6), ("vid_board", 1), ("clocking", 1)];

/// More states are refused: their expression is nested as deeply as there are states.
const MOST_STATES: usize = 20;

/// `AcisDpaStatePower`: `mult / 100 (pow - bias)`, `pow` the power of the first state that fits. A state is a digit for
/// each of [`PLACES`], `x` for any.
pub fn power_of_states(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let states = component.arguments.texts("pow_states")?.unwrap_or_else(|| STATES.to_vec());
    if states.is_empty() || states.len() > MOST_STATES {
        return Err(format!("`pow_states` has {} states; 1 to {MOST_STATES} are read", states.len()));
    }
    // xija takes the states from the names of the parameters in `pars`, which overwrite those of the arguments.
    let mut named = Vec::new();
    let mut powers = Vec::new();
    for declared in &states {
        let state = assembly.next_name().and_then(|name| name.strip_prefix("pow_")).unwrap_or(declared);
        let is_place = |byte: u8| byte == b'x' || byte.is_ascii_digit();
        if state.is_empty() || state.len() > PLACES.len() || !state.bytes().all(is_place) {
            return Err(format!("the state `{state}` must be up to four digits or `x`, as in 3xx1"));
        }
        powers.push(assembly.parameter(component, &format!("pow_{state}"), "W", |power| power)?);
        named.push(state);
    }
    if let Some(missing) = uncovered(&named) {
        let processors = missing.chars().next().unwrap_or('0');
        return Err(format!("none of its states fits {missing}; add one, such as `{processors}xxx`"));
    }
    if named != states {
        let message = format!(
            "{}: `pow_states` has {}, but xija takes the states from the names in `pars`, {}; so does the deck",
            component.name,
            states.join(" "),
            named.join(" ")
        );
        assembly.note(component, message);
    }
    let factor = assembly.parameter(component, "mult", "1", |factor| factor)?;
    let bias = assembly.parameter(component, "bias", "W", |power| power)?;
    // From the last state back: every state before takes what fits it. All fit one, so that the last needs no mask.
    let mut power = powers.pop().unwrap_or_default();
    for (state, name) in named.iter().zip(powers).rev() {
        let mask = mask(assembly, component, state)?;
        power = if mask.is_empty() { name } else { format!("{mask} * {name} + (1 - {mask}) * ({power})") };
    }
    assembly.load(component, format!("{factor} / 100 * ({power} - {bias})"))
}

/// A combination that fits no state.
fn uncovered(states: &[&str]) -> Option<String> {
    let fits = |state: &str, digits: &str| {
        state.bytes().zip(digits.bytes()).all(|(place, digit)| place == b'x' || place == digit)
    };
    (0..=6)
        .flat_map(|processors| (0..=6).map(move |chips| (processors, chips)))
        .flat_map(|(processors, chips)| ["00", "01", "10", "11"].map(|flags| format!("{processors}{chips}{flags}")))
        .find(|digits| !states.iter().any(|state| fits(state, digits)))
}

/// 1 where a state fits, else 0: a product of steps halfway between counts; empty where every combination fits.
fn mask(assembly: &mut Assembly<'_>, component: &Component<'_>, state: &str) -> Result<String, String> {
    let mut factors = Vec::new();
    for (place, (argument, largest)) in state.bytes().zip(PLACES) {
        if place == b'x' {
            continue;
        }
        let classes = [Class::CmdStatesData, Class::TelemData];
        let input = assembly
            .driver(component, argument, None, &classes)?
            .ok_or_else(|| format!("the argument `{argument}` is missing, which the state `{state}` needs"))?;
        let digit = f64::from(place - b'0');
        if place > b'0' {
            factors.push(format!("step({input} - {})", digit - 0.5));
        }
        if place - b'0' < largest {
            factors.push(format!("step({} - {input})", digit + 0.5));
        }
    }
    Ok(factors.join(" * "))
}

/// `AcisDpaPower`: `k (measured power - bias) / 10`.
pub fn measured_power(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let k = assembly.parameter(component, "k", "1", |factor| factor)?;
    let bias = assembly.parameter(component, "bias", "W", |power| power)?;
    let power = assembly.input("dp_dpa_power", "W", 70.0, "measured power of the digital processing assembly");
    assembly.load(component, format!("{k} * ({power} - {bias}) / 10"))
}

/// `StepFunctionPower`: a heat from a date on.
pub fn step(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let date = component.arguments.required_text("time")?;
    let time = seconds_since_1998(date)?;
    let power = assembly.parameter(component, "P", "W", |power| power)?;
    assembly.note(component, format!("{} acts from {date} on, t = {time} s", component.name));
    assembly.load(component, format!("{power} * step(t - {})", number(time)))
}

/// `MsidStatePower`: a heat while a telemetry point has a value.
pub fn power_of_telemetry(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let (point, value) =
        (component.arguments.required_text("state_msid")?, component.arguments.required_text("state_val")?);
    let power = assembly.parameter(component, "P", "W", |power| power)?;
    let description = format!("1 while {} is {}, else 0", point.to_lowercase(), value.trim());
    let state = assembly.input(component.name, "1", 0.0, &description);
    assembly.load(component, format!("{power} * {state}"))
}
