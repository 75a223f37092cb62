//! A small HTTP/1.1 server for programs and browsers on the same machine: bounded heads, bodies, times and numbers of
//! connections. A thread a connection, which may carry many requests. What is asked and answered is the caller's.

pub mod client;
pub mod message;

use std::io::{ErrorKind, Read, Write};
use std::net::{IpAddr, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use message::{HEAD_BYTES, Length, MOST_FIELDS, length, values};

/// Most connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// How long a connection may be silent.
const SILENCE: Duration = Duration::from_secs(60);
/// How long a request may take to come in.
const PATIENCE: Duration = Duration::from_secs(30);
/// Where a pause follows a refusal of the system.
const PAUSE: Duration = Duration::from_millis(50);

/// A request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Method, as in `POST`.
    pub method: String,
    /// Path, without what follows `?`.
    pub path: String,
    /// What follows `?`.
    pub query: String,
    /// Fields of the head, names in lower case; a value that is no UTF-8 is left out.
    pub fields: Vec<(String, String)>,
    /// Body.
    pub body: Vec<u8>,
}

impl Request {
    /// The values of a field by its name in lower case.
    pub fn field<'r>(&'r self, name: &'r str) -> impl Iterator<Item = &'r str> {
        self.fields.iter().filter(move |(own, _)| own == name).map(|(_, value)| value.as_str())
    }
}

/// An answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// Status.
    pub status: u16,
    /// Fields of its head, length and connection left out. No value holds a line's end.
    pub fields: Vec<(&'static str, String)>,
    /// Body.
    pub body: Vec<u8>,
}

impl Response {
    /// An answer whose body is JSON.
    pub fn json(status: u16, body: Vec<u8>) -> Self {
        Self { status, fields: vec![("Content-Type", "application/json".to_owned())], body }
    }
}

/// Answers requests.
pub trait Handler: Sync {
    /// The answer to a request.
    fn answer(&self, request: &Request) -> Response;
    /// The answer to what is no request that can be read, or fails: `reason` in words.
    fn refusal(&self, status: u16, reason: &str) -> Response;
}

/// Why a request could not be had.
enum Broken {
    /// The other side left, or was silent.
    Gone,
    /// It is no request that is served: status and reason.
    Refused(u16, &'static str),
}

impl From<std::io::Error> for Broken {
    fn from(_: std::io::Error) -> Self {
        Self::Gone
    }
}

/// Serves until the process ends.
///
/// # Errors
/// The listener's own address cannot be had.
pub fn serve(listener: &TcpListener, handler: &dyn Handler) -> std::io::Result<()> {
    let own = listener.local_addr()?.ip();
    let open = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for stream in listener.incoming() {
            let Ok(mut stream) = stream else {
                // Out of files, or a connection that was taken back.
                std::thread::sleep(PAUSE);
                continue;
            };
            if open.fetch_add(1, Ordering::AcqRel) >= MOST_CONNECTIONS {
                let _ = write(&mut stream, &handler.refusal(503, "too many connections"), false);
                open.fetch_sub(1, Ordering::AcqRel);
                continue;
            }
            let open = &open;
            let started = std::thread::Builder::new().spawn_scoped(scope, move || {
                // A reader that leaves ends its connection alone.
                let _ = connection(&mut stream, own, handler);
                open.fetch_sub(1, Ordering::AcqRel);
            });
            if started.is_err() {
                open.fetch_sub(1, Ordering::AcqRel);
                std::thread::sleep(PAUSE);
            }
        }
    });
    Ok(())
}

/// Serves in a thread of its own until the process ends.
///
/// # Errors
/// There is no further thread, or the listener's own address cannot be had.
pub fn serve_beside(listener: TcpListener, handler: Arc<dyn Handler + Send>) -> std::io::Result<()> {
    listener.local_addr()?;
    let serving = move || serve(&listener, handler.as_ref());
    std::thread::Builder::new().name("http".to_owned()).spawn(serving).map(drop)
}

/// A connection, with what was read of it and not used yet.
struct Connection<'s> {
    stream: &'s mut TcpStream,
    kept: Vec<u8>,
    /// When the request that comes in began to.
    begun: Option<Instant>,
}

/// Answers the requests of a connection until it ends.
fn connection(stream: &mut TcpStream, own: IpAddr, handler: &dyn Handler) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(SILENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut connection = Connection { stream, kept: Vec::new(), begun: None };
    loop {
        match connection.request(own) {
            Ok((request, stays)) => {
                let answered = catch_unwind(AssertUnwindSafe(|| handler.answer(&request)));
                let response = answered.unwrap_or_else(|_| handler.refusal(500, "what should answer failed"));
                write(connection.stream, &response, stays)?;
                if !stays {
                    return Ok(());
                }
            }
            Err(Broken::Gone) => return Ok(()),
            Err(Broken::Refused(status, reason)) => {
                return write(connection.stream, &handler.refusal(status, reason), false);
            }
        }
    }
}

