//! What is answered to a browser: pages of the last good round, how the round under way stands, and an adoption.

use std::sync::{Arc, PoisonError};

use super::page::{Kind, Served};
use super::round::Round;
use super::session::Session;
use super::state::State;
use crate::batch::next_pass::{Acting, Adoption, Asked, adopt_into, diagnosis, to_mend};
use crate::document::visible::shell_word;
use crate::report::live::{self, Offered};
use crate::report::page::encoded;
use crate::runner::http::{Handler, Request, Response};

/// The one address that the pages may be asked at.
const HOST: &str = "127.0.0.1";
/// Diagnostics shown of one refusal.
const MOST_DIAGNOSTICS: usize = 20;
/// Fields of a form.
const MOST_FIELDS: usize = 64;

/// Answers browsers of this machine.
pub struct Site {
    state: Arc<State>,
    session: Session,
    host: String,
    /// Tells what happens, in the terminal.
    tell: Box<dyn Fn(&str) + Send + Sync>,
}

/// Why a request is refused: status, and the reason in words.
struct Refused(u16, String);

impl Refused {
    fn new(status: u16, reason: impl Into<String>) -> Self {
        Self(status, reason.into())
    }
}

impl Site {
    /// The pages of a study, served at a port of 127.0.0.1.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn new(state: Arc<State>, port: u16, tell: Box<dyn Fn(&str) + Send + Sync>) -> std::io::Result<Self> {
        Ok(Self { state, session: Session::new(port)?, host: format!("{HOST}:{port}"), tell })
    }

    /// The link that opens one browser.
    pub fn link(&self) -> String {
        format!("http://{}/?token={}", self.host, self.session.token())
    }

    fn answered(&self, request: &Request) -> Result<Response, Refused> {
        let hosts: Vec<&str> = request.field("host").collect();
        if hosts != [self.host.as_str()] {
            return Err(Refused::new(403, format!("this is served as http://{} alone", self.host)));
        }
        let own_origin = format!("http://{}", self.host);
        if request.field("origin").any(|origin| origin != own_origin) {
            return Err(Refused::new(403, "a page of another origin may not ask here"));
        }
        if let ("GET", "/", Some(token)) = (request.method.as_str(), request.path.as_str(), token(&request.query)) {
            return self.entered(token);
        }
        if !request.field("cookie").any(|cookies| self.session.knows(cookies)) {
            return Err(Refused::new(403, "open the link that bmv watch printed: it opens one browser, once"));
        }
        match (request.method.as_str(), request.path.as_str()) {
            ("GET", "/status") => Ok(unstored(Response::json(200, self.state.json().to_string().into_bytes()))),
            ("GET", path) => self.page(path),
            ("POST", "/adopt") if request.field("origin").next().is_none() => {
                Err(Refused::new(403, "what changes files is asked from a page of this origin alone"))
            }
            ("POST", "/adopt") => self.adopted(&request.body),
            (_, "/adopt") => Err(Refused::new(405, "adoptions are posted")),
            _ => Err(Refused::new(405, "pages are asked for by GET")),
        }
    }

    /// Lets a browser in.
    fn entered(&self, token: &str) -> Result<Response, Refused> {
        let cookie = self.session.enter(token).map_err(|error| Refused::new(500, error.to_string()))?;
        let Some(cookie) = cookie else {
            return Err(Refused::new(403, "this link was used or is none: bmv watch printed another one"));
        };
        (self.tell)(&format!("opened; for another browser: {}", self.link()));
        let mut response = moved("/");
        response.fields.push(("Set-Cookie", cookie));
        Ok(response)
    }

    fn page(&self, path: &str) -> Result<Response, Refused> {
        let (version, round) = self.state.round();
        if let (Some(round), "/") = (&round, path) {
            return Ok(moved(&address(&round.home)));
        }
        let path = decoded(path);
        match round.as_ref().and_then(|round| round.pages.get(&path)) {
            Some(Served { kind: Kind::Other(kind), content, .. }) => Ok(file(200, kind, content.clone())),
            Some(page) => {
                let offers: Vec<Offered<'_>> = (page.offers.iter())
                    .map(|(pass, own)| Offered {
                        pass,
                        job: &own.job,
                        effects: &own.effects,
                        title: &own.title,
                        probability: &own.probability,
                        command: &own.command,
                        acts: &own.acts,
                    })
                    .collect();
                self.whole(200, &String::from_utf8_lossy(&page.content), version, &offers, "")
            }
            None if path.ends_with(".html") || path == "/" => {
                let text = live::waiting().map_err(|error| Refused::new(500, error.to_string()))?;
                self.whole(if path == "/" { 200 } else { 202 }, &text, version, &[], "")
            }
            None => Err(Refused::new(404, "there is no such page")),
        }
    }

    /// A page with the state, and with what can be adopted from it.
    fn whole(
        &self,
        status: u16,
        text: &str,
        version: u64,
        offers: &[Offered<'_>],
        notice: &str,
    ) -> Result<Response, Refused> {
        let shown = self.state.shown();
        let around = live::Around {
            version,
            state: shown.state,
            lines: &shown.lines,
            messages: &shown.messages,
            offers,
            notice,
        };
        let text = live::served(text, &around).map_err(|error| Refused::new(500, error.to_string()))?;
        Ok(file(status, "text/html; charset=utf-8", text.into_bytes()))
    }

    /// Writes the next pass, as `bmv adopt` does.
    fn adopted(&self, body: &[u8]) -> Result<Response, Refused> {
        let form = form(body).ok_or_else(|| Refused::new(400, "the form cannot be read"))?;
        let field = |name: &str| form.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str());
        let (version, round) = self.state.round();
        let (Some(round), Some(file), Some(job)) = (round, field("pass"), field("job")) else {
            return Err(Refused::new(400, "the form names no pass, or no diagnosis"));
        };
        if self.state.shown().state != "ready" {
            return Err(Refused::new(
                409,
                "the study is running again, or something in it is wrong: adopt when the new results are there",
            ));
        }
        let effects = form.iter().filter(|(name, _)| name == "effect").map(|(_, value)| value.clone()).collect();
        let acting = if field("test_only").is_some() { Acting::InTests } else { Acting::Everywhere };
        match self.written(&round, file, job, (effects, acting))? {
            Ok(to) => Ok(moved(&to)),
            Err(messages) => {
                (self.tell)(&messages);
                let text = live::waiting().map_err(|error| Refused::new(500, error.to_string()))?;
                self.whole(409, &text, version, &[], &messages)
            }
        }
    }

    /// Where the next pass will be shown, or the messages of a refusal.
    fn written(
        &self,
        round: &Round,
        file: &str,
        job: &str,
        (effects, acting): (Vec<String>, Acting),
    ) -> Result<Result<String, String>, Refused> {
        let passes = &round.executed.passes;
        let pass = passes.iter().find(|pass| pass.file == file);
        let pass = pass.ok_or_else(|| Refused::new(404, "there is no such pass"))?;
        let output = diagnosis(pass, &round.executed, job);
        let output = output.ok_or_else(|| Refused::new(404, "the pass has no result of such a diagnosis"))?;
        let asked = Asked::new(&format!("bmv adopt {}", shell_word(&pass.shown)), &effects);
        let asked = asked.acting(acting).mending(to_mend(pass, &round.executed));
        let one_at_a_time = self.state.adopting.lock().unwrap_or_else(PoisonError::into_inner);
        let adoption = match adopt_into(&pass.pass, job, &output, &asked, None, false) {
            Ok(adoption) => adoption,
            Err(wrong) => return Ok(Err(wrong.render(false, MOST_DIAGNOSTICS))),
        };
        drop(one_at_a_time);
        let path = match adoption {
            Adoption::Written(path, next) => {
                let names: Vec<&str> = next.adopted.iter().map(|(name, _)| name.as_str()).collect();
                (self.tell)(&format!("wrote {}: {} with {}", path.display(), pass.file, names.join(", ")));
                self.state.adopt(path.clone());
                path
            }
            Adoption::There(path) => path,
        };
        let folder = path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let study = round.home.split('/').nth(1).unwrap_or_default().to_owned();
        Ok(Ok(address(&format!("/{study}/{folder}/report.html"))))
    }
}

