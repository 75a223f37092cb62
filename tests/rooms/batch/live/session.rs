//! Tests of `src/batch/live/session.rs`.

use bmv::batch::live::session::*;

#[test]
fn a_token_opens_once_and_a_cookie_again_and_again() {
    let session = Session::new(8080).expect("random numbers");
    let token = session.token();
    assert_eq!(token.len(), 64);
    assert_eq!(session.enter("").expect("random numbers"), None);
    assert_eq!(session.enter(&token[1..]).expect("random numbers"), None);
    let set = session.enter(&token).expect("random numbers").expect("the right one");
    assert_eq!(session.enter(&token).expect("random numbers"), None, "used up");
    assert_ne!(session.token(), token);
    assert!(set.contains("; HttpOnly; SameSite=Strict"));
    let cookie = set.split(';').next().expect("a first part");
    assert!(session.knows(cookie) && session.knows(&format!("a=b; {cookie}")));
    for wrong in ["", "bmv-8080=", &cookie[..cookie.len() - 1], &cookie.replace("8080", "8081")] {
        assert!(!session.knows(wrong), "{wrong}");
    }
}
