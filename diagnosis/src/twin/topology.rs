//! Networks drawn at random: chains, stars, heads on a bench, satellites, stacks of boards, cooled detectors.

use serde::{Deserialize, Serialize};

use super::draw::{Draw, short};
use super::specification::{
    CoolerSketch, InputSketch, LoadSketch, NetworkSpecification, NodeSketch, ParameterSketch, PathSketch,
};
use crate::random::Distribution;

/// Kinds of network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Topology {
    /// A bar between a plate and the cold, heated on the way.
    Chain,
    /// A hub on a plate with arms that see a shroud.
    Star,
    /// A detector head on a bench: plate, housing, electronics, detector, radiator.
    BenchHead,
    /// Panels in the sun, a frame, boards and a battery.
    Satellite,
    /// Boards in a box in a room.
    Boards,
    /// A detector on a thermoelectric cooler.
    Cooled,
}

impl Topology {
    /// All kinds.
    pub const ALL: [Self; 6] = [Self::Chain, Self::Star, Self::BenchHead, Self::Satellite, Self::Boards, Self::Cooled];
}

/// A specification under construction.
struct Builder<'a> {
    specification: NetworkSpecification,
    draw: &'a mut Draw,
}

impl Builder<'_> {
    fn input(&mut self, name: &str, unit: &'static str, nominal: f64, range: [f64; 2]) -> String {
        let name = name.to_owned();
        self.specification.inputs.push(InputSketch { name: name.clone(), unit, nominal, range });
        name
    }

    fn node(&mut self, name: &str, node: NodeSketch) -> usize {
        self.specification.nodes.push((name.to_owned(), node));
        self.specification.nodes.len() - 1
    }

    fn boundary(&mut self, name: &str, temperature: &str) -> usize {
        self.node(name, NodeSketch::Boundary(temperature.to_owned()))
    }

    /// A node with a capacity, J/K, of a typical size; uncertain in one of four cases.
    fn mass(&mut self, name: &str, typical: f64) -> usize {
        let nominal = short(typical * self.draw.scale(0.6, 1.7));
        let text = if self.draw.happens(0.25) {
            self.parameter(&format!("C_{}", self.specification.nodes.len()), "J/K", nominal)
        } else {
            format!("{nominal}")
        };
        self.node(name, NodeSketch::Capacity(text))
    }

    /// A parameter with a prior about a nominal value: uniform, or normal in the logarithm.
    fn parameter(&mut self, name: &str, unit: &'static str, nominal: f64) -> String {
        let prior = if self.draw.happens(0.65) {
            let (below, above) = (self.draw.between(0.35, 0.8), self.draw.between(1.25, 2.0));
            Distribution::Uniform { lower: short(nominal * below), upper: short(nominal * above) }
        } else {
            Distribution::LogNormal { median: nominal, factor: self.draw.between(1.15, 1.6) }
        };
        self.specification.parameters.push(ParameterSketch { name: name.to_owned(), unit, nominal, prior });
        name.to_owned()
    }

    /// The size of a path: uncertain, or a number in one of six cases.
    fn size(&mut self, prefix: &str, count: usize, unit: &'static str, nominal: f64) -> String {
        if self.draw.happens(0.83) {
            self.parameter(&format!("{prefix}_{count}"), unit, nominal)
        } else {
            format!("{nominal}")
        }
    }

    fn conductor(&mut self, between: [usize; 2], lower: f64, upper: f64) {
        let nominal = self.draw.scale(lower, upper);
        let count = self.specification.conductors.len() + 1;
        let size = self.size("G", count, "W/K", nominal);
        let name = format!("{} to {}", self.specification.nodes[between[0]].0, self.specification.nodes[between[1]].0);
        self.specification.conductors.push(PathSketch { name, between, size });
    }

    /// Exchange through an area with an emittance that is uncertain.
    fn radiation(&mut self, between: [usize; 2], lower: f64, upper: f64) {
        let area = self.draw.scale(lower, upper);
        let count = self.specification.radiations.len() + 1;
        let emittance = self.draw.between(0.5, 0.85);
        let size = if self.draw.happens(0.7) {
            let prior = Distribution::Uniform { lower: short(0.8 * emittance), upper: short(1.15 * emittance) };
            let name = format!("eps_{count}");
            self.specification.parameters.push(ParameterSketch {
                name: name.clone(),
                unit: "1",
                nominal: emittance,
                prior,
            });
            format!("{name} * {area}")
        } else {
            format!("{}", short(emittance * area))
        };
        let name =
            format!("{} sees {}", self.specification.nodes[between[0]].0, self.specification.nodes[between[1]].0);
        self.specification.radiations.push(PathSketch { name, between, size });
    }

    fn load(&mut self, name: &str, into: usize, power: String) {
        self.specification.loads.push(LoadSketch { name: name.to_owned(), into, power });
    }

    /// A power that is an input, into a node.
    fn heated(&mut self, name: &str, into: usize, most: f64) {
        let input = self.input(name, "W", short(0.5 * most), [0.0, most]);
        let label = format!("{name} into {}", self.specification.nodes[into].0);
        self.load(&label, into, input);
    }

    fn plate(&mut self) -> usize {
        let input = self.input("T_plate", "K", 293.0, [253.0, 318.0]);
        self.boundary("plate", &input)
    }

    fn shroud(&mut self) -> usize {
        let input = self.input("T_shroud", "K", 120.0, [95.0, 230.0]);
        self.boundary("shroud", &input)
    }

    fn pressure(&mut self) {
        if self.draw.happens(0.5) {
            self.input("P_ch", "Pa", 1e-4, [1e-5, 0.05]);
        }
    }
}

