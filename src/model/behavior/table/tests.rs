//! Tables at, between and beyond their rows, and rows that are none.

use crate::behavior::table::*;
use num_dual::{Dual2SVec64, DualSVec64};
use pintle_scene::{Code, TableRow};

fn rows(rows: &[(&[f64], Option<f64>)]) -> Vec<TableRow> {
    let row = |(values, temperature): &(&[f64], Option<f64>)| TableRow {
        values: values.iter().copied().map(Some).collect(),
        temperature: *temperature,
        ..TableRow::default()
    };
    rows.iter().map(row).collect()
}

fn table(data: &[(&[f64], Option<f64>)], columns: usize, extrapolation: Extrapolation) -> Table {
    Table::new(&rows(data), 1, &["x", "y", "z"][..columns], extrapolation).unwrap()
}

/// Where a product of two linear functions is a table, the table is that product, with its derivatives.
#[test]
fn a_grid_is_affine_in_each_variable() {
    let product = |x: f64, y: f64| (1.0 + 2.0 * x) * (3.0 - y);
    let mut data = Vec::new();
    for y in [-1.0, 0.5, 2.0] {
        for x in [0.0, 1.0, 4.0] {
            data.push(vec![product(x, y), x, y]);
        }
    }
    let data: Vec<(&[f64], Option<f64>)> = data.iter().map(|row| (row.as_slice(), None)).collect();
    let table = table(&data, 2, Extrapolation::Linear);
    for (x, y) in [(0.25, 0.25), (3.0, 1.0), (-2.0, 5.0), (1.0, 0.5), (4.0, 2.0), (0.0, -1.0), (9.0, -4.0)] {
        let seeded = [Dual2SVec64::<2>::from_re(x).derivative(0), Dual2SVec64::<2>::from_re(y).derivative(1)];
        let value = table.evaluate(0, |variable| match variable {
            Variable::Column(j) => seeded[j],
            _ => unreachable!(),
        });
        let (gradient, second) = (value.v1.0.unwrap(), value.v2.0.unwrap());
        let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-13 * (1.0 + b.abs()), "{x} {y}: {a} {b}");
        near(value.re, product(x, y));
        near(gradient[0], 2.0 * (3.0 - y));
        near(gradient[1], -(1.0 + 2.0 * x));
        near(second[(0, 0)], 0.0);
        near(second[(0, 1)], -2.0);
    }
}

/// The values given are the values got, bit for bit, and a curve may have other abscissae at another temperature.
#[test]
fn rows_are_met_exactly() {
    let data: [(&[f64], Option<f64>); 5] = [
        (&[0.1, -0.3], Some(20.0)),
        (&[0.7, 0.2], Some(20.0)),
        (&[0.3, -1.1], Some(100.0)),
        (&[0.5, 0.1], Some(100.0)),
        (&[0.9, 1.7], Some(100.0)),
    ];
    let table = table(&data, 1, Extrapolation::Constant);
    assert!(table.depends_on().eq([Variable::Column(0), Variable::Temperature]));
    for (values, temperature) in data {
        let value = table.evaluate(0, |variable| match variable {
            Variable::Temperature => temperature.unwrap(),
            _ => values[1],
        });
        assert_eq!(value, values[0]);
    }
    let between = table.evaluate(0, |variable| if variable == Variable::Temperature { 60.0 } else { 0.1 });
    // At 20 degrees 0.1 + 0.6·0.4/0.5, at 100 degrees 0.5.
    assert!((between - 0.5 * (0.58 + 0.5)).abs() < 1e-15, "{between}");
}

