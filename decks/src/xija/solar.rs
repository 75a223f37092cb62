//! Heats of the Sun.

use super::assembly::Assembly;
use super::class::Class;
use super::component::Component;
use super::date::{YEAR_2000_S, YEAR_S, seconds_since_1998};
use super::pitch::{MOST_POINTS, abscissae, function, number};

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// `SolarHeat` and its kin: `P(pitch) + bias + dP(pitch) v(t) + ampl cos(year)`, 0 in eclipse, then what depends on the
/// instrument in the focus or on the housing heater, which eclipses leave alone.
///
/// `v` is `days / tau` or `1 - exp(-days / tau)` from the epoch on. `SolarHeatMulplicative` and `SolarHeatHrcMult`
/// multiply by `1 + ampl cos(year)` instead of adding.
pub fn by_pitch(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    assembly.predicted_node(component, "node")?;
    let pitch = pitch_of(assembly, component)?;
    let pitches = abscissae(component, "P_pitches", &[45.0, 65.0, 90.0, 130.0, 180.0])?;
    let change_pitches = change_abscissae(component, &pitches)?;
    for (argument, points) in [("Ps", pitches.len()), ("dPs", change_pitches.len())] {
        check_length(component, argument, points)?;
    }
    let as_table = pitches.len() + change_pitches.len() > MOST_POINTS;
    let steady = function(assembly, component, &pitch, "P", &pitches, as_table)?;
    let change = function(assembly, component, &pitch, "dP", &change_pitches, as_table)?;
    let growth = growth(assembly, component, "exp", "2010:001:12:00:00")?;
    let multiplies = matches!(component.class, Class::SolarHeatMulplicative | Class::SolarHeatHrcMult);
    let amplitude = assembly.parameter(component, "ampl", if multiplies { "1" } else { "W" }, |value| value)?;
    let bias = assembly.parameter(component, "bias", "W", |power| power)?;
    let year = year();
    let mut power = format!("{steady} + {bias} + ({change}) * {growth}");
    power = if multiplies {
        format!("({power}) * (1 + {amplitude} * {year})")
    } else {
        format!("{power} + {amplitude} * {year}")
    };
    if let Some(eclipse) = assembly.driver(component, "eclipse_comp", None, &[Class::Eclipse])? {
        power = format!("({power}) * (1 - {eclipse})");
    }
    power.push_str(&offsets(assembly, component)?);
    assembly.load(component, power)
}

