//! What several sensors show together. A sensor's fault is its own; where a second one jumps the same way at the same time, the article
//! did something: water ran down, a door was open. Unless it was the logger, which has all channels fail alike.

use std::ops::Range;

use crate::diagnosis::channel::median;

/// A jump of a channel that comes back.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// Channel, by its position.
    pub channel: usize,
    /// Rows of the measurement, from the first to behind the last.
    pub rows: Range<usize>,
    /// Largest distance from what is beside it.
    pub by: f64,
    /// Standard deviation of such distances in the channel.
    pub sd: f64,
    /// What the channel showed meanwhile, by row.
    pub readings: Vec<(usize, f64)>,
    /// Whether these lie beyond all that it showed otherwise.
    pub is_beyond: bool,
}

/// Rows by which a jump may come earlier or later in another channel.
const APART: usize = 1;
/// Least share of the larger of two jumps that the smaller has: less may be the logger's own crosstalk.
const LEAST_SHARE: f64 = 0.1;
/// Rows above which a jump is of one value, and so no answer of an article.
pub const LONGEST_ANSWER: usize = 3;
/// Share of their median by which jumps by one offset differ, or standard deviations of their own.
const ALIKE_SHARE: f64 = 0.05;
const ALIKE_SDS: f64 = 3.0;

impl Jump {
    /// Whether two jumps of different channels are at one time and in one direction.
    fn is_with(&self, other: &Self) -> bool {
        self.channel != other.channel
            && self.rows.start < other.rows.end + APART
            && other.rows.start < self.rows.end + APART
            && are_alike(self.by, other.by)
    }

    /// Whether another channel shows the same value in a row of both.
    fn has_code_of(&self, other: &Self) -> bool {
        self.channel != other.channel && self.readings.iter().any(|own| other.readings.contains(own))
    }
}

/// Of each jump the channels that show it too, itself among them; one that is a fault stands alone. `channels` are so many, and
/// `answers` says whether another one that has no such jump moves with it.
pub fn shown_by(jumps: &[Jump], channels: usize, answers: impl Fn(usize, &Jump) -> bool) -> Vec<Vec<usize>> {
    let is_code = |jump: &Jump| {
        let same: Vec<&Jump> = jumps.iter().filter(|other| jump.has_code_of(other)).collect();
        let is_all =
            (0..channels).all(|channel| channel == jump.channel || same.iter().any(|one| one.channel == channel));
        // What an article reaches, such as the melting point of ice, several sensors may show to the digit.
        !same.is_empty() && (is_all || jump.is_beyond && same.iter().any(|other| other.is_beyond))
    };
    let is_fault: Vec<bool> = jumps.iter().map(|jump| jump.rows.len() > LONGEST_ANSWER || is_code(jump)).collect();
    let of = |(place, jump): (usize, &Jump)| -> Vec<usize> {
        let alone = vec![jump.channel];
        if is_fault[place] {
            return alone;
        }
        let faulty = |channel: usize| {
            let is_there = |(other, is_fault): (&Jump, &bool)| {
                *is_fault
                    && other.channel == channel
                    && other.rows.start <= jump.rows.end
                    && jump.rows.start <= other.rows.end
            };
            jumps.iter().zip(&is_fault).any(is_there)
        };
        let with: Vec<&Jump> = jumps
            .iter()
            .zip(&is_fault)
            .filter(|(other, is_fault)| !**is_fault && jump.is_with(other))
            .map(|(other, _)| other)
            .collect();
        let is_of_all =
            (0..channels).all(|channel| channel == jump.channel || with.iter().any(|one| one.channel == channel));
        if is_of_all && is_one_offset(jump, &with) {
            return alone;
        }
        let shows = |channel: &usize| {
            *channel == jump.channel
                || with.iter().any(|other| other.channel == *channel)
                || !faulty(*channel) && answers(*channel, jump)
        };
        (0..channels).filter(shows).collect()
    };
    jumps.iter().enumerate().map(of).collect()
}

/// Whether two jumps are in one direction, and neither is so small that it may be the other's crosstalk.
pub fn are_alike(one: f64, other: f64) -> bool {
    one * other > 0.0 && one.abs().min(other.abs()) >= LEAST_SHARE * one.abs().max(other.abs())
}

/// Whether jumps of all channels are in the same rows by one offset, as a logger's reference is.
fn is_one_offset(jump: &Jump, with: &[&Jump]) -> bool {
    let Some(usual) = median(with.iter().map(|other| other.by).chain([jump.by]).collect()) else { return false };
    let is_alike = |one: &Jump| {
        one.rows == jump.rows && (one.by - usual).abs() <= (ALIKE_SHARE * usual.abs()).max(ALIKE_SDS * one.sd)
    };
    is_alike(jump) && with.iter().all(|one| is_alike(one))
}