impl Handler for Site {
    fn answer(&self, request: &Request) -> Response {
        self.answered(request).unwrap_or_else(|Refused(status, reason)| self.refusal(status, &reason))
    }

    fn refusal(&self, status: u16, reason: &str) -> Response {
        file(status, "text/plain; charset=utf-8", format!("{reason}\n").into_bytes())
    }
}

/// The token of a query.
pub fn token(query: &str) -> Option<&str> {
    query.split('&').find_map(|part| part.strip_prefix("token="))
}

/// An answer that no browser keeps, reads as anything else, or shows within another page.
fn file(status: u16, kind: &str, body: Vec<u8>) -> Response {
    let fields = vec![("Content-Type", kind.to_owned()), ("Content-Security-Policy", live::policy())];
    unstored(Response { status, fields, body })
}

fn unstored(mut response: Response) -> Response {
    response.fields.extend([
        ("Cache-Control", "no-store".to_owned()),
        ("X-Content-Type-Options", "nosniff".to_owned()),
        ("Referrer-Policy", "same-origin".to_owned()),
        ("Cross-Origin-Resource-Policy", "same-origin".to_owned()),
    ]);
    response
}

fn moved(to: &str) -> Response {
    unstored(Response { status: 303, fields: vec![("Location", to.to_owned())], body: Vec::new() })
}

/// A path as an address has it.
pub fn address(path: &str) -> String {
    path.split('/').map(encoded).collect::<Vec<_>>().join("/")
}

/// A path as it was before it was written as an address.
pub fn decoded(path: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = path.as_bytes();
    while let [first, others @ ..] = rest {
        let digits = others.get(..2).and_then(|digits| str::from_utf8(digits).ok());
        let code = digits.filter(|_| *first == b'%').and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { others.get(2..).unwrap_or_default() } else { others };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The fields of a form as browsers send it; nothing where it has very many, or is no text.
pub fn form(body: &[u8]) -> Option<Vec<(String, String)>> {
    let text = str::from_utf8(body).ok()?;
    let pairs: Vec<&str> = text.split('&').collect();
    let one = |pair: &&str| {
        let (name, value) = pair.split_once('=')?;
        Some((decoded(&name.replace('+', " ")), decoded(&value.replace('+', " "))))
    };
    if pairs.len() > MOST_FIELDS { None } else { pairs.iter().map(one).collect() }
}
