//! Asks models outside: programs and servers, several points at a time, and only what is allowed.
//!
//! A call that fails at a point is data, as a solve that fails is. What keeps every call from succeeding (a program that cannot be
//! started, a server that is gone) breaks the model off instead: nothing that was found since then is kept.

mod access;
mod call;
mod command;
pub mod output;
pub mod process;
mod umbridge;
mod umbridge_slopes;

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use crate::study::external::{External, How, Lender};
use crate::thermal::{Evaluator, Fault, Point, SlopesAt};
use crate::watch;

pub use access::Access;
use call::{Call, Failure};
use umbridge::Server;

/// How often a wait looks whether the run goes on.
const GLANCE: Duration = Duration::from_millis(20);
/// Pause before a server that was gone is asked again, doubled each time up to the longest.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// What is asked of a model at a point.
#[derive(Clone, Copy, Debug)]
enum Question<'a> {
    /// The outputs.
    Outputs(&'a Point),
    /// Slopes of the outputs.
    Slopes(&'a SlopesAt),
}

impl Question<'_> {
    fn point(&self) -> &Point {
        match self {
            Self::Outputs(point) => point,
            Self::Slopes(asked) => &asked.point,
        }
    }
}

/// Lends what asks models outside: equal models have one, so that they share how many calls are made at a time.
#[derive(Debug, Default)]
pub struct Outside {
    access: Access,
    lent: Mutex<HashMap<String, Arc<Asker>>>,
}

impl Outside {
    /// Asks what is allowed.
    pub fn new(access: Access) -> Self {
        Self { access, lent: Mutex::default() }
    }

    /// What is allowed.
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// Asks what is allowed, and has asked nothing yet: a model that broke off is tried again.
    pub fn anew(&self) -> Self {
        Self::new(self.access.clone())
    }
}

impl Lender for Outside {
    fn lend(&self, external: &Arc<External>) -> Arc<dyn Evaluator> {
        let where_it_is = match &external.how {
            How::Command(command) => command.folder.display().to_string(),
            How::UmBridge(model) => format!("{}{}", model.host, model.path),
        };
        let name = format!("{} {where_it_is}", external.fingerprint());
        let mut lent = self.lent.lock().unwrap_or_else(PoisonError::into_inner);
        let asker = lent.entry(name).or_insert_with(|| Arc::new(Asker::new(external, self.access.clone())));
        Arc::<Asker>::clone(asker)
    }
}

/// Asks one model.
#[derive(Debug)]
struct Asker {
    external: Arc<External>,
    access: Access,
    /// Calls that may begin.
    free: Mutex<u64>,
    freed: Condvar,
    at_once: u64,
    broken: OnceLock<String>,
    /// Whether it may be asked, and the server where it is one.
    ready: OnceLock<Result<Option<Server>, String>>,
}

impl Asker {
    fn new(external: &Arc<External>, access: Access) -> Self {
        let processors = || std::thread::available_parallelism().map_or(1, |count| count.get() as u64);
        let at_once = external.calls.at_once.unwrap_or_else(processors).max(1);
        Self {
            external: Arc::clone(external),
            access,
            free: Mutex::new(at_once),
            freed: Condvar::new(),
            at_once,
            broken: OnceLock::new(),
            ready: OnceLock::new(),
        }
    }

    fn prepared(&self) -> &Result<Option<Server>, String> {
        self.ready.get_or_init(|| match &self.external.how {
            How::Command(command) => self.access.command(&self.external, command).map(|()| None),
            How::UmBridge(model) => {
                let server = Server::new(&self.external, model, self.access.is_remote_allowed())?;
                Ok(Some(server.checked(&self.external, model)?))
            }
        })
    }

    /// The answer to a question: a call, repeated where it fails.
    fn answer(&self, question: Question<'_>, is_over: &dyn Fn() -> bool) -> Result<Vec<f64>, Fault> {
        let cannot = |detail: &str| Fault { what: "the model cannot be asked", detail: detail.to_owned() };
        if let Some(reason) = self.broken.get() {
            return Err(cannot(reason));
        }
        let server = match self.prepared() {
            Ok(server) => server.as_ref(),
            Err(reason) => return Err(cannot(self.broken.get_or_init(|| reason.clone()))),
        };
        let point = question.point();
        let given: Vec<f64> = (point.parameters.iter().chain(&point.inputs).enumerate())
            .map(|(place, value)| self.external.shown(place, *value))
            .collect();
        let call = Call { external: &self.external, given: &given, is_over };
        let mut pause = FIRST_PAUSE;
        let mut attempt = 0;
        let failure = loop {
            let answered = match (&self.external.how, server, question) {
                (How::Command(command), _, Question::Outputs(_)) => {
                    command::call(&call, command).and_then(|numbers| call.outputs(&numbers))
                }
                (How::Command(_), _, Question::Slopes(_)) => Err(Failure::Broken("a program has no slopes".to_owned())),
                (How::UmBridge(model), Some(server), Question::Outputs(_)) => {
                    server.call(&call, model).and_then(|numbers| call.outputs(&numbers))
                }
                (How::UmBridge(model), Some(server), Question::Slopes(asked)) => server.slopes(&call, model, asked),
                (How::UmBridge(_), None, _) => Err(Failure::Broken("the server was not looked for".to_owned())),
            };
            let failure = match answered {
                Ok(numbers) => return Ok(numbers),
                Err(failure) => failure,
            };
            let is_repeated = !matches!(failure, Failure::Refused(_)) && attempt < self.external.calls.retries;
            if !is_repeated || is_over() {
                break failure;
            }
            attempt += 1;
            if matches!(failure, Failure::Broken(_)) && server.is_some() {
                // It may be starting anew.
                let steps = pause.as_millis() / GLANCE.as_millis();
                for _ in 0..steps {
                    if !is_over() {
                        std::thread::sleep(GLANCE);
                    }
                }
                pause = (2 * pause).min(LONGEST_PAUSE);
            }
        };
        match failure {
            Failure::At(fault) | Failure::Refused(fault) => Err(fault),
            Failure::Broken(reason) => {
                let reason = format!("{}: {reason}", self.external.place);
                Err(cannot(self.broken.get_or_init(|| reason)))
            }
        }
    }

