//! `bmv serve-model`: the plate on a wall by HTTP. What is asked wrongly, or is no request at all, is answered by an error of
//! the protocol, and the server goes on.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::studies::{bmv, code, plate, text};

/// A server, which ends with the test.
struct Server {
    process: Child,
    address: SocketAddr,
    _study: TempDir,
}

impl Server {
    fn start() -> Self {
        let study = plate();
        let mut process = Command::new(env!("CARGO_BIN_EXE_bmv"))
            .current_dir(study.path())
            .args(["serve-model", "plate/pass-1.json", "--port", "0"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("forward at http://").unwrap_or_else(|| panic!("{line}"));
        Self { address: address.parse().unwrap(), process, _study: study }
    }

    /// Sends bytes and reads until the other side closes: status and body.
    fn raw(&self, bytes: &[u8]) -> (u16, Value) {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        // A server that refuses may close before it has all.
        let _ = stream.write_all(bytes);
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_else(|| panic!("{answer}"));
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, serde_json::from_str(body).unwrap())
    }

    fn post(&self, path: &str, body: &str) -> (u16, Value) {
        let head = format!("POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n");
        self.raw(format!("{head}Content-Length: {}\r\n\r\n{body}", body.len()).as_bytes())
    }

    fn output(&self, path: &str, body: &Value) -> Value {
        let (status, answer) = self.post(path, &body.to_string());
        assert_eq!(status, 200, "{answer}");
        answer["output"].clone()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn a_network_answers_as_its_closed_form_and_refuses_what_is_wrong() {
    let server = Server::start();
    let (status, info) = server.raw(b"GET /Info HTTP/1.1\r\nHost: 127.0.0.1:1\r\nConnection: close\r\n\r\n");
    assert_eq!((status, info), (200, json!({"protocolVersion": 1.0, "models": ["forward"]})));
    let name = json!({"name": "forward"}).to_string();
    assert_eq!(server.post("/InputSizes", &name).1, json!({"inputSizes": [1, 2]}));
    assert_eq!(server.post("/OutputSizes", &name).1, json!({"outputSizes": [2]}));
    let (_, about) = server.post("/ModelInfo", &name);
    assert_eq!(about["support"]["Gradient"], true);
    // What requirement and sensor name, which is the same temperature here.
    assert_eq!(about["outputs"][0][0], json!({"name": "plate temperature", "unit": "K"}));
    assert_eq!(about["inputs"][0], json!([{"name": "G", "unit": "W/K", "nominal": 0.5}]));

    // 10 W through 0.4 W/K: 25 K above the wall; by G it is -Q / G^2, by Q 1 / G, by the wall 1. Solved to 1e-9 W.
    let at = json!([[0.4], [10.0, 290.0]]);
    let close = |found: &Value, expected: f64| {
        let found = found.as_f64().unwrap_or_else(|| panic!("{found} is a number"));
        assert!((found - expected).abs() < 1e-8 * expected.abs(), "{found} {expected}");
    };
    close(&server.output("/Evaluate", &json!({"name": "forward", "input": at, "config": {}}))[0][0], 315.0);
    let gradient = |input: u64| {
        let asked = json!({"name": "forward", "input": at, "outWrt": 0, "inWrt": input, "sens": [1.5, 0.5]});
        server.output("/Gradient", &asked)
    };
    close(&gradient(0)[0], -2.0 * 10.0 / 0.16);
    close(&gradient(1)[0], 2.0 / 0.4);
    close(&gradient(1)[1], 2.0);
    let along = json!({"name": "forward", "input": at, "outWrt": 0, "inWrt": 1, "vec": [2.0, 3.0]});
    close(&server.output("/ApplyJacobian", &along)[1], 2.0 / 0.4 + 3.0);

    let with = |change: Value| {
        let mut asked = json!({"name": "forward", "input": at, "outWrt": 0, "inWrt": 0, "sens": [1.0, 0.0]});
        for (field, value) in change.as_object().unwrap() {
            asked[field] = value.clone();
        }
        asked.to_string()
    };
    let wrong = [
        ("/Gradient", with(json!({"name": "other"})), "ModelNotFound", "there is no model `other`"),
        ("/Evaluate", with(json!({"input": [[0.4]]})), "InvalidInput", "`input` has 1 vector, expected 2"),
        ("/Evaluate", with(json!({"input": [[0.4], [1.0]]})), "InvalidInput", "1 number, expected 2: Q, T_wall"),
        ("/Evaluate", with(json!({"input": [["x"], [1.0, 2.0]]})), "InvalidInput", "the value of G is no finite"),
        ("/Evaluate", with(json!({"config": {"fine": true}})), "InvalidInput", "takes no `config`"),
        ("/Evaluate", with(json!({"input": [[-0.4], [10.0, 290.0]]})), "EvaluationFailed", ""),
        ("/Gradient", with(json!({"inWrt": 2})), "InvalidInput", "`inWrt` is no whole number from 0 to 1"),
        ("/Gradient", with(json!({"outWrt": -1})), "InvalidInput", "`outWrt`"),
        ("/Gradient", with(json!({"sens": []})), "InvalidInput", "`sens` has 0 numbers, expected 2"),
        ("/ApplyHessian", with(json!({})), "UnsupportedFeature", ""),
        ("/Evaluate", "{".to_owned(), "InvalidInput", "no JSON"),
        ("/Evaluate", "[".repeat(100_000), "InvalidInput", "no JSON"),
        ("/nothing", with(json!({})), "UnsupportedFeature", "there is no `/nothing`"),
    ];
    for (path, body, kind, message) in &wrong {
        let (status, answer) = server.post(path, body);
        assert!(status >= 400, "{path} {body}: {answer}");
        assert_eq!(answer["error"]["type"], *kind, "{path}: {answer}");
        assert!(answer["error"]["message"].as_str().unwrap().contains(message), "{path}: {answer}");
    }
    let raw: [(&[u8], u16); 7] = [
        (b"\x16\x03\x01\x02\x00\x01\x00\r\n\r\n", 400),
        (b"POST /Evaluate HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\n", 413),
        (b"POST /Evaluate HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n", 400),
        (b"POST /Evaluate HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 411),
        // A page of another site, which has given its name the address of this machine.
        (b"GET /Info HTTP/1.1\r\nHost: rebound.example:4242\r\n\r\n", 403),
        (b"GET /Evaluate HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", 405),
        (&[b"GET /Info HTTP/1.1\r\nX: ".as_slice(), &[b'a'; 20_000]].concat(), 431),
    ];
    for (bytes, expected) in raw {
        let (status, answer) = server.raw(bytes);
        assert_eq!(status, expected, "{} {answer}", bytes[..bytes.len().min(60)].escape_ascii());
        assert_eq!(answer["error"]["type"], "InvalidRequest");
    }
    close(&server.output("/Evaluate", &json!({"name": "forward", "input": at}))[0][0], 315.0);
}

#[test]
fn other_machines_are_let_in_by_a_flag_alone() {
    let study = plate();
    let refused = bmv(study.path(), &["serve-model", "plate/pass-1.json", "--address", "0.0.0.0", "--port", "0"]);
    assert_eq!(code(&refused), 2);
    assert!(text(&refused.stderr).contains("add --allow-remote if that is wanted"), "{}", text(&refused.stderr));
}
