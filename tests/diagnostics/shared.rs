//! Studies that lie outside the repository load without errors (where `BMV_SHARED` names their folder).

use bmv::document::Diagnostics;
use bmv::study::model;

#[test]
fn models_outside_the_repository_load() {
    let Ok(folder) = std::env::var("BMV_SHARED") else { return };
    let mut seen = 0;
    for entry in walkdir::WalkDir::new(folder).sort_by_file_name().into_iter().flatten() {
        if entry.file_name() != "model.json" {
            continue;
        }
        let bytes = std::fs::read(entry.path()).expect("readable");
        let mut diagnostics = Diagnostics::new();
        let model = model::load("model.json", &bytes, &mut diagnostics);
        assert!(
            model.is_some() && diagnostics.is_empty(),
            "{}:\n{}",
            entry.path().display(),
            diagnostics.render(false, 10)
        );
        seen += 1;
    }
    assert!(seen > 0, "the folder holds models");
}
