//! Values that follow temperature, numbered headers with stated units, printed transients and heaters, by hand.

use super::*;

/// A bar between a boundary and a heated end, in steel whose conductivity and heat capacity follow temperature.
const BAR: &str = "HEADER CONTROL DATA, GLOBAL\n abszro = -273.15, sigma = 1.\nHEADER NODE DATA, A
 SIV 1, 20., PROPS.A1, 0.5
 SPV 2, 20., A5, 2.
 -3, 0.
 SIM 4, 2, 1, 20., PROPS.A1, 1.0
 DIV 6, 20., PROPS.A1, 1.0, 3.0, 2.0
 CAL 7, 20., 2., 3., 4., 0.5
 8, 20., 1.0, 9, 20., -1.0
HEADER ARRAY DATA, A
 5 = 1.0, 0.01
HEADER ARRAY DATA, PROPS
C     a steel:
            1 =
            0.,  400.
            100.,  500.
            2 = 0.,  10., 100., 20.
HEADER CONDUCTOR DATA, A
 SIV 1, 1, 3, PROPS.A2, 0.1
 DIV 2, 1, 2, PROPS.A2, 0.1, PROPS.A2, 0.3
 CAL 3, 2, 3, 2., 3., 4., 6.
 SIV -4, 2, 3, PROPS.A2, 1.0E-12
 SIM 10, 2, 1, 4, 1, 5, 1, PROPS.A2, 0.1
HEADER SOURCE DATA, A
 1, 30., 2, 5.
 SIV 8, PROPS.A2, 0.1
 GEN 4, 2, 1, 0.25
END OF DATA
what stands here is not read
";

