//! Tests of `src/import/logger/proposal.rs`.

use bmv::import::logger::proposal::*;
use bmv::import::logger::{Settings, read};

fn known() -> Known {
    Known { measured: vec!["box".into(), "panel".into()], inputs: vec!["Q_box".into()], ..Known::default() }
}

#[test]
fn a_logged_temperature_of_nothing_in_the_model_may_become_an_input() {
    let notes = |header: &str| {
        let log = format!("time [s],box [degC],{header}\n0,20,18\n10,21,18.5\n20,22,19\n");
        let settings = Settings { time: None, channels: None };
        let record = read(&[("a.csv".to_owned(), log)], &settings).expect("understood");
        propose(&record, &known(), &Said::default(), "data/log.csv").expect("proposed").notes.join("\n")
    };
    assert!(notes("flange [degC]").contains("can be an input of model.json that nothing uses"));
    assert!(!notes("supply [V]").contains("that nothing uses"));
}

#[test]
fn two_files_of_a_german_logger_become_one_clean_table() {
    let first = "Logger 34970A\n\nZeit;Kanal 1;Kanal 2;Kanal 3;Q box;Bemerkung\n;\u{B0}C;\u{B0}C;\u{B0}C;W;\n\
                 17.05.2024 12:00:00;20,5;9,9E+37;21;5;ein\n17.05.2024 12:00:10;20,75;;21,5;5,5;\n";
    let second = "Zeit;Kanal 1\n;\u{B0}C\n17.05.2024 12:00:20;---\n17.05.2024 12:00:30;-300\n";
    let map = "channel,name,measures\nKanal 1,TC1,box\nKanal 3,Panel,\n";
    let files = [("a.csv".to_owned(), first.to_owned()), ("b.csv".to_owned(), second.to_owned())];
    let settings = Settings { time: None, channels: Some(("map.csv".into(), map.into())) };
    let record = read(&files, &settings).expect("understood");
    let proposal = propose(&record, &known(), &Said::default(), "data/log.csv").expect("proposed");
    assert_eq!(proposal.csv, "time [s],TC1 [degC],Panel [degC],Q_box [W]\n0,20.5,21,5\n10,20.75,21.5,5.5\n30,,,\n");
    assert_eq!((proposal.sensors.len(), proposal.inputs.as_slice()), (2, &["Q_box".to_owned()][..]));
    assert_eq!(proposal.measurement["transient"]["sensors"]["TC1"]["measures"], "box");
    assert_eq!(proposal.measurement["transient"]["sensors"]["Panel"]["measures"], "panel");
    let notes = proposal.notes.join("\n");
    for part in ["`Kanal 2` has no reading", "`Bemerkung` holds text", "1 reading of `TC1` at or below absolute zero"] {
        assert!(notes.contains(part), "{part} in {notes}");
    }
}

#[test]
fn what_is_not_understood_is_said_at_its_place() {
    let said = |text: &str, map: Option<&str>| {
        let files = [("log.csv".to_owned(), text.to_owned())];
        let channels = map.map(|map| ("map.csv".to_owned(), map.to_owned()));
        let wrong = read(&files, &Settings { time: None, channels }).expect_err("not understood");
        wrong.render(false, 9)
    };
    let cell = said("time;T1 [K]\n0;300\n1;30O\n2;301\n", None);
    assert!(cell.contains("log.csv:3:3") && cell.contains("`30O` is no reading"), "{cell}");
    let time = said("time;T1 [K]\n03/04/2024 10:00;300\n03/04/2024 10:01;301\n", None);
    assert!(time.contains("log.csv:2:1") && time.contains("is no time"), "{time}");
    let map = said("time;T1 [K]\n0;300\n1;301\n", Some("channel,name\nT2,box\n"));
    assert!(map.contains("map.csv:2:1") && map.contains("no file has a channel `T2`"), "{map}");
    assert!(map.contains("one of `T1`"), "{map}");
    let files = [("log.csv".to_owned(), "time;T1 [K]\n0;300\n1;301\n".to_owned())];
    let whole = Some(("map.csv".to_owned(), "channel,name\nT1 [K],box\n".to_owned()));
    let record =
        read(&files, &Settings { time: None, channels: whole }).expect("a heading with its unit names the channel");
    assert_eq!(record.channels[0].name, "box");
}

