//! Expression graphs for Graphviz.

use crate::graph::{Graph, Id, Node};
use crate::input::Inputs;
use crate::print::text::{PART, Unicode};
use crate::print::{Language, Text};

/// The graph that `roots` are formed from, in the DOT language: `dot -Tsvg` draws it. Arrows lead from operands to what is formed of
/// them; those of operands that may not be exchanged are numbered.
pub fn graphviz(graph: &Graph, inputs: &Inputs, roots: &[(String, Id)]) -> String {
    let mut text = String::from(
        "digraph expression {\n  rankdir=LR;\n  node [fontname=\"Helvetica\", fontsize=12, shape=box, style=rounded];\n  \
         edge [fontname=\"Helvetica\", fontsize=10];\n",
    );
    let ids: Vec<Id> = roots.iter().map(|(_, id)| *id).collect();
    for id in graph.reachable(&ids) {
        let node = graph.node(id);
        let (label, style) = match node {
            Node::Constant(number) => (Unicode.number(*number).text, ", shape=plain"),
            Node::Pi => ("π".into(), ", shape=plain"),
            Node::Input(number) => (
                inputs.find(*number).map_or(String::new(), |(input, place)| Unicode.input(input, place).text),
                ", style=\"rounded,filled\", fillcolor=\"#e8f0fe\"",
            ),
            other => (operation(other), ""),
        };
        text.push_str(&format!("  n{} [label=\"{}\"{style}];\n", id.0, label.replace('"', "\\\"")));
        let ordered = !matches!(node, Node::Add(..) | Node::Multiply(..) | Node::Norm(_));
        let operands = node.operands();
        for (i, operand) in operands.iter().enumerate() {
            let number =
                if ordered && operands.len() > 1 { format!(" [label=\"{}\"]", i + 1) } else { String::new() };
            text.push_str(&format!("  n{} -> n{}{number};\n", operand.0, id.0));
        }
    }
    for (i, (name, id)) in roots.iter().enumerate() {
        text.push_str(&format!(
            "  r{i} [label=\"{name}\", style=\"rounded,filled\", fillcolor=\"#e6f4ea\"];\n  n{} -> r{i};\n",
            id.0
        ));
    }
    text.push_str("}\n");
    text
}

fn operation(node: &Node) -> String {
    match node {
        Node::Add(..) => "+".into(),
        Node::Multiply(..) => "×".into(),
        Node::Divide(..) => "÷".into(),
        Node::Negate(_) => "−".into(),
        Node::Norm(_) => "norm".into(),
        Node::Quaternion(_, part) => format!("quaternion.{}", PART[usize::from(*part) % 4]),
        Node::Select { .. } => "1 < 2 ? 3 : 4".into(),
        Node::Arctangent(..) => "atan2".into(),
        Node::Power(..) => "power".into(),
        Node::Unsigned(_) => "0 +".into(),
        other => {
            let text = Unicode.function(other, &[Text::atom("x")]).text;
            text.strip_suffix("(x)").map_or(text.clone(), String::from)
        }
    }
}
