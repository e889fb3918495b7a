use crate::plan::Subject;
use crate::{Folder, Plan, Ranges, Summary, Sweep};
use rayon::prelude::*;

fn sweep(share: f64) -> Sweep {
    let plan = Plan::new("all types", "pintle", share, Subject::catalogue());
    Sweep::new(&plan.text().unwrap()).unwrap()
}

fn run(sweep: &Sweep, first: u64, count: u64) -> Summary {
    sweep.run(first, count, &|_| {}).unwrap()
}

/// Nothing is called wrong, at many states of every type, and the worst is what another computation of that state gives.
#[test]
fn nothing_is_wrong() {
    let sweep = sweep(0.02);
    let found = run(&sweep, 0, 40_000);
    assert_eq!(found.states.count(), 40_000);
    let judged: u64 = found.subjects.iter().map(|of| of.judged).sum();
    assert!(judged > 500, "{judged}");
    for of in &found.subjects {
        assert_eq!(of.wrong(), 0, "{of:?}");
        assert!(of.states() > 1000 && of.judged > 5 && of.numbers > 1000, "{of:?}");
        let rigid = of.largest_rigid.unwrap();
        let again = run(&sweep, rigid.index, 1);
        let [again] = again.subjects.iter().filter_map(|of| of.largest_rigid).collect::<Vec<_>>()[..] else {
            panic!("one state is of one subject");
        };
        assert_eq!(again, rigid, "{}", of.name);
    }
}

/// Any partition, order and number of threads: one summary.
#[test]
fn any_partition_gives_the_same_digest() {
    const STATES: u64 = 30_000;
    let sweep = sweep(0.005);
    let whole = run(&sweep, 0, STATES);
    let digest = whole.digest().unwrap();
    // Ends that lie within tiles, blocks and pieces.
    let ends = [0, 1, 2, 5, 31, 32, 33, 4095, 4097, 9_999, 20_001, 29_999, STATES];
    let chunks: Vec<(u64, u64)> = ends.windows(2).map(|pair| (pair[0], pair[1] - pair[0])).collect();
    let parts: Vec<Summary> = chunks.par_iter().map(|(first, count)| run(&sweep, *first, *count)).collect();
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| run(&sweep, 0, STATES)), whole, "{threads} threads");
    }
    let merged = |order: &[usize]| {
        let mut all = sweep.empty();
        order.iter().for_each(|i| all.merge(&parts[*i]).unwrap());
        all.digest().unwrap()
    };
    let mut order: Vec<usize> = (0..parts.len()).collect();
    for turn in 0..6 {
        assert_eq!(merged(&order), digest, "{order:?}");
        order.rotate_left(5);
        order.swap(0, 2 + turn);
    }
    // Pairs first: the merge is associative.
    let mut all = sweep.empty();
    for pair in parts.chunks(2).rev() {
        let mut two = pair.last().unwrap().clone();
        pair.iter().rev().skip(1).for_each(|one| two.merge(one).unwrap());
        all.merge(&two).unwrap();
    }
    assert_eq!(all, whole);
    // And what is kept as text is the same.
    assert_eq!(serde_json::from_str::<Summary>(&whole.text().unwrap()).unwrap(), whole);
    assert!(all.merge(&parts[3]).is_err(), "a state cannot count twice");
}

/// A digest that could not change would prove nothing: another seed, share or number of states has another one.
#[test]
fn what_differs_has_another_digest() {
    let of = |seed: &str, share: f64, count: u64| {
        let plan = Plan::new("", seed, share, vec![Subject::catalogue().swap_remove(0)]);
        let found = run(&Sweep::new(&plan.text().unwrap()).unwrap(), 0, count);
        (found.fingerprint, found.digest().unwrap())
    };
    let [one, seed, share, count] = [("a", 0.01, 900), ("b", 0.01, 900), ("a", 0.2, 900), ("a", 0.01, 901)]
        .map(|(seed, share, count)| of(seed, share, count));
    assert_eq!(one, of("a", 0.01, 900));
    assert!(one.0 != seed.0 && one.0 != count.0 && one.0 == share.0, "the numbers are those of the states");
    assert!(one.1 != seed.1 && one.1 != share.1 && one.1 != count.1);
}

/// What is there is not computed again, what is not is; a file of another plan is refused by name.
#[test]
fn a_folder_knows_what_is_left() {
    let path = std::env::temp_dir().join(format!("pintle-sweep-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&path);
    let sweep = sweep(0.001);
    let text = sweep.plan().text().unwrap();
    let folder = Folder::open(&path, &text).unwrap();
    let all = Ranges::of(0, 3000);
    let chunks = folder.left(&all, sweep.empty()).unwrap().chunks(1000);
    assert_eq!(chunks, [(0, 1000), (1000, 1000), (2000, 1000)]);
    for (first, count) in [chunks[2], chunks[0]] {
        folder.keep(&run(&sweep, first, count)).unwrap();
    }
    // What a killed worker leaves.
    std::fs::write(path.join(".chunk-000000000001000-1000.json.7.part"), "{\"sch").unwrap();
    let folder = Folder::open(&path, &text).unwrap();
    assert_eq!(folder.left(&all, sweep.empty()).unwrap().chunks(1000), [chunks[1]]);
    folder.keep(&run(&sweep, 1000, 1000)).unwrap();
    let digest = folder.merged(sweep.empty()).unwrap().digest().unwrap();
    assert_eq!(digest, run(&sweep, 0, 3000).digest().unwrap());
    let other = Plan::new("other", "pintle", 0.0, vec![Subject::catalogue().swap_remove(1)]).text().unwrap();
    let refused = Folder::open(&path, &other).unwrap_err().to_string();
    assert!(refused.contains("plan.json") && refused.contains("another plan"), "{refused}");
    std::fs::write(path.join("chunk-000000000009000-10.json"), "{").unwrap();
    let refused = folder.merged(sweep.empty()).unwrap_err().to_string();
    assert!(refused.contains("chunk-000000000009000-10.json") && refused.contains("delete it"), "{refused}");
    std::fs::remove_dir_all(&path).unwrap();
}
