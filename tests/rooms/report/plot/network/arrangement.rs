//! Tests of `src/report/plot/network/arrangement.rs`.

use bmv::report::plot::canvas::text_width;
use bmv::report::plot::network::arrangement::{Arrangement, arrange};
use bmv::report::plot::network::room::{Boxed, crosses, overlap};
use bmv::report::plot::{Diagram, Missing, NodeShape, Path, Source, network};

/// Numbers that look random, the same on every machine.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % bound.max(1)
    }

    fn name(&mut self, what: &str, number: usize) -> String {
        let long = [
            "",
            " to shroud",
            " between the forward baseplate and the instrument bench",
            "_with_a_name_that_has_no_blank_at_all_and_is_longer_than_any_box_of_the_picture_could_ever_be_on_a_page",
        ];
        format!("{what} {number}{}", long[[0, 0, 0, 1, 1, 2, 3][self.below(7)]])
    }

    fn path(&mut self) -> Path {
        [Path::Conductor, Path::Radiation, Path::Flow, Path::Cooler][self.below(4)]
    }
}

/// A network with this many nodes, and marks that a diagnosis and adopted effects leave.
fn generated(seed: u64, count: usize, (adopted, missing): (usize, usize)) -> Diagram {
    let mut numbers = Numbers(seed);
    let shapes = [NodeShape::Diffusion, NodeShape::Diffusion, NodeShape::Arithmetic, NodeShape::Boundary];
    let mut out = Diagram { is_small: seed.is_multiple_of(2), full_scale: 3.0, ..Diagram::default() };
    out.nodes = (0..count).map(|node| (numbers.name("n", node), shapes[numbers.below(4)])).collect();
    for node in 1..count {
        out.paths.push((numbers.name("path", node), numbers.path(), numbers.below(node), node));
    }
    for extra in 0..numbers.below(count) {
        let (from, to) = (numbers.below(count), numbers.below(count));
        out.paths.push((numbers.name("more", extra), numbers.path(), from, to));
    }
    for source in 0..numbers.below(2 + count / 2) {
        let kind = if source % 3 == 0 { Source::Heater } else { Source::Load };
        out.sources.push((numbers.name("heat", source), kind, numbers.below(count)));
    }
    out.deviations = (0..count).map(|node| (node % 3 > 0).then(|| numbers.below(4000) as f64 / 100.0 - 20.0)).collect();
    for effect in 0..adopted {
        let name = numbers.name("effect", effect);
        let (from, to) = (numbers.below(count), numbers.below(count));
        match numbers.below(4) {
            0 => {
                out.paths.push((name.clone(), Path::Conductor, from, out.nodes.len()));
                out.nodes.push((format!("{name}.hidden"), NodeShape::Diffusion));
                out.deviations.push(None);
                out.adopted.push(format!("{name}.hidden"));
            }
            1 => out.sources.push((name.clone(), Source::Load, from)),
            _ => out.paths.push((name.clone(), numbers.path(), from, to)),
        }
        out.adopted.push(name);
    }
    out.missing = (0..missing)
        .map(|effect| {
            let (from, to) = (numbers.below(count), numbers.below(count));
            let to = if effect % 2 == 0 { from } else { to };
            let label = format!("missing: {}, 0.0{effect} W", numbers.name("effect", effect));
            Missing { label, path: numbers.path(), from, to, is_node: numbers.below(3) == 0 }
        })
        .collect();
    out
}

/// The model of a network alone, without readings.
fn bare(diagram: &Diagram) -> Diagram {
    let mut out = diagram.clone();
    out.nodes.retain(|own| !diagram.adopted.contains(&own.0));
    out.paths.retain(|own| !diagram.adopted.contains(&own.0));
    out.sources.retain(|own| !diagram.adopted.contains(&own.0));
    (out.adopted, out.missing, out.deviations) = Default::default();
    out
}

fn inside(own: &Boxed, frame: (f64, f64)) -> bool {
    let within = |at: f64, size: f64, whole: f64| at - 0.5 * size >= 0.0 && at + 0.5 * size <= whole;
    within(own.0.0, own.1.0, frame.0) && within(own.0.1, own.1.1, frame.1)
}

/// What lies outside the frame or on something else.
fn faults(placed: &Arrangement) -> Vec<String> {
    let mut out = Vec::new();
    let boxes = placed.boxes.iter().chain(placed.hidden.iter().flatten()).map(|own| ("box".to_owned(), *own));
    let labels = placed.labels.iter().map(|label| (label.lines.join(" "), label.area));
    let areas: Vec<(String, Boxed)> = boxes.chain(labels).collect();
    for (position, (name, area)) in areas.iter().enumerate() {
        if !inside(area, placed.frame) {
            out.push(format!("`{name}` leaves the frame: {area:?}"));
        }
        for (other, on) in areas[..position].iter().filter(|(_, other)| overlap(area, other)) {
            out.push(format!("`{name}` lies on `{other}`: {area:?}, {on:?}"));
        }
    }
    for label in &placed.labels {
        let needed = label.lines.iter().map(|line| text_width(line, 29.0)).fold(0.0, f64::max);
        if needed > label.area.1.0 || label.lines.iter().any(|line| line.contains('\u{2026}')) {
            out.push(format!("`{}` is cut", label.lines.join(" ")));
        }
    }
    // Half of a band on either side of a line.
    let lines = placed.lines.iter().chain(&placed.arrows).flatten().map(|own| vec![own.0, own.1]);
    let curves = placed.missing.iter().cloned().chain(placed.adopted.iter().map(|own| own.1.clone())).chain(lines);
    for curve in curves {
        if let Some(at) = curve.iter().find(|at| !inside(&(**at, (2.0, 2.0)), placed.frame)) {
            out.push(format!("a line leaves the frame: {at:?}"));
        }
    }
    for (tail, tip) in placed.arrows.iter().flatten() {
        let (low, high) = ((tail.0.min(tip.0), tail.1.min(tip.1)), (tail.0.max(tip.0), tail.1.max(tip.1)));
        let shaft = ((0.5 * (low.0 + high.0), 0.5 * (low.1 + high.1)), (high.0 - low.0 - 2.0, high.1 - low.1 - 2.0));
        if let Some(under) = areas.iter().find(|(_, area)| overlap(&shaft, area)) {
            out.push(format!("an arrow lies on `{}`", under.0));
        }
    }
    out
}

