//! `ro-crate-metadata.json`: the reports of a study as a research object, after RO-Crate Metadata Specification 1.1
//! (Sefton et al., 2020), in JSON-LD.
//!
//! The files of the reports are data entities. What they were made of lies outside the folder and is named by its hash, as
//! RFC 6920 writes it (`nih:sha-256;...`). Each pass is an action that made the one from the other.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::document::hash::sha256_hex;
use crate::report::INDEX;
use crate::runner::manifest::{FILE_NAME as MANIFEST, FileRecord};
use crate::study::file;

use super::{ArchivedPass, ArchivedStudy, FORMAT};

/// The file's name, which the specification prescribes.
pub const FILE_NAME: &str = "ro-crate-metadata.json";
const CONTEXT: &str = "https://w3id.org/ro/crate/1.1/context";
const PROFILE: &str = "https://w3id.org/ro/crate/1.1";
/// Largest file that is read, bytes.
const LARGEST: u64 = 1 << 30;
/// What made the files.
const SOFTWARE: &str = "#bmv";

/// What the specification asks of a root dataset and the study does not state.
pub fn lacks(study: &ArchivedStudy) -> Vec<&'static str> {
    let document = study.document();
    let lacks_date = document.is_none().then_some("date");
    lacks_date.into_iter().chain(document.is_none_or(|own| own.licence.is_none()).then_some("licence")).collect()
}

/// The description; `pages` are the files beside the passes' folders.
///
/// # Errors
/// What JSON cannot hold.
pub fn text(study: &ArchivedStudy, pages: &BTreeMap<String, FileRecord>) -> Result<String, serde_json::Error> {
    let mut graph = vec![
        json!({
            "@id": FILE_NAME,
            "@type": "CreativeWork",
            "about": {"@id": "./"},
            "conformsTo": {"@id": PROFILE},
            "version": FORMAT,
        }),
        root(study, pages),
    ];
    graph.extend(pages.iter().map(|(name, record)| entity(name, record)));
    let (mut inputs, mut actions, mut software) = (BTreeMap::new(), Vec::new(), BTreeMap::new());
    for pass in &study.passes {
        let files = files(pass);
        graph.push(json!({
            "@id": format!("{}/", address(&pass.folder)),
            "@type": "Dataset",
            "name": pass.record.title,
            "description": format!("Report of {} of the study {}", pass.record.pass, pass.record.study),
            "hasPart": references(files.keys().map(|name| address(name))),
        }));
        graph.extend(files.iter().map(|(name, record)| entity(name, record)));
        let mut read = Vec::new();
        for (path, record) in &pass.manifest.inputs {
            let id = format!("nih:sha-256;{}", record.sha256);
            read.push(id.clone());
            inputs.entry(id).or_insert_with(|| (path.clone(), record.clone()));
        }
        let engine = pass.manifest.engine_version;
        software.insert(format!("{SOFTWARE}-{engine}"), engine);
        actions.push(json!({
            "@id": format!("#{}", address(&pass.folder)),
            "@type": "CreateAction",
            "name": pass.manifest.command,
            "description": "Runs the jobs of the pass and renders its report",
            "instrument": {"@id": format!("{SOFTWARE}-{engine}")},
            "object": references(read.iter()),
            "result": references(files.keys().map(|name| address(name))),
        }));
    }
    graph.extend(inputs.into_iter().map(|(id, (path, record))| {
        json!({
            "@id": id,
            "@type": "CreativeWork",
            "name": path,
            "description": "Input, by its path in the project's folder",
            "encodingFormat": encoding(&path),
            "contentSize": record.bytes.to_string(),
            "sha256": record.sha256.as_str(),
        })
    }));
    graph.extend(software.into_iter().map(|(id, engine)| {
        let version = format!("numeric engine {engine}");
        json!({"@id": id, "@type": "SoftwareApplication", "name": "bmv", "softwareVersion": version})
    }));
    graph.extend(actions);
    graph.extend(contextual(study));
    let whole = json!({"@context": [CONTEXT, {"sha256": "https://schema.org/sha256"}], "@graph": graph});
    Ok(serde_json::to_string_pretty(&whole)? + "\n")
}

