//! Dimensions: powers of the SI base units, as exact as decimal powers (`W/K^1.25`) need.

/// Number of base units: kg, m, s, A, K, mol, cd.
const BASES: usize = 7;

const NAMES: [&str; BASES] = ["kg", "m", "s", "A", "K", "mol", "cd"];

/// Powers closer than this are the same.
const SAME: f64 = 1e-9;

/// A product of powers of SI base units. Angles have none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dimension([f64; BASES]);

impl PartialEq for Dimension {
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(a, b)| (a - b).abs() < SAME)
    }
}

impl Dimension {
    /// No unit.
    pub const NONE: Self = Self([0.0; BASES]);
    /// kg.
    pub const MASS: Self = Self::base([1, 0, 0, 0, 0, 0, 0]);
    /// m.
    pub const LENGTH: Self = Self::base([0, 1, 0, 0, 0, 0, 0]);
    /// m2.
    pub const AREA: Self = Self::base([0, 2, 0, 0, 0, 0, 0]);
    /// s.
    pub const TIME: Self = Self::base([0, 0, 1, 0, 0, 0, 0]);
    /// A.
    pub const CURRENT: Self = Self::base([0, 0, 0, 1, 0, 0, 0]);
    /// K.
    pub const TEMPERATURE: Self = Self::base([0, 0, 0, 0, 1, 0, 0]);
    /// W.
    pub const POWER: Self = Self::base([1, 2, -3, 0, 0, 0, 0]);
    /// J/K.
    pub const HEAT_CAPACITY: Self = Self::base([1, 2, -2, 0, -1, 0, 0]);
    /// W/K.
    pub const CONDUCTANCE: Self = Self::base([1, 2, -3, 0, -1, 0, 0]);
    /// V.
    pub const VOLTAGE: Self = Self::base([1, 2, -3, -1, 0, 0, 0]);
    /// ohm.
    pub const RESISTANCE: Self = Self::base([1, 2, -3, -2, 0, 0, 0]);
    /// V/K.
    pub const SEEBECK: Self = Self::base([1, 2, -3, -1, -1, 0, 0]);
    /// W/(m2 K4), of the Stefan-Boltzmann constant.
    pub const STEFAN_BOLTZMANN: Self = Self::base([1, 0, -3, 0, -4, 0, 0]);

    /// From whole powers of kg, m, s, A, K, mol, cd.
    pub const fn base(powers: [i8; BASES]) -> Self {
        let mut out = [0.0; BASES];
        let mut i = 0;
        while i < BASES {
            out[i] = powers[i] as f64;
            i += 1;
        }
        Self(out)
    }

    /// Of a product.
    pub fn times(self, other: Self) -> Self {
        self.plus(other, 1.0)
    }

    /// Of a quotient.
    pub fn over(self, other: Self) -> Self {
        self.plus(other, -1.0)
    }

    fn plus(mut self, other: Self, sign: f64) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += sign * b;
        }
        self
    }

    /// Of a power.
    pub fn power(mut self, exponent: f64) -> Self {
        for a in &mut self.0 {
            *a *= exponent;
        }
        self
    }

    /// The power of mass in it: 1 in every unit of heat.
    pub fn mass_power(self) -> f64 {
        self.0[0]
    }

    /// Whether there is no unit.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// Dimensions with a usual name.
const USUAL: &[(&str, Dimension)] = &[
    ("1", Dimension::NONE),
    ("W", Dimension::POWER),
    ("W/K", Dimension::CONDUCTANCE),
    ("J/K", Dimension::HEAT_CAPACITY),
    ("V", Dimension::VOLTAGE),
    ("V/K", Dimension::SEEBECK),
    ("ohm", Dimension::RESISTANCE),
    ("W/(m2 K4)", Dimension::STEFAN_BOLTZMANN),
    ("J", Dimension::base([1, 2, -2, 0, 0, 0, 0])),
    ("Pa", Dimension::base([1, -1, -2, 0, 0, 0, 0])),
    ("N", Dimension::base([1, 1, -2, 0, 0, 0, 0])),
    ("W/m2", Dimension::base([1, 0, -3, 0, 0, 0, 0])),
    ("W/(m K)", Dimension::base([1, 1, -3, 0, -1, 0, 0])),
    ("W/(m2 K)", Dimension::base([1, 0, -3, 0, -1, 0, 0])),
    ("J/(kg K)", Dimension::base([0, 2, -2, 0, -1, 0, 0])),
];

impl std::fmt::Display for Dimension {
    /// The SI unit, such as `W/K` or `kg m/s3`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some((name, _)) = USUAL.iter().find(|(_, d)| d == self) {
            return f.write_str(name);
        }
        let part = |sign: f64| {
            let mut parts = Vec::new();
            for (name, power) in NAMES.iter().zip(self.0) {
                let power = power * sign;
                if power <= SAME {
                    continue;
                }
                // Rounded, so that 0.1 + 0.2 prints as 0.3.
                let shown = (power * 1e6).round() / 1e6;
                parts.push(match shown {
                    1.0 => (*name).to_owned(),
                    p if p.fract() == 0.0 => format!("{name}{p}"),
                    p => format!("{name}^{p}"),
                });
            }
            parts
        };
        let (above, below) = (part(1.0), part(-1.0));
        if above.is_empty() {
            f.write_str("1")?;
        }
        f.write_str(&above.join(" "))?;
        match below.len() {
            0 => Ok(()),
            1 => write!(f, "/{}", below[0]),
            _ => write!(f, "/({})", below.join(" ")),
        }
    }
}
