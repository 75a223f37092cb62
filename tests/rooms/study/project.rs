//! Tests of `src/study/project.rs`.

use bmv::study::project::*;

/// A tree with these folders, and the root of a study's project in it.
fn root_of(folders: &[&str], study: &str) -> String {
    let tree = tempfile::tempdir().expect("a folder");
    for folder in folders.iter().chain([&study]) {
        std::fs::create_dir_all(tree.path().join(folder)).expect("made");
    }
    let root = Project::of(&tree.path().join(study)).root;
    let below = root.strip_prefix(whole(tree.path())).expect("inside the tree");
    below.display().to_string()
}

#[test]
fn the_nearest_repository_or_folder_of_studies_is_the_project() {
    assert_eq!(root_of(&[], "a/b/plate"), "a/b", "else where the study lies");
    assert_eq!(root_of(&[], "a/studies/plate"), "a");
    assert_eq!(root_of(&[], "a/studies/deep/plate"), "a");
    assert_eq!(root_of(&["a/.git"], "a/b/plate"), "a");
    assert_eq!(root_of(&["a/.git"], "a/b/studies/plate"), "a/b");
    assert_eq!(root_of(&["a/studies/b/.git"], "a/studies/b/plate"), "a/studies/b");
    assert_eq!(root_of(&["a/plate/.git"], "a/plate"), "a/plate", "a study may be a repository");
    assert_eq!(root_of(&["a/.bmv"], "a/b/plate"), "a");
    assert_eq!(root_of(&["a/b/.bmv", "a/.git"], "a/b/plate"), "a", "a cache says less than a repository");
    assert_eq!(root_of(&["a/plate/.bmv"], "a/plate"), "a", "a cache in the study itself says nothing");
}

#[cfg(unix)]
#[test]
fn a_folder_in_which_everybody_may_write_is_no_project() {
    use std::os::unix::fs::PermissionsExt;
    let tree = tempfile::tempdir().expect("a folder");
    std::fs::create_dir_all(tree.path().join("all/.bmv/cache")).expect("made");
    std::fs::create_dir_all(tree.path().join("all/mine/plate")).expect("made");
    let of_study = || Project::of(&tree.path().join("all/mine/plate")).root;
    assert!(of_study().ends_with("all"));
    let open = PermissionsExt::from_mode(0o1777);
    std::fs::set_permissions(tree.path().join("all"), open).expect("set");
    assert!(of_study().ends_with("mine"));
}

#[test]
fn paths_in_the_project_do_not_depend_on_the_spelling() {
    let tree = tempfile::tempdir().expect("a folder");
    std::fs::create_dir_all(tree.path().join("studies/plate/data")).expect("made");
    let plate = tree.path().join("studies/plate");
    for study in [plate.clone(), plate.join("."), plate.join("data/.."), tree.path().join("./studies/../studies/plate")]
    {
        let project = Project::of(&study);
        assert_eq!(project, Project::of(&plate));
        assert_eq!(project.path_of(&study, "pass-1.json"), "studies/plate/pass-1.json");
    }
}
