//! For how long planes let two convex shapes touch of which one moves along a line.

/// A share of a way, from the moment at which the last plane between two shapes lets them touch, to
/// that at which the first one parts them again: they touch in between, if all planes that may part
/// them were asked, and never otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Window<A> {
    /// Nearer to each other than this along a normal, two count as touching.
    slack: f64,
    enter: f64,
    leave: f64,
    /// When they touch along the normal that lets them do so last, and which one that is.
    last: Option<(f64, A)>,
}

impl<A: Copy> Window<A> {
    /// The whole way up to a limit.
    pub fn new(limit: f64, slack: f64) -> Self {
        Self {
            slack,
            enter: f64::NEG_INFINITY,
            leave: limit,
            last: None,
        }
    }

    /// Asks a plane between the two: how far they are from each other along its normal, and how fast
    /// they come nearer to each other.
    pub fn ask(&mut self, gap: f64, closing: f64, axis: A) {
        if closing > 0.0 {
            let enter = (gap - self.slack) / closing;
            if enter > self.enter {
                (self.enter, self.last) = (enter, Some((gap / closing, axis)));
            }
        } else if gap > self.slack {
            self.leave = f64::NEG_INFINITY;
        } else if closing < 0.0 {
            self.leave = self.leave.min((gap - self.slack) / closing);
        }
    }

    /// Asks for the two sides of a slab, of which the first shape is so far from the middle, and as
    /// it goes, comes nearer to where it was not.
    pub fn ask_slab(&mut self, from_middle: f64, velocity: f64, reach: f64, axis: A) {
        let side = 1f64.copysign(from_middle);
        let (distance, closing) = (from_middle.abs(), velocity * side);
        self.ask(distance - reach, closing, axis);
        if closing > 0.0 {
            self.leave = self.leave.min((distance + reach + self.slack) / closing);
        }
    }

    /// May an answer of so much change anything?
    pub fn counts(&self, gap: f64, closing: f64) -> bool {
        if closing > 0.0 {
            gap - self.slack > self.enter * closing
        } else {
            gap > self.slack || gap - self.slack > self.leave * closing
        }
    }

    /// Is there a moment at which no plane that was asked parts the two?
    pub fn is_open(&self) -> bool {
        self.enter <= self.leave && self.leave >= 0.0
    }

    /// Is no plane between the two from the start?
    pub fn begins_open(&self) -> bool {
        self.enter <= 0.0 && self.is_open()
    }

    /// When the two meet, and along which normal. Those that only graze do so at any moment at which
    /// they are within the slack.
    pub fn first(&self) -> Option<(f64, A)> {
        let (time, axis) = self.last.filter(|_| self.is_open())?;
        Some((time.min(self.leave).max(0.0), axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_open_and_close_it() {
        let mut window = Window::new(10.0, 0.0);
        window.ask_slab(5.0, 1.0, 2.0, 'x');
        assert_eq!(window.first(), Some((3.0, 'x')));
        window.ask_slab(-9.0, -2.0, 1.0, 'y');
        assert_eq!(window.first(), Some((4.0, 'y')));
        // Apart for ever, and beside each other for ever.
        let mut beside = window;
        beside.ask_slab(1.0, 0.0, 1.5, 'z');
        assert_eq!(beside.first(), Some((4.0, 'y')));
        beside.ask_slab(1.0, 0.0, 0.5, 'z');
        assert_eq!(beside.first(), None);
        // It has passed by one before it comes to the other.
        window.ask_slab(0.0, 1.0, 3.5, 'z');
        assert_eq!(window.first(), None);
    }

    #[test]
    fn beyond_the_limit_nothing_is_met() {
        let mut window = Window::new(2.5, 0.0);
        window.ask_slab(5.0, 1.0, 2.0, ());
        assert!(!window.is_open());
    }

    #[test]
    fn what_does_not_count_changes_nothing() {
        let mut window = Window::new(10.0, 1e-3);
        window.ask_slab(5.0, 1.0, 2.0, ());
        for (gap, closing) in [
            (2.0, 1.0),
            (4.0, 1.0),
            (1.0, -1.0),
            (-1.0, -1.0),
            (-9.0, -1.0),
            (1.0, 0.0),
        ] {
            let mut asked = window;
            asked.ask(gap, closing, ());
            let same = (asked.enter, asked.leave) == (window.enter, window.leave);
            assert_eq!(same, !window.counts(gap, closing), "{gap} {closing}");
        }
    }
}
