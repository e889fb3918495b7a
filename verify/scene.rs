//! Decks and states: what the gallery contains, what is refused and how, and that nothing panics.

use pintle::scene::GALLERY;

#[test]
fn gallery_reads() {
    for example in GALLERY {
        let scene = example.scene().unwrap_or_else(|error| panic!("{}", error.render(110, false)));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let states = example.states(&scene).unwrap_or_else(|error| panic!("{}", error.render(110, false)));
        assert!(states.states.len() > 10);
    }
}