#[test]
fn slopes_at_a_row_are_those_of_least_norm() {
    let of = |y: [f64; 3], x: f64, extrapolation| {
        let points = [(-1.0, y[0]), (0.0, y[1]), (2.0, y[2])];
        let table = Table::curve(&points, extrapolation).unwrap();
        let value = table.evaluate(0, |_| DualSVec64::<1>::from_re(x).derivative(0));
        let kinks = table.kinks(0, |_| x);
        (value.eps.0.map_or(0.0, |eps| eps[0]), kinks.first().map(|kink| (kink.left, kink.right)))
    };
    use Extrapolation::{Constant, Linear};
    assert_eq!(of([0.0, 0.0, 6.0], 0.0, Constant), (0.0, Some((0.0, 3.0))));
    assert_eq!(of([-5.0, 0.0, 6.0], 0.0, Constant), (3.0, Some((5.0, 3.0))));
    assert_eq!(of([-2.0, 0.0, 6.0], 0.0, Constant), (2.0, Some((2.0, 3.0))));
    assert_eq!(of([5.0, 0.0, 6.0], 0.0, Constant), (0.0, Some((-5.0, 3.0))));
    assert_eq!(of([-3.0, 0.0, 6.0], 0.0, Constant), (3.0, None));
    assert_eq!(of([-3.0, 0.0, 6.0], 2.0, Constant), (0.0, Some((3.0, 0.0))));
    assert_eq!(of([-3.0, 0.0, 6.0], -1.0, Constant), (0.0, Some((0.0, 3.0))));
    assert_eq!(of([-3.0, 0.0, 6.0], 2.0, Linear), (3.0, None));
    assert_eq!(of([-3.0, 0.0, 8.0], 7.0, Linear), (4.0, None));
    assert_eq!(of([-3.0, 0.0, 8.0], 7.0, Constant), (0.0, None));
    // A hair beside the row the slope is that of the segment, and the row is still told.
    assert_eq!(of([0.0, 0.0, 6.0], 1e-300, Constant), (3.0, None));
    assert_eq!(of([0.0, 4.0, 4.0], 2.0 + 1e-15, Constant), (0.0, None));
    assert_eq!(of([0.0, 0.0, 6.0], 2.0 - 1e-15, Constant), (3.0, Some((3.0, 0.0))));
}

#[test]
fn the_range_of_doubles_is_used() {
    let points = [(-1e300, -2e-300), (1e-300, 3e300), (1e300, 4e300)];
    let table = Table::curve(&points, Extrapolation::Constant).unwrap();
    for (x, y) in points {
        assert_eq!(table.evaluate(0, |_| x), y);
    }
    let value = table.evaluate(0, |_| DualSVec64::<1>::from_re(5e299).derivative(0));
    assert!((value.re - 3.5e300).abs() < 1e285 && (value.eps.0.unwrap()[0] - 1.0).abs() < 1e-15);
    let steep = Table::curve(&[(0.0, 0.0), (1e-300, 1e300)], Extrapolation::Constant);
    assert_eq!(steep.unwrap_err().code(), Code::NumberOutOfRange);
    let near = Table::curve(&[(0.0, 0.0), (5e-324, 0.0)], Extrapolation::Constant);
    assert_eq!(near.unwrap_err().code(), Code::NumberOutOfRange);
}

#[test]
fn rows_out_of_order_are_told() {
    let fails = |data: &[(&[f64], Option<f64>)]| {
        let error = Table::new(&rows(data), 1, &["x", "y"], Extrapolation::Constant).unwrap_err();
        (error.code(), error.message().to_string())
    };
    let twice = fails(&[(&[1.0, 0.0, 0.0], None), (&[2.0, 0.0, 0.0], None)]);
    assert_eq!(twice, (Code::TableOrder, "this row stands twice".to_string()));
    let back = fails(&[(&[1.0, 1.0, 0.0], None), (&[2.0, 0.0, 0.0], None)]);
    assert_eq!(back, (Code::TableOrder, "x goes from 1 to 0".to_string()));
    let blocks = fails(&[(&[1.0, 0.0, 0.0], None), (&[1.0, 0.0, 1.0], None), (&[2.0, 1.0, 0.0], None)]);
    assert_eq!(blocks, (Code::TableOrder, "y goes from 1 to 0".to_string()));
    let partly = fails(&[(&[1.0, 0.0, 0.0], Some(20.0)), (&[2.0, 1.0, 0.0], None)]);
    assert_eq!(partly, (Code::MissingData, "the temperature is missing".to_string()));
}

/// A table of two variables with opposite slopes in neighbouring rows.
fn crossing(extrapolation: Extrapolation) -> Table {
    let data: [&[f64]; 6] = [
        &[1.0, 1.0, 1.0],
        &[-3.0, 3.0, 1.0],
        &[1.0, 4.0, 1.0],
        &[5.0, 1.0, 3.0],
        &[7.0, 3.0, 3.0],
        &[7.5, 4.0, 3.0],
    ];
    table(&data.map(|row| (row, None)), 2, extrapolation)
}

