//! Tests of `diagnosis/src/diagnosis/together.rs`.

use bmv::diagnosis::together::{Jump, shown_by};

fn jump(channel: usize, first: usize, readings: &[f64], by: f64) -> Jump {
    let rows = first..first + readings.len();
    let readings = rows.clone().zip(readings.iter().copied()).collect();
    Jump { channel, rows, by, sd: 0.02, readings, is_beyond: false }
}

fn beyond(jump: Jump) -> Jump {
    Jump { is_beyond: true, ..jump }
}

fn shown(jumps: &[Jump], channels: usize) -> Vec<Vec<usize>> {
    shown_by(jumps, channels, |_, _| false)
}

#[test]
fn an_excursion_of_several_sensors_is_the_articles_and_one_alone_is_a_fault() {
    let alone = [jump(0, 40, &[290.0], 5.0)];
    assert_eq!(shown(&alone, 3), [vec![0]]);
    // Own sizes, a row later deeper down.
    let warm = [jump(0, 40, &[273.0, 272.8], 0.5), jump(2, 41, &[272.6], 0.2)];
    assert_eq!(shown(&warm, 3), [vec![0, 2], vec![0, 2]]);
    // Another direction, another time, or so little that it is the logger's crosstalk.
    for other in [jump(2, 41, &[272.6], -0.2), jump(2, 44, &[272.6], 0.2), jump(2, 40, &[272.6], 0.02)] {
        assert_eq!(shown(&[warm[0].clone(), other], 3), [vec![0], vec![2]]);
    }
}

#[test]
fn a_channel_that_moves_along_without_a_spike_counts() {
    let jumps = [jump(1, 40, &[273.0], 0.5)];
    let moves = |channel: usize, jump: &Jump| channel == 2 && jump.rows.start == 40;
    assert_eq!(shown_by(&jumps, 3, moves), [vec![1, 2]]);
}

#[test]
fn what_a_logger_does_to_its_channels_is_a_fault() {
    // All drop to one code, or some to one that lies beyond all that they show.
    let zeros = [0, 1, 2].map(|channel| jump(channel, 9, &[0.0], -290.0 - channel as f64));
    assert_eq!(shown(&zeros, 3), [vec![0], vec![1], vec![2]]);
    let bank = [beyond(zeros[0].clone()), beyond(zeros[1].clone())];
    assert_eq!(shown(&bank, 5), [vec![0], vec![1]]);
    // Two of five that reach the melting point, as they do at other times too.
    let melt = [jump(0, 9, &[273.15], 0.5), jump(1, 9, &[273.15], 0.3)];
    assert_eq!(shown(&melt, 5), [vec![0, 1], vec![0, 1]]);
    // A reference that is off for a row, by one offset in all.
    let offset = [4.0, 4.03, 3.98].into_iter().enumerate();
    let offset: Vec<Jump> = offset.map(|(channel, by)| jump(channel, 9, &[290.0 + by], by)).collect();
    assert_eq!(shown(&offset, 3), [vec![0], vec![1], vec![2]]);
    assert_eq!(shown(&offset, 4)[0], [0, 1, 2], "a fourth channel has it not");
    // A long stretch of a value each.
    let held = [jump(0, 9, &[290.0; 6], 3.0), jump(1, 9, &[280.0; 6], 5.0)];
    assert_eq!(shown(&held, 3), [vec![0], vec![1]]);
}

/// One channel drops out as the others show an excursion.
#[test]
fn a_fault_beside_an_excursion_is_one() {
    let jumps = [
        jump(0, 9, &[273.0], 0.5),
        jump(1, 9, &[272.8], 0.3),
        beyond(jump(2, 9, &[400.0], 127.0)),
        beyond(jump(3, 9, &[400.0], 128.0)),
    ];
    assert_eq!(shown(&jumps, 5), [vec![0, 1], vec![0, 1], vec![2], vec![3]]);
}
