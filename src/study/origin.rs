//! The address of pinned data: what may be fetched from where.
//!
//! A study from elsewhere must not make the program ask machines that only this one can reach. So an origin is https, its
//! host is resolved here, and every address of it must be one of the public internet. The program that fetches is
//! given these addresses alone, and each redirect is looked at in the same way.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, ToSocketAddrs};

/// The port of https.
const PORT: u16 = 443;

/// An address of the form `https://host[:port]/...`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The host: a name, or an address (of version 6 without its brackets).
    pub host: String,
    /// The port.
    pub port: u16,
}

impl Origin {
    /// Reads an address. Only plain ones are taken: no name of a user, no characters that programs read in several ways,
    /// no numbers that only some programs read as an address.
    pub fn parse(url: &str) -> Option<Self> {
        let rest =
            url.strip_prefix("https://").filter(|rest| !rest.contains(|c: char| c.is_whitespace() || c == '\\'))?;
        let authority = rest.split(['/', '?', '#']).next()?;
        let (host, port) = match authority.strip_prefix('[') {
            Some(rest) => {
                let (host, port) = rest.split_once(']')?;
                host.parse::<Ipv6Addr>().ok()?;
                (host, port)
            }
            None => authority.split_at(authority.find(':').unwrap_or(authority.len())),
        };
        let port = if port.is_empty() { PORT } else { port.strip_prefix(':')?.parse().ok()? };
        let origin = Self { host: host.to_owned(), port };
        (origin.is_literal() || is_name(host)).then_some(origin)
    }

    fn is_literal(&self) -> bool {
        self.host.parse::<IpAddr>().is_ok()
    }

    /// Its addresses, by the system's own resolver.
    ///
    /// # Errors
    /// What the resolver says.
    pub(super) fn resolve(&self) -> io::Result<Vec<IpAddr>> {
        Ok((self.host.as_str(), self.port).to_socket_addrs()?.map(|address| address.ip()).collect())
    }

    /// What tells `curl` to use these addresses for this host, whatever the name stands for by then.
    pub fn pin(&self, addresses: &[IpAddr]) -> Option<String> {
        let bracketed = |address: &IpAddr| match address {
            IpAddr::V4(address) => address.to_string(),
            IpAddr::V6(address) => format!("[{address}]"),
        };
        let list: Vec<String> = addresses.iter().map(bracketed).collect();
        (!self.is_literal()).then(|| format!("{}:{}:{}", self.host, self.port, list.join(",")))
    }
}

/// Whether a text is a name of a host and nothing else: the last part of a number's text is a number.
fn is_name(host: &str) -> bool {
    let is_part = |part: &str| {
        !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_'))
    };
    let host = host.strip_suffix('.').unwrap_or(host);
    let last = host.rsplit('.').next().unwrap_or_default();
    host.split('.').all(is_part) && last.starts_with(|c: char| c.is_ascii_alphabetic())
}

/// Whether an address is none of the public internet: this machine, its own or a private network, or no single machine.
/// Ranges by the IANA registries of special-purpose addresses (RFC 6890).
pub fn is_internal(address: IpAddr) -> bool {
    match address {
        IpAddr::V4(address) => is_internal_v4(address),
        IpAddr::V6(address) => {
            let parts = address.segments();
            let embedded = |high: u16, low: u16| {
                let [[a, b], [c, d]] = [high.to_be_bytes(), low.to_be_bytes()];
                is_internal_v4(Ipv4Addr::new(a, b, c, d))
            };
            match parts {
                // Global unicast but for its special blocks; 6to4 holds an address of version 4.
                [0x2002, high, low, ..] => embedded(high, low),
                [0x2001, second, ..] => second < 0x0200 || second == 0x0db8,
                [0x64, 0xff9b, 0, 0, 0, 0, high, low] | [0, 0, 0, 0, 0, 0xffff, high, low] => embedded(high, low),
                [first, ..] => first & 0xe000 != 0x2000,
            }
        }
    }
}

fn is_internal_v4(address: Ipv4Addr) -> bool {
    match address.octets() {
        [0 | 10 | 127, ..] | [169, 254, ..] | [192, 168, ..] | [198, 18 | 19, ..] => true,
        [100, second, ..] => (64..128).contains(&second),
        [172, second, ..] => (16..32).contains(&second),
        [192, 0, 0 | 2, _] | [198, 51, 100, _] | [203, 0, 113, _] => true,
        // Many machines at once, and reserved.
        [first, ..] => first >= 224,
    }
}