/// Which pages and manifests are not as the descriptions beside these reports list them; nothing where there is none.
///
/// # Errors
/// What the system says of a file that is there.
pub fn contradictions(reports: &[PathBuf]) -> std::io::Result<Vec<String>> {
    let mut found = Vec::new();
    let mut studies: Vec<&Path> = reports.iter().filter_map(|report| report.parent()).collect();
    studies.dedup();
    for study in studies {
        let Ok(bytes) = file::read(&study.join(FILE_NAME), LARGEST) else { continue };
        let listed: Value = serde_json::from_slice(&bytes).unwrap_or_default();
        let entities = listed.get("@graph").and_then(Value::as_array);
        let own =
            reports.iter().filter(|report| report.parent() == Some(study)).filter_map(|report| report.file_name());
        let manifests = own.map(|name| format!("{}/{MANIFEST}", name.to_string_lossy()));
        for name in manifests.chain(["html", "md"].map(|ending| format!("{INDEX}.{ending}"))) {
            let entity = entities.into_iter().flatten().find(|own| own.get("@id") == Some(&address(&name).into()));
            let hash = entity.and_then(|own| own.get("sha256")).and_then(Value::as_str);
            // A report that is kept elsewhere is not in the description.
            let is_page = !name.ends_with(MANIFEST);
            let is_listed = match file::read(&study.join(&name), LARGEST) {
                Ok(bytes) => hash.map_or(!is_page, |hash| hash == sha256_hex(&bytes)),
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => false,
                Err(error) => return Err(error),
            };
            if !is_listed {
                let place = study.join(&name);
                found.push(format!("{} is not as {FILE_NAME} beside it lists it", place.display()));
            }
        }
    }
    Ok(found)
}

fn root(study: &ArchivedStudy, pages: &BTreeMap<String, FileRecord>) -> Value {
    let document = study.document();
    let about = format!("Reports of the validation of a thermal model, study {}", study.folder);
    let passes = study.passes.iter().map(|pass| format!("{}/", address(&pass.folder)));
    let parts: Vec<String> = pages.keys().map(|name| address(name)).chain(passes).collect();
    let mut root = json!({
        "@id": "./",
        "@type": "Dataset",
        "name": study.title(),
        "description": document.and_then(|own| own.summary.clone()).unwrap_or(about),
        "hasPart": references(parts.iter()),
        "mentions": references(study.passes.iter().map(|pass| format!("#{}", address(&pass.folder)))),
    });
    if let (Some(document), Some(root)) = (document, root.as_object_mut()) {
        root.insert("identifier".into(), document.number.as_str().into());
        root.insert("version".into(), document.issue.as_str().into());
        root.insert("datePublished".into(), document.date.as_str().into());
        let linked = [
            ("license", document.licence.as_deref().map(licence_id)),
            ("author", document.author.as_ref().map(|_| "#author".to_owned())),
            ("publisher", document.organisation.as_ref().map(|_| "#organisation".to_owned())),
        ];
        for (term, id) in linked {
            root.extend(id.map(|id| (term.to_owned(), json!({"@id": id}))));
        }
    }
    root
}

/// Licence, author and publisher. A document does not say whether its author is a person or a part of the organisation.
fn contextual(study: &ArchivedStudy) -> Vec<Value> {
    let Some(document) = study.document() else { return Vec::new() };
    let licence = document.licence.as_ref().map(|licence| {
        json!({
            "@id": licence_id(licence),
            "@type": "CreativeWork",
            "name": licence,
            "description": format!("Licence of the reports: {licence}"),
        })
    });
    let named = |id: &str, name: &Option<String>| {
        name.as_ref().map(|name| json!({"@id": id, "@type": "Organization", "name": name}))
    };
    let author = named("#author", &document.author);
    licence.into_iter().chain(author).chain(named("#organisation", &document.organisation)).collect()
}

/// A licence's address: as it is written, that of a licence by its short name in the SPDX list, or one in this file.
fn licence_id(licence: &str) -> String {
    let is_short = licence.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-.+".contains(&byte));
    let is_address = licence.starts_with("https://") && licence.bytes().all(|byte| byte.is_ascii_graphic());
    match (is_address, is_short && !licence.is_empty()) {
        (true, _) => licence.to_owned(),
        (false, true) => format!("https://spdx.org/licenses/{licence}"),
        (false, false) => "#licence".to_owned(),
    }
}

/// The files of a pass by their path from the study's folder, the manifest with them.
fn files(pass: &ArchivedPass) -> BTreeMap<String, FileRecord> {
    let listed = pass.manifest.outputs.iter().map(|(name, record)| (name.as_str(), record));
    let all = listed.chain([(MANIFEST, &pass.manifest_file)]);
    all.map(|(name, record)| (format!("{}/{name}", pass.folder), record.clone())).collect()
}

fn entity(name: &str, record: &FileRecord) -> Value {
    json!({
        "@id": address(name),
        "@type": "File",
        "name": name,
        "encodingFormat": encoding(name),
        "contentSize": record.bytes.to_string(),
        "sha256": record.sha256.as_str(),
    })
}

fn references(ids: impl Iterator<Item = impl AsRef<str>>) -> Vec<Value> {
    ids.map(|id| json!({"@id": id.as_ref()})).collect()
}

/// A path as a relative address.
fn address(path: &str) -> String {
    path.split('/').map(crate::report::page::encoded).collect::<Vec<_>>().join("/")
}

/// Media type by the name's ending.
fn encoding(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("html") => "text/html",
        Some("md") => "text/markdown",
        Some("json") => "application/json",
        Some("svg") => "image/svg+xml",
        Some("csv") => "text/csv",
        Some("txt") => "text/plain",
        _ => "application/octet-stream",
    }
}
