//! `bmv watch`: who may ask, what is served, a change that is picked up, an adoption from the page.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::story::changed;
use super::studies::{bmv, code, plate, printed};

/// A study that is watched, until the test ends.
struct Watched {
    process: Child,
    /// `127.0.0.1:PORT`.
    host: String,
    token: String,
}

/// An answer: status, head, body.
struct Answer(u16, String, String);

impl Answer {
    fn field(&self, name: &str) -> Option<&str> {
        self.1.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "))
    }
}

impl Watched {
    fn start(root: &Path, study: &str) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_bmv"))
            .current_dir(root)
            .args(["watch", study, "--cache", "cache"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (host, token) = line.trim().strip_prefix("http://").unwrap().split_once("/?token=").unwrap();
        assert!(host.starts_with("127.0.0.1:"), "{line}");
        Self { process, host: host.to_owned(), token: token.to_owned() }
    }

    /// Asks, with these fields beside those that every request needs.
    fn ask(&self, what: &str, fields: &[&str], body: &str) -> Answer {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let fields: String = fields.iter().map(|field| format!("{field}\r\n")).collect();
        let length = body.len();
        let head = format!("{what} HTTP/1.1\r\nConnection: close\r\nContent-Length: {length}\r\n{fields}\r\n{body}");
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        Answer(head.split(' ').nth(1).unwrap().parse().unwrap(), head.to_owned(), body.to_owned())
    }

    /// Asks until the study stands so, at that version or a later one: a file that is read while it is written may make one of its own.
    fn until(&self, own: &[&str], state: &str, version: u64) -> Value {
        let begun = Instant::now();
        loop {
            let status: Value = serde_json::from_str(&self.ask("GET /status", own, "").2).unwrap();
            if status["state"] == state && status["version"].as_u64().is_some_and(|own| own >= version) {
                return status;
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "{status}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
#[ignore = "thorough"]
fn a_watched_study_is_served_to_one_browser_run_again_and_taken_further() {
    let root = changed(|pass| pass["jobs"].as_object_mut().unwrap().retain(|name, _| name == "missing"));
    let study = root.path().join("hidden");
    let watched = Watched::start(root.path(), "hidden");
    let host = format!("Host: {}", watched.host);
    let origin = format!("Origin: http://{}", watched.host);
    let enter = format!("GET /?token={}", watched.token);

    // Nobody comes in without the link, by another name, or from the page of another origin.
    assert_eq!(watched.ask("GET /status", &[&host], "").0, 403);
    assert_eq!(watched.ask("GET /?token=00", &[&host], "").0, 403);
    for field in ["Host: rebound.example", "Host: localhost:1", "X: y"] {
        assert_eq!(watched.ask(&enter, &[field], "").0, 403, "{field}");
    }
    assert_eq!(watched.ask(&enter, &[&host, "Origin: http://127.0.0.1:1"], "").0, 403);
    let entered = watched.ask(&enter, &[&host], "");
    assert_eq!((entered.0, entered.field("Location")), (303, Some("/")));
    let cookie = entered.field("Set-Cookie").unwrap().split(';').next().unwrap();
    assert_eq!(watched.ask(&enter, &[&host], "").0, 403, "a link opens one browser");
    let cookie = format!("Cookie: {cookie}");
    let own = [host.as_str(), cookie.as_str()];
    assert_eq!(watched.ask("GET /status", &["Host: localhost", &cookie], "").0, 403);
    assert_eq!(watched.ask("GET /status", &[&host, "Cookie: bmv-1=0"], "").0, 403);

    watched.until(&own, "ready", 1);
    let home = watched.ask("GET /", &own, "");
    assert_eq!(home.field("Location"), Some("/hidden/pass-1/report.html"));
    let page = watched.ask("GET /hidden/pass-1/report.html", &own, "");
    assert_eq!(page.0, 200);
    let policy = page.field("Content-Security-Policy").unwrap();
    assert!(policy.contains("default-src 'none'") && policy.contains("frame-ancestors 'none'"), "{policy}");
    assert!(page.2.contains("data-version=\"1\"") && page.2.contains("What is missing"), "{}", page.2);
    let offered = "<code>bmv adopt hidden/pass-1.json</code>";
    assert!(page.2.contains("action=\"/adopt\"") && page.2.contains(offered), "{}", page.2);
    for page in ["/index.html", "/hidden/index.html", "/hidden/pass-1/results.json"] {
        assert_eq!(watched.ask(&format!("GET {page}"), &own, "").0, 200, "{page}");
    }
    for path in [
        "/hidden/model.json",
        "/hidden/../hidden/model.json",
        "/hidden/pass-1/../../../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/hidden/pass-1/report.html/",
        "http://127.0.0.1/etc/passwd",
    ] {
        assert_eq!(watched.ask(&format!("GET {path}"), &own, "").0, 404, "{path}");
    }
    assert!(!root.path().join("reports").exists(), "reports are kept in memory");

    // What is wrong is shown at its place, and the last good report stays.
    let model = fs::read_to_string(study.join("model.json")).unwrap();
    fs::write(study.join("model.json"), model.replacen("\"nodes\"", "\"nodse\"", 1)).unwrap();
    let wrong = watched.until(&own, "wrong", 1);
    let said = wrong["messages"].as_str().unwrap();
    assert!(said.contains("hidden/model.json:") && said.contains("`nodse`"), "{said}");
    let page = watched.ask("GET /hidden/pass-1/report.html", &own, "");
    assert!(page.2.contains("data-state=\"wrong\"") && page.2.contains("What is missing"), "{}", page.2);
    // What is shown is older than the files: nothing is adopted from it.
    let own_page = [own[0], own[1], origin.as_str()];
    let no_effect = "pass=pass-1.json&job=missing&effect=no-such-effect";
    let refused = watched.ask("POST /adopt", &own_page, no_effect);
    assert_eq!(refused.0, 409);
    assert!(refused.2.contains("something in it is wrong: adopt when the new results are there"), "{}", refused.2);
    fs::write(study.join("model.json"), &model).unwrap();
    let again = watched.until(&own, "ready", 2)["version"].as_u64().unwrap();

    // Nor while it runs again. What nothing reads starts no run.
    fs::write(study.join("notes.txt"), "seen by nobody").unwrap();
    let pass = fs::read_to_string(study.join("pass-1.json")).unwrap();
    let mut other: Value = serde_json::from_str(&pass).unwrap();
    other["seed"] = (other["seed"].as_u64().unwrap() + 1).into();
    fs::write(study.join("pass-1.json"), other.to_string()).unwrap();
    watched.until(&own, "running", again);
    let refused = watched.ask("POST /adopt", &own_page, no_effect);
    assert_eq!(refused.0, 409);
    assert!(refused.2.contains("the study is running again"), "{}", refused.2);
    let other_seed = watched.until(&own, "ready", again + 1)["version"].as_u64().unwrap();
    fs::write(study.join("pass-1.json"), pass).unwrap();
    watched.until(&own, "ready", other_seed + 1);

    // The page adopts what the command adopts, byte for byte; and nothing by a request of another origin.
    let form = "pass=pass-1.json&job=missing";
    assert_eq!(watched.ask("POST /adopt", &own, form).0, 403);
    let foreign = [own[0], own[1], "Origin: null"];
    assert_eq!(watched.ask("POST /adopt", &foreign, form).0, 403);
    assert_eq!(watched.ask("POST /adopt", &[&host, &origin], form).0, 403);
    assert_eq!(watched.ask("POST /adopt", &own_page, "pass=..%2Fpass-1.json&job=missing").0, 404);
    assert_eq!(watched.ask("POST /adopt", &own_page, "pass=pass-1.json&job=other").0, 404);
    let refused = watched.ask("POST /adopt", &own_page, &format!("{form}&effect=no-such-effect"));
    assert_eq!(refused.0, 409);
    assert!(refused.2.contains("no effect `no-such-effect`"), "{}", refused.2);
    assert!(!study.join("pass-2.json").exists());
    let adopted = watched.ask("POST /adopt", &own_page, form);
    assert_eq!((adopted.0, adopted.field("Location")), (303, Some("/hidden/pass-2/report.html")));
    drop(watched);
    let by_command = |by_page: Vec<u8>, options: &[&str]| {
        fs::remove_file(study.join("pass-2.json")).unwrap();
        let command = ["adopt", "hidden/pass-1.json", "--cache", "cache"];
        printed(root.path(), &[&command, options].concat());
        assert_eq!(by_page, fs::read(study.join("pass-2.json")).unwrap());
        fs::remove_file(study.join("pass-2.json")).unwrap();
    };
    by_command(fs::read(study.join("pass-2.json")).unwrap(), &[]);

    // It says where the effect acts, and keeps it in the test alone where that is asked for.
    let watched = Watched::start(root.path(), "hidden");
    let (host, origin) = (format!("Host: {}", watched.host), format!("Origin: http://{}", watched.host));
    let entered = watched.ask(&format!("GET /?token={}", watched.token), &[&host], "");
    let cookie = format!("Cookie: {}", entered.field("Set-Cookie").unwrap().split(';').next().unwrap());
    let own_page = [host.as_str(), cookie.as_str(), origin.as_str()];
    watched.until(&own_page[..2], "ready", 1);
    let page = watched.ask("GET /hidden/pass-1/report.html", &own_page[..2], "").2;
    assert!(page.contains("it acts in measurement") && page.contains("--test-only</code>"), "{page}");
    assert_eq!(watched.ask("POST /adopt", &own_page, &format!("{form}&test_only=1")).0, 303);
    drop(watched);
    let by_page = fs::read(study.join("pass-2.json")).unwrap();
    assert!(String::from_utf8_lossy(&by_page).contains("applies_to"));
    by_command(by_page, &["--test-only"]);
}

#[test]
fn a_job_that_failed_is_reported_with_its_reason_and_data_below_target_are_seen() {
    let root = plate();
    let study = root.path().join("plate");
    fs::create_dir(study.join("target")).unwrap();
    fs::rename(study.join("data/balance.csv"), study.join("target/balance.csv")).unwrap();
    let pass = fs::read_to_string(study.join("pass-1.json")).unwrap();
    fs::write(study.join("pass-1.json"), pass.replace("data/balance.csv", "target/balance.csv")).unwrap();
    // Below 0.45 W/K the load is no number: samples fail, and so does their job.
    let model = fs::read_to_string(study.join("model.json")).unwrap();
    let model = model.replace(r#""power": "Q""#, r#""power": "Q + 1e-9 * log(G - 0.45)""#);
    fs::write(study.join("model.json"), model).unwrap();
    let watched = Watched::start(root.path(), "plate");
    let host = format!("Host: {}", watched.host);
    let entered = watched.ask(&format!("GET /?token={}", watched.token), &[&host], "");
    let cookie = format!("Cookie: {}", entered.field("Set-Cookie").unwrap().split(';').next().unwrap());
    let own = [host.as_str(), cookie.as_str()];
    let said = watched.until(&own, "ready", 1);
    let messages = said["messages"].as_str().unwrap();
    assert!(messages.contains("pass-1.json: prior failed: ") && messages.contains("samples failed"), "{messages}");
    assert!(watched.ask("GET /plate/pass-1/report.html", &own, "").2.contains("samples failed"));
    fs::write(study.join("target/balance.csv"), "phase,Q,wall,plate\nP1,10,20,43\nP2,5,20,34\n").unwrap();
    watched.until(&own, "ready", 2);
    let csv = watched.ask("GET /plate/pass-1/plots/delivered-balance-phases.csv", &own, "");
    assert_eq!((csv.0, csv.field("Content-Type")), (200, Some("text/csv; charset=utf-8")));
    let last: Vec<&str> = csv.2.lines().last().unwrap().split(',').collect();
    // Measured 34 degC, predicted 20 degC + 5 W / 0.5 W/K and 3e-9 W.
    assert!(last[..2] == ["P2", "plate"] && (last[2].parse::<f64>().unwrap() - 4.0).abs() < 1e-6, "{}", csv.2);
}

#[test]
fn one_study_is_watched() {
    let root = tempfile::tempdir().unwrap();
    for study in ["a", "b"] {
        fs::create_dir(root.path().join(study)).unwrap();
        fs::write(root.path().join(study).join("pass-1.json"), "{}").unwrap();
    }
    let refused = bmv(root.path(), &["watch", "."]);
    assert_eq!(code(&refused), 2);
    assert!(String::from_utf8_lossy(&refused.stderr).contains("watch one: a, b"));
}
