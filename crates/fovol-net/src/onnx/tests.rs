use super::export::model;
use super::model::{Dim, Graph, Model, TensorData};
use super::protobuf::Encode;
use crate::Weights;
use crate::plan::{Named, Plan};
use std::collections::HashSet;

fn exported(named: Named) -> (Plan, Model) {
    let config = named.config();
    let (plan, weights) = (config.plan().unwrap(), Weights::random(&config, 1).unwrap());
    let model = model(&plan, &weights, &[("training", "none".to_owned())]).unwrap();
    (plan, model)
}

/// Asserts that every value is written once, and before it is read.
fn check(graph: &Graph) {
    let given = graph.inputs.iter().map(|info| info.name.as_str());
    let constant = graph.initialisers.iter().map(|tensor| tensor.name.as_str());
    let mut known = HashSet::new();
    given.chain(constant).for_each(|name| assert!(known.insert(name), "{name} twice"));
    for node in &graph.nodes {
        let missing = node.inputs.iter().find(|input| !input.is_empty() && !known.contains(input.as_str()));
        assert_eq!(missing, None, "{}", node.name);
        node.outputs.iter().for_each(|name| assert!(!name.is_empty() && known.insert(name), "{name} twice"));
    }
    assert!(graph.outputs.iter().all(|info| known.contains(info.name.as_str())));
    let nodes: HashSet<_> = graph.nodes.iter().map(|node| &node.name).collect();
    assert_eq!(nodes.len(), graph.nodes.len());
}

#[test]
fn values_are_there_before_they_are_read() {
    Named::ALL.into_iter().for_each(|named| check(&exported(named).1.graph));
}

#[test]
fn every_value_is_read_or_an_output() {
    for named in Named::ALL {
        let graph = exported(named).1.graph;
        let read = graph.nodes.iter().flat_map(|node| &node.inputs);
        let shown = graph.outputs.iter().map(|info| &info.name);
        let used: HashSet<_> = read.chain(shown).collect();
        let made = graph.nodes.iter().flat_map(|node| &node.outputs);
        let made = made.chain(graph.initialisers.iter().map(|tensor| &tensor.name));
        let unused: Vec<_> = made.filter(|name| !used.contains(name)).collect();
        assert!(unused.is_empty(), "{named}: {unused:?}");
    }
}

#[test]
fn inputs_and_outputs_are_those_of_the_plan() {
    for named in Named::ALL {
        let (plan, model) = exported(named);
        let names = |list: &[super::model::ValueInfo]| -> Vec<String> {
            list.iter().map(|info| info.name.clone()).collect()
        };
        let of_states = |kind: &str| plan.states().iter().map(|s| format!("{kind}.{}", s.name)).collect();
        let states: Vec<String> = of_states("state");
        let motion = plan.inputs().motion.map(|_| "motion".to_owned());
        let inputs: Vec<String> = ["input".to_owned()].into_iter().chain(motion).chain(states).collect();
        assert_eq!(names(&model.graph.inputs), inputs, "{named}");
        let next: Vec<String> = of_states("next");
        assert_eq!(names(&model.graph.outputs), [&["output".to_owned()], &next[..]].concat(), "{named}");
        let channels = if plan.inputs().mask.is_some() { 4 } else { 3 };
        assert_eq!(model.graph.inputs[0].dims[..2], [Dim::Fixed(1), Dim::Fixed(channels)]);
        assert_eq!(model.graph.inputs[0].dims[2..], [Dim::Free("H".into()), Dim::Free("W".into())]);
    }
}

#[test]
fn initialisers_hold_the_learned_arrays() {
    let (plan, model) = exported(Named::WNetFast);
    let weights = Weights::random(&Named::WNetFast.config(), 1).unwrap();
    for parameter in plan.parameters() {
        let tensor = model.graph.initialisers.iter().find(|tensor| tensor.name == parameter.name).unwrap();
        assert_eq!(tensor.dims, parameter.shape);
        assert_eq!(tensor.data, TensorData::Floats(weights.values(&parameter.name).unwrap().to_vec()));
    }
}

#[test]
fn metadata_says_what_a_caller_needs() {
    let (_, model) = exported(Named::WNetFast);
    let value = |key: &str| model.metadata.iter().find(|entry| entry.key == key).unwrap().value.as_str();
    assert_eq!(value("fovolnet.multiple"), "16");
    assert_eq!(value("training"), "none");
    let states = r#"[{"name":"output","channels":3,"scale":1},{"name":"samples","channels":6,"scale":1}]"#;
    assert_eq!(value("fovolnet.states"), states);
}

#[test]
fn weights_of_another_network_are_refused() {
    let plan = Named::WNetPaper.config().plan().unwrap();
    let weights = Weights::random(&Named::WNetFast.config(), 1).unwrap();
    assert!(super::export(&plan, &weights, &[]).is_err());
}

#[test]
fn files_begin_with_the_version_of_the_format() {
    assert_eq!(exported(Named::WNetFast).1.to_bytes()[..12], *b"\x08\x08\x12\x08fovolnet");
}
