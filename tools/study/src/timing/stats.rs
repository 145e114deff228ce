//! The statistics: medians, a paired test, and a straight line.
//!
//! Running times have long tails, since other work of the machine makes some runs slower and none
//! faster. All but the line is therefore a matter of order and rank, and assumes no distribution.

use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, StudentsT};

/// How sure all intervals are.
const CONFIDENCE: f64 = 0.95;

/// What is left out at either end.
const TAIL: f64 = (1.0 - CONFIDENCE) / 2.0;

/// A value and its interval of 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub low: f64,
    pub mid: f64,
    pub high: f64,
}

impl Estimate {
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            low: f(self.low),
            mid: f(self.mid),
            high: f(self.high),
        }
    }
}

/// The median. Its interval is made of order statistics; of fewer than 6 samples, which cannot give
/// 95 %, it is the range.
pub fn median(samples: &[f64]) -> Estimate {
    let sorted = sorted(samples.to_vec());
    let trials = Binomial::new(0.5, sorted.len() as u64).expect("one half is a probability");
    let cut = (0..sorted.len())
        .take_while(|&cut| trials.cdf(cut as u64) <= TAIL)
        .last()
        .unwrap_or(0);
    middle(&sorted, cut)
}

/// The outcome of a [`signed_rank`] test.
#[derive(Clone, Copy, Debug)]
pub struct SignedRank {
    /// How probable so uneven a sum of ranks would be if neither side were favoured: two-sided,
    /// exact.
    pub p: f64,
    /// The Hodges–Lehmann estimate of the typical difference.
    pub shift: Estimate,
}

/// Wilcoxon's signed-rank test on paired differences, and the estimate that belongs to it.
pub fn signed_rank(differences: &[f64]) -> SignedRank {
    let mut by_size: Vec<f64> = differences
        .iter()
        .copied()
        .filter(|difference| *difference != 0.0)
        .collect();
    by_size.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let mut ranks = Vec::with_capacity(by_size.len());
    for tied in by_size.chunk_by(|a, b| a.abs() == b.abs()) {
        // Twice the mean of the ranks that they share, which is whole.
        let rank = 2 * ranks.len() + tied.len() + 1;
        ranks.extend(tied.iter().map(|_| rank));
    }
    let positive: usize = ranks
        .iter()
        .zip(&by_size)
        .filter(|(_, difference)| **difference > 0.0)
        .map(|(r, _)| r)
        .sum();
    let chances = rank_sums(&ranks);
    let below: f64 = chances[..=positive].iter().sum();
    let above: f64 = chances[positive..].iter().sum();

    let walsh = differences.iter().enumerate();
    let walsh = walsh.flat_map(|(i, a)| differences[i..].iter().map(move |b| (a + b) / 2.0));
    let walsh = sorted(walsh.collect());
    let untied: Vec<usize> = (1..=differences.len()).map(|rank| 2 * rank).collect();
    let cut = rank_sums(&untied)
        .into_iter()
        .step_by(2)
        .scan(0.0, |sum, chance| {
            *sum += chance;
            (*sum <= TAIL).then_some(())
        });
    SignedRank {
        p: (2.0 * below.min(above)).min(1.0),
        shift: middle(&walsh, cut.count().saturating_sub(1)),
    }
}

/// The probability of each sum of those ranks that are drawn, when each is drawn or not with equal
/// chance.
fn rank_sums(ranks: &[usize]) -> Vec<f64> {
    let mut chances = vec![0.0; ranks.iter().sum::<usize>() + 1];
    chances[0] = 1.0;
    for &rank in ranks {
        for sum in (0..chances.len()).rev() {
            let drawn = if sum >= rank {
                chances[sum - rank]
            } else {
                0.0
            };
            chances[sum] = (chances[sum] + drawn) / 2.0;
        }
    }
    chances
}

/// Holm's correction: what each of many p values is worth, given that there are many.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut corrected = vec![0.0; p.len()];
    let mut least: f64 = 0.0;
    for (place, &index) in order.iter().enumerate() {
        least = least.max(p[index] * (p.len() - place) as f64).min(1.0);
        corrected[index] = least;
    }
    corrected
}

/// A straight line.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub slope: Estimate,
    pub intercept: f64,
}

/// The line of least squares, with the interval that Student's distribution gives its slope. `None`
/// for fewer than three points.
pub fn fit_line(points: &[(f64, f64)]) -> Option<Line> {
    let freedom = points.len().checked_sub(2).filter(|freedom| *freedom > 0)? as f64;
    let mean =
        |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let variance = mean(&|p| (p.0 - x).powi(2));
    let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / variance;
    let intercept = y - slope * x;
    let residual = mean(&|p| (p.1 - intercept - slope * p.0).powi(2));
    let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
    let reach = student.inverse_cdf(1.0 - TAIL) * (residual / variance / freedom).sqrt();
    Some(Line {
        slope: Estimate {
            low: slope - reach,
            mid: slope,
            high: slope + reach,
        },
        intercept,
    })
}

