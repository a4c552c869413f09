//! What is decided at a gap, and why.

/// What decides at a gap: why it is a way on, or why it is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    NoDirection,
    Line,
    LongLine,
    Slit,
    Straight,
    InnerCorner,
    Width,
    SeenInside,
    Face,
    SidePassage,
    InFront,
    PlainSight,
    Mouth,
    Blank,
}

impl Reason {
    /// The reason in a few words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::NoDirection => "too little is seen for a direction",
            Self::Line => "the line of the nearer wall goes on",
            Self::LongLine => "the line of the nearer wall over 3 m goes on",
            Self::Slit => "a slit",
            Self::Straight => "the wall turns too little",
            Self::InnerCorner => "an inner corner",
            Self::Width => "width for the turn",
            Self::SeenInside => "depth behind the nearer wall",
            Self::Face => "the face of a corner",
            Self::SidePassage => "the face of a side passage",
            Self::InFront => "a wall in front",
            Self::PlainSight => "width in plain sight",
            Self::Mouth => "depth behind a mouth or a door",
            Self::Blank => "nothing is seen",
        }
    }
}

/// How much room there is at a gap, by the rule that finds the most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    /// The room that there is, divided by the room that a way on needs; 0 if the gap hides nothing.
    pub(super) room_ratio: f64,
    pub(super) reason: Reason,
}

impl Decision {
    /// No room, for this reason.
    pub(super) fn no_room(reason: Reason) -> Self {
        Self { room_ratio: 0.0, reason }
    }

    pub(super) fn is_way(self) -> bool {
        self.room_ratio >= 1.0
    }

    /// The one of the two that finds more room; this one if they find as much.
    pub(super) fn or(self, reason: Reason, room_ratio: f64) -> Self {
        if room_ratio > self.room_ratio { Self { room_ratio, reason } } else { self }
    }
}
