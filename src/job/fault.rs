//! What is stated of a sample without a result.

/// Parameters that are stated.
const MOST_LISTED: usize = 8;

/// Parameters by name, SI, the first few: `a = 1, b = 2.5`.
pub fn listed(parameters: &[(String, f64)]) -> String {
    let parameter_texts = parameters.iter().take(MOST_LISTED).map(|(name, value)| format!("{name} = {value}"));
    let mut text = parameter_texts.collect::<Vec<_>>().join(", ");
    if parameters.len() > MOST_LISTED {
        text.push_str(&format!(" and {} more", parameters.len() - MOST_LISTED));
    }
    text
}
