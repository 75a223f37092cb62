//! Where the nodes of a network stand: stress majorisation (Gansner, Koren, North 2005) of the distances in the
//! graph, from a circle, with a fixed number of sweeps, then boxes pushed apart. The same network gives the same
//! places.

use crate::math::functions::{cos, sin};

/// Sweeps of the majorisation; it has settled well before for networks that fit a page.
const SWEEPS: usize = 200;

/// Distance of boxes from the rim of the canvas, pixels.
pub const FREE: f64 = 14.0;

/// Positions in the unit square for `count` nodes joined by `links`; `sinks` end up low.
pub fn positions(count: usize, links: &[(usize, usize)], sinks: &[bool]) -> Vec<(f64, f64)> {
    if count < 2 {
        return vec![(0.5, 0.5); count];
    }
    let distance = distances(count, links);
    let mut places: Vec<(f64, f64)> = (0..count)
        .map(|i| {
            let angle = 2.0 * std::f64::consts::PI * (i as f64 + 0.25) / count as f64;
            (cos(angle) * count as f64 / 4.0, sin(angle) * count as f64 / 4.0)
        })
        .collect();
    for _ in 0..SWEEPS {
        for i in 0..count {
            let (mut x, mut y, mut total) = (0.0, 0.0, 0.0);
            for j in (0..count).filter(|&j| j != i) {
                let wanted = distance[i * count + j];
                let weight = 1.0 / (wanted * wanted);
                let (dx, dy) = (places[i].0 - places[j].0, places[i].1 - places[j].1);
                let length = (dx * dx + dy * dy).sqrt().max(1e-9);
                x += weight * (places[j].0 + wanted * dx / length);
                y += weight * (places[j].1 + wanted * dy / length);
                total += weight;
            }
            places[i] = (x / total, y / total);
        }
    }
    into_unit_square(&turned(&places), sinks)
}

/// Numbers of links between nodes; nodes that are not joined stand a little farther apart than any that are.
fn distances(count: usize, links: &[(usize, usize)]) -> Vec<f64> {
    let mut neighbours = vec![Vec::new(); count];
    for &(a, b) in links.iter().filter(|l| l.0 < count && l.1 < count && l.0 != l.1) {
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    let mut all = vec![0.0; count * count];
    let mut farthest: f64 = 1.0;
    for start in 0..count {
        let row = &mut all[start * count..(start + 1) * count];
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(node) = queue.pop_front() {
            for &next in &neighbours[node] {
                if next != start && row[next] == 0.0 {
                    row[next] = row[node] + 1.0;
                    farthest = farthest.max(row[next]);
                    queue.push_back(next);
                }
            }
        }
    }
    for value in all.iter_mut().filter(|v| **v == 0.0) {
        *value = farthest.min(4.0) + 1.0;
    }
    all
}

/// The places turned so that their longest direction is horizontal.
fn turned(places: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let n = places.len() as f64;
    let (mx, my) = (places.iter().map(|p| p.0).sum::<f64>() / n, places.iter().map(|p| p.1).sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in places {
        xx += (p.0 - mx) * (p.0 - mx);
        xy += (p.0 - mx) * (p.1 - my);
        yy += (p.1 - my) * (p.1 - my);
    }
    let half = 0.5 * (xx - yy);
    let largest = 0.5 * (xx + yy) + (half * half + xy * xy).sqrt();
    let (mut ux, mut uy) = (xy, largest - xx);
    if ux.abs() + uy.abs() < 1e-9 * (xx + yy) {
        (ux, uy) = if xx >= yy { (1.0, 0.0) } else { (0.0, 1.0) };
    }
    let length = (ux * ux + uy * uy).sqrt();
    let (ux, uy) = (ux / length, uy / length);
    places.iter().map(|p| ((p.0 - mx) * ux + (p.1 - my) * uy, (p.1 - my) * ux - (p.0 - mx) * uy)).collect()
}

fn into_unit_square(places: &[(f64, f64)], sinks: &[bool]) -> Vec<(f64, f64)> {
    let span = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v: f64| (low.min(v), high.max(v)))
    };
    let (x0, x1) = span(&mut places.iter().map(|p| p.0));
    let (y0, y1) = span(&mut places.iter().map(|p| p.1));
    let share = |v: f64, low: f64, high: f64| if high - low < 1e-6 { 0.5 } else { (v - low) / (high - low) };
    let flat = y1 - y0 < 0.02 * (x1 - x0);
    let mut out: Vec<(f64, f64)> =
        places.iter().map(|p| (share(p.0, x0, x1), if flat { 0.5 } else { share(p.1, y0, y1) })).collect();
    // Boundaries belong below: heat falls.
    let mean = |wanted: bool| {
        let chosen: Vec<f64> = out.iter().zip(sinks).filter(|(_, s)| **s == wanted).map(|(p, _)| p.1).collect();
        if chosen.is_empty() { 0.5 } else { chosen.iter().sum::<f64>() / chosen.len() as f64 }
    };
    if mean(true) < mean(false) {
        for place in &mut out {
            place.1 = 1.0 - place.1;
        }
    }
    out
}

/// Pushes boxes (centre and size) apart until they keep `gap` between them, or 200 rounds are over; they stay
/// within the canvas.
pub fn push_apart(centres: &mut [(f64, f64)], sizes: &[(f64, f64)], gap: f64, canvas: (f64, f64)) {
    for _ in 0..200 {
        let mut moved = false;
        for i in 0..centres.len() {
            for j in 0..i {
                let (dx, dy) = (centres[i].0 - centres[j].0, centres[i].1 - centres[j].1);
                let over_x = 0.5 * (sizes[i].0 + sizes[j].0) + gap - dx.abs();
                let over_y = 0.5 * (sizes[i].1 + sizes[j].1) + gap - dy.abs();
                if over_x <= 0.0 || over_y <= 0.0 {
                    continue;
                }
                moved = true;
                // The odd one goes down where they lie exactly beside one another.
                if over_y < over_x {
                    let sign = if dy == 0.0 { if i % 2 == 1 { 1.0 } else { -1.0 } } else { dy.signum() };
                    centres[i].1 += 0.55 * over_y * sign;
                    centres[j].1 -= 0.55 * over_y * sign;
                } else {
                    let sign = if dx == 0.0 { 1.0 } else { dx.signum() };
                    centres[i].0 += 0.55 * over_x * sign;
                    centres[j].0 -= 0.55 * over_x * sign;
                }
            }
        }
        for (centre, size) in centres.iter_mut().zip(sizes) {
            let (half_x, half_y) = (size.0 / 2.0 + FREE, size.1 / 2.0 + FREE);
            centre.0 = centre.0.clamp(half_x, (canvas.0 - half_x).max(half_x));
            centre.1 = centre.1.clamp(half_y, (canvas.1 - half_y).max(half_y));
        }
        if !moved {
            return;
        }
    }
}