/// A network of a kind, of 5 to 12 nodes with one to three boundaries.
pub fn network(topology: Topology, draw: &mut Draw) -> NetworkSpecification {
    let mut builder = Builder { specification: NetworkSpecification::default(), draw };
    match topology {
        Topology::Chain => chain(&mut builder),
        Topology::Star => star(&mut builder),
        Topology::BenchHead => bench_head(&mut builder),
        Topology::Satellite => satellite(&mut builder),
        Topology::Boards => boards(&mut builder),
        Topology::Cooled => cooled(&mut builder),
    }
    builder.specification
}

fn chain(b: &mut Builder<'_>) {
    b.specification.title = "Bar between a plate and a shroud".to_owned();
    let (plate, shroud) = (b.plate(), b.shroud());
    let links = b.draw.whole(4, 8);
    let mut before = plate;
    for link in 1..=links {
        let node = b.mass(&format!("section {link}"), 150.0);
        b.conductor([before, node], 0.15, 1.2);
        // The last sees the shroud with more; a coupling of its own has one name.
        if b.draw.happens(0.3) && link < links {
            b.radiation([node, shroud], 0.002, 0.01);
        }
        before = node;
    }
    b.radiation([before, shroud], 0.02, 0.08);
    let middle = 2 + b.draw.position(links);
    b.heated("Q_1", middle, 6.0);
    if b.draw.happens(0.6) {
        b.heated("Q_2", before, 4.0);
    }
    b.pressure();
}

fn star(b: &mut Builder<'_>) {
    b.specification.title = "Hub with arms".to_owned();
    let (plate, shroud) = (b.plate(), b.shroud());
    let hub = b.mass("hub", 700.0);
    b.conductor([hub, plate], 0.4, 1.5);
    let arms = b.draw.whole(3, 7);
    for arm in 1..=arms {
        let node = b.mass(&format!("arm {arm}"), 120.0);
        b.conductor([node, hub], 0.05, 0.5);
        if arm == 1 || b.draw.happens(0.6) {
            b.radiation([node, shroud], 0.004, 0.03);
        }
        if arm <= 2 || b.draw.happens(0.25) {
            b.heated(&format!("Q_{arm}"), node, 5.0);
        }
    }
    b.pressure();
}

fn bench_head(b: &mut Builder<'_>) {
    b.specification.title = "Detector head on a bench".to_owned();
    let (plate, shroud) = (b.plate(), b.shroud());
    let base = b.mass("baseplate", 800.0);
    let housing = b.mass("housing", 600.0);
    b.conductor([base, plate], 0.4, 1.4);
    b.conductor([housing, base], 0.3, 1.0);
    let electronics = b.draw.whole(1, 2);
    for board in 1..=electronics {
        let node = b.mass(&format!("board {board}"), 220.0);
        b.conductor([node, housing], 0.1, 0.5);
        b.heated(&format!("Q_board_{board}"), node, 9.0);
    }
    let radiator = b.mass("radiator", 400.0);
    b.radiation([radiator, shroud], 0.03, 0.08);
    b.conductor([radiator, housing], 0.005, 0.02);
    let cold = b.mass("detector", 60.0);
    if b.draw.happens(0.6) {
        let strap = b.mass("strap", 50.0);
        b.conductor([cold, strap], 0.06, 0.25);
        b.conductor([strap, radiator], 0.08, 0.3);
    } else {
        b.conductor([cold, radiator], 0.06, 0.25);
    }
    b.conductor([cold, housing], 0.004, 0.02);
    b.heated("Q_det", cold, 2.0);
    if b.draw.happens(0.5) {
        let blanket = b.node("blanket", NodeSketch::Arithmetic);
        b.radiation([housing, blanket], 0.008, 0.03);
        b.radiation([blanket, shroud], 0.2, 0.4);
    }
    if b.draw.happens(0.6) {
        b.heated("Q_heater", base, 10.0);
    }
    b.pressure();
}

