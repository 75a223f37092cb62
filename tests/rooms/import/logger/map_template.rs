//! Tests of `src/import/logger/map_template.rs`.

use bmv::import::logger::{Known, Settings, map_template, propose, read};

fn known() -> Known {
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    Known {
        measured: names(&["pcb", "lid", "radiator", "plate", "shroud"]),
        inputs: names(&["T_plate", "T_shroud", "Q_pcb", "Q_heater"]),
        units: names(&["degC", "degC", "W", "W"]),
        boundaries: vec![("plate".into(), "T_plate".into()), ("shroud".into(), "T_shroud".into())],
    }
}

const LOG: &str = "Time,TC01 PCB (degC),TC04 Radiator (degC),PLATE (degC),Heater PSU (W),\"Spare, 7 (degC)\",Remark\n\
                   0,20.1,-3.2,15.0,0.0,18.3,on\n10,20.2,-3.1,15.1,0.0,18.9,on\n20,20.3,-3.0,15.0,5.0,19.4,on\n";

#[test]
fn every_channel_of_an_odd_name_stands_in_the_map_with_what_it_may_be() {
    let record = read(&[("log.csv".into(), LOG.into())], &Settings::default()).expect("understood");
    let template = map_template(&record, &known());
    assert_eq!(
        template.csv,
        "channel,name,unit,measures\nTC01 PCB,TC01 PCB,degC,pcb\nTC04 Radiator,TC04 Radiator,degC,radiator\n\
         Heater PSU,Q_heater,W,\n\"Spare, 7\",\"Spare, 7\",degC,\n"
    );
    assert!(template.is_of_some, "PLATE is clear and needs no line");
    assert_eq!(template.without_channel, "inputs `T_shroud [degC]` and `Q_pcb [W]`; nodes and quantities `lid`");
    // The map is read as it stands.
    let channels = Some(("channels.csv".to_owned(), template.csv));
    let mapped = read(&[("log.csv".into(), LOG.into())], &Settings { time: None, channels }).expect("understood");
    let proposal = propose(&mapped, &known(), &bmv::import::logger::Said::default(), "data/log.csv").expect("proposed");
    assert_eq!(proposal.sensors, ["TC01 PCB", "TC04 Radiator"]);
    assert_eq!(proposal.inputs, ["T_plate", "Q_heater"]);
}

/// A thermometer of a boundary node is no check of the model: its reading is the input.
#[test]
fn a_channel_named_like_a_boundary_node_feeds_its_input() {
    let log = |header: &str| {
        let cells = if header.contains(',') { ["15,15.3", "15.2,15", "15.1,15.4"] } else { ["15", "15.2", "15.1"] };
        format!("time [s],{header},lid [degC]\n0,{},20\n10,{},20.1\n20,{},20.3\n", cells[0], cells[1], cells[2])
    };
    let proposed = |header: &str| {
        let record = read(&[("log.csv".into(), log(header))], &Settings::default()).expect("understood");
        propose(&record, &known(), &bmv::import::logger::Said::default(), "data/log.csv").expect("proposed")
    };
    let fed = proposed("PLATE [degC]");
    assert_eq!((fed.inputs.as_slice(), fed.sensors.as_slice()), (&["T_plate".to_owned()][..], &["lid".to_owned()][..]));
    assert!(fed.notes.iter().any(|note| note.contains("`PLATE` is named like a boundary node")), "{:?}", fed.notes);
    // Where the input has a channel of its own, the other one is a thermometer.
    let both = proposed("plate [degC],T_plate [degC]").sensors;
    assert_eq!(both, ["lid", "plate"], "named like both");
}
