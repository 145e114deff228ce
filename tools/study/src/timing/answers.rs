//! The questions that the report leaves open in its section 3.3, answered with statistics.

use std::fmt::Write as _;

use bevy_octree::scene::TestSet;

use super::{
    measure::Row,
    output::significant,
    stats::{Estimate, holm, median, quantile, signed_rank},
    table::Table,
};

/// Differences are called significant below this p, corrected.
const SIGNIFICANCE: f64 = 0.05;

/// Where the right-hand side of Figure 9, which is Figure 10, begins.
pub const RIGHT_HAND_SIDE: usize = 338;

/// What the measurements say.
pub struct Answers {
    /// The best N over the right-hand side.
    pub best: Row,
    /// In Markdown.
    pub text: String,
    /// On the largest set, the octree at the best N against exhaustive search.
    pub largest: Comparison,
}

/// The time of one way to search over that of another.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    pub ratio: Estimate,
    pub p: f64,
    /// Holm's correction of `p` over the family of comparisons that it belongs to.
    pub corrected: f64,
}

impl Comparison {
    pub fn is_faster(&self) -> bool {
        self.corrected < SIGNIFICANCE && self.ratio.mid < 1.0
    }

    fn is_slower(&self) -> bool {
        self.corrected < SIGNIFICANCE && self.ratio.mid > 1.0
    }
}

