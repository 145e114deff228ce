//! The collision report of a clip: which objects touch, and when.

use std::collections::{BTreeMap, HashMap};
#[cfg(feature = "reports")]
use std::io;

use serde::Serialize;
use thiserror::Error;

/// Collects the contacts of an animation tick by tick, and tells the animator which objects collide
/// and when, so that nobody has to go through the clip frame by frame (Swan, *Fast Collision
/// Detection with an N-Objects Octree*, 1994, section 1.1).
///
/// Memory grows with the number of contacts, not with how long they last.
///
/// ```
/// use bevy_octree::scene::CollisionReport;
///
/// let mut report = CollisionReport::default();
/// report.record(0, [("arm", "wall")])?;
/// report.record(1, [("wall", "arm"), ("arm", "floor")])?;
/// report.record(2, [] as [(&str, &str); 0])?;
///
/// # #[cfg(feature = "reports")] {
/// let mut csv = Vec::new();
/// report.write_csv(&mut csv)?;
/// assert_eq!(
///     String::from_utf8(csv)?,
///     "a,b,first_contact,last_contact,ticks,contacts\n\
///      arm,wall,0,1,2,1\n\
///      arm,floor,1,1,1,1\n"
/// );
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Formats
///
/// With the feature `reports`, it is written to files.
///
/// Rows of pairs come in the order of their first contact, then of their names; rows of ticks in
/// the order of the ticks, then of the names. Within a pair, `a` sorts before `b`.
///
/// | | a row for each | columns or fields |
/// |---|---|---|
/// | `write_csv` | pair | `a`, `b`, `first_contact`, `last_contact` (ticks), `ticks` (how many with contact), `contacts` (how many intervals without a break) |
/// | `write_jsonl` | pair | `a`, `b`, `first_contact`, `last_contact`, `ticks`, `intervals` (of `[first, last]` tick) |
/// | `write_ticks_csv` | tick and pair | `tick`, `a`, `b` |
/// | `write_ticks_jsonl` | tick with a contact | `tick`, `contacts` (of `[a, b]`) |
///
/// CSV starts with a row of column names; both formats end each row with a line feed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionReport {
    names: Vec<String>,
    ids: HashMap<String, usize>,
    /// For each pair of names, its intervals in order, not adjoining.
    pairs: BTreeMap<(usize, usize), Vec<Interval>>,
    last_tick: Option<u64>,
}

/// The first and the last tick of a contact without a break.
pub type Interval = (u64, u64);

/// What the report says about two objects.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PairContacts<'a> {
    /// The name that sorts first.
    pub a: &'a str,
    /// The other one.
    pub b: &'a str,
    /// The first tick with contact.
    pub first_contact: u64,
    /// The last tick with contact.
    pub last_contact: u64,
    /// The number of ticks with contact.
    pub ticks: u64,
    /// The contacts between breaks, in order; never empty.
    pub intervals: &'a [Interval],
}

/// The error of a tick that is recorded, but is not later than the one recorded before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("tick {tick} is recorded after tick {previous}, expected a later one")]
pub struct TickOutOfOrder {
    /// The refused tick.
    pub tick: u64,
    /// The tick recorded before.
    pub previous: u64,
}

impl CollisionReport {
    /// Takes down all contacts of a tick, in any order, as pairs of names.
    ///
    /// Ticks with consecutive numbers continue a contact; a tick left out breaks it.
    ///
    /// # Errors
    ///
    /// [`TickOutOfOrder`] if `tick` is not later than the tick before. The report stays as it is
    /// then.
    pub fn record<A: AsRef<str>, B: AsRef<str>>(
        &mut self,
        tick: u64,
        contacts: impl IntoIterator<Item = (A, B)>,
    ) -> Result<(), TickOutOfOrder> {
        if let Some(previous) = self.last_tick.filter(|&previous| previous >= tick) {
            return Err(TickOutOfOrder { tick, previous });
        }
        self.last_tick = Some(tick);
        for (a, b) in contacts {
            let (a, b) = (a.as_ref(), b.as_ref());
            let (a, b) = if a <= b { (a, b) } else { (b, a) };
            let pair = (self.id(a), self.id(b));
            let intervals = self.pairs.entry(pair).or_default();
            match intervals.last_mut() {
                Some((_, last)) if *last == tick || *last + 1 == tick => *last = tick,
                _ => intervals.push((tick, tick)),
            }
        }
        Ok(())
    }

