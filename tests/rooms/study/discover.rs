//! Tests of `src/study/discover.rs`.

use std::path::Path;

use bmv::study::discover::*;

fn tree(files: &[&str]) -> tempfile::TempDir {
    let root = tempfile::tempdir().expect("a folder");
    for file in files {
        let path = root.path().join(file);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("made");
        std::fs::write(path, "{}").expect("written");
    }
    root
}

fn names(root: &Path, found: &[Found]) -> Vec<String> {
    let relative = |path: &Path| path.strip_prefix(root).expect("below").display().to_string();
    found.iter().flat_map(|study| study.passes.iter().map(|pass| relative(pass))).collect()
}

#[test]
fn studies_are_found_sorted_and_hidden_folders_skipped() {
    let root = tree(&[
        "b/pass-10.json",
        "b/pass-2.json",
        "b/pass-1.json",
        "b/pass-x.json",
        "b/model.json",
        "a/deep/pass-1.json",
        ".git/pass-1.json",
        "target/pass-1.json",
        "c/model.json",
    ]);
    let studies = discover(&[root.path().to_owned()]).expect("found");
    assert_eq!(
        names(root.path(), &studies),
        ["a/deep/pass-1.json", "b/pass-1.json", "b/pass-2.json", "b/pass-10.json"]
    );
}

#[test]
fn a_file_a_folder_and_both_give_each_pass_once() {
    let root = tree(&["b/pass-1.json", "b/pass-2.json"]);
    let pass = root.path().join("b/pass-2.json");
    let one = discover(std::slice::from_ref(&pass)).expect("found");
    assert_eq!(names(root.path(), &one), ["b/pass-2.json"]);
    let both = discover(&[pass, root.path().join("b")]).expect("found");
    assert_eq!(names(root.path(), &both), ["b/pass-1.json", "b/pass-2.json"]);
}

#[test]
fn other_spellings_of_a_path_are_the_same_study() {
    let root = tree(&["b/pass-1.json", "b/pass-2.json", "b/data/x.csv"]);
    let spellings = ["b", "./b/", "b/./pass-1.json", "b/data/../pass-1.json"].map(|path| root.path().join(path));
    let studies = discover(&spellings).expect("found");
    assert_eq!(names(root.path(), &studies), ["b/pass-1.json", "b/pass-2.json"]);
    assert_eq!(plain(Path::new("./a/./b/")), Path::new("a/b"));
    assert_eq!(plain(Path::new("./pass-1.json")), Path::new("pass-1.json"));
}

#[test]
fn nothing_there_is_an_error() {
    let root = tree(&["c/model.json", "c/data.csv"]);
    assert!(matches!(discover(&[root.path().to_owned()]), Err(DiscoverError::NoPass { .. })));
    assert!(matches!(discover(&[root.path().join("no")]), Err(DiscoverError::Missing { .. })));
    assert!(matches!(discover(&[root.path().join("c/data.csv")]), Err(DiscoverError::NotAPass { .. })));
}
