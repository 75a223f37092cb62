//! Pages of reports as they are served while somebody works on the study: with a bar that says how it stands, buttons that
//! adopt, and the script that loads the page anew. Nothing of this is in a report that lies in a folder.

use serde::Serialize;

use crate::document::visible::escaped_lines;

use super::html::{self, Beside, HtmlError};
use super::page::{Block, Page, Section};
use super::script;

const PANEL: &str = include_str!("../../templates/live/panel.html");
const BAR: &str = include_str!("../../templates/live/bar.html");
const STYLE: &str = include_str!("../../templates/live/watch.css");
/// What runs in a live page.
pub const SCRIPT: &str = include_str!("../../templates/live/watch.js");

/// Effects that the page offers to adopt.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Offered<'a> {
    /// File of the pass.
    pub pass: &'a str,
    /// The diagnosis.
    pub job: &'a str,
    /// Ids to be named; none where the diagnosis settles it.
    pub effects: &'a [String],
    /// In words.
    pub title: &'a str,
    /// How probable; empty where that is not known.
    pub probability: &'a str,
    /// The command that does the same.
    pub command: &'a str,
    /// Where the effects act unless they belong to the test alone; empty where they act on no model.
    pub acts: &'a str,
}

/// What stands round a page.
#[derive(Clone, Copy, Debug)]
pub struct Around<'a> {
    /// Number of the round that the page is of.
    pub version: u64,
    /// `ready`, `running` or `wrong`.
    pub state: &'a str,
    /// What goes on, or what came out.
    pub lines: &'a [String],
    /// Messages on the files.
    pub messages: &'a str,
    /// What can be adopted.
    pub offers: &'a [Offered<'a>],
    /// What is to be read first; mostly empty.
    pub notice: &'a str,
}

/// A page with what stands round it.
///
/// # Errors
/// A template does not fit what it is given.
pub fn served(page: &str, around: &Around<'_>) -> Result<String, HtmlError> {
    let mut tera = tera::Tera::default();
    tera.add_raw_templates([("panel.html", PANEL), ("bar.html", BAR)])?;
    let context = tera::Context::from_serialize(&Context {
        version: around.version,
        state: around.state,
        words: std::iter::once(around.state)
            .chain(around.lines.iter().map(String::as_str))
            .collect::<Vec<_>>()
            .join("\n"),
        messages: around.messages,
        offers: around.offers,
        notice: around.notice,
    })?;
    let panel = escaped_lines(&tera.render("panel.html", &context)?).into_owned();
    let bar = escaped_lines(&tera.render("bar.html", &context)?).into_owned();
    // Texts of a study are escaped, so that each of these stands in the template alone.
    let additions = [
        (script::policy(&[script::OF_PAGES]), policy_of_page()),
        ("</style>".to_owned(), format!("{STYLE}</style>")),
        (html::MAIN.to_owned(), format!("{}{panel}", html::MAIN)),
        ("</body>".to_owned(), format!("{bar}<script>{SCRIPT}</script>\n</body>")),
    ];
    Ok(additions.iter().fold(page.to_owned(), |text, (at, instead)| text.replacen(at, instead, 1)))
}

/// A page that waits for the first results.
///
/// # Errors
/// As [`html::render`].
pub fn waiting() -> Result<String, HtmlError> {
    let words = "This page is not here yet: it comes when the jobs of its pass have run. It loads by itself.";
    let section = Section { id: "waiting", title: "No results yet".into(), blocks: vec![Block::paragraph(words)] };
    html::render(&Page { title: "bmv watch".into(), sections: vec![section], ..Page::default() }, Beside::Nothing)
}

#[derive(Serialize)]
struct Context<'a> {
    version: u64,
    state: &'a str,
    words: String,
    messages: &'a str,
    offers: &'a [Offered<'a>],
    notice: &'a str,
}

/// What a served page may do: its own style and scripts, and asking and posting where it comes from.
pub fn policy_of_page() -> String {
    let scripts = script::policy(&[script::OF_PAGES, SCRIPT]);
    format!("{scripts}; connect-src 'self'; form-action 'self'; base-uri 'none'")
}

/// The same as a field of an answer, which can also keep others from showing the page within theirs.
pub fn policy() -> String {
    format!("{}; frame-ancestors 'none'", policy_of_page())
}