fn satellite(b: &mut Builder<'_>) {
    b.specification.title = "Small satellite".to_owned();
    let space = b.boundary("space", "3");
    let frame = b.mass("frame", 260.0);
    let panels = b.draw.whole(2, 4);
    for (panel, letter) in (0..panels).zip(["x", "y", "z", "w"]) {
        let node = b.mass(&format!("panel {letter}"), 110.0);
        b.conductor([node, frame], 0.2, 0.9);
        b.radiation([node, space], 0.012, 0.03);
        let sun = b.input(&format!("S_{letter}"), "W/m2", 300.0, [0.0, 1361.0]);
        let nominal = b.draw.between(0.5, 0.85);
        let area = b.draw.between(0.006, 0.014);
        let power = if panel < 2 {
            let name = format!("alpha_{letter}");
            let prior = Distribution::Uniform { lower: short(0.8 * nominal), upper: short(1.15 * nominal) };
            b.specification.parameters.push(ParameterSketch { name: name.clone(), unit: "1", nominal, prior });
            format!("{name} * {area} * {sun}")
        } else {
            format!("{} * {sun}", short(nominal * area))
        };
        b.load(&format!("sun on {letter}"), node, power);
    }
    let stack = b.mass("stack", 350.0);
    b.conductor([stack, frame], 0.08, 0.4);
    b.heated("Q_stack", stack, 3.0);
    if b.draw.happens(0.8) {
        let battery = b.mass("battery", 220.0);
        b.conductor([battery, stack], 0.04, 0.2);
        b.heated("Q_heater", battery, 1.5);
        b.input("I_battery", "A", 0.4, [0.1, 1.1]);
    }
    if b.draw.happens(0.5) {
        let radio = b.mass("radio", 90.0);
        b.conductor([radio, stack], 0.05, 0.3);
        b.heated("Q_radio", radio, 2.0);
    }
    if b.draw.happens(0.5) {
        b.input("pitch", "rad", 1.5, [0.0, core::f64::consts::PI]);
    }
}

fn boards(b: &mut Builder<'_>) {
    b.specification.title = "Boards in a box in a room".to_owned();
    let room = b.input("T_room", "K", 295.0, [283.0, 308.0]);
    let room = b.boundary("room", &room);
    let cabinet = b.mass("box", 900.0);
    b.conductor([cabinet, room], 0.6, 2.5);
    if b.draw.happens(0.5) {
        b.radiation([cabinet, room], 0.05, 0.2);
    }
    let count = b.draw.whole(3, 6);
    let mut nodes: Vec<usize> = Vec::new();
    for board in 1..=count {
        let node = b.mass(&format!("board {board}"), 120.0);
        b.conductor([node, cabinet], 0.08, 0.5);
        if let Some(&neighbour) = nodes.last()
            && b.draw.happens(0.7)
        {
            b.conductor([node, neighbour], 0.02, 0.2);
        }
        if board <= 2 || b.draw.happens(0.4) {
            b.heated(&format!("Q_{board}"), node, 8.0);
        }
        nodes.push(node);
    }
    if b.draw.happens(0.4) {
        b.input("I_bus", "A", 1.0, [0.2, 3.0]);
    }
}

fn cooled(b: &mut Builder<'_>) {
    b.specification.title = "Detector on a thermoelectric cooler".to_owned();
    let (plate, shroud) = (b.plate(), b.shroud());
    let sink = b.mass("heat sink", 500.0);
    b.conductor([sink, plate], 0.5, 2.0);
    let detector = b.mass("detector", 25.0);
    b.conductor([detector, sink], 0.003, 0.015);
    let case = b.mass("case", 200.0);
    b.conductor([case, sink], 0.1, 0.6);
    b.radiation([case, shroud], 0.005, 0.03);
    b.radiation([detector, case], 0.0005, 0.003);
    let board = b.mass("board", 120.0);
    b.conductor([board, case], 0.1, 0.5);
    b.heated("Q_board", board, 5.0);
    b.heated("Q_det", detector, 0.4);
    let current = b.input("I_cooler", "A", 0.8, [0.0, 1.4]);
    b.specification.coolers.push(CoolerSketch { name: "cooler".to_owned(), nodes: [detector, sink], current });
    b.pressure();
}