/// Heats by the instrument in the focus. Positions are whole steps, so that limits between them are exact.
fn offsets(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<String, String> {
    let bias = |assembly: &mut Assembly<'_>, name: &str| assembly.parameter(component, name, "W", |power| power);
    Ok(match component.class {
        Class::SolarHeatHrc => {
            let offset = bias(assembly, "hrc_bias")?;
            format!(" + {offset} * step((-0.5) - {})", position(assembly, component)?)
        }
        Class::SolarHeatHrcOpts | Class::SolarHeatHrcMult => {
            let (imaging, spectroscopy) = (bias(assembly, "hrci_bias")?, bias(assembly, "hrcs_bias")?);
            let position = position(assembly, component)?;
            format!(
                " + {imaging} * step((-0.5) - {position}) + ({spectroscopy} - {imaging}) * step((-86146.5) - {position})"
            )
        }
        Class::SolarHeatAcisCameraBody => {
            let offset = bias(assembly, "dh_heater_bias")?;
            format!(" + {offset} * {}", housing_heater(assembly, component)?)
        }
        _ => String::new(),
    })
}

/// `SolarHeatOffNomRoll`: heat by the Sun's projection on the body's Y axis, with a factor for each side.
pub fn by_roll(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let pitch = pitch_of(assembly, component)?;
    let roll =
        assembly.driver(component, "roll_comp", Some("roll"), &[Class::Roll])?.ok_or("`roll_comp` is missing")?;
    let plus = assembly.parameter(component, "P_plus_y", "W", |power| power)?;
    let minus = assembly.parameter(component, "P_minus_y", "W", |power| power)?;
    let sun = format!("sin({pitch}) * sin({roll})");
    let mut power = format!("{plus} * max({sun}, 0) + {minus} * min({sun}, 0)");
    if let Some(eclipse) = assembly.driver(component, "eclipse_comp", None, &[Class::Eclipse])? {
        power = format!("({power}) * (1 - {eclipse})");
    }
    assembly.load(component, power)
}

/// `SimZDepSolarHeat` and its kin: a function `P(pitch)` for each range of the instrument module's position.
pub fn by_instrument(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    assembly.predicted_node(component, "node")?;
    // Ranges from low to high positions. Ends belong to the lower range; beyond +-400000 xija takes the first.
    let (limits, instruments): (&[f64], &[&str]) = match component.class {
        Class::HrcISAcisSimZSolarHeat => (&[-85_000.0, 0.0], &["hrcs", "hrci", "acis"]),
        Class::AcisISHrcSimZSolarHeat => (&[0.0, 83_000.0], &["hrc", "aciss", "acisi"]),
        _ => (&[-85_000.0, 0.0, 83_000.0], &["hrcs", "hrci", "aciss", "acisi"]),
    };
    if component.class == Class::AcisISHrcSimZSolarHeat {
        let message = "xija calls the first powers of AcisISHrcSimZSolarHeat `acisi` and the last `hrc`, but uses the first at \
                       positions below 0 (HRC) and the last above 83000 (ACIS-I): the parameters here are named by their use";
        assembly.note(component, message);
    }
    let pitch = pitch_of(assembly, component)?;
    let pitches = abscissae(component, "P_pitches", &[45.0, 55.0, 70.0, 90.0, 150.0])?;
    let change_pitches = change_abscissae(component, &pitches)?;
    check_length(component, "dPs", change_pitches.len())?;
    if let Some(rows) = component.arguments.row_lengths("P_vals")? {
        let points = pitches.len();
        if rows.len() < instruments.len() || rows.iter().any(|length| *length < points) {
            let count = instruments.len();
            return Err(format!("`P_vals` must have {count} rows of {points} powers, one per pitch of `P_pitches`"));
        }
    }
    let as_table = pitches.len() * instruments.len() + change_pitches.len() > MOST_POINTS;
    let position = position(assembly, component)?;
    let mut power = String::new();
    for (at, instrument) in instruments.iter().enumerate() {
        let steady = function(assembly, component, &pitch, &format!("P_{instrument}"), &pitches, as_table)?;
        let above = |limit: &f64| format!("step({position} - {})", number(limit + 0.5));
        let from = at.checked_sub(1).and_then(|before| limits.get(before)).map_or("1".to_owned(), above);
        let to = limits.get(at).map(|limit| format!(" - {}", above(limit))).unwrap_or_default();
        power.push_str(&format!("({steady}) * ({from}{to}) + "));
    }
    let change = function(assembly, component, &pitch, "dP", &change_pitches, as_table)?;
    let growth = growth(assembly, component, "linear", "2013:001:12:00:00")?;
    let amplitude = assembly.parameter(component, "ampl", "W", |power| power)?;
    let heater_power = assembly.parameter(component, "dh_heater", "W", |power| power)?;
    let heater = housing_heater(assembly, component)?;
    power.push_str(&format!("({change}) * {growth} + {amplitude} * {} + {heater_power} * {heater}", year()));
    if let Some(eclipse) = assembly.driver(component, "eclipse_comp", None, &[Class::Eclipse])? {
        power = format!("({power}) * (1 - {eclipse})");
    }
    assembly.load(component, power)
}

fn pitch_of(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<String, String> {
    assembly
        .driver(component, "pitch_comp", Some("pitch"), &[Class::Pitch])?
        .ok_or_else(|| "`pitch_comp` is missing".to_owned())
}

fn position(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<String, String> {
    assembly
        .driver(component, "simz_comp", Some("sim_z"), &[Class::SimZ])?
        .ok_or_else(|| "`simz_comp` is missing".to_owned())
}

fn housing_heater(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<String, String> {
    assembly
        .driver(component, "dh_heater_comp", Some("dh_heater"), &[Class::DetectorHousingHeater])?
        .ok_or_else(|| "`dh_heater_comp` is missing".to_owned())
}

/// Abscissae of the change of the powers: those of the powers, or others over the same range.
fn change_abscissae(component: &Component<'_>, pitches: &[f64]) -> Result<Vec<f64>, String> {
    let own = abscissae(component, "dP_pitches", pitches)?;
    if (own.first(), own.last()) != (pitches.first(), pitches.last()) {
        return Err("`P_pitches` and `dP_pitches` must begin and end at the same pitch".to_owned());
    }
    Ok(own)
}

/// xija drops numbers beyond the abscissae; too few would shift all later parameters.
fn check_length(component: &Component<'_>, argument: &str, points: usize) -> Result<(), String> {
    match component.arguments.numbers(argument)? {
        Some(powers) if powers.len() < points => {
            let count = powers.len();
            Err(format!("`{argument}` has {count} powers for {points} pitch angles; give one per angle"))
        }
        _ => Ok(()),
    }
}

/// The factor of the change since the epoch, with its parameter `tau`, in days in xija.
fn growth(
    assembly: &mut Assembly<'_>,
    component: &Component<'_>,
    default: &str,
    epoch: &str,
) -> Result<String, String> {
    let epoch = seconds_since_1998(component.arguments.text("epoch")?.unwrap_or(epoch))?;
    let tau = assembly.parameter(component, "tau", "s", |days| days * DAY_S)?;
    let periods = format!("(t - {}) / {tau}", number(epoch));
    match component.arguments.text("var_func")?.unwrap_or(default) {
        "linear" => Ok(format!("({periods})")),
        "exp" => Ok(format!("(1 - exp(-({periods})))")),
        other => Err(format!("`var_func` is `{other}`; it must be linear or exp")),
    }
}

/// The yearly rhythm: 1 at the start of a year.
fn year() -> String {
    format!("cos(2 * pi * (t - {YEAR_2000_S}) / {YEAR_S})")
}