/// The mean, with the interval that Student's distribution gives it. `None` for fewer than two
/// samples, or if they are not all finite.
pub fn mean(samples: &[f64]) -> Option<Estimate> {
    let freedom = samples
        .len()
        .checked_sub(1)
        .filter(|freedom| *freedom > 0)? as f64;
    let count = samples.len() as f64;
    let mid = samples.iter().sum::<f64>() / count;
    let variance = samples.iter().map(|x| (x - mid).powi(2)).sum::<f64>() / freedom;
    let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
    let reach = student.inverse_cdf(1.0 - TAIL) * (variance / count).sqrt();
    mid.is_finite().then_some(Estimate {
        low: mid - reach,
        mid,
        high: mid + reach,
    })
}

/// The value below which a share of the samples lies.
pub fn quantile(samples: &[f64], share: f64) -> f64 {
    let sorted = sorted(samples.to_vec());
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

/// The median, and the values `cut` places from either end.
fn middle(sorted: &[f64], cut: usize) -> Estimate {
    let last = sorted.len() - 1;
    Estimate {
        low: sorted[cut],
        mid: (sorted[last / 2] + sorted[last.div_ceil(2)]) / 2.0,
        high: sorted[last - cut],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-4
    }

    #[test]
    fn medians_have_the_textbooks_intervals() {
        let samples: Vec<f64> = (1..=15).map(f64::from).collect();
        assert_eq!(
            median(&samples),
            Estimate {
                low: 4.0,
                mid: 8.0,
                high: 12.0
            }
        );
        assert_eq!(
            median(&samples[..6]),
            Estimate {
                low: 1.0,
                mid: 3.5,
                high: 6.0
            }
        );
        assert_eq!(
            median(&[7.0]),
            Estimate {
                low: 7.0,
                mid: 7.0,
                high: 7.0
            }
        );
    }

    #[test]
    fn signed_ranks_agree_with_tables() {
        // All 6 positive: 2 of the 64 assignments of signs are as uneven.
        let all_slower = signed_rank(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert!(near(all_slower.p, 0.03125));
        assert_eq!(
            (
                all_slower.shift.low,
                all_slower.shift.mid,
                all_slower.shift.high
            ),
            (1.0, 3.5, 6.0)
        );
        // The critical value of the two-sided test at 5 % for n = 10 is 8.
        let signs = |negative: &[usize]| -> Vec<f64> {
            (1..=10)
                .map(|rank| {
                    if negative.contains(&rank) {
                        -(rank as f64)
                    } else {
                        rank as f64
                    }
                })
                .collect()
        };
        assert!(signed_rank(&signs(&[8])).p < 0.05);
        assert!(signed_rank(&signs(&[9])).p > 0.05);
        assert!(near(signed_rank(&[1.0, -1.0, 2.0, -2.0]).p, 1.0));
        assert!(near(signed_rank(&[0.0, 0.0]).p, 1.0));
    }

    #[test]
    fn holms_correction_steps_down() {
        let corrected = holm(&[0.04, 0.01, 0.03, 0.5]);
        for (got, expected) in corrected.into_iter().zip([0.09, 0.04, 0.09, 0.5]) {
            assert!(near(got, expected), "{got} {expected}");
        }
    }

    #[test]
    fn means_have_the_textbooks_intervals() {
        assert!(mean(&[1.0]).is_none());
        assert!(mean(&[1.0, f64::INFINITY]).is_none());
        // A standard deviation of 1, and 4.3027 standard errors either side.
        let three = mean(&[1.0, 2.0, 3.0]).unwrap();
        assert!(near(three.mid, 2.0) && near(three.high - three.mid, 4.3027 / 3f64.sqrt()));
    }

    #[test]
    fn lines_are_fitted() {
        assert!(fit_line(&[(0.0, 1.0), (1.0, 3.0)]).is_none());
        let exact = fit_line(&[(0.0, 1.0), (1.0, 3.0), (4.0, 9.0)]).unwrap();
        assert!(
            near(exact.slope.low, 2.0) && near(exact.slope.high, 2.0) && near(exact.intercept, 1.0)
        );
        // Residuals 1/6, −1/3, 1/6: a standard error of √(1/6 / 2), and 12.706 of them either side.
        let bent = fit_line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 1.0)])
            .unwrap()
            .slope;
        assert!(
            near(bent.mid, 0.5) && near(bent.high - bent.mid, 12.7062 * (1.0f64 / 12.0).sqrt())
        );
    }
}
