//! The twin laboratory: cases whose truth is known, and how well answers do on them.
//!
//! `specification`, `topology`: networks drawn at random. `campaign`: tests of them. `truth`, `choice`, `world`, `finer`, `inject`, `refit`:
//! what is hidden, and how large it is made. `noise`: how it is read. `rivals`: what could be taken for it. `case`, `folder`: all
//! of it together, in memory and as a study. `answer`, `score`: what was said of it, and how often that is right.
//! `trial`: truths drawn, tests simulated, the diagnosis asked. May not know studies or jobs.

pub mod answer;
pub mod campaign;
pub mod case;
mod choice;
mod draw;
mod finer;
pub mod folder;
pub mod inject;
pub mod noise;
pub mod refit;
pub mod rivals;
pub mod score;
pub mod specification;
pub mod topology;
pub mod trial;
pub mod truth;
pub mod world;

pub use answer::Answer;
pub use campaign::TestKind;
pub use case::{Case, Recipe, case};
pub use inject::{Hidden, InjectError, InjectionRequest, inject};
pub use score::{FinerScore, Rate, Score, Trial, score};
pub use topology::Topology;
pub use trial::{Outcome, ask, dated, drawn_case, finer, own_case, own_request, simulate, standard};
pub use truth::{HiddenEffect, NoiseTruth, Outside, Rival, Truth};
