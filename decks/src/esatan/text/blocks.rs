//! A model's text cut into statements of its blocks.

use crate::{DeckError, Note};

use crate::arithmetic::piece::{Piece, pieces};

/// Deepest nesting of submodels.
const DEEPEST: usize = 64;

/// Kinds of statements that carry data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Data {
    /// Real or integer constants.
    Constants {
        /// Whether they are integers.
        is_integer: bool,
    },
    /// Constants that steer ESATAN's solution.
    Control,
    Nodes,
    Conductors,
}

/// A statement of data, up to its `;`.
#[derive(Debug)]
pub(super) struct Statement {
    pub(super) data: Data,
    /// Path of its model below the one at the top.
    pub(super) model: Vec<String>,
    /// Line of its first piece.
    pub(super) line: usize,
    pub(super) pieces: Vec<Piece>,
    /// The comment behind its end.
    pub(super) comment: Option<String>,
}

/// What the lines of a block are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lines {
    /// Outside of any block.
    Outside,
    Data(Data),
    /// Constants whose type is not known yet.
    Untyped,
    /// Code that runs while the model is solved: refused.
    Code(&'static str),
    /// Left out with a note.
    Skipped(&'static str),
}

/// A text in pieces.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    /// Name of the model at the top.
    pub(super) title: String,
    pub(super) statements: Vec<Statement>,
    pub(super) notes: Vec<Note>,
    pub(super) errors: Vec<DeckError>,
}

/// Cuts a text into statements.
pub(super) fn cut(file: &str, text: &str) -> Blocks {
    let mut cutter = Cutter {
        file,
        blocks: Blocks::default(),
        models: Vec::new(),
        lines: Lines::Outside,
        open: None,
        is_reported: false,
        is_ended: false,
    };
    let mut last = 1;
    for (index, line) in text.lines().enumerate() {
        last = index + 1;
        cutter.line(last, line);
    }
    cutter.close_statement();
    if !cutter.models.is_empty() {
        cutter.fail(last, "the model does not end; expected `$ENDMODEL`".to_owned());
    } else if !cutter.is_ended {
        cutter.fail(last, "there is no model; expected `$MODEL NAME`".to_owned());
    }
    cutter.blocks
}

struct Cutter<'a> {
    file: &'a str,
    blocks: Blocks,
    /// Names of the models that are open, from the top.
    models: Vec<String>,
    lines: Lines,
    /// A statement that lacks its `;` as yet.
    open: Option<Statement>,
    /// Whether a note or an error tells of the present block already.
    is_reported: bool,
    is_ended: bool,
}