impl Connection<'_> {
    /// Reads a request, and whether another may follow.
    fn request(&mut self, own: IpAddr) -> Result<(Request, bool), Broken> {
        // The first byte may take as long as the connection may be silent; then all of the request has to come.
        self.begun = (!self.kept.is_empty()).then(Instant::now);
        let head = loop {
            if let Some(head) = head(&self.kept, own)? {
                break head;
            }
            if self.kept.len() > HEAD_BYTES {
                return Err(Broken::Refused(431, "the head of the request is too large"));
            }
            self.more()?;
        };
        let whole = head.length + head.body;
        if head.waits && self.kept.len() < whole {
            self.stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n")?;
        }
        while self.kept.len() < whole {
            self.more()?;
        }
        let rest = self.kept.split_off(whole);
        let body = self.kept.split_off(head.length);
        self.kept = rest;
        let (path, query) = head.target.split_once('?').unwrap_or((&head.target, ""));
        let (path, query) = (path.to_owned(), query.to_owned());
        Ok((Request { method: head.method, path, query, fields: head.fields, body }, head.stays))
    }

    /// Waits for more bytes.
    fn more(&mut self) -> Result<(), Broken> {
        let mut buffer = [0; 8 << 10];
        match self.stream.read(&mut buffer) {
            Ok(0) => return Err(Broken::Gone),
            Ok(count) => self.kept.extend(buffer.iter().take(count)),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error.into()),
        }
        if self.begun.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
            return Err(Broken::Refused(408, "the request took too long to come in"));
        }
        Ok(())
    }
}

/// What a head says.
struct Head {
    method: String,
    target: String,
    fields: Vec<(String, String)>,
    /// Its own length, bytes.
    length: usize,
    /// Length of the body, bytes.
    body: usize,
    /// Whether the connection stays.
    stays: bool,
    /// Whether the body waits for a word.
    waits: bool,
}

/// Reads a head; `None` where it is not complete.
fn head(bytes: &[u8], own: IpAddr) -> Result<Option<Head>, Broken> {
    let mut fields = [httparse::EMPTY_HEADER; MOST_FIELDS];
    let mut request = httparse::Request::new(&mut fields);
    let own_length = match request.parse(bytes) {
        Ok(httparse::Status::Complete(length)) => length,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => return Err(Broken::Refused(431, "the head has too many fields")),
        Err(_) => return Err(Broken::Refused(400, "this is no HTTP request")),
    };
    let values = |name: &str| values(request.headers, name);
    if !values("transfer-encoding").is_empty() {
        return Err(Broken::Refused(411, "a body needs a Content-Length, and no other encoding is read"));
    }
    let body = match length(request.headers) {
        Length::Unsaid => 0,
        Length::Bytes(bytes) => bytes,
        Length::TooLong => return Err(Broken::Refused(413, "the body is larger than 16 MiB")),
        Length::Unreadable => return Err(Broken::Refused(400, "the Content-Length is no number")),
    };
    // A page in a browser may send requests to this machine by a name of its own; then the name tells.
    let is_local = |host: &String| {
        let name = host.rsplit_once(':').filter(|(_, port)| port.bytes().all(|digit| digit.is_ascii_digit()));
        let name = name.map_or(host.as_str(), |(name, _)| name).trim_matches(['[', ']']);
        name == "localhost" || name.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
    };
    if own.is_loopback() && !values("host").iter().all(is_local) {
        return Err(Broken::Refused(403, "this is served on this machine alone: ask 127.0.0.1 or localhost"));
    }
    let connection = values("connection");
    let stays = match request.version {
        Some(1) => !connection.iter().any(|value| value == "close"),
        _ => connection.iter().any(|value| value == "keep-alive"),
    };
    Ok(Some(Head {
        method: request.method.unwrap_or_default().to_owned(),
        target: request.path.unwrap_or_default().to_owned(),
        fields: (request.headers.iter())
            .filter_map(|field| Some((field.name.to_ascii_lowercase(), str::from_utf8(field.value).ok()?.to_owned())))
            .collect(),
        length: own_length,
        body,
        stays,
        waits: values("expect").iter().any(|value| value == "100-continue"),
    }))
}

/// Writes an answer.
fn write(stream: &mut TcpStream, response: &Response, stays: bool) -> std::io::Result<()> {
    let reason = match response.status {
        200..400 => "OK",
        status if status < 500 => "Refused",
        _ => "Failed",
    };
    let connection = if stays { "keep-alive" } else { "close" };
    let fields: String = response.fields.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
    let mut bytes = format!(
        "HTTP/1.1 {} {reason}\r\n{fields}Content-Length: {}\r\nConnection: {connection}\r\n\r\n",
        response.status,
        response.body.len()
    )
    .into_bytes();
    bytes.extend(&response.body);
    stream.write_all(&bytes)?;
    stream.flush()
}
