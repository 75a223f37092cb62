//! How elements are drawn.

/// Whether an element is a path between nodes or a source at one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawing {
    /// A line from each node to the next.
    Path(Path),
    /// A mark at the node that is heated.
    Source(Source),
}

/// What a path between two nodes is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Linear conductor.
    Conductor,
    /// Radiative exchange.
    Radiation,
    /// Any heat flow.
    Flow,
    /// Cooler, from the cold to the hot side.
    Cooler,
}

/// What brings heat to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A load.
    Load,
    /// A controlled heater.
    Heater,
}
