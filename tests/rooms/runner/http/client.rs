//! Tests of `src/runner/http/client.rs`.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::time::Duration;

use bmv::runner::http::client::*;

/// A server that answers each connection's one request with these bytes.
fn answering(answers: &'static [&'static [u8]]) -> Client {
    let listener = TcpListener::bind("127.0.0.1:0").expect("bound");
    let address = listener.local_addr().expect("an address");
    std::thread::spawn(move || {
        for answer in answers {
            let (mut stream, _) = listener.accept().expect("a connection");
            let mut asked = [0; 4096];
            let _ = stream.read(&mut asked);
            let _ = stream.write_all(answer);
        }
    });
    Client::new("localhost", vec![address])
}

#[test]
fn bodies_come_by_length_in_chunks_and_until_the_end() {
    let client = answering(&[
        b"HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\n[1]\n",
        b"HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 500 No\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n[1\r\n1;x=y\r\n]\r\n0\r\nA: b\r\n\r\n",
        b"HTTP/1.0 200 OK\r\n\r\n[1]",
        b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n",
        b"SMTP\r\n\r\n",
        b"HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n[1]",
    ]);
    let ask = || client.post("/Evaluate", b"{}", Duration::from_secs(20), &|| false);
    assert_eq!(ask(), Ok(Answer { status: 200, body: b"[1]\n".to_vec() }));
    assert_eq!(ask(), Ok(Answer { status: 500, body: b"[1]".to_vec() }));
    assert_eq!(ask(), Ok(Answer { status: 200, body: b"[1]".to_vec() }));
    assert!(matches!(ask(), Err(Silence::Unreadable(_))));
    assert!(matches!(ask(), Err(Silence::Unreadable(_))));
    assert!(matches!(ask(), Err(Silence::Unreachable(_))), "broken off");
}

#[test]
fn a_server_that_is_silent_is_waited_for_no_longer_than_asked() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("bound");
    let client = Client::new("localhost", vec![listener.local_addr().expect("an address")]);
    let asked = client.post("/", b"{}", Duration::from_millis(120), &|| false);
    assert_eq!(asked, Err(Silence::TimedOut));
    assert_eq!(client.post("/", b"{}", Duration::from_secs(600), &|| true), Err(Silence::TimedOut));
}
