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
pub(super) struct Origin {
    /// The host: a name, or an address (of version 6 without its brackets).
    pub host: String,
    /// The port.
    pub port: u16,
}

impl Origin {
    /// Reads an address. Only plain ones are taken: no name of a user, no characters that programs read in several ways,
    /// no numbers that only some programs read as an address.
    pub(super) fn parse(url: &str) -> Option<Self> {
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
    pub(super) fn pin(&self, addresses: &[IpAddr]) -> Option<String> {
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
pub(super) fn is_internal(address: IpAddr) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(url: &str) -> Option<(String, u16)> {
        Origin::parse(url).map(|origin| (origin.host, origin.port))
    }

    #[test]
    fn only_plain_https_addresses_are_taken() {
        let some = |host: &str, port| Some((host.to_owned(), port));
        assert_eq!(parsed("https://example.org/x.csv"), some("example.org", 443));
        assert_eq!(parsed("https://example.org:8443?x"), some("example.org", 8443));
        assert_eq!(parsed("https://192.0.2.1/x"), some("192.0.2.1", 443));
        assert_eq!(parsed("https://[2001:db8::1]:1/x"), some("2001:db8::1", 1));
        for url in [
            "http://example.org/x",
            "file:///etc/passwd",
            "-o/tmp/x",
            "https://a b",
            "https:///x",
            "https://user@127.0.0.1/x",
            "https://example.org\\@127.0.0.1/x",
            "https://0x7f.0.0.1/x",
            "https://2130706433/x",
            "https://127.1/x",
            "https://example.org:x/",
            "https://ex%61mple.org/",
            "https://[::1/x",
        ] {
            assert_eq!(parsed(url), None, "{url}");
        }
    }

    #[test]
    fn addresses_that_are_not_public_are_known() {
        for text in [
            "127.0.0.1",
            "10.1.2.3",
            "172.16.0.1",
            "172.31.255.255",
            "192.168.1.1",
            "169.254.169.254",
            "100.64.0.1",
            "0.0.0.0",
            "224.0.0.1",
            "255.255.255.255",
            "::",
            "::1",
            "fe80::1",
            "fc00::1",
            "fd12::1",
            "ff02::1",
            "::ffff:127.0.0.1",
            "::ffff:10.0.0.1",
            "64:ff9b::a00:1",
            "2002:7f00:1::",
            "2001:db8::1",
            "2001::1",
        ] {
            assert!(is_internal(text.parse().expect("an address")), "{text}");
        }
        for text in
            ["8.8.8.8", "172.32.0.1", "100.128.0.1", "2606:4700::1111", "2001:4860:4860::8888", "2002:808:808::"]
        {
            assert!(!is_internal(text.parse().expect("an address")), "{text}");
        }
    }

    #[test]
    fn a_name_is_pinned_to_what_was_looked_at() {
        let addresses: Vec<IpAddr> = ["8.8.8.8", "2606:4700::1111"].map(|text| text.parse().expect("one")).to_vec();
        let origin = Origin::parse("https://example.org/x").expect("plain");
        assert_eq!(origin.pin(&addresses).expect("a name"), "example.org:443:8.8.8.8,[2606:4700::1111]");
        assert_eq!(Origin::parse("https://8.8.8.8/x").expect("plain").pin(&addresses), None);
    }
}
