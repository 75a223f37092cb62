//! Certified nonlinear regressions of the NIST Statistical Reference Datasets (`nist/`, public domain): parameters and
//! standard deviations to six digits from both starting points.

use bmv::inference::estimate::point_estimate::{PointEstimate, PointSettings, estimate};
use bmv::inference::target::{LeastSquares, Rejected, Target};
use bmv::random::{Distribution, StreamKey};

type Model = fn(&[f64], f64, &mut [f64]) -> f64;

struct Regression {
    names: Vec<String>,
    priors: Vec<Distribution>,
    starts: [Vec<f64>; 2],
    certified: Vec<f64>,
    certified_sd: Vec<f64>,
    certified_squares: f64,
    readings: Vec<(f64, f64)>,
    model: Model,
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

impl Regression {
    fn parse(text: &str, model: Model) -> Self {
        let rows: Vec<Vec<f64>> =
            text.lines().filter(|line| line.trim_start().starts_with('b') && line.contains('=')).map(numbers).collect();
        let rows: Vec<Vec<f64>> = rows.into_iter().filter(|row| row.len() == 4).collect();
        let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let squares = text.lines().find(|line| line.starts_with("Residual Sum of Squares")).expect("given");
        // The data follow the last line that begins with the word.
        let (_, data) = text.rsplit_once("Data:").expect("data");
        let readings = data.lines().map(numbers).filter(|row| row.len() == 2).map(|row| (row[0], row[1])).collect();
        Self {
            names: (0..rows.len()).map(|i| format!("b{}", i + 1)).collect(),
            // Wide enough to touch nothing on the way.
            priors: vec![Distribution::Uniform { lower: -1e9, upper: 1e9 }; rows.len()],
            starts: [column(0), column(1)],
            certified: column(2),
            certified_sd: column(3),
            certified_squares: squares.split_whitespace().last().expect("a word").parse().expect("a number"),
            readings,
            model,
        }
    }

    fn fit(&self, start: usize) -> PointEstimate {
        let settings = PointSettings { starts: 0, most_iterations: 100_000, ..PointSettings::default() };
        let key = StreamKey::new(1, "nist", "starts");
        estimate(self, &settings, &key, &[self.starts[start].clone()]).expect("an estimate")
    }

    /// Smallest number of agreeing digits of parameters and of standard deviations.
    fn digits(&self, fit: &PointEstimate) -> (f64, f64) {
        let variance = fit.chi_square / (self.readings.len() - self.certified.len()) as f64;
        let agreement = |own: f64, certified: f64| -libm::log10(((own - certified) / certified).abs().max(1e-11));
        let mut digits = (f64::INFINITY, f64::INFINITY);
        for i in 0..self.certified.len() {
            digits.0 = digits.0.min(agreement(fit.parameters[i], self.certified[i]));
            digits.1 = digits.1.min(agreement(fit.sd()[i] * variance.sqrt(), self.certified_sd[i]));
        }
        digits
    }
}

impl Target for Regression {
    type Workspace = Vec<f64>;

    fn names(&self) -> &[String] {
        &self.names
    }

    fn priors(&self) -> &[Distribution] {
        &self.priors
    }

    fn workspace(&self) -> Vec<f64> {
        vec![0.0; self.names.len()]
    }

    fn log_likelihood(&self, parameters: &[f64], slopes: &mut Vec<f64>) -> Result<f64, Rejected> {
        Ok(self.readings.iter().map(|(y, x)| (self.model)(parameters, *x, slopes) - y).map(|r| -0.5 * r * r).sum())
    }

    fn log_likelihood_gradient(&self, _: &[f64], _: &mut Vec<f64>, _: &mut [f64]) -> Result<f64, Rejected> {
        Err(Rejected::new("not needed"))
    }
}

impl LeastSquares for Regression {
    fn residual_count(&self) -> usize {
        self.readings.len()
    }

    fn residuals(&self, parameters: &[f64], slopes: &mut Vec<f64>, residuals: &mut [f64]) -> Result<f64, Rejected> {
        for ((y, x), r) in self.readings.iter().zip(residuals) {
            *r = (self.model)(parameters, *x, slopes) - y;
        }
        Ok(0.0)
    }

    fn jacobian(
        &self,
        parameters: &[f64],
        _: &mut Vec<f64>,
        residuals: &mut [f64],
        jacobian: &mut [f64],
        offset_gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        offset_gradient.fill(0.0);
        for (i, row) in jacobian.chunks_exact_mut(parameters.len()).enumerate() {
            let (y, x) = self.readings[i];
            residuals[i] = (self.model)(parameters, x, row) - y;
        }
        Ok(0.0)
    }
}

/// (b1 + b2 x + b3 x^2 + b4 x^3) / (1 + b5 x + b6 x^2 + b7 x^3).
fn rational(b: &[f64], x: f64, slopes: &mut [f64]) -> f64 {
    let powers = [1.0, x, x * x, x * x * x];
    let above: f64 = (0..4).map(|i| b[i] * powers[i]).sum();
    let below = 1.0 + (1..4).map(|i| b[3 + i] * powers[i]).sum::<f64>();
    for i in 0..4 {
        slopes[i] = powers[i] / below;
    }
    for i in 1..4 {
        slopes[3 + i] = -above / below / below * powers[i];
    }
    above / below
}

/// b1 exp(b2 / (x + b3)).
fn thermistor(b: &[f64], x: f64, slopes: &mut [f64]) -> f64 {
    let growth = libm::exp(b[1] / (x + b[2]));
    slopes[0] = growth;
    slopes[1] = b[0] * growth / (x + b[2]);
    slopes[2] = -b[0] * growth * b[1] / (x + b[2]) / (x + b[2]);
    b[0] * growth
}

fn check(regression: &Regression, start: usize) {
    let fit = regression.fit(start);
    let (parameters, sd) = regression.digits(&fit);
    println!("start {start}: {parameters:.1} {sd:.1} digits, {:?}", fit.descents[0].iterations);
    assert!(parameters >= 6.0 && sd >= 6.0, "start {start}: {parameters:.1} and {sd:.1} digits, {fit:?}");
    assert!((fit.chi_square / regression.certified_squares - 1.0).abs() < 1e-9);
    assert!(fit.descents[0].converged);
}

#[test]
fn thermal_expansion_of_copper() {
    let regression = Regression::parse(include_str!("nist/Hahn1.dat"), rational);
    assert_eq!((regression.readings.len(), regression.certified.len()), (236, 7));
    check(&regression, 0);
    check(&regression, 1);
}

#[test]
fn electron_mobility() {
    let regression = Regression::parse(include_str!("nist/Thurber.dat"), rational);
    assert_eq!((regression.readings.len(), regression.certified.len()), (37, 7));
    check(&regression, 0);
    check(&regression, 1);
}

#[test]
fn thermistor_resistance() {
    let regression = Regression::parse(include_str!("nist/MGH10.dat"), thermistor);
    assert_eq!((regression.readings.len(), regression.certified.len()), (16, 3));
    check(&regression, 0);
    check(&regression, 1);
}