impl Cutter<'_> {
    fn fail(&mut self, line: usize, message: String) {
        self.blocks.errors.push(DeckError::at(self.file, line, message));
    }

    fn line(&mut self, number: usize, line: &str) {
        // In blocks of code a C or a * in the first column marks a comment, as in Fortran.
        let is_code = matches!(self.lines, Lines::Code(_) | Lines::Skipped(_));
        let mut start = line.chars();
        let is_marked =
            matches!(start.next(), Some('C' | 'c' | '*')) && !start.next().is_some_and(char::is_alphanumeric);
        if is_code && is_marked {
            return;
        }
        let (code, comment) = without_comment(line);
        let code = code.trim();
        if code.is_empty() {
            return;
        }
        if let Some(heading) = code.strip_prefix('$') {
            self.heading(number, heading);
            return;
        }
        match self.lines {
            Lines::Outside => self.fail(number, format!("`{}` stands in no block", shortened(code))),
            _ if self.holds_constants() && is_type(code) => self.heading(number, code.trim_start_matches('*')),
            Lines::Untyped => self.fail(number, "expected `$REAL` or `$INTEGER` above constants".to_owned()),
            Lines::Data(data) => self.data(number, data, code, comment),
            // Where ESATAN-TMS puts the code that it generates; that code itself is refused.
            Lines::Code("INITIAL") if code.eq_ignore_ascii_case("GENMOR") => {}
            Lines::Code(block) if !self.is_reported => {
                self.is_reported = true;
                let code = shortened(code);
                self.fail(number, format!(
                    "`{code}` in ${block} runs while the model is solved, which is not read; give what it sets in the \
                     blocks of data, or import a `.TMD` of the solved model"
                ));
            }
            Lines::Skipped(block) if !self.is_reported => {
                self.is_reported = true;
                let place = format!("{}:{number}", self.file);
                self.blocks.notes.push(Note::at(place, format!("Block ${block} is left out.")));
            }
            Lines::Code(_) | Lines::Skipped(_) => {}
        }
    }

    fn heading(&mut self, number: usize, heading: &str) {
        let mut words = heading.split_whitespace();
        let word = words.next().unwrap_or_default().to_ascii_uppercase();
        // Behind a model's name may stand its options: `$MODEL NAME, ACDFILE`.
        let rest = words.next().and_then(|word| word.split(',').next()).unwrap_or_default();
        // A type within a block that is left out is part of it.
        if self.lines == Lines::Skipped("ARRAYS") && is_type(&word) {
            return;
        }
        self.close_statement();
        self.is_reported = false;
        if self.models.is_empty() && word != "MODEL" {
            self.fail(number, format!("`${word}` stands in no model; expected `$MODEL NAME`"));
            return;
        }
        let is_typed = self.holds_constants();
        self.lines = match word.as_str() {
            "MODEL" => return self.open_model(number, rest),
            "ENDMODEL" => {
                let name = self.models.pop();
                if !rest.is_empty() && name.as_ref().is_some_and(|name| !name.eq_ignore_ascii_case(rest)) {
                    self.fail(number, format!("`$ENDMODEL {rest}` ends model {}", name.unwrap_or_default()));
                }
                self.is_ended = self.models.is_empty();
                Lines::Outside
            }
            "LOCALS" | "CONSTANTS" => Lines::Untyped,
            "REAL" if is_typed => Lines::Data(Data::Constants { is_integer: false }),
            "INTEGER" if is_typed => Lines::Data(Data::Constants { is_integer: true }),
            "CONTROL" if is_typed => Lines::Data(Data::Control),
            "CHARACTER" if is_typed => Lines::Skipped("CHARACTER"),
            "NODES" => Lines::Data(Data::Nodes),
            "CONDUCTORS" => Lines::Data(Data::Conductors),
            "ARRAYS" => Lines::Skipped("ARRAYS"),
            // Whatever calls them is refused.
            "SUBROUTINES" => Lines::Skipped("SUBROUTINES"),
            "EXECUTION" => Lines::Skipped("EXECUTION"),
            "OUTPUTS" => Lines::Skipped("OUTPUTS"),
            "INITIAL" => Lines::Code("INITIAL"),
            "VARIABLES1" => Lines::Code("VARIABLES1"),
            "VARIABLES2" => Lines::Code("VARIABLES2"),
            "EVENTS" => Lines::Code("EVENTS"),
            _ => {
                self.fail(number, format!("`${word}` is not read here; write what it stands for in its place"));
                // One error is enough for what stands below.
                self.is_reported = true;
                Lines::Skipped("")
            }
        };
    }

    fn holds_constants(&self) -> bool {
        match self.lines {
            Lines::Untyped | Lines::Skipped("CHARACTER") | Lines::Data(Data::Constants { .. } | Data::Control) => true,
            Lines::Outside | Lines::Data(_) | Lines::Code(_) | Lines::Skipped(_) => false,
        }
    }

    fn open_model(&mut self, number: usize, name: &str) {
        self.lines = Lines::Outside;
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !is_name {
            self.fail(number, format!("`{name}` is no name of a model; expected `$MODEL NAME`"));
        }
        if self.is_ended {
            self.fail(number, "a second model at the top; expected one, with submodels within".to_owned());
        }
        if self.models.len() >= DEEPEST {
            self.fail(number, format!("submodels are nested deeper than {DEEPEST}"));
            return;
        }
        if self.models.is_empty() {
            self.blocks.title = name.to_owned();
        }
        self.models.push(name.to_owned());
    }

    fn data(&mut self, number: usize, data: Data, code: &str, comment: Option<&str>) {
        let pieces = match pieces(code) {
            Ok(pieces) => pieces,
            Err(message) => {
                // The rest of the statement means nothing without this line.
                self.open = None;
                return self.fail(number, message);
            }
        };
        for piece in pieces {
            if piece == Piece::Sign(';') {
                if let Some(mut statement) = self.open.take() {
                    statement.comment = comment.map(str::to_owned);
                    self.blocks.statements.push(statement);
                }
                continue;
            }
            let model = self.models.iter().skip(1);
            let statement = self.open.get_or_insert_with(|| Statement {
                data,
                model: model.cloned().collect(),
                line: number,
                pieces: Vec::new(),
                comment: None,
            });
            statement.pieces.push(piece);
        }
    }

    fn close_statement(&mut self) {
        if let Some(statement) = self.open.take() {
            self.fail(statement.line, "the statement does not end before the next block; expected `;`".to_owned());
        }
    }
}

/// A line without its comment, and the comment. A `#` within quotes is text.
fn without_comment(line: &str) -> (&str, Option<&str>) {
    let mut quote = None;
    for (position, character) in line.char_indices() {
        match (quote, character) {
            (None, '#') => {
                let (code, comment) = line.split_at(position);
                return (code, comment.get(1..).map(str::trim));
            }
            (None, '\'' | '"') => quote = Some(character),
            (Some(open), _) if open == character => quote = None,
            _ => {}
        }
    }
    (line, None)
}

/// Whether a line is a type of constants alone.
fn is_type(code: &str) -> bool {
    let word = code.trim_start_matches('*').to_ascii_uppercase();
    matches!(word.as_str(), "REAL" | "INTEGER" | "CHARACTER" | "CONTROL")
}

/// The start of a line, for a message.
fn shortened(code: &str) -> String {
    code.chars().take(40).collect()
}
