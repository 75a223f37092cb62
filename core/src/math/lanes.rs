//! Numbers side by side: one value, or several that share every instruction.

/// One value, or several evaluated side by side with the same bits as one at a time.
pub trait Lanes: Copy + Send + Sync {
    /// Number of lanes.
    const COUNT: usize;
    /// The value of a lane; the number is below [`Lanes::COUNT`].
    fn lane(&self, lane: usize) -> f64;
    /// Replaces the value of a lane.
    fn set_lane(&mut self, lane: usize, value: f64);
    /// The same value in every lane.
    fn splat(value: f64) -> Self;
    /// A function applied to every lane.
    fn map(self, function: impl Fn(f64) -> f64) -> Self;
    /// A function applied lane by lane to two.
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self;
    /// Becomes [`Lanes::map`] of another, without a copy of either.
    fn become_map(&mut self, a: &Self, function: impl Fn(f64) -> f64);
    /// Becomes [`Lanes::zip`] of two others, without a copy of any.
    fn become_zip(&mut self, a: &Self, b: &Self, function: impl Fn(f64, f64) -> f64);
    /// Adds `a b`.
    fn add_product(&mut self, a: &Self, b: &Self);
    /// Subtracts `a b`.
    fn subtract_product(&mut self, a: &Self, b: &Self);
    /// Subtracts `(a0 b0 + a1 b1) + (a2 b2 + a3 b3)`.
    fn subtract_four_products(&mut self, a: [&Self; 4], b: [&Self; 4]);
}

/// Scalar product of two vectors of equal length, by two interleaved sums.
#[inline]
pub fn dot<V: Lanes>(a: &[V], b: &[V]) -> V {
    let (mut even, mut odd, mut last) = (V::splat(0.0), V::splat(0.0), V::splat(0.0));
    let (pairs_a, pairs_b) = (a.chunks_exact(2), b.chunks_exact(2));
    if let ([x], [y]) = (pairs_a.remainder(), pairs_b.remainder()) {
        last.become_zip(x, y, |x, y| x * y);
    }
    for (x, y) in pairs_a.zip(pairs_b) {
        even.add_product(&x[0], &y[0]);
        odd.add_product(&x[1], &y[1]);
    }
    even.zip(odd, |even, odd| even + odd).zip(last, |sum, last| sum + last)
}

/// `x -= factor * y`.
#[inline]
pub fn subtract_multiple(x: &mut [f64], factor: f64, y: &[f64]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x -= factor * y;
    }
}

/// `x += factor * y`.
#[inline]
pub fn add_multiple(x: &mut [f64], factor: f64, y: &[f64]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x += factor * y;
    }
}

impl Lanes for f64 {
    const COUNT: usize = 1;
    #[inline]
    fn lane(&self, _: usize) -> f64 {
        *self
    }
    #[inline]
    fn set_lane(&mut self, _: usize, value: f64) {
        *self = value;
    }
    #[inline]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        function(self)
    }
    #[inline]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        function(self, other)
    }
    #[inline]
    fn become_map(&mut self, a: &Self, function: impl Fn(f64) -> f64) {
        *self = function(*a);
    }
    #[inline]
    fn become_zip(&mut self, a: &Self, b: &Self, function: impl Fn(f64, f64) -> f64) {
        *self = function(*a, *b);
    }
    #[inline]
    fn add_product(&mut self, a: &Self, b: &Self) {
        *self += a * b;
    }
    #[inline]
    fn subtract_product(&mut self, a: &Self, b: &Self) {
        *self -= a * b;
    }
    #[inline]
    fn subtract_four_products(&mut self, a: [&Self; 4], b: [&Self; 4]) {
        *self -= (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]);
    }
}

impl<const N: usize> Lanes for [f64; N] {
    const COUNT: usize = N;
    #[inline]
    fn lane(&self, lane: usize) -> f64 {
        self[lane]
    }
    #[inline]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self[lane] = value;
    }
    #[inline]
    fn splat(value: f64) -> Self {
        [value; N]
    }
    #[inline]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for value in &mut out {
            *value = function(*value);
        }
        out
    }
    #[inline]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for (value, &second) in out.iter_mut().zip(&other) {
            *value = function(*value, second);
        }
        out
    }
    #[inline]
    fn become_map(&mut self, a: &Self, function: impl Fn(f64) -> f64) {
        for (value, &a) in self.iter_mut().zip(a) {
            *value = function(a);
        }
    }
    #[inline]
    fn become_zip(&mut self, a: &Self, b: &Self, function: impl Fn(f64, f64) -> f64) {
        for ((value, &a), &b) in self.iter_mut().zip(a).zip(b) {
            *value = function(a, b);
        }
    }
    #[inline]
    fn add_product(&mut self, a: &Self, b: &Self) {
        for ((value, a), b) in self.iter_mut().zip(a).zip(b) {
            *value += a * b;
        }
    }
    #[inline]
    fn subtract_product(&mut self, a: &Self, b: &Self) {
        for ((value, a), b) in self.iter_mut().zip(a).zip(b) {
            *value -= a * b;
        }
    }
    #[inline]
    fn subtract_four_products(&mut self, a: [&Self; 4], b: [&Self; 4]) {
        for lane in 0..N {
            let (first, second) = (a[0][lane] * b[0][lane], a[1][lane] * b[1][lane]);
            let (third, fourth) = (a[2][lane] * b[2][lane], a[3][lane] * b[3][lane]);
            self[lane] -= (first + second) + (third + fourth);
        }
    }
}
