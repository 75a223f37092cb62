//! Tests of `core/src/effect/law.rs`.

use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::effect::checked::Effect;
use bmv::effect::law::*;

/// Every law of every unknown function of the catalogue is an effect file without a fault.
#[test]
fn all_laws_are_effect_files() {
    let embedded = Catalogue::embedded(&mut Diagnostics::new());
    let curves: Vec<&Effect> = embedded.effects().iter().filter(|effect| effect.is_unknown_function()).collect();
    assert_eq!(curves.len(), 2);
    for effect in curves {
        let files = laws(effect, true, "a curve");
        assert_eq!(files.len(), LAWS.len());
        for file in files {
            let (mut catalogue, mut diagnostics) = (embedded.clone(), Diagnostics::new());
            catalogue.read(&file.name, &file.name, file.text.as_bytes(), &mut diagnostics);
            catalogue.check(&mut diagnostics);
            assert!(diagnostics.is_empty(), "{}\n{}", file.text, diagnostics.render(false, 10));
            assert!(embedded.get(&file.name).is_none(), "{} has a name of its own", file.name);
        }
    }
    assert!(laws(embedded.get("heat-load").expect("there"), true, "a load").is_empty());
}

#[test]
fn the_input_has_the_name_that_the_effect_gives_it() {
    let heat = "constant + size * exp((x - x_upper) / x)";
    assert_eq!(with_input(heat, "flux"), "constant + size * exp((flux - flux_upper) / flux)");
}