#[test]
#[ignore = "thorough"]
fn nothing_is_covered_or_cut_off_and_no_box_moves_in_any_network() {
    let mut looked_at = 0;
    for count in 2..=40 {
        for round in 0..6_u64 {
            let marks = ((count + round as usize * 5) % 7, (count / 2 + round as usize) % 5);
            let diagram = generated(97 * count as u64 + round, count, marks);
            let placed = arrange(&diagram);
            assert_eq!(faults(&placed), Vec::<String>::new(), "{count} nodes, {marks:?}, round {round}");
            let before = arrange(&bare(&diagram));
            let centres = |own: &Arrangement| own.boxes[..count].iter().map(|own| own.0).collect::<Vec<_>>();
            assert_eq!(centres(&placed), centres(&before), "{count} nodes, {marks:?}: boxes keep their places");
            for own in &diagram.missing {
                let is_named =
                    |lines: &[String]| lines.concat().replace(' ', "").starts_with(&own.label.replace(' ', "")[..20]);
                let names =
                    placed.labels.iter().map(|label| &label.lines).chain(placed.listed.iter().map(|own| &own.lines));
                assert!(names.into_iter().any(|lines| is_named(lines)), "{} is named", own.label);
            }
            looked_at += diagram.missing.len() + diagram.adopted.len();
        }
    }
    assert!(looked_at > 800, "{looked_at}");
}

/// What is written lies in the picture that a browser shows.
#[test]
fn no_coordinate_of_a_drawing_lies_outside_it() {
    for count in [2, 6, 13, 30] {
        for round in 0..4_u64 {
            let drawing = network(&generated(31 * count as u64 + round, count, (round as usize + 1, 4)));
            let (width, height) = (f64::from(drawing.size().0), f64::from(drawing.size().1));
            let svg = drawing.svg("id", "title", "description", true);
            for points in svg.split("points=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or_default()) {
                for pair in points.split_whitespace() {
                    let (x, y) = pair.split_once(',').expect("a pair");
                    let (x, y): (f64, f64) = (x.parse().expect("x"), y.parse().expect("y"));
                    assert!((0.0..=width).contains(&x) && (0.0..=height).contains(&y), "{count} nodes: {pair}");
                }
            }
        }
    }
}

#[test]
fn a_name_without_room_stands_below_under_its_number() {
    let long = "missing: radiation to ambient ".repeat(12);
    let diagram = Diagram {
        nodes: vec![("a".into(), NodeShape::Diffusion), ("b".into(), NodeShape::Boundary)],
        paths: vec![("path".into(), Path::Conductor, 0, 1)],
        missing: vec![Missing { label: long.clone(), path: Path::Radiation, from: 0, to: 0, is_node: false }],
        ..Diagram::default()
    };
    let placed = arrange(&diagram);
    let number = placed.labels.iter().find(|label| label.is_number).expect("a number");
    assert_eq!(number.lines, ["1"]);
    assert_eq!(placed.listed[0].lines.join(" "), long.trim());
    let short = Diagram {
        missing: vec![Missing { label: "missing: load".into(), ..diagram.missing[0].clone() }],
        ..diagram.clone()
    };
    assert!(arrange(&short).listed.is_empty());
}

/// The name of a line hides no other one; what has no room for its name, a line or an arrow of heat, has a number with its name
/// below.
#[test]
fn names_of_the_model_hide_no_other_line_and_stand_below_where_there_is_no_room() {
    let (mut of_lines, mut of_sources) = (0, 0);
    for count in [6, 10, 16, 24] {
        for round in 0..6_u64 {
            let diagram = generated(53 * count as u64 + round, count, (0, 0));
            let placed = arrange(&diagram);
            let is_path = |text: &str| diagram.paths.iter().any(|path| path.0 == text);
            for label in placed.labels.iter().filter(|label| is_path(&label.lines.join(" "))) {
                let hidden = placed.lines.iter().flatten().filter(|line| crosses(line, &label.area)).count();
                assert!(hidden <= 1, "`{}` lies on {hidden} lines", label.lines.join(" "));
            }
            let numbers = placed.labels.iter().filter(|label| label.is_number).count();
            let listed: Vec<String> = placed.listed.iter().map(|own| own.lines.join(" ")).collect();
            of_lines += listed.iter().filter(|text| is_path(text)).count();
            of_sources += listed.iter().filter(|text| diagram.sources.iter().any(|own| own.0 == **text)).count();
            // Names of nodes that are too long stand below too, under a number in their box.
            let in_boxes = placed.names.iter().filter(|name| name[0].parse::<usize>().is_ok()).count();
            let arrows = listed.iter().filter(|text| text.starts_with("no room for")).count();
            assert_eq!(numbers + in_boxes + arrows, listed.len(), "each number has its name: {listed:?}");
        }
    }
    assert!(of_lines > 5 && of_sources > 2, "{of_lines} {of_sources}");
}
