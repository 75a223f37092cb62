//! Tests of `src/report/live.rs`.

use bmv::report::html;
use bmv::report::html::Beside;
use bmv::report::live::*;
use bmv::report::page::Page;

#[test]
fn a_served_page_has_everything_once_and_no_markup_of_the_study() {
    let hostile = "</main></style><script>alert(1)</script>\"'";
    let page = html::render(&Page { title: hostile.into(), ..Page::default() }, Beside::Nothing).expect("rendered");
    let offer = Offered {
        pass: hostile,
        job: hostile,
        effects: &[hostile.to_owned()],
        title: hostile,
        probability: hostile,
        command: hostile,
        acts: hostile,
    };
    let around = Around {
        version: 3,
        state: "ready",
        lines: &[hostile.to_owned()],
        messages: hostile,
        offers: &[offer],
        notice: hostile,
    };
    let served = served(&page, &around).expect("served");
    for (part, count) in
        [("<script>", 2), ("<script", 2), ("</style>", 1), (html::MAIN, 1), ("</main>", 1), ("id=\"live\"", 1)]
    {
        assert_eq!(served.matches(part).count(), count, "{part}: {served}");
    }
    assert!(served.contains("data-version=\"3\"") && served.contains(&policy_of_page()));
    assert!(served.contains("<button type=\"submit\">Adopt</button>"));
    assert_eq!(served.matches("name=\"test_only\"").count(), 1);
    let of_sensors = Around { offers: &[Offered { acts: "", ..offer }], ..around };
    let of_sensors = bmv::report::live::served(&page, &of_sensors).expect("served");
    assert!(!of_sensors.contains("test_only"), "a sensor is in no prediction");
    assert!(!page.contains(SCRIPT) && !page.contains("connect-src"), "a report has none of it");
}
