//! What a routine gave at all states, as tables: checks, why they are wrong, the report.

use crate::candidate::{AT_ONCE, KEPT};
use crate::case::quantity::Quantity;
use crate::engine::checks_of;
use crate::judge::bound::OF_OTHERS;
use crate::judge::outcome::{Against, Check, Expected, Report, Subject};
use crate::judge::table::ResultTable;
use crate::judge::verdict::{Finding, Judgement, Score, Verdict};
use crate::mutants::diagnosis::diagnose_tables;
use crate::oracles::certificate::Certificate;
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use crate::share::spread;
use rayon::prelude::*;

/// Checks, and the tables of what is wrong.
#[derive(Default)]
pub(super) struct Tables {
    checks: Vec<Check>,
    wrong: Vec<ResultTable>,
}

impl Tables {
    /// What a routine gives at each case, asked for some at once, and judged; of so many of the states mutants prove the check.
    ///
    /// # Errors
    /// The first of the routine.
    pub(super) fn asked<C: Sync, G: Send, E>(
        cases: &[C],
        mut routine: impl FnMut(&[&C]) -> Result<Vec<Option<G>>, E>,
        proving: usize,
        judge: impl Fn(&C, G, bool) -> Self + Sync,
    ) -> Result<Self, E> {
        let mut given = Vec::with_capacity(cases.len());
        for asked in cases.chunks(AT_ONCE) {
            let mut answers = routine(&asked.iter().collect::<Vec<_>>())?.into_iter();
            given.extend(asked.iter().map(|_| answers.next().flatten()));
        }
        let proves = spread(cases.len(), proving);
        let judged: Vec<Self> = cases
            .par_iter()
            .zip(given)
            .enumerate()
            .filter_map(|(i, (case, given))| Some(judge(case, given?, proves.contains(&i))))
            .collect();
        Ok(Self::merged(judged))
    }

    /// Judges a table at a state, with mutants where `proves`; `explain` adds what may explain it where it is wrong.
    pub(super) fn see(
        &mut self,
        mut table: ResultTable,
        (state, proves): (&str, bool),
        explain: impl FnOnce(&mut ResultTable),
    ) {
        table.entries.iter_mut().for_each(|entry| entry.scale *= OF_OTHERS);
        let mut check = table.check(proves, state, None);
        if matches!(check.verdict, Verdict::Wrong | Verdict::Invalid) {
            explain(&mut table);
            self.wrong.push(table);
        }
        // It is told when every state was seen.
        check.diagnosis = None;
        self.checks.push(check);
    }

    /// An entry that must be there and is not, or the other way round.
    pub(super) fn misplaced(&mut self, quantity: Quantity, entry: String, state: &str) {
        let worst = Some(Finding::new(entry, [f64::NAN; 2], 0.0, f64::INFINITY));
        let mut check = Check::new(Some(quantity), Against::Oracle(Oracle::WideDifferences));
        let judgement = Judgement { verdict: Verdict::Wrong, worst, compared: 1 };
        check.add_at(judgement, Score::default(), state, None);
        self.checks.push(check);
    }

    /// All states together.
    pub(super) fn merged(all: impl IntoIterator<Item = Self>) -> Self {
        let mut found = Self::default();
        for Self { checks, wrong } in all {
            checks_of(&mut found.checks, checks);
            found.wrong.extend(wrong);
        }
        for check in &mut found.checks {
            let quantity = check.quantity;
            diagnosed(check, found.wrong.iter().filter(|table| Some(table.quantity) == quantity));
        }
        found
    }

    /// The report of a routine at so many states. The verdict on its formula is that of the first of these quantities that was judged.
    pub(super) fn report(
        self,
        name: &str,
        (settings, states): (&Settings, usize),
        certificate: Option<Certificate>,
        offers: &[Quantity],
        formulas: &[Quantity],
    ) -> Report {
        let expected = Expected::numbers(offers);
        let mut subject = Subject::new(name.to_string(), certificate, states as u64, self.checks, &expected);
        let of = |quantity: &Quantity| subject.checks.iter().find(|check| check.quantity == Some(*quantity));
        let formula = formulas.iter().find_map(of);
        // Of one that offers none of these the formula is that of what it offers.
        let offered = || subject.checks.iter().map(|check| check.verdict).max();
        subject.formula = formula.map(|check| check.verdict).or_else(offered).unwrap_or(Verdict::Undecided);
        Report {
            version: pintle_kinematics::VERSION,
            settings: settings.clone(),
            constant: crate::C * OF_OTHERS,
            subjects: vec![subject],
            sampled: Vec::new(),
            atlas: Vec::new(),
            models: Vec::new(),
        }
    }
}

/// Says why tables of a check are wrong, one at a state: a cause holds over several.
pub(super) fn diagnosed<'a>(check: &mut Check, wrong: impl Iterator<Item = &'a ResultTable>) {
    /// It is right elsewhere where it passes at so large a part of its states.
    const MANY: u64 = 4;
    let tables: Vec<&ResultTable> = wrong.collect();
    let kept: Vec<&ResultTable> = spread(tables.len(), KEPT).into_iter().map(|place| tables[place]).collect();
    if kept.is_empty() {
        return;
    }
    let passed = check.states.get(&Verdict::Pass).copied().unwrap_or_default();
    let elsewhere = MANY * passed >= check.states.values().sum();
    check.diagnosis = diagnose_tables(&kept, elsewhere).map(Box::new);
}