#[test]
fn values_follow_temperature_as_their_arrays_say() {
    let deck = read(&[SindaFile { name: "bar.inp", text: BAR }]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let expression = |text: &str| Value::Expression(text.to_owned());
    let capacity = |place: usize| match &deck.nodes[place].kind {
        NodeKind::Diffusion { capacity } => capacity.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(capacity(0), expression("(interp(PROPS_A1, T)) * 0.5"));
    assert_eq!(capacity(1), expression("((1.0 + ((T) - 273.15) * (0.01))) * 2.0"));
    assert_eq!(deck.nodes[4].name, "A.5");
    assert_eq!(capacity(4), expression("(interp(PROPS_A1, T)) * 1.0"));
    assert_eq!(capacity(5), expression("((interp(PROPS_A1, T)) * 1.0) + 6.0"));
    assert_eq!((capacity(6), capacity(7)), (Value::Number(12.0), Value::Number(1.0)));
    assert_eq!(deck.nodes[8].kind, NodeKind::Arithmetic);
    assert!(!deck.notes.iter().any(|note| note.message.contains("Arrays are not read")), "{:?}", deck.notes);
    // Tables are in K, each once.
    assert_eq!(deck.tables.len(), 2);
    assert_eq!((&deck.tables[0].x, &deck.tables[0].y), (&vec![273.15, 373.15], &vec![400.0, 500.0]));
    let value = |place: usize| deck.couplings[place].value.clone();
    assert_eq!(value(0), expression("(interp(PROPS_A2, (Ta + Tb) / 2)) * 0.1"));
    // At 20 degC: 12 W/(m K), so 1.2 and 3.6 W/K in series.
    let series = value(1);
    assert!(matches!(&series, Value::Expression(text) if text.contains("Ta)") && text.contains("Tb)")), "{series:?}");
    assert_eq!(value(2), Value::Number(4.0), "2 * 3 * 4 / 6");
    assert_eq!(value(3), expression("((interp(PROPS_A2, (Ta + Tb) / 2)) * 1e-12) * radiation_A"));
    assert_eq!(deck.couplings[5].name, "A.11");
    let heats: Vec<&Value> = deck.loads.iter().map(|load| &load.power).collect();
    let by_temperature = expression("(interp(PROPS_A2, T)) * 0.1");
    let numbers = [30.0, 5.0, 0.25, 0.25].map(Value::Number);
    assert_eq!(heats, [&numbers[0], &numbers[1], &by_temperature, &numbers[2], &numbers[3]]);

    let refused = |from: &str, to: &str, line: usize, words: &str| {
        assert!(BAR.contains(from), "{from}");
        let text = BAR.replacen(from, to, 1);
        let errors = read(&[SindaFile { name: "bar.inp", text: &text }]).expect_err(to);
        let first = &errors[0];
        assert!(first.line == Some(line) && first.message.contains(words), "{to}: {first}");
    };
    refused("PROPS.A1, 0.5", "PROPS.A7, 0.5", 4, "is not among ARRAY DATA");
    refused("PROPS.A1, 0.5", "steel, 0.5", 4, "expected an array such as `A3`");
    refused("100.,  500.", "0.,  500.", 4, "does not rise");
    refused("100.,  500.", "100.", 4, "expected pairs");
    refused("100.,  500.", "100., hot", 4, "`hot`");
    refused("SIV 1, 20., PROPS.A1, 0.5", "SIV 1, 20., PROPS.A1", 4, "3 fields of SIV");
    refused("-3, 0.", "SIT -3, 0., A5, 1.", 6, "follows time");
    refused("SIV 8, PROPS.A2, 0.1", "SIT 8, PROPS.A2, 0.1", 27, "follows time");
    refused("SIV -4, 2, 3, PROPS.A2, 1.0E-12", "DIV -4, 2, 3, PROPS.A2, 1., PROPS.A2, 1.", 23, "radiation");
    // A node whose line is refused is not missed elsewhere.
    let text = BAR.replacen("SIV 1, 20.", "SIX 1, 20.", 1);
    assert_eq!(read(&[SindaFile { name: "bar.inp", text: &text }]).expect_err("SIX").len(), 1);
}

/// Two plates and space with numbered headers, in BTU, minutes, feet and degF.
const NUMBERED: &str = "C TDUNITS, Energy = BTU
C TDUNITS, Time = min
C TDUNITS, Temp = F
       BCD 3THERMAL LPCS
       BCD 9 TWO PLATES
       END
       BCD 3NODE DATA
C         NODE, T, C
CcC   old, 1., 2.
       REM plates
            1, 68., 2.0 * 0.5     $ hot plate
            2, 68., -1.           $ cold plate
           -9, -459.67, 1.
       END
       BCD 3CONDUCTOR DATA
            10, 1, 2, 0.6
            -   20, 2, 9, 1.0E-11
       END
       BCD 3CONSTANTS DATA
           NLOOP=1000, TMPZRO=459.67
       END
       BCD 3VARIABLES 1
M       Q1 = 3.0
M       Q2 = Q2 + 1.5
       END
       BCD 3END OF DATA
anything
";

#[test]
fn numbered_headers_and_english_units_are_read() {
    let file = [SindaFile { name: "plates.sin", text: NUMBERED }];
    assert!(recognises(&file));
    let deck = read(&file).unwrap_or_else(|errors| panic!("{errors:?}"));
    assert_eq!((deck.title.as_str(), deck.tool.as_str()), ("TWO PLATES", "SINDA/G"));
    let names: Vec<&str> = deck.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["1", "2", "9"]);
    let close = |value: f64, expected: f64| assert!((value / expected - 1.0).abs() < 1e-12, "{value} {expected}");
    // 68 degF are 20 degC; a BTU is 1055.05585262 J, a degree 5/9 K, a BTU/min 17.584264210333... W.
    close(deck.nodes[0].initial_temperature_k.unwrap(), 293.15);
    let NodeKind::Diffusion { capacity } = &deck.nodes[0].kind else { panic!("{:?}", deck.nodes[0]) };
    close(number(&deck, capacity), 1_055.055_852_62 * 9.0 / 5.0);
    let watt = 1_055.055_852_62 / 60.0;
    close(number(&deck, &deck.couplings[0].value), 0.6 * watt * 9.0 / 5.0);
    let NodeKind::Boundary { temperature } = &deck.nodes[2].kind else { panic!("{:?}", deck.nodes[2]) };
    assert!(number(&deck, temperature).abs() < 1e-9);
    // The heat of 1e-11 BTU/(min R4) from 500 R to 0: 0.625 BTU/min.
    assert_eq!(number(&deck, &deck.couplings[1].value), 1e-11);
    close(deck.stefan_boltzmann.unwrap() * 1e-11 * libm::pow(500.0 * 5.0 / 9.0, 4.0), 0.625 * watt);
    let heats: Vec<f64> = deck.loads.iter().map(|load| number(&deck, &load.power)).collect();
    close(heats[0], 3.0 * watt);
    close(heats[1], 1.5 * watt);

    let refused = |from: &str, to: &str, line: Option<usize>, words: &str| {
        assert!(NUMBERED.contains(from), "{from}");
        let text = NUMBERED.replacen(from, to, 1);
        let errors = read(&[SindaFile { name: "plates.sin", text: &text }]).expect_err(to);
        let first = &errors[0];
        assert!(first.line == line && first.message.contains(words), "{to}: {first}");
    };
    refused("2, 9, 1.0E-11", "2, 9, -1.0E-11", Some(17), "0 or more");
    // Finite elements have conductors below 0.
    let text = NUMBERED.replacen("1, 2, 0.6", "1, 2, -0.6", 1).replacen("       REM plates", "       REM", 1);
    // A conductor of 0 is switched off.
    let text = text.replacen("            -   20", "            11, 1, 2, 0.0\n            -   20", 1);
    // -460 degF is absolute zero, rounded.
    let text = text.replacen("-459.67, 1.", "-460., 1.", 1);
    let deck = read(&[SindaFile { name: "plates.sin", text: &text }]).expect("a deck");
    assert_eq!(deck.nodes[2].kind, NodeKind::Boundary { temperature: Value::Number(0.0) });
    assert_eq!(deck.couplings.len(), 2);
    assert!(deck.notes.iter().any(|note| note.message.contains("below 0") && note.message.contains("plates.sin:16")));
    refused("C TDUNITS, Energy = BTU\n", "", None, "state the units in comments");
    refused("Energy = BTU", "Energy = erg", Some(1), "expected one of J");
    refused("TMPZRO=459.67", "TMPZRO=273.15", None, "does not go with TDUNITS");
    refused("M       Q1 = 3.0", "       DTIMEH = Q1", Some(23), "`Q12 = Q12 + 0.5`");
    let heaters = |lines: &str| {
        let text = NUMBERED.replacen("M       Q1 = 3.0", lines, 1);
        read(&[SindaFile { name: "plates.sin", text: &text }])
    };
    let lines =
        "M     XK3 = 2.0\n      TRMSTD(T2, 32.00, 50.00,  K 4, 0, K3, Q1 )\n      TRMSTD(T1, 14., 32., K5, 0, 1.5, Q1)";
    let deck = heaters(lines).unwrap_or_else(|errors| panic!("{errors:?}"));
    let [first, second] = deck.heaters.as_slice() else { panic!("{:?}", deck.heaters) };
    assert_eq!((first.into, first.senses, second.into, second.senses), (0, 1, 0, 0));
    for (value, expected) in [
        (first.on_below_k, 273.15),
        (first.off_above_k, 283.15),
        (number(&deck, &first.power), 2.0 * watt),
        (second.on_below_k, 263.15),
        (number(&deck, &second.power), 1.5 * watt),
    ] {
        close(value, expected);
    }
    for lines in [
        "TRMSTD(T1, 0., 10., K4, 0, K3, Q1)",
        "TRMSTD(T1, 10., 0., K4, 0, 1., Q1)",
        "TRMSTD(T1, 0., 10., K4, 1, 1., Q1)",
    ] {
        let first = &heaters(&format!("      {lines}")).expect_err(lines)[0];
        assert!(first.line == Some(23) && first.message.contains("`heaters` of the imported"), "{first}");
    }
    refused("Q2 = Q2 + 1.5", "Q1 = 1.5", Some(24), "replaces heat");
    refused("-   20, 2, 9", "-   2 0, 7, 9", Some(17), "7 is not defined");
}

#[test]
fn a_printed_transient_is_the_record_of_its_instants() {
    let print = " (C) COPYRIGHT 1982-1998 J.D.GASKI SINDA/G\n TIME= 0.00000E+00, DTIMEU= 0.0\n T      1 =   68.0 T      2 =   68.0\n \
                 T      9 = -459.67\n TIME= 1.50000E+00, DTIMEU= 0.1\n T      1 =   70.0 T      2 =   69.8\n T      9 = -459.67\n";
    let deck =
        |print: &str| read(&[SindaFile { name: "p.sin", text: NUMBERED }, SindaFile { name: "p.out", text: print }]);
    let record = deck(print).expect("a deck").record.expect("a record");
    assert!(!record.is_steady);
    assert_eq!(record.times_s, [0.0, 90.0]);
    assert!((record.temperatures_k[1][1] - (69.8 - 32.0) / 1.8 - 273.15).abs() < 1e-9);
    // One print alone is a steady state; times that fall are two runs.
    let one = print.split(" TIME= 1.5").next().unwrap();
    assert!(deck(one).expect("a deck").record.is_some_and(|record| record.is_steady));
    let errors = deck(&print.replace("1.50000E+00", "-1.0")).expect_err("two runs");
    assert!(errors[0].to_string().contains("several runs"), "{}", errors[0]);
    // SINDA/FLUINT's print: the time stands before the temperatures of each submodel.
    let instant = |time: f64, t: f64| {
        format!(
            " MODEL = SINDA\n   TRANSIENT\n SUBMODEL NAME = A\n  PROBLEM TIME    TIMEN   =  {time}  VS. TIMEND= 9.\n   T   1=  {t}\n"
        )
    };
    let text = "HEADER CONTROL DATA, GLOBAL\n abszro = 0.\nHEADER NODE DATA, A\n 1, 300., 5.\n 2, 300., -1.\nHEADER CONDUCTOR DATA, A\n \
                1, 1, 2, 1.\n";
    let print = format!(" S I N D A\n{}{}", instant(0.0, 300.0), instant(10.0, 301.5));
    let files = [SindaFile { name: "a.inp", text }, SindaFile { name: "a.out", text: &print }];
    let record = read(&files).expect("a deck").record.expect("a record");
    assert_eq!((record.times_s, &record.temperatures_k[0]), (vec![0.0, 10.0], &vec![300.0, 301.5]));
    assert!(record.temperatures_k[1].is_empty());
}

const HEATER: &str = "HEADER CONTROL DATA, GLOBAL
 abszro = -273.15, sigma = 1.
HEADER REGISTER DATA
 INT:CH3F = 0
 PO3F = 0
HEADER NODE DATA, BOX
 1, 0., 10.
 2, 0., 20.
HEADER CONDUCTOR DATA, BOX
 1, 1, 2, 0.5
HEADER VARIABLES 1, BOX
C
C Heater-Survival[BOX]::3F
C
      HY3F = 4.
      PO3F = 4.
      IF( NSOL .LE. 1 ) THEN
          T__TD =   1. * BOX.T2
          ST3F = T__TD
          O__TD = -10. $ ON TEMP
          F__TD = -5. $ OFF TEMP
          D__TD = F__TD - O__TD
          IF( T__TD .LT. F__TD .AND. D__TD .NE. 0. ) THEN
              X__TD = (F__TD - T__TD)/(D__TD)
              IF( X__TD .GT. 1. ) X__TD = 1.
          ELSE
              X__TD = 0.
          ENDIF
          X__TD = XP3F + ( X__TD - XP3F ) * 0.05
          IF( X__TD .LT. .001 ) X__TD = 0.
          IF( X__TD .GT. .999 ) X__TD = 1.
          PO3F = PO3F * X__TD
          XP3F = X__TD
              BOX.Q1 = BOX.Q1 + PO3F * 0.75
              BOX.Q2 = BOX.Q2 + PO3F * 0.25
      ELSE
          T__TD =   1. * BOX.T2
          ST3F = T__TD
          O__TD = -10. $ ON TEMP
          F__TD = -5. $ OFF TEMP
          IF( T__TD .LT. O__TD .OR.
     +       (HT3F .EQ. 1 .AND. T__TD .LT. F__TD ) ) THEN
              IF( HT3F .EQ. 0 ) CH3F = 1 + CH3F
              HT3F = 1
              BOX.Q1 = BOX.Q1 + PO3F * 0.75
              BOX.Q2 = BOX.Q2 + PO3F * 0.25
          ELSE
              HT3F = 0
              PO3F = 0.
          ENDIF
      ENDIF
      SO3F = O__TD
      SF3F = F__TD
HEADER VARIABLES 2, BOX
      IF( HT3F .EQ. 1 ) THEN
          OT3F = OT3F + DTIMEU
          TP3F = TP3F + DTIMEU * PO3F
      ENDIF
HEADER SUBROUTINE
      SUBROUTINE TDREL
      CALL COMMON
      WRITE(NOUT,*) 'Heater Steady State Q Values:'
F     IF( ISBUILT( 'BOX' ) ) THEN
F         T__TD =   1. * T(INTNOD('BOX', 2))
F     ENDIF
F     RETURN
F     END
";

#[test]
fn heaters_of_thermal_desktop_are_thermostats() {
    let deck = read(&[SindaFile { name: "h.inp", text: HEATER }]).unwrap_or_else(|errors| panic!("{errors:?}"));
    assert!(deck.loads.is_empty());
    let [first, second] = deck.heaters.as_slice() else { panic!("{:?}", deck.heaters) };
    assert_eq!(first.name, "Heater-Survival[BOX]::3F");
    assert_eq!((first.into, first.senses, &first.power), (0, 1, &Value::Number(3.0)));
    assert_eq!((second.into, second.senses, &second.power), (1, 1, &Value::Number(1.0)));
    assert_eq!((first.on_below_k, first.off_above_k), (-10.0 + 273.15, -5.0 + 273.15));
    let refused = |from: &str, to: &str, line: usize, words: &str| {
        assert!(HEATER.contains(from), "{from}");
        let text = HEATER.replacen(from, to, 1);
        let errors = read(&[SindaFile { name: "h.inp", text: &text }]).expect_err(to);
        assert!(errors[0].line == Some(line) && errors[0].message.contains(words), "{to}: {}", errors[0]);
    };
    refused("1. * BOX.T2", "0.5 * BOX.T1 + 0.5 * BOX.T2", 18, "a single node is read");
    refused("X__TD = (F__TD - T__TD)/(D__TD)", "X__TD = 1.", 24, "expected `X__TD=(F__TD-T__TD)/(D__TD)`");
    refused("F__TD = -5.", "F__TD = -15.", 40, "has other temperatures");
    refused("HT3F = 0\n", "BOX.Q1 = 7.\n", 48, "expected `HT3F=0`");
    refused("OT3F = OT3F + DTIMEU", "BOX.T1 = 3.", 55, "behind each step");
    refused("WRITE(NOUT,*) 'Heater", "BOX.G1 = 7. 'Heater", 62, "other logic");
}