    /// Takes one of the calls that are made at a time; `None` where the wait was given up.
    fn permit(&self, is_over: &dyn Fn() -> bool) -> Option<Permit<'_>> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        while *free == 0 {
            let (now, _) = self.freed.wait_timeout(free, GLANCE).unwrap_or_else(PoisonError::into_inner);
            free = now;
            if *free == 0 && is_over() {
                return None;
            }
        }
        *free -= 1;
        Some(Permit(self))
    }

    fn one(&self, question: Question<'_>, is_over: &dyn Fn() -> bool) -> Result<Vec<f64>, Fault> {
        match self.permit(is_over) {
            Some(_permit) => self.answer(question, is_over),
            None => Err(Fault { what: "the model was not asked", detail: "the run was left".to_owned() }),
        }
    }

    /// Each question once, several at a time.
    fn all(&self, questions: &[Question<'_>]) -> Vec<Result<Vec<f64>, Fault>> {
        // A stop unwinds from here; what runs then is ended by whoever waits for it.
        let go_on = || {
            watch::check();
            false
        };
        if let [question] = questions {
            return vec![self.one(*question, &go_on)];
        }
        let (left, next) = (AtomicBool::new(false), AtomicUsize::new(0));
        let workers = usize::try_from(self.at_once).unwrap_or(usize::MAX).min(questions.len());
        let mut answers: Vec<Option<Result<Vec<f64>, Fault>>> = vec![None; questions.len()];
        std::thread::scope(|scope| {
            let leaving = Leaving(&left);
            let (sender, receiver) = channel();
            for _ in 0..workers {
                let (sender, left, next) = (sender.clone(), &left, &next);
                scope.spawn(move || {
                    let is_over = || left.load(Ordering::Relaxed);
                    let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|at| *at < questions.len());
                    while let Some(place) = take()
                        && !is_over()
                    {
                        // Nobody listens any more where the run was left.
                        let _ = sender.send((place, self.one(questions[place], &is_over)));
                    }
                });
            }
            drop(sender);
            loop {
                match receiver.recv_timeout(GLANCE) {
                    Ok((place, answer)) => answers[place] = Some(answer),
                    Err(RecvTimeoutError::Timeout) => watch::check(),
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            }
            drop(leaving);
        });
        let missing = || Fault { what: "the model was not asked", detail: "a thread ended early".to_owned() };
        answers.into_iter().map(|answer| answer.unwrap_or_else(|| Err(missing()))).collect()
    }
}

/// Tells the threads of a scope that is left to leave too.
struct Leaving<'a>(&'a AtomicBool);

impl Drop for Leaving<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// One of the calls that are made at a time.
struct Permit<'a>(&'a Asker);

impl Drop for Permit<'_> {
    fn drop(&mut self) {
        *self.0.free.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.0.freed.notify_one();
    }
}

impl Evaluator for Asker {
    fn ready(&self) -> Result<(), String> {
        if let Some(reason) = self.broken.get() {
            return Err(reason.clone());
        }
        self.prepared().as_ref().map(|_| ()).map_err(|reason| format!("{}: {reason}", self.external.place))
    }

    fn evaluate(&self, points: &[Point]) -> Vec<Result<Vec<f64>, Fault>> {
        // Equal points are asked once.
        let mut distinct: Vec<Question<'_>> = Vec::new();
        let mut places: HashMap<Vec<u64>, usize> = HashMap::new();
        let bits = |point: &Point| point.parameters.iter().chain(&point.inputs).map(|value| value.to_bits()).collect();
        let of: Vec<usize> = (points.iter())
            .map(|point| {
                *places.entry(bits(point)).or_insert_with(|| {
                    distinct.push(Question::Outputs(point));
                    distinct.len() - 1
                })
            })
            .collect();
        let answers = self.all(&distinct);
        of.into_iter().map(|place| answers[place].clone()).collect()
    }

    fn slopes(&self, asked: &[SlopesAt]) -> Vec<Result<Vec<f64>, Fault>> {
        let questions: Vec<Question<'_>> = asked.iter().map(Question::Slopes).collect();
        self.all(&questions)
    }

    fn broken(&self) -> Option<String> {
        self.broken.get().cloned()
    }
}