    /// Returns each pair that touched, in the order of first contacts, then of names.
    #[must_use]
    pub fn pairs(&self) -> Vec<PairContacts<'_>> {
        let pairs = self.pairs.iter().filter_map(|(&(a, b), intervals)| {
            let (&(first_contact, _), &(_, last_contact)) = (intervals.first()?, intervals.last()?);
            Some(PairContacts {
                a: &self.names[a],
                b: &self.names[b],
                first_contact,
                last_contact,
                ticks: intervals.iter().map(|(first, last)| last - first + 1).sum(),
                intervals,
            })
        });
        let mut pairs: Vec<_> = pairs.collect();
        pairs.sort_by_key(|pair| (pair.first_contact, pair.a, pair.b));
        pairs
    }

    /// Returns each tick that had contacts, in order, with the pairs that touched, in the order of
    /// names.
    pub fn ticks(&self) -> impl Iterator<Item = (u64, Vec<(&str, &str)>)> {
        let pairs = self.pairs();
        let mut starts: Vec<_> = pairs
            .iter()
            .flat_map(|pair| {
                pair.intervals
                    .iter()
                    .map(|&(first, last)| (first, last, pair.a, pair.b))
            })
            .collect();
        starts.sort_unstable();
        let mut starts = starts.into_iter().peekable();
        let mut current: Vec<(&str, &str, u64)> = Vec::new();
        let mut previous = None;
        std::iter::from_fn(move || {
            current.retain(|&(_, _, last)| Some(last) > previous);
            let tick = match previous {
                Some(previous) if !current.is_empty() => previous + 1,
                _ => starts.peek()?.0,
            };
            while let Some((_, last, a, b)) = starts.next_if(|start| start.0 == tick) {
                current.push((a, b, last));
            }
            current.sort_unstable();
            previous = Some(tick);
            Some((tick, current.iter().map(|&(a, b, _)| (a, b)).collect()))
        })
    }

    /// The number under which a name is kept.
    fn id(&mut self, name: &str) -> usize {
        if let Some(&id) = self.ids.get(name) {
            return id;
        }
        let id = self.names.len();
        self.names.push(name.to_owned());
        self.ids.insert(name.to_owned(), id);
        id
    }
}

/// Reports that are written, with the feature `reports`.
#[cfg(feature = "reports")]
impl CollisionReport {
    /// Writes a row for each pair, as CSV.
    ///
    /// # Errors
    ///
    /// Those of the writer.
    pub fn write_csv(&self, writer: impl io::Write) -> io::Result<()> {
        let mut csv = csv::Writer::from_writer(writer);
        csv.write_record([
            "a",
            "b",
            "first_contact",
            "last_contact",
            "ticks",
            "contacts",
        ])?;
        for pair in self.pairs() {
            let (first, last) = (pair.first_contact, pair.last_contact);
            csv.serialize((
                pair.a,
                pair.b,
                first,
                last,
                pair.ticks,
                pair.intervals.len(),
            ))?;
        }
        csv.flush()
    }

    /// Writes a row for each tick and pair, as CSV.
    ///
    /// # Errors
    ///
    /// Those of the writer.
    pub fn write_ticks_csv(&self, writer: impl io::Write) -> io::Result<()> {
        let mut csv = csv::Writer::from_writer(writer);
        csv.write_record(["tick", "a", "b"])?;
        for (tick, contacts) in self.ticks() {
            for (a, b) in contacts {
                csv.serialize((tick, a, b))?;
            }
        }
        csv.flush()
    }

    /// Writes an object for each pair, as JSON lines.
    ///
    /// # Errors
    ///
    /// Those of the writer.
    pub fn write_jsonl(&self, mut writer: impl io::Write) -> io::Result<()> {
        for pair in self.pairs() {
            write_line(&mut writer, &pair)?;
        }
        writer.flush()
    }

    /// Writes an object for each tick with contacts, as JSON lines.
    ///
    /// # Errors
    ///
    /// Those of the writer.
    pub fn write_ticks_jsonl(&self, mut writer: impl io::Write) -> io::Result<()> {
        #[derive(Serialize)]
        struct Tick<'a> {
            tick: u64,
            contacts: Vec<(&'a str, &'a str)>,
        }
        for (tick, contacts) in self.ticks() {
            write_line(&mut writer, &Tick { tick, contacts })?;
        }
        writer.flush()
    }
}

#[cfg(feature = "reports")]
fn write_line(writer: &mut impl io::Write, row: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *writer, row)?;
    writer.write_all(b"\n")
}

#[cfg(all(test, feature = "reports"))]
mod tests;