/// Compares pairs of samples of the logarithm of times, as one family.
fn compare(pairs: &[(&[f64], &[f64])]) -> Vec<Comparison> {
    let tests: Vec<_> = pairs
        .iter()
        .map(|(mine, other)| {
            signed_rank(
                &mine
                    .iter()
                    .zip(*other)
                    .map(|(a, b)| a - b)
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    let corrected = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
    let comparison = |(test, corrected): (&super::stats::SignedRank, f64)| Comparison {
        ratio: test.shift.map(f64::exp),
        p: test.p,
        corrected,
    };
    tests.iter().zip(corrected).map(comparison).collect()
}

/// Answers the report's questions.
pub fn answer(table: &Table, seed: u64) -> Answers {
    let mut text = String::from(
        "# Answers to the report's open questions\n\n\
         Ratios are Hodges–Lehmann estimates over runs paired by repeat, with 95 % confidence intervals that are not \
         corrected for being many. The p values are two-sided, from Wilcoxon's exact signed-rank test; of a family of \
         comparisons, Holm's correction is given too, and decides.\n",
    );
    let best = best_n(table, &mut text);
    let largest = by_size(table, best, &mut text);
    crossover(table, best, seed, &mut text);
    Answers {
        best,
        text,
        largest,
    }
}

/// By row of those that have an N: for each repeat, the mean logarithm of the times of some sets.
fn scores(table: &Table, sets: impl Fn(usize) -> bool) -> Vec<(Row, Vec<f64>)> {
    let rows = Row::ALL.into_iter().filter(|row| *row != Row::Exhaustive);
    rows.map(|row| {
        let logs: Vec<Vec<f64>> = (0..table.sets.len())
            .filter(|set| sets(*set))
            .map(|set| table.logs(row, set))
            .collect();
        let score =
            |repeat: usize| logs.iter().map(|log| log[repeat]).sum::<f64>() / logs.len() as f64;
        (row, (0..logs[0].len()).map(score).collect())
    })
    .collect()
}

/// The row of the lowest median score, and each of the others against it. All pairs of rows are one
/// family, for the one to compare with is not known beforehand.
fn rank(scores: &[(Row, Vec<f64>)]) -> (Row, Vec<(Row, Comparison)>) {
    let middle = |scores: &Vec<f64>| median(scores).mid;
    let fastest =
        (0..scores.len()).min_by(|&a, &b| middle(&scores[a].1).total_cmp(&middle(&scores[b].1)));
    let fastest = fastest.expect("there are rows");
    let places: Vec<_> = (0..scores.len())
        .flat_map(|a| (0..a).map(move |b| (a, b)))
        .collect();
    let oriented = |&(a, b): &(usize, usize)| if a == fastest { (b, a) } else { (a, b) };
    let places: Vec<_> = places.iter().map(oriented).collect();
    let family: Vec<_> = places
        .iter()
        .map(|&(a, b)| (&scores[a].1[..], &scores[b].1[..]))
        .collect();
    let others = compare(&family)
        .into_iter()
        .zip(&places)
        .filter(|(_, (_, other))| *other == fastest);
    (
        scores[fastest].0,
        others
            .map(|(comparison, &(row, _))| (scores[row].0, comparison))
            .collect(),
    )
}

fn best_n(table: &Table, text: &mut String) -> Row {
    let objects: Vec<usize> = table.sets.iter().map(TestSet::object_count).collect();
    let scores_of_large = scores(table, |set| objects[set] >= RIGHT_HAND_SIDE);
    let (fastest, others) = rank(&scores_of_large);
    let ties: Vec<String> = others
        .iter()
        .filter(|(_, comparison)| !comparison.is_slower())
        .map(|(row, _)| row.to_string())
        .collect();
    let with = if ties.is_empty() {
        "all others are slower".into()
    } else {
        format!("a tie with {}", ties.join(", "))
    };
    _ = write!(
        text,
        "\n## Which N is best?\n\n\
         On the sets of {RIGHT_HAND_SIDE} objects and more together (geometric mean of the times): **{fastest}**, \
         {with}.\n\n\
         | against {fastest} | ratio of times | p | p, Holm | verdict |\n| --- | --- | --- | --- | --- |\n"
    );
    for (row, comparison) in &others {
        let verdict = if comparison.is_slower() {
            "slower"
        } else {
            "tie"
        };
        _ = writeln!(text, "| {row} | {} | {verdict} |", columns(comparison));
    }
    text.push_str(
        "\nSet by set:\n\n| set | objects | fastest | tied with it |\n| --- | --: | --- | --- |\n",
    );
    for (index, set) in table.sets.iter().enumerate() {
        let (fastest, others) = rank(&scores(table, |other| other == index));
        let ties = others
            .iter()
            .filter(|(_, comparison)| !comparison.is_slower());
        let ties: Vec<String> = ties.map(|(row, _)| row.to_string()).collect();
        let ties = if ties.is_empty() {
            "–".to_owned()
        } else {
            ties.join(", ")
        };
        _ = writeln!(
            text,
            "| {} | {} | {fastest} | {ties} |",
            set.name(),
            set.object_count()
        );
    }
    // Where undivided space wins, the questions that follow are still about the octree.
    let divided = scores_of_large.iter().filter(|(row, _)| row.is_divided());
    let best = divided.min_by(|a, b| median(&a.1).mid.total_cmp(&median(&b.1).mid));
    best.map_or(fastest, |(row, _)| *row)
}

fn by_size(table: &Table, best: Row, text: &mut String) -> Comparison {
    // Every N is in the family, so that choosing the best afterwards is paid for.
    let divided: Vec<Row> = Row::ALL
        .into_iter()
        .filter(|row| row.is_divided())
        .collect();
    let sets = 0..table.sets.len();
    let exhaustive: Vec<Vec<f64>> = sets
        .clone()
        .map(|set| table.logs(Row::Exhaustive, set))
        .collect();
    let octrees: Vec<_> = divided
        .iter()
        .flat_map(|row| {
            sets.clone()
                .map(move |set| (*row, set, table.logs(*row, set)))
        })
        .collect();
    let family: Vec<_> = octrees
        .iter()
        .map(|(_, set, logs)| (&logs[..], &exhaustive[*set][..]))
        .collect();
    let comparisons: Vec<_> = compare(&family)
        .into_iter()
        .zip(&octrees)
        .filter(|(_, octree)| octree.0 == best)
        .map(|(c, _)| c)
        .collect();
    _ = write!(
        text,
        "\n## Is the octree faster than exhaustive search?\n\n\
         The octree at {best} against exhaustive search without an octree. A ratio below 1 is in the octree's favour. \
         Holm's correction is over all {} comparisons of {} sets and {} values of N.\n\n\
         | set | objects | ratio of times | p | p, Holm | verdict |\n| --- | --: | --- | --- | --- | --- |\n",
        family.len(),
        table.sets.len(),
        divided.len()
    );
    for (set, comparison) in table.sets.iter().zip(&comparisons) {
        let verdict = match comparison {
            comparison if comparison.is_faster() => "the octree is faster",
            comparison if comparison.is_slower() => "exhaustive search is faster",
            _ => "no difference shown",
        };
        _ = writeln!(
            text,
            "| {} | {} | {} | {verdict} |",
            set.name(),
            set.object_count(),
            columns(comparison)
        );
    }
    *comparisons.last().expect("there are sets")
}

fn crossover(table: &Table, best: Row, seed: u64, text: &mut String) {
    const RESAMPLES: usize = 2000;
    let objects = object_counts(table);
    let ratios = log_ratios(table, best);
    let repeats = ratios[0].len();
    let crossing = |drawn: &[usize]| crossing_of(&objects, &ratios, drawn);
    let mut random = fastrand::Rng::with_seed(seed);
    let resampled: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            crossing(
                &(0..repeats)
                    .map(|_| random.usize(..repeats))
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    let name = |crossing: f64| match crossing {
        0.0 => format!("fewer than {}", objects[0]),
        f64::INFINITY => format!("more than {}", objects[objects.len() - 1]),
        crossing => format!("{crossing:.0}"),
    };
    let estimate = crossing(&(0..repeats).collect::<Vec<_>>());
    let [low, high] = [0.025, 0.975].map(|share| name(quantile(&resampled, share)));
    let sides = objects.windows(2).find(|sides| (sides[0]..=sides[1]).contains(&estimate)).map_or_else(
        || "outside of the sizes measured".to_owned(),
        |sides| {
            let [below, above] = [sides[0], sides[1]];
            format!("between the sets of {below} and {above}, by a line through the logarithms of objects and ratio")
        },
    );
    _ = write!(
        text,
        "\n## Where is the crossover?\n\n\
         The octree at {best} is faster than exhaustive search from **{} objects** on: {sides}. Of {RESAMPLES} \
         bootstrap resamples of the repeats, 95 % lie from {low} to {high}.\n",
        name(estimate)
    );
}

/// How many objects each set has.
fn object_counts(table: &Table) -> Vec<f64> {
    table
        .sets
        .iter()
        .map(|set| set.object_count() as f64)
        .collect()
}

/// By set and repeat: the logarithm of the time of a row over that of exhaustive search.
fn log_ratios(table: &Table, row: Row) -> Vec<Vec<f64>> {
    (0..table.sets.len())
        .map(|set| {
            let exhaustive = table.logs(Row::Exhaustive, set);
            table
                .logs(row, set)
                .iter()
                .zip(exhaustive)
                .map(|(octree, exhaustive)| octree - exhaustive)
                .collect()
        })
        .collect()
}

/// The crossover by the medians of some repeats.
fn crossing_of(objects: &[f64], ratios: &[Vec<f64>], repeats: &[usize]) -> f64 {
    let middle = |ratios: &Vec<f64>| {
        let drawn: Vec<f64> = repeats.iter().map(|repeat| ratios[*repeat]).collect();
        median(&drawn).mid
    };
    last_crossing(objects, &ratios.iter().map(middle).collect::<Vec<_>>())
}

/// On the largest set, the time of a row over that of exhaustive search: the typical ratio of its
/// repeats.
pub fn largest_ratio(table: &Table, row: Row) -> f64 {
    log_ratios(table, row)
        .last()
        .map_or(f64::NAN, |ratios| signed_rank(ratios).shift.mid.exp())
}

/// The number of objects from which on a row is faster than exhaustive search: 0 if it is
/// everywhere, infinity if not even at the last.
pub fn place_of_crossover(table: &Table, row: Row) -> f64 {
    let ratios = log_ratios(table, row);
    let repeats: Vec<usize> = (0..ratios.first().map_or(0, Vec::len)).collect();
    crossing_of(&object_counts(table), &ratios, &repeats)
}

/// The number of objects from which on the logarithm of the ratio stays below 0: 0 if it is
/// everywhere, infinity if not even at the last.
fn last_crossing(objects: &[f64], log_ratios: &[f64]) -> f64 {
    match log_ratios.iter().rposition(|ratio| *ratio >= 0.0) {
        None => 0.0,
        Some(last) if last + 1 == objects.len() => f64::INFINITY,
        Some(last) => {
            let share = log_ratios[last] / (log_ratios[last] - log_ratios[last + 1]);
            objects[last] * (objects[last + 1] / objects[last]).powf(share)
        }
    }
}

/// Ratio, p, and corrected p, as three columns.
fn columns(
    Comparison {
        ratio,
        p,
        corrected,
    }: &Comparison,
) -> String {
    let Estimate { low, mid, high } = *ratio;
    let ratio = format!(
        "{} ({}–{})",
        significant(mid),
        significant(low),
        significant(high)
    );
    format!(
        "{ratio} | {} | {}",
        probability(*p),
        probability(*corrected)
    )
}

/// A probability to two significant digits.
pub fn probability(p: f64) -> String {
    if p < 1e-4 {
        "< 0.0001".to_owned()
    } else {
        format!("{p:.*}", (1.0 - p.log10().floor()) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_are_interpolated() {
        let objects = [10.0, 100.0, 1000.0];
        assert_eq!(last_crossing(&objects, &[-1.0, -1.0, -1.0]), 0.0);
        assert_eq!(last_crossing(&objects, &[-1.0, -1.0, 1.0]), f64::INFINITY);
        assert!((last_crossing(&objects, &[1.0, 1.0, -1.0]) - 100.0 * 10f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn the_fastest_is_found_and_ties_are_no_losses() {
        let scores = |shift: f64| {
            (0..12)
                .map(|repeat| f64::from(repeat % 5) + shift)
                .collect::<Vec<_>>()
        };
        let mut tie = scores(0.0);
        tie.iter_mut()
            .enumerate()
            .for_each(|(repeat, score)| *score += if repeat % 2 == 0 { 0.1 } else { -0.09 });
        let (fastest, others) = rank(&[
            (Row::Big, scores(1.0)),
            (Row::Octree(5), scores(0.0)),
            (Row::Octree(10), tie),
        ]);
        assert_eq!(fastest, Row::Octree(5));
        assert_eq!(
            others.iter().map(|(row, _)| *row).collect::<Vec<_>>(),
            [Row::Big, Row::Octree(10)]
        );
        assert!(others[0].1.is_slower() && !others[1].1.is_slower());
        assert!((others[0].1.ratio.mid - 1f64.exp()).abs() < 1e-9);
    }
}
