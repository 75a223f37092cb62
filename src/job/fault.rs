//! What is told of a sample without a result.

/// Parameters that are stated.
const TOLD: usize = 8;

/// Parameters by name, SI, the first few: `a = 1, b = 2.5`.
pub fn listed(parameters: &[(String, f64)]) -> String {
    let told = parameters.iter().take(TOLD).map(|(name, value)| format!("{name} = {value}"));
    let mut text = told.collect::<Vec<_>>().join(", ");
    if parameters.len() > TOLD {
        text.push_str(&format!(" and {} more", parameters.len() - TOLD));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_parameters_are_told() {
        let parameters: Vec<(String, f64)> = (0..10).map(|i| (format!("p{i}"), f64::from(i) / 2.0)).collect();
        assert_eq!(listed(&parameters[..2]), "p0 = 0, p1 = 0.5");
        assert!(listed(&parameters).ends_with("p7 = 3.5 and 2 more"));
    }
}
