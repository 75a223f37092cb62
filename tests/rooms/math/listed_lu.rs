//! Tests of `core/src/math/listed_lu.rs`.

use bmv::math::lanes::Lanes;
use bmv::math::listed_lu::*;
use bmv::math::sparse::Pattern;

const SIZE: usize = 12;

/// A ring with chords, not symmetric in value; in lane 1 a pivot on the diagonal is 0.
fn entries() -> Vec<(usize, usize, [f64; 2])> {
    let mut entries = Vec::new();
    for row in 0..SIZE {
        let diagonal = if row == 4 { [7.0, 0.0] } else { [6.0 + row as f64, 5.0 + row as f64] };
        entries.push((row, row, diagonal));
        for (step, value) in [(1, -1.0), (SIZE - 1, -1.5), (5, 0.25)] {
            entries.push((row, (row + step) % SIZE, [value, value - 0.125 * row as f64]));
        }
    }
    entries
}

fn factored<V: Lanes>(value: impl Fn([f64; 2]) -> V) -> ListedLu<V> {
    let entries = entries();
    let positions: Vec<(usize, usize)> = entries.iter().map(|&(row, column, _)| (row, column)).collect();
    let mut lu = ListedLu::new(Pattern::new(SIZE, &positions).unwrap());
    let slots = lu.pattern().slots().to_vec();
    for (slot, (_, _, both)) in slots.into_iter().zip(entries) {
        lu.values[slot] = value(both);
    }
    lu.factor();
    lu
}

/// Systems with the solution 1, 2, ..., and those of the transposed matrix: entries below 100, conditions below some hundred.
#[test]
fn systems_are_solved_side_by_side_with_the_bits_that_each_has_alone() {
    let lanes = factored(|both| both);
    let (mut rhs, mut transposed) = (vec![[0.0; 2]; SIZE], vec![[0.0; 2]; SIZE]);
    for (row, column, both) in entries() {
        for lane in 0..2 {
            rhs[row][lane] += both[lane] * (column + 1) as f64;
            transposed[column][lane] += both[lane] * (row + 1) as f64;
        }
    }
    let given = [rhs.clone(), transposed.clone()];
    lanes.solve(&mut rhs);
    lanes.solve_transposed(&mut transposed);
    for lane in 0..2 {
        let alone = factored(|both| both[lane]);
        assert_eq!(alone.exchanged(), lane, "the pivot of 0 takes row exchanges");
        let of_lane = |side: &[[f64; 2]]| -> Vec<f64> { side.iter().map(|both| both[lane]).collect() };
        let (mut x, mut y) = (of_lane(&given[0]), of_lane(&given[1]));
        let mut columns: Vec<f64> = x.iter().flat_map(|value| [*value, -2.0 * value]).collect();
        alone.solve(&mut x);
        alone.solve_transposed(&mut y);
        alone.solve_columns(&mut columns, 2);
        for row in 0..SIZE {
            assert_eq!([x[row].to_bits(), y[row].to_bits()], [rhs[row][lane], transposed[row][lane]].map(f64::to_bits));
            assert_eq!([columns[2 * row], columns[2 * row + 1]], [x[row], -2.0 * x[row]]);
            for value in [x[row], y[row]] {
                assert!((value - (row + 1) as f64).abs() < 1e-11, "lane {lane}, row {row}: {value}");
            }
        }
    }
}

#[test]
fn the_solution_of_a_singular_matrix_is_no_number() {
    let mut lu = factored(|both| both[0]);
    lu.values.fill(0.0);
    lu.factor();
    let mut rhs = vec![1.0; SIZE];
    lu.solve(&mut rhs);
    assert!(rhs.iter().all(|value| value.is_nan()), "{rhs:?}");
}
