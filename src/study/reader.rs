//! Reads the passes of a run, each once: several passes may build upon one, and have parents in common.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::document::{Diagnostics, Node, written};

use super::external::Lender;
use super::folder::{Folder, FolderError};
use super::job::Kinds;
use super::ledger::Content;
use super::resolve;
use super::resolved::Pass;

/// A pass that was read, or all that is wrong with it.
pub type Loaded = Result<Arc<Pass>, Arc<Diagnostics>>;

/// A file's tree, with what was found in it.
#[derive(Clone)]
pub(super) struct Parsed {
    /// The tree; `None` where the text is broken off.
    pub tree: Option<Arc<Node>>,
    /// Errors of its JSON.
    pub diagnostics: Arc<Diagnostics>,
    /// The bytes it was read from.
    content: Content,
}

/// Reads passes and keeps what it has read.
pub struct Reader {
    /// The kinds of job that passes may ask for.
    pub(super) kinds: Kinds,
    passes: RefCell<HashMap<PathBuf, Loaded>>,
    trees: RefCell<HashMap<PathBuf, Parsed>>,
    /// The seed of all passes, whatever they state.
    seed: Option<u64>,
    /// Lends what asks models outside; where there is none, nobody asks them.
    pub(super) lender: Option<Arc<dyn Lender>>,
}

impl Reader {
    /// A reader of passes with jobs of these kinds.
    pub fn new(kinds: Kinds) -> Self {
        Self { kinds, passes: RefCell::default(), trees: RefCell::default(), seed: None, lender: None }
    }

    /// A reader that gives all passes another seed than they state: what samples draws other numbers, and data stay as they
    /// are.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed: Some(seed), ..self }
    }

    /// A reader whose passes can ask models outside.
    #[must_use]
    pub fn with_lender(self, lender: Arc<dyn Lender>) -> Self {
        Self { lender: Some(lender), ..self }
    }

    /// A pass with its parents, its model and its data.
    ///
    /// # Errors
    /// All that is wrong with the files; warnings stand among them.
    pub fn load(&self, pass: &Path) -> Loaded {
        self.load_in_chain(pass, &[])
    }

    /// A pass that is read because one of the study's passes of this chain uses it.
    pub(super) fn load_in_chain(&self, pass: &Path, chain: &[String]) -> Loaded {
        if let Some(loaded) = self.passes.borrow().get(pass) {
            return loaded.clone();
        }
        let loaded = resolve::load(self, pass, chain);
        let loaded =
            loaded.map(|pass| Arc::new(Pass { seed: self.seed.unwrap_or(pass.seed), ..pass })).map_err(Arc::new);
        self.passes.borrow_mut().insert(pass.to_owned(), loaded.clone());
        loaded
    }

    /// The tree of a JSON file of a study's folder.
    pub(super) fn tree(&self, folder: &Folder, name: &str) -> Result<Parsed, FolderError> {
        let shown = folder.shown_name(name);
        let path = PathBuf::from(&shown);
        if let Some(parsed) = self.trees.borrow().get(&path) {
            folder.note(name, parsed.content.clone())?;
            return Ok(parsed.clone());
        }
        let bytes = folder.read(name)?;
        let mut diagnostics = Diagnostics::new();
        let tree = written::read_document(&shown, &bytes, &mut diagnostics).map(Arc::new);
        let parsed = Parsed { tree, diagnostics: Arc::new(diagnostics), content: Content::of(&bytes) };
        self.trees.borrow_mut().insert(path, parsed.clone());
        Ok(parsed)
    }
}

/// Reads one pass with its parents, its model and its data; its jobs are of these kinds.
///
/// # Errors
/// As [`Reader::load`].
pub fn load(kinds: &Kinds, pass: &Path) -> Result<Pass, Diagnostics> {
    match Reader::new(kinds.clone()).load(pass) {
        Ok(pass) => Ok(Arc::unwrap_or_clone(pass)),
        Err(diagnostics) => Err(Arc::unwrap_or_clone(diagnostics)),
    }
}