/// Forty minutes between two of sixty rows, over which the box cools by 3 K; from row to row it changes by 0.5 K, ten times its noise.
#[test]
fn a_gap_is_said_with_what_mends_it_and_is_no_quick_change() {
    let mut log = "time [s];TC1 [degC];Q box [W];panels [degC]\n".to_owned();
    for row in 0..60 {
        let time = 10 * row + if row < 30 { 0 } else { 2400 };
        let box_c = 20.0 + 0.5 * f64::from(row) - if row < 30 { 0.0 } else { 3.5 };
        let noise = if row % 2 == 0 { 0.02 } else { -0.02 };
        let power = if row / 10 % 2 == 0 { 5 } else { 0 };
        log.push_str(&format!("{time};{};{power};21\n", box_c + noise));
    }
    let map = "channel,name,measures\nTC1,TC box,box\n";
    let settings = Settings { time: None, channels: Some(("map.csv".into(), map.into())) };
    let record = read(&[("log.csv".to_owned(), log)], &settings).expect("understood");
    let notes = propose(&record, &known(), &Said::default(), "data/log.csv").expect("proposed").notes.join("\n");
    assert!(notes.contains(r#"with "max_gap": {"value": 200, "unit": "s"} beside "file""#), "{notes}");
    assert!(!notes.contains("changes by up to"), "{notes}");
}

#[test]
fn a_name_of_the_map_that_means_nothing_is_held_against_the_nearest() {
    let log = "time;A [degC];B [degC]\n0;20;21\n1;20.5;21.4\n2;21;21.9\n".to_owned();
    let map = "channel,name,measures\nA,TC box,box\nB,TC panel,panle\n";
    let settings = Settings { time: None, channels: Some(("map.csv".into(), map.into())) };
    let record = read(&[("log.csv".to_owned(), log)], &settings).expect("understood");
    let notes = propose(&record, &known(), &Said::default(), "data/log.csv").expect("proposed").notes.join("\n");
    assert!(notes.contains("`TC panel` (mapped to `panle`; did you mean `panel`?)"), "{notes}");
}

#[test]
fn scatter_is_that_of_the_noise_and_not_of_the_ramp() {
    // A ramp with a deviation of 0.1 K up and down in turn: second differences are 0.4 K, 1.4826 * 0.4 / sqrt(6) is
    // 0.242. A display in steps of 0.5 K, whose standard deviation is 0.144 K.
    let ramp: Vec<Option<f64>> =
        (0..40).map(|at| Some(f64::from(at) * 3.0 + if at % 2 == 0 { 0.1 } else { -0.1 })).collect();
    assert_eq!(scatter(&ramp), Some(0.24));
    let display: Vec<Option<f64>> = (0..40).map(|at| Some(f64::from(at / 10) * 0.5)).collect();
    assert_eq!(scatter(&display), Some(0.14));
    assert_eq!(scatter(&ramp[..5]), None);
}

/// Cells that nothing known separates, as a comma in the numbers suggests another separator: one error, whatever the map says.
#[test]
fn a_log_that_cannot_be_split_is_one_error() {
    let said = |separator: &str| {
        let rows = ["Zeit;T1;T2;T3", "0;1,5;2,5;3,5", "10;1,6;2,6;3,6", "20;1,7;2,7;3,7"].join("\n");
        let map = "channel,name\nT1,box\nT2,panel\n";
        let settings = Settings { time: None, channels: Some(("map.csv".into(), map.into())) };
        let wrong =
            read(&[("log.csv".to_owned(), rows.replace(';', separator))], &settings).expect_err("not understood");
        assert_eq!(wrong.errors(), 1, "{}", wrong.render(false, 9));
        wrong.render(false, 9)
    };
    for separator in ["#", " ", "/"] {
        let said = said(separator);
        assert!(said.contains("log.csv:2:1") && said.contains("no line of names stands above"), "{said}");
        assert!(said.contains(&format!("`{separator}` seems to separate these: put `;` in its place")), "{said}");
    }
}
