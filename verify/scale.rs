//! What holds of large models: the sparse Jacobian is that of the elements, threads change no bit, memory does not grow with time.

mod arrays;
pub(crate) mod chain;
mod demand;
mod forces;
mod sparse;
mod threads;

use pintle_model::evaluate::Model;
use pintle_scene::Scene;

/// A model of a chain of connectors of every type.
fn model(connectors: usize, rest: &str) -> (Scene, Model) {
    let text = chain::deck(connectors, &chain::types(), rest);
    let scene =
        Scene::parse("chain.inp", &text).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    let model = Model::compile(&scene).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    (scene, model)
}
