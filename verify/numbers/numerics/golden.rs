//! The product against mpmath, number by number.

use super::function::{ALL, Function};
use super::{Reference, Worst, assert_gates, judge, unmeasured};
use serde::Deserialize;

#[derive(Deserialize)]
struct Header {
    sections: Vec<Section>,
}

#[derive(Deserialize)]
struct Section {
    function: String,
    cases: usize,
    inputs: usize,
    outputs: usize,
    numbers: usize,
    offset: usize,
}

/// The inputs of one case and the reference of each number of each output.
pub(super) struct Case {
    pub(super) inputs: Vec<f64>,
    pub(super) outputs: Vec<Vec<Reference>>,
}

/// The golden cases of a function.
pub(super) fn cases(function: Function) -> Vec<Case> {
    let header: Header = serde_json::from_str(include_str!("../../golden/numerics.json")).unwrap();
    let section = header.sections.iter().find(|s| s.function == function.name()).unwrap();
    let mut rest: &[u8] = &include_bytes!("../../golden/numerics.bin")[section.offset..];
    let mut double = |size: usize| {
        let (field, after) = rest.split_at(size);
        rest = after;
        if size == 8 {
            f64::from_le_bytes(field.try_into().unwrap())
        } else {
            f64::from(f32::from_le_bytes(field.try_into().unwrap()))
        }
    };
    (0..section.cases)
        .map(|_| Case {
            inputs: (0..section.inputs).map(|_| double(8)).collect(),
            outputs: (0..section.outputs)
                .map(|_| {
                    (0..section.numbers)
                        .map(|_| Reference { value: double(8), scale: double(8), rest: double(4) })
                        .collect()
                })
                .collect(),
        })
        .collect()
}

#[test]
fn product_agrees_with_mpmath() {
    let measured: Vec<Worst> = ALL
        .iter()
        .flat_map(|function| {
            let mut worst = unmeasured(*function);
            for case in cases(*function) {
                judge(&mut worst, *function, &case.inputs, &function.numbers(&case.inputs), &case.outputs);
            }
            worst
        })
        .collect();
    assert_gates("mpmath", &measured, &[]);
}
