//! A small HTTP/1.1 client: JSON is posted to one host, whose connections are kept. No TLS, no redirects.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::message::{BODY_BYTES, HEAD_BYTES, Length, MOST_FIELDS, length, values};

/// How long a connection may take to be made.
const TO_CONNECT: Duration = Duration::from_secs(10);
/// How long a request may take to go out.
const TO_SEND: Duration = Duration::from_secs(30);
/// How often a wait looks whether it goes on.
const GLANCE: Duration = Duration::from_millis(50);

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Silence {
    /// No connection, or one that broke off.
    Unreachable(String),
    /// It took too long.
    TimedOut,
    /// The answer is none that is read.
    Unreadable(String),
}

/// An answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Status.
    pub status: u16,
    /// Body.
    pub body: Vec<u8>,
}

/// Asks one host.
#[derive(Debug)]
pub struct Client {
    host: String,
    addresses: Vec<SocketAddr>,
    idle: Mutex<Vec<TcpStream>>,
}

/// A wait that ends.
struct Wait<'a> {
    until: Instant,
    /// Called now and then; it may unwind. Whether the wait is given up.
    is_over: &'a dyn Fn() -> bool,
}

impl Client {
    /// Asks the host of this name, as requests state it, at one of these addresses.
    pub fn new(host: &str, addresses: Vec<SocketAddr>) -> Self {
        Self { host: host.to_owned(), addresses, idle: Mutex::default() }
    }

    /// The answer to a body posted to a path. `is_over` is called now and then while it waits; it may unwind, and gives the wait
    /// up as one that took too long.
    ///
    /// # Errors
    /// Why there is no answer.
    pub fn post(
        &self,
        path: &str,
        body: &[u8],
        timeout: Duration,
        is_over: &dyn Fn() -> bool,
    ) -> Result<Answer, Silence> {
        let wait = Wait { until: Instant::now() + timeout, is_over };
        let kept = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        if let Some(stream) = kept {
            match self.on(stream, path, body, &wait) {
                // The other side may have closed it since.
                Err(Silence::Unreachable(_)) => {}
                answered => return answered,
            }
        }
        self.on(self.connect(timeout)?, path, body, &wait)
    }

    fn connect(&self, timeout: Duration) -> Result<TcpStream, Silence> {
        let mut why = "the name has no address".to_owned();
        for address in &self.addresses {
            match TcpStream::connect_timeout(address, timeout.min(TO_CONNECT)) {
                Ok(stream) => return Ok(stream),
                Err(error) => why = error.to_string(),
            }
        }
        Err(Silence::Unreachable(why))
    }

    fn on(&self, mut stream: TcpStream, path: &str, body: &[u8], wait: &Wait<'_>) -> Result<Answer, Silence> {
        let gone = |error: std::io::Error| Silence::Unreachable(error.to_string());
        let set = stream.set_nodelay(true).and_then(|()| stream.set_write_timeout(Some(TO_SEND)));
        set.and_then(|()| stream.set_read_timeout(Some(GLANCE))).map_err(gone)?;
        let mut request = format!(
            "POST {path} HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n",
            self.host,
            body.len()
        )
        .into_bytes();
        request.extend(body);
        stream.write_all(&request).map_err(gone)?;
        let mut incoming = Incoming { stream: &mut stream, kept: Vec::new(), wait };
        let (response, stays) = incoming.response()?;
        if stays && incoming.kept.is_empty() {
            self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(stream);
        }
        Ok(response)
    }
}

/// An answer that comes in.
struct Incoming<'a> {
    stream: &'a mut TcpStream,
    kept: Vec<u8>,
    wait: &'a Wait<'a>,
}

/// What the head of an answer says.
struct Head {
    status: u16,
    own_length: usize,
    length: Length,
    is_chunked: bool,
    stays: bool,
}

fn unreadable(why: &str) -> Silence {
    Silence::Unreadable(why.to_owned())
}

