//! Who may ask: whoever opens the link with the token, once; from then on the browser that got the cookie for it.

use std::sync::{Mutex, PoisonError};

use crate::document::hash::hex;

/// Random bytes of a secret.
const BYTES: usize = 32;

/// The secrets of a served study.
#[derive(Debug)]
pub struct Session {
    /// Name of the cookie: browsers send the cookies of all ports of a host.
    pub cookie: String,
    secret: String,
    token: Mutex<String>,
}

impl Session {
    /// New secrets.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn new(port: u16) -> std::io::Result<Self> {
        Ok(Self { cookie: format!("bmv-{port}"), secret: random()?, token: Mutex::new(random()?) })
    }

    /// The token that opens the next browser.
    pub fn token(&self) -> String {
        self.token.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Uses a token up: what the browser is to keep, where it is the right one and was not used before.
    ///
    /// # Errors
    /// The system gives no random numbers for the next one.
    pub fn enter(&self, given: &str) -> std::io::Result<Option<String>> {
        let mut token = self.token.lock().unwrap_or_else(PoisonError::into_inner);
        if !is_same(given, &token) {
            return Ok(None);
        }
        *token = random()?;
        Ok(Some(format!("{}={}; HttpOnly; SameSite=Strict; Path=/", self.cookie, self.secret)))
    }

    /// Whether a value of the field `Cookie` holds the secret.
    pub fn knows(&self, cookies: &str) -> bool {
        let pairs = cookies.split(';').filter_map(|pair| pair.trim().split_once('='));
        pairs.filter(|(name, _)| *name == self.cookie).any(|(_, value)| is_same(value, &self.secret))
    }
}

fn random() -> std::io::Result<String> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    Ok(hex(&bytes))
}

/// Whether two texts are the same, in a time that does not tell where they differ.
fn is_same(given: &str, own: &str) -> bool {
    let differing = given.bytes().zip(own.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    given.len() == own.len() && differing == 0
}
