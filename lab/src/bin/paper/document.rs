//! The page with the figures and the tables.

use crosscut_evaluate::Proportion;
use crosscut_evaluate::tables::Table;

use crosscut_lab::markdown;

use crate::figures::Figure;
use crate::tolerance::{EXPONENTS, ToleranceShares};

const OPENING: &str = "\
# The paper's evaluation, in our form

Mansouri et al. show their method on simulated scans and on flights through two mines in Sweden, by figures only. Their
data is not public. Here is the same kind of scans from the simulator, whose truth is known. `lab/make paper`
makes this page and its figures, the same bytes each time.
";

const TOLERANCE: &str = "\
## Why \"the number of zero eigenvalues\" needs a tolerance

Equation (1) connects every pair of returns, so exactly one eigenvalue is zero, and a computer finds even that one only
to within rounding. The others that should be zero are as large as the leak between two walls, about exp(-σ·width²):
1e-24 across 6 m, 1e-8 across 3.5 m, 0.1 across 1.2 m. What counts as zero has to be said, the paper does not say it, and
no single tolerance is right for all widths.

The tables count the development scenes of each family (`crosscut simulate --list`), 95 % of the time to within 4 points
of a family's true share if it has 600. Each scene is decomposed once. At a tolerance τ, k is the number of eigenvalues
below it. An answer can be right only if k is the true number of walls, and U is then the same whichever τ gave that k:
so each scene is clustered once, with the true number, and the verdict holds at every τ that gives it. That is exact, not
an approximation.
";

/// The page, as Markdown.
pub(crate) fn document(figures: &[Figure], families: &[ToleranceShares], tolerance_of_preset: f64) -> String {
    let mut text = OPENING.to_owned();
    for figure in figures {
        text += &format!("\n![{}]({})\n\n{}\n", figure.file(), figure.file(), figure.caption);
    }
    let all = sum_of(families);
    let rows: Vec<&ToleranceShares> = families.iter().chain([&all]).collect();
    let scenes = all.right[0].of;
    text += &format!("\n{TOLERANCE}\n");
    let tables = [
        table(&rows, "right counts, % of the scenes, by tolerance; best of each row in bold", |family| {
            &family.right_count
        }),
        table(&rows, "right: count and walls, % of the scenes, by tolerance; best of each row in bold", |family| {
            &family.right
        }),
    ];
    for table in &tables {
        text += &format!("**{}**\n\n{}\n", table.title, markdown(table));
    }
    let best = (0..EXPONENTS.len()).rev().max_by_key(|&at| all.right[at].hits).unwrap_or(0);
    text += &format!(
        "The best single tolerance is 1e{}: right in {} of {scenes} scenes. Preset `paper` takes {tolerance_of_preset:e}.\n",
        EXPONENTS[best], all.right[best].hits
    );
    text
}

/// The sum of all families.
fn sum_of(families: &[ToleranceShares]) -> ToleranceShares {
    let sum = |of: fn(&ToleranceShares) -> &[Proportion; EXPONENTS.len()]| {
        let mut sums = [Proportion::default(); EXPONENTS.len()];
        for family in families {
            sums.iter_mut().zip(of(family)).for_each(|(sum, share)| sum.merge(*share));
        }
        sums
    };
    ToleranceShares { name: "all", right_count: sum(|family| &family.right_count), right: sum(|family| &family.right) }
}

fn table(rows: &[&ToleranceShares], title: &str, of: fn(&ToleranceShares) -> &[Proportion; EXPONENTS.len()]) -> Table {
    let header = ["family".to_owned()].into_iter().chain(EXPONENTS.map(|exponent| format!("1e{exponent}")));
    let row = |family: &&ToleranceShares| {
        let shares = of(family);
        let best = shares.iter().map(|share| share.hits).max();
        let cell = |share: &Proportion| {
            let percent = share.value().map_or_else(|| "-".to_owned(), |share| format!("{:.0}", 100.0 * share));
            if Some(share.hits) == best { format!("**{percent}**") } else { percent }
        };
        [family.name.to_owned()].into_iter().chain(shares.iter().map(cell)).collect()
    };
    Table { title: title.to_owned(), header: header.collect(), rows: rows.iter().map(row).collect() }
}
