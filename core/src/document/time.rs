//! Times, and changes in a time, as people state them: in the unit that keeps their numbers short.

const MINUTE_S: f64 = 60.0;
const HOUR_S: f64 = 3600.0;
const DAY_S: f64 = 86_400.0;
/// Of 365.25 days.
const YEAR_S: f64 = 31_557_600.0;

/// A change in a second below which it is stated by a longer time.
const SLOW: f64 = 0.01;
/// Least change that is stated by the hour or the day.
const LEAST_CHANGE: f64 = 0.1;
/// What flows or spreads by the second, and is never stated by a longer time.
const FLOWS: [&str; 8] = ["m", "m2", "m^2", "m3", "m^3", "kg", "g", "mol"];

/// Digits that the longest time of a record has.
const DIGITS: i32 = 4;
/// Digits that the length of a stretch has.
const STRETCH_DIGITS: i32 = 2;
/// Most digits behind the point.
const MOST_DECIMALS: i32 = 6;

/// The unit in which times up to this one, s, are stated: its length, s, and symbol.
pub fn unit_of_time(longest_s: f64) -> (f64, &'static str) {
    match longest_s.abs() {
        within_ten_minutes if within_ten_minutes <= 10.0 * MINUTE_S => (1.0, "s"),
        within_two_hours if within_two_hours <= 2.0 * HOUR_S => (MINUTE_S, "min"),
        within_three_days if within_three_days <= 72.0 * HOUR_S => (HOUR_S, "h"),
        _ => (DAY_S, "d"),
    }
}

/// Whether a unit is that of a change in a second which is stated by a longer time where it is slow.
pub fn is_rate(unit: &str) -> bool {
    unit.strip_suffix("/s").is_some_and(|of| !FLOWS.contains(&of))
}

/// How a slow change is stated whose unit ends in `/s`, such as `K/s`: the length of the hour, day or year that shows it best, s, and the
/// unit with it, such as `K/d`. `size` is in the unit. `None` where it is stated as it is.
pub fn unit_of_rate(unit: &str, size: f64) -> Option<(f64, String)> {
    let of = unit.strip_suffix("/s").filter(|_| is_rate(unit))?;
    let size = size.abs();
    if size == 0.0 || size >= SLOW || size.is_nan() {
        return None;
    }
    let times = [(HOUR_S, "h"), (DAY_S, "d")].into_iter().find(|(length, _)| size * length >= LEAST_CHANGE);
    let (length, symbol) = times.unwrap_or((YEAR_S, "yr"));
    Some((length, format!("{of}/{symbol}")))
}

/// An instant of a record that ends at `longest_s`: `57 s`, `4.41 d`.
pub fn instant(time_s: f64, longest_s: f64) -> String {
    let (length, unit) = unit_of_time(longest_s);
    format!("{} {unit}", to_decimals(time_s / length, decimals(longest_s / length, DIGITS)))
}

/// A stretch of a record that ends at `longest_s`, by its ends: `10 to 120 s`, `4.4 to 8.8 d`, `at 3.5 h` for a single instant.
pub fn stretch(from_s: f64, to_s: f64, longest_s: f64) -> String {
    let (length, unit) = unit_of_time(longest_s);
    if from_s == to_s {
        return format!("at {}", instant(from_s, longest_s));
    }
    let decimals = decimals((to_s - from_s) / length, STRETCH_DIGITS);
    let [from, to] = [from_s, to_s].map(|end| to_decimals(end / length, decimals));
    format!("{from} to {to} {unit}")
}

/// Digits behind the point with which a number has so many in all.
fn decimals(number: f64, digits: i32) -> usize {
    let power = format!("{number:e}").rsplit_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0);
    usize::try_from((digits - 1 - power).min(MOST_DECIMALS)).unwrap_or(0)
}

/// A number rounded to so many digits behind the point, without zeros that say nothing.
fn to_decimals(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    // Not "-0".
    text.parse::<f64>().map_or(text, |rounded| (rounded + 0.0).to_string())
}