/// Σ |slopes of the rows| along the first variable; |Δ| and both rows' sizes over the step along the second.
#[test]
fn slopes_are_measured_by_what_they_are_formed_from() {
    let table = crossing(Extrapolation::Constant);
    let scales = |x: f64, y: f64| {
        let argument = |variable| if variable == Variable::Column(0) { x } else { y };
        let slope = |variable| table.slope_scale(0, argument, variable);
        [
            slope(Variable::Column(0)),
            slope(Variable::Column(1)),
            slope(Variable::Temperature),
            table.value_scale(0, argument),
        ]
    };
    assert_eq!(scales(2.0, 1.5), [3.0, 8.5, 0.0, 7.0]);
    // Where two slopes meet, the larger.
    assert_eq!(scales(3.0, 1.5), [4.5, 10.25, 0.0, 7.5]);
    // From the left, where there is nothing on the right.
    assert_eq!(scales(4.0, 1.5), [4.5, 7.5, 0.0, 7.5]);
    // Beyond the rows it is constant.
    assert_eq!(scales(9.0, 1.5), [0.0, 7.5, 0.0, 7.5]);
    assert_eq!(scales(2.0, 5.0), [1.0, 0.0, 0.0, 7.0]);
    assert_eq!(scales(2.0, -1.0), [2.0, 0.0, 0.0, 3.0]);
    let single =
        self::table(&[(&[1.0, 1.0, 2.0], None), (&[4.0, 3.0, 2.0], None)], 2, Extrapolation::Constant);
    let argument = |_| 2.0;
    let slope = |column| single.slope_scale(0, argument, Variable::Column(column));
    assert_eq!([slope(0), slope(1), single.value_scale(0, argument)], [1.5, 0.0, 4.0]);
}

/// Tables go to files and come back; what makes none is refused.
#[test]
fn tables_are_read_back_or_refused() {
    let table = crossing(Extrapolation::Linear);
    let written = serde_json::to_value(&table).unwrap();
    let read = |value: &serde_json::Value| {
        serde_json::from_value::<Table>(value.clone()).map_err(|error| error.to_string())
    };
    assert_eq!(read(&written).unwrap(), table);
    assert_eq!(table.outputs(), 1);
    // Whether a variable varies is found anew.
    let mut flags = written.clone();
    flags["variables"][0][1] = false.into();
    assert_eq!(read(&flags).unwrap(), table);
    let single = self::table(&[(&[1.0, 2.0], None)], 1, Extrapolation::Constant);
    let mut flags = serde_json::to_value(&single).unwrap();
    flags["variables"][0][1] = true.into();
    assert_eq!(read(&flags).unwrap(), single);
    let spoiled = |path: &str, value: serde_json::Value| {
        let mut spoiled = written.clone();
        *spoiled.pointer_mut(path).unwrap() = value;
        read(&spoiled).unwrap_err()
    };
    let inner = "/root/Along/blocks/1/Along";
    let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    for (path, value, why) in [
        ("/root/Along/at", "[1.0, 1.0]", "do not increase"),
        ("/root/Along/at", "[3.0, 1.0]", "do not increase"),
        ("/root/Along/at", "[1.0]", "a table has 1 values of a variable for 2 rows"),
        ("/root/Along/blocks", "[]", "a table has 2 values of a variable for 0 rows"),
        ("/root", r#"{"Along": {"at": [], "blocks": []}}"#, "a table has 0 values of a variable for 0 rows"),
        (&format!("{inner}/blocks/0"), r#"{"Values": []}"#, "no dependent value"),
        (&format!("{inner}/blocks/2"), r#"{"Values": [1.0, 2.0]}"#, "different numbers of dependent values"),
        (&format!("{inner}/blocks/2"), r#"{"Along": {"at": [1.0], "blocks": [{"Values": [1.0]}]}}"#, ""),
        ("/root", r#"{"Values": [1.0]}"#, ""),
    ] {
        let error = spoiled(path, json(value));
        assert!(error.contains(why), "{path} {value}: {error}");
    }
    assert_eq!(Block::Values(vec![1.0, 2.0, 3.0]).outputs(0), Ok(3));
    for x in [f64::NAN, f64::INFINITY] {
        assert!(Block::Values(vec![1.0, x]).outputs(0).is_err());
        let one = || Block::Values(vec![1.0]);
        assert!(Block::Along { at: vec![x], blocks: vec![one()] }.outputs(1).is_err());
        assert!(Block::Along { at: vec![1.0, x], blocks: vec![one(), one()] }.outputs(1).is_err());
    }
}
