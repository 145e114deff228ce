//! Answers of many queries at once.

use crate::parallel;

/// So many queries are answered by one job.
const QUERIES_PER_JOB: usize = 64;

/// What several queries found, each any number of hits, in one list.
///
/// ```
/// use bevy::math::{Vec3, bounding::Aabb3d};
/// use bevy_octree::broad_phase::{HitLists, SpatialIndex};
///
/// let mut index = SpatialIndex::default();
/// for x in [0.0, 2.0, 9.0] {
///     index.insert(Aabb3d::new(Vec3::X * x, Vec3::splat(0.5)))?;
/// }
/// index.update();
///
/// let mut nearest = HitLists::default();
/// index.k_nearest_of_each(&[Vec3::X, Vec3::X * 6.0], 2, 3.0, &mut nearest);
/// assert_eq!(nearest.len(), 2);
/// assert_eq!(nearest[0].iter().map(|hit| hit.distance).collect::<Vec<_>>(), [0.5, 0.5]);
/// assert_eq!(nearest[1].iter().map(|hit| hit.distance).collect::<Vec<_>>(), [2.5]);
/// # Ok::<(), bevy_octree::broad_phase::BoxError>(())
/// ```
#[derive(Clone, Debug)]
pub struct HitLists<T> {
    hits: Vec<T>,
    /// By query: where its hits end.
    ends: Vec<usize>,
    /// Lists of single jobs, kept for the next time.
    jobs: Vec<Self>,
}

impl<T> Default for HitLists<T> {
    fn default() -> Self {
        Self {
            hits: Vec::new(),
            ends: Vec::new(),
            jobs: Vec::new(),
        }
    }
}

/// As many lists with as much in each.
impl<T: PartialEq> PartialEq for HitLists<T> {
    fn eq(&self, other: &Self) -> bool {
        self.hits == other.hits && self.ends == other.ends
    }
}

impl<T> HitLists<T> {
    /// Returns the number of queries.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns `true` if nothing was asked.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Returns what a query found, by its number; `None` if there was no such query.
    #[must_use]
    pub fn get(&self, query: usize) -> Option<&[T]> {
        let end = *self.ends.get(query)?;
        let start = query.checked_sub(1).map_or(0, |before| self.ends[before]);
        Some(&self.hits[start..end])
    }

    /// Returns what each query found, in the order of the queries.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> {
        (0..self.len()).map(|query| &self[query])
    }

    /// Returns what all queries found, in the order of the queries.
    #[must_use]
    pub fn hits(&self) -> &[T] {
        &self.hits
    }

    /// Empties the lists, and keeps their memory.
    pub fn clear(&mut self) {
        self.hits.clear();
        self.ends.clear();
    }
}

impl<T: Copy + Send> HitLists<T> {
    /// Answers queries, side by side on all threads, each by what `answer` appends to a list. The
    /// answers replace what was there.
    pub(crate) fn fill<Q: Sync>(&mut self, queries: &[Q], answer: impl Fn(&Q, &mut Vec<T>) + Sync) {
        self.clear();
        let chunks = queries.chunks(QUERIES_PER_JOB);
        if !parallel::is_on() || chunks.len() <= 1 {
            return self.append(queries, &answer);
        }
        let mut jobs = std::mem::take(&mut self.jobs);
        jobs.resize_with(jobs.len().max(chunks.len()), Self::default);
        let jobs_now = &mut jobs[..chunks.len()];
        parallel::for_each(chunks.zip(&mut *jobs_now), |(queries, job)| {
            job.clear();
            job.append(queries, &answer);
        });
        for job in jobs_now {
            let before = self.hits.len();
            self.hits.extend_from_slice(&job.hits);
            self.ends.extend(job.ends.iter().map(|end| before + end));
        }
        self.jobs = jobs;
    }

    fn append<Q>(&mut self, queries: &[Q], answer: &impl Fn(&Q, &mut Vec<T>)) {
        for query in queries {
            answer(query, &mut self.hits);
            self.ends.push(self.hits.len());
        }
    }
}

impl<T> std::ops::Index<usize> for HitLists<T> {
    type Output = [T];

    /// Returns what a query found, by its number.
    ///
    /// # Panics
    /// If there was no such query.
    fn index(&self, query: usize) -> &[T] {
        self.get(query)
            .expect("a query of that number was answered")
    }
}

/// Answers queries, side by side on all threads, in their order. The answers replace what is in
/// `answers`.
pub(crate) fn answer_each<Q: Sync, T: Clone + Default + Send>(
    queries: &[Q],
    answers: &mut Vec<T>,
    answer: impl Fn(&Q) -> T + Sync,
) {
    answers.clear();
    answers.resize(queries.len(), T::default());
    parallel::for_each(
        queries
            .chunks(QUERIES_PER_JOB)
            .zip(answers.chunks_mut(QUERIES_PER_JOB)),
        |(queries, answers)| {
            for (query, slot) in queries.iter().zip(answers) {
                *slot = answer(query);
            }
        },
    );
}