impl Incoming<'_> {
    /// Waits for more bytes; whether there are any.
    fn more(&mut self) -> Result<bool, Silence> {
        let mut buffer = [0; 8 << 10];
        loop {
            match self.stream.read(&mut buffer) {
                Ok(0) => return Ok(false),
                Ok(count) => {
                    self.kept.extend(buffer.iter().take(count));
                    return Ok(true);
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(Silence::Unreachable(error.to_string())),
            }
            if (self.wait.is_over)() || Instant::now() > self.wait.until {
                return Err(Silence::TimedOut);
            }
        }
    }

    /// As [`Incoming::more`], where there has to be more.
    fn must_have_more(&mut self) -> Result<(), Silence> {
        if self.more()? { Ok(()) } else { Err(Silence::Unreachable("the connection was closed".to_owned())) }
    }

    /// The answer, and whether the connection stays.
    fn response(&mut self) -> Result<(Answer, bool), Silence> {
        let head = loop {
            if let Some(head) = head(&self.kept)? {
                // What a server says before it answers.
                if head.status >= 200 {
                    break head;
                }
                self.kept.drain(..head.own_length);
                continue;
            }
            if self.kept.len() > HEAD_BYTES {
                return Err(unreadable("the head of the answer is too large"));
            }
            self.must_have_more()?;
        };
        self.kept.drain(..head.own_length);
        let body = match head.length {
            _ if head.is_chunked => self.chunks()?,
            Length::Bytes(length) => {
                while self.kept.len() < length {
                    self.must_have_more()?;
                }
                let rest = self.kept.split_off(length);
                std::mem::replace(&mut self.kept, rest)
            }
            Length::Unsaid => {
                while self.more()? {
                    if self.kept.len() > BODY_BYTES {
                        return Err(unreadable("the answer is larger than 16 MiB"));
                    }
                }
                return Ok((Answer { status: head.status, body: std::mem::take(&mut self.kept) }, false));
            }
            Length::TooLong => return Err(unreadable("the answer is larger than 16 MiB")),
            Length::Unreadable => return Err(unreadable("the Content-Length of the answer is no number")),
        };
        Ok((Answer { status: head.status, body }, head.stays))
    }

    /// A body in chunks; trailing fields are read over.
    fn chunks(&mut self) -> Result<Vec<u8>, Silence> {
        let mut body = Vec::new();
        loop {
            let (from, size) = loop {
                match httparse::parse_chunk_size(&self.kept) {
                    Ok(httparse::Status::Complete((from, size))) => break (from, size),
                    Ok(httparse::Status::Partial) => self.must_have_more()?,
                    Err(_) => return Err(unreadable("the answer's chunks cannot be read")),
                }
            };
            let size = usize::try_from(size).unwrap_or(usize::MAX);
            if size > BODY_BYTES || body.len() + size > BODY_BYTES {
                return Err(unreadable("the answer is larger than 16 MiB"));
            }
            // A chunk ends with a line of its own; after the last one fields may follow, up to an empty line.
            while self.kept.len() < from + size + 2 {
                self.must_have_more()?;
            }
            body.extend(self.kept.get(from..from + size).unwrap_or_default());
            if size > 0 {
                self.kept.drain(..from + size + 2);
                continue;
            }
            self.kept.drain(..from);
            loop {
                match self.kept.windows(2).position(|pair| pair == b"\r\n") {
                    Some(0) => {
                        self.kept.drain(..2);
                        return Ok(body);
                    }
                    Some(end) => drop(self.kept.drain(..end + 2)),
                    None if self.kept.len() > HEAD_BYTES => return Err(unreadable("the answer's end is too long")),
                    None => self.must_have_more()?,
                }
            }
        }
    }
}

/// Reads a head; `None` where it is not complete.
fn head(bytes: &[u8]) -> Result<Option<Head>, Silence> {
    let mut fields = [httparse::EMPTY_HEADER; MOST_FIELDS];
    let mut response = httparse::Response::new(&mut fields);
    let own_length = match response.parse(bytes) {
        Ok(httparse::Status::Complete(length)) => length,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(_) => return Err(unreadable("what answers is no HTTP server")),
    };
    let named = |name: &str| values(response.headers, name);
    let is_chunked = named("transfer-encoding").iter().any(|value| value.contains("chunked"));
    let connection = named("connection");
    let stays = match response.version {
        Some(1) => !connection.iter().any(|value| value == "close"),
        _ => connection.iter().any(|value| value == "keep-alive"),
    };
    Ok(Some(Head {
        status: response.code.unwrap_or_default(),
        own_length,
        length: length(response.headers),
        is_chunked,
        stays,
    }))
}
