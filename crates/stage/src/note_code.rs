//! Notes explained: each kind of note has a short code that stays, what was seen, what was done, and what the user can do.
//!
//! The codes are declared here alone. `crosscut info --note CODE` prints an entry, and docs/notes.md has all of them.

/// The explanation of one kind of note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoteCode {
    /// The code, such as `N012`. It never changes its meaning.
    pub code: &'static str,
    /// What every note of this kind contains, in this order.
    pub contains: &'static [&'static str],
    /// What was seen.
    pub seen: &'static str,
    /// What was done about it.
    pub done: &'static str,
    /// What the user can do.
    pub remedy: &'static str,
}

macro_rules! note_codes {
    ($($code:literal [$($part:literal),+] seen $seen:literal done $done:literal remedy $remedy:literal;)*) => {
        /// Every kind of note, by its code.
        pub const NOTE_CODES: &[NoteCode] = &[$(
            NoteCode { code: $code, contains: &[$($part),+], seen: $seen, done: $done, remedy: $remedy },
        )*];
    };
}

note_codes! {
    // Beams and ranges of a scan.
    "N001" ["in masked sectors left out"]
        seen "Beams or points lie in a sector that `ingest.masked_sectors_rad` masks."
        done "They are left out, and nothing is known in their directions."
        remedy "Nothing, if the mask is right.";
    "N002" ["of range 0 read as no return"]
        seen "Beams have range 0, which many drivers write for no return."
        done "They count as free up to the largest range."
        remedy "Nothing. If 0 means too near for your sensor, mask those beams.";
    "N003" ["of negative range read as no return"]
        seen "Beams have a negative range, which no sensor measures."
        done "They count as no return."
        remedy "Ask what the driver means by it.";
    "N004" ["of range -inf"]
        seen "Beams have range -inf: something is too near to be measured (REP 117)."
        done "They are left out, and nothing is known in their directions."
        remedy "Mask the parts of the vehicle that the lidar sees: `ingest.masked_sectors_rad`.";
    "N005" ["at or beyond range_max"]
        seen "Beams have the largest range that the message states, or more."
        done "They count as no return."
        remedy "Nothing.";
    "N006" ["of exactly", "the largest range, read as no return"]
        seen "Several beams have exactly the largest range of the scan, which is how the driver writes no return."
        done "They count as no return."
        remedy "Nothing.";
    "N007" ["below range_min"]
        seen "Beams are nearer than the `range_min` of the message."
        done "They are left out, and nothing is known in their directions."
        remedy "If these are real walls, correct `range_min` in the driver; if it is the vehicle, mask the sector.";
    "N008" ["nearer than min_range_m"]
        seen "Beams or points are nearer than `ingest.min_range_m`."
        done "They are left out."
        remedy "Nothing, if the setting is right.";
    "N009" ["farther than", "ranges are read in metres"]
        seen "Most returns are farther than a lidar sees: the ranges may be millimetres."
        done "They are used as metres."
        remedy "Set the unit, `--set ingest.range_scale=0.001`, of a table `--set csv.unit=mm`; or have the driver write metres.";
    "N010" ["beyond max_range_m"]
        seen "Beams or points are beyond `ingest.max_range_m`."
        done "They count as no return."
        remedy "Nothing, if the setting is right.";
    "N011" ["range_min", "is no range"]
        seen "The message's `range_min` is not a number of metres."
        done "0 is used."
        remedy "Correct the driver.";
    "N012" ["range_max", "is no range"]
        seen "The message's `range_max` is not a positive number of metres."
        done "Ranges have no upper limit."
        remedy "Correct the driver, or set `ingest.max_range_m`.";
    "N013" ["range_max", "is not above range_min"]
        seen "The message's `range_max` is below its `range_min`."
        done "Both are ignored."
        remedy "Correct the driver, or set `ingest.min_range_m` and `ingest.max_range_m`.";
    "N014" ["the scan has no beams"]
        seen "The message has no ranges."
        done "The revolution has no return and no wall."
        remedy "Look at the driver if this is often so.";
    "N015" ["angle_min", "is no angle"]
        seen "The message's `angle_min` is not an angle."
        done "No beam has a bearing, so the revolution has no return."
        remedy "Correct the driver.";
    "N016" ["the last beam looks where the first one does"]
        seen "The scan covers exactly a full turn, both ends included."
        done "The last beam is left out."
        remedy "Nothing.";
    "N017" ["beyond a full turn left out"]
        seen "The scan has more beams than a full turn takes."
        done "The beams after one turn are left out."
        remedy "Correct `angle_increment` in the driver if the lidar does not turn more than once a message.";
    "N018" ["angle_max", "does not fit", "beams"]
        seen "`angle_max` contradicts `angle_min`, `angle_increment` and the number of beams."
        done "`angle_max` is ignored."
        remedy "Check in the viewer that the walls are straight; if not, correct the driver.";
    "N019" ["angle_increment", "replaced by"]
        seen "`angle_increment` cannot be used."
        done "It is computed from both ends of the scan."
        remedy "Correct the driver.";
    "N020" ["angle_increment", "are unusable"]
        seen "Neither `angle_increment` nor `angle_max` gives the beams a bearing."
        done "The revolution has no return."
        remedy "Correct the driver.";
    "N021" ["intensities for", "ranges: not used"]
        seen "There are not as many intensities as ranges."
        done "The intensities are not used."
        remedy "Nothing: counts do not need them.";
    "N022" ["short of a full turn: walls are followed across"]
        seen "The scan misses a few beams of a full turn."
        done "It counts as a full turn."
        remedy "Nothing.";
    "N023" ["never returned anything in the first scans, taken as blind"]
        seen "Some neighbouring beams returned nothing in the first scans: the vehicle probably covers them."
        done "Nothing is known in their directions, instead of free space."
        remedy "Mask them for good with the setting in the note, or turn the search off with `ingest.find_blind_sectors = false`.";
    "N024" ["a sector that was taken as blind returns something"]
        seen "A sector that seemed to be covered returns something."
        done "It is in view from here on."
        remedy "Nothing.";
    "N025" ["bearings mirrored"]
        seen "`ingest.upside_down` is set."
        done "Bearings run the other way."
        remedy "Nothing, if the sensor hangs upside down.";
    "N026" ["bearings turned by the sensor's yaw"]
        seen "`ingest.yaw_rad` is set."
        done "Bearings are turned by it."
        remedy "Nothing, if the setting is right.";
    "N027" ["turned by", "during the scan"]
        seen "The vehicle turned, or moved, while the lidar swept once."
        done "Beams are brought to where they were seen from in the middle of the scan."
        remedy "Nothing; `ingest.deskew = false` turns it off.";
    "N028" ["in degrees"]
        seen "`angle_min`, `angle_max` or `angle_increment` make a sensible scan only as degrees."
        done "They are taken as degrees."
        remedy "Correct the driver: the message asks for radians.";
    "N029" ["within noise of range_max"]
        seen "Beams without a hit have ranges that scatter about `range_max`, as some simulated lidars write no return."
        done "They count as no return."
        remedy "Nothing.";
    // Clouds.
    "N030" ["the cloud does not state rings"]
        seen "`ingest.rings` is set, but the cloud has no field `ring`."
        done "All points are used."
        remedy "Choose points by height instead, or record the rings.";
    "N031" ["at the sensor itself read as no return"]
        seen "Points lie at the sensor, which is how many drivers write no return."
        done "They count as no return."
        remedy "Nothing.";
    "N032" ["of other rings than ingest.rings left out"]
        seen "The cloud has more rings than `ingest.rings` names."
        done "Only the named rings are used."
        remedy "Nothing, if the setting is right.";
    // Stamps, messages, parts of a recording.
    "N040" ["the stamp is that of the scan before"]
        seen "Two scans have the same stamp."
        done "Both are used, in the order of the recording."
        remedy "Correct the driver: odometry and several scanners are matched by stamps.";
    "N041" ["the stamp is", "before that of the scan before"]
        seen "The stamps go back."
        done "The scan is used where the recording has it."
        remedy "Give the parts of one flight in order, and one flight at a time.";
    "N042" ["the stamp is", "after that of the scan before"]
        seen "Scans are missing: the gap is several times as long as usual."
        done "The next scan is used as it is."
        remedy "Look for lost messages (a slow disk, a lossy network) if counts are unsteady there.";
    "N043" ["frame_id", "of several sensors on a topic"]
        seen "Scans of two frames come on one topic."
        done "All are used, as one sensor's."
        remedy "Choose one with `ingest.frame_id`.";
    "N044" ["recorded", "before the scan before it"]
        seen "A scan was recorded earlier than the one before it."
        done "It is used where it stands."
        remedy "Give the parts of a flight in order.";
    "N045" ["the message cannot be decoded"]
        seen "A message does not hold what its schema states."
        done "The revolution has no return and no wall."
        remedy "Check the recording with its own tools; `crosscut info` tells how it is read.";
    "N046" ["a message of this turn cannot be decoded"]
        seen "One of the messages that make a turn cannot be read."
        done "The turn is made of the others."
        remedy "As for N045.";
    "N047" ["a revolution joined of"]
        seen "The lidar sends a turn in several messages."
        done "They are joined; `seq` counts revolutions."
        remedy "Nothing.";
    "N048" ["of messages that are missing left out"]
        seen "A turn lacks some of its messages."
        done "Nothing is known in the directions of their beams."
        remedy "Look for lost messages.";
    "N049" ["no stamp: the time of recording is used"]
        seen "The scan has no stamp."
        done "The time at which it was recorded is its stamp."
        remedy "Nothing for one scanner. Odometry and several scanners are matched by stamps: have the driver set them.";
    "N057" ["the stamp is more than a day off"]
        seen "The stamp is more than a day from where those of other scans and its time of recording put it."
        done "The time at which it was recorded is its stamp."
        remedy "Correct the clock of the driver.";
    "N058" ["implausible time of recording"]
        seen "The time of recording is far from that of most other messages."
        done "The stamp replaces it, else the time of the first scan; the note says which."
        remedy "Check the clock of the machine that recorded.";
    // Several scanners.
    "N050" ["is not joined: it has no scan within"]
        seen "Another scanner has no scan at this time."
        done "The revolution is made without it."
        remedy "Look at its rate and at the clocks of both.";
    "N051" ["is not joined: no transforms lead from"]
        seen "The recording has no transforms between two scanners."
        done "The revolution is made without the other one."
        remedy "Record /tf_static.";
    "N052" ["no scanner is joined: the pose of"]
        seen "The transform of the first scanner is not known at this time."
        done "The revolution is that of the first scanner alone."
        remedy "Record /tf from the start.";
    "N053" ["joined with"]
        seen "Several scanners see this revolution."
        done "Their returns are one revolution, in the frame that the note names."
        remedy "Nothing.";
    "N054" ["is not joined: its pose is not known"]
        seen "The transform of another scanner is not known at this time."
        done "The revolution is made without it."
        remedy "Record /tf from the start.";
    "N055" ["between those of the scanners: as far as the farther neighbour sees"]
        seen "Between the views of two scanners some directions are seen by neither."
        done "They count as free as far as the farther neighbour sees."
        remedy "Nothing.";
    "N056" ["is not joined: both scanners state the frame"]
        seen "Two scanners state the same frame, and in it they see different things."
        done "The revolution is made without the other one."
        remedy "Give each scanner a frame of its own in its driver, with its place in /tf_static.";
    // Affinity.
    "N060" ["passage:", "in the air"]
        seen "Single returns hang in the air, as of dust, rain or the edges of pillars."
        done "They are ignored: they join no walls and belong to none."
        remedy "Nothing. If they are real walls, the lidar may be too coarse for them: look at the scan with `crosscut view`.";
    "N061" ["passage:", "within the vehicle, nearer than"]
        seen "Returns lie within the outline of the vehicle."
        done "They are ignored."
        remedy "Mask the parts of the vehicle that the lidar sees, or correct `vehicle.width_m`.";
    "N062" ["processed as a cloud of"]
        seen "The sweep has more than 4096 beams: neighbouring returns are closer than a range is exact."
        done "The revolution is what a level vehicle sees of its returns, in up to 720 beams."
        remedy "Nothing.";
    "N063" ["above or below the vehicle"]
        seen "Points of the cloud lie above or below the vehicle, or within it."
        done "They are ignored, by every affinity."
        remedy "Correct `vehicle.height_m` and the mounting if walls are lost.";
    // Eigenvalues and clusters.
    "N070" ["slicing:", "by full decomposition"]
        seen "Too many eigenvalues are small for the fast solver."
        done "All eigenvalues are computed; the result is the same."
        remedy "Nothing; it takes longer.";
    "N071" ["blocks: a component of"]
        seen "A component of the graph is too hard for the fast solver."
        done "All its eigenvalues are computed; the result is the same."
        remedy "Nothing; it takes longer.";
    "N072" ["blocks: no edge set aside"]
        seen "A wall between weak edges is itself almost two."
        done "The solver does not split the graph there."
        remedy "Nothing.";
    "N073" ["no eigenvalue counts as zero"]
        seen "No eigenvalue of L lies below the tolerance."
        done "No return has a cluster, and no wall is counted."
        remedy "Raise the tolerance: `spectral.zero_tolerance`.";
    "N074" ["k-means: the best restart had not settled"]
        seen "k-means had not settled after its last iteration."
        done "The clusters so far are used."
        remedy "Raise `kmeans.max_iterations`.";
    "N075" ["k-means: only", "distinct rows of U"]
        seen "U has fewer different rows than k."
        done "There are only that many clusters."
        remedy "Nothing.";
    "N076" ["components:", "returns left out"]
        seen "Components of the graph have very few returns."
        done "They are left out and are no wall."
        remedy "Lower `kmeans.min_cluster` if they are walls.";
    "N077" ["components: some rows of U"]
        seen "Some rows of U have several entries: the components of the graph are not clear."
        done "k-means finds the clusters."
        remedy "Nothing.";
    // Report.
    "N080" ["report: no confidence"]
        seen "The affinity is one of your own, for which no confidence was calibrated."
        done "The answers have no confidence."
        remedy "Measure how often it is right: `crosscut evaluate`.";
    "N081" ["report: returns stand"]
        seen "Neighbouring returns are so far apart that a gap between walls cannot be told from a gap between returns."
        done "The confidence is lowered."
        remedy "Use a finer lidar, or drive closer.";
    "N082" ["report:", "m of a wall returned nothing"]
        seen "In a part of a wall nothing is seen: it is a doorway or a dark surface."
        done "It counts as wall, and the confidence is lowered."
        remedy "Set `vehicle.width_m` if the vehicle fits, or look at the place with `crosscut view`.";
    "N083" ["report:", "too small to be a wall"]
        seen "Clusters have fewer returns than `report.min_returns`."
        done "They count in k, but are no wall."
        remedy "Lower `report.min_returns` if they are walls.";
    // Pose.
    "N090" ["pose: the odometry is not finite"]
        seen "The odometry at this time is not a pose."
        done "It is not used."
        remedy "Correct its source.";
    "N091" ["pose: no odometry yet"]
        seen "`flight.pose` asks for odometry, and there was none so far."
        done "The revolution has no pose, and no place on the map."
        remedy "Record the odometry, or set `flight.pose = \"scan_match\"`.";
    "N092" ["pose: no odometry at this time; the pose before"]
        seen "The odometry is missing at this time."
        done "The pose before is used."
        remedy "Look for lost messages.";
    "N093" ["pose: no odometry at this time; by the scan alone"]
        seen "The odometry is missing at this time."
        done "The pose comes from matching scans alone."
        remedy "Look for lost messages.";
    "N094" ["pose:", "the map begins here"]
        seen "The walls of this scan are not those before: the vehicle is lost, as after a jump, or in an open place."
        done "The map begins anew here; what came before is not joined to it."
        remedy "Record odometry and every scan. At the start of a flight nothing is to be done.";
    "N096" ["pose:", "; a new stretch begins"]
        seen "The stamps leave a gap or jump back, and no odometry bridges it."
        done "The map begins a new stretch, which is joined to the rest once its places are recognised."
        remedy "Look for lost messages; give one flight at a time, its parts in order.";
    "N097" ["pose: the walls do not show how far along the passage"]
        seen "The walls are so smooth that a scan does not show how far the vehicle came along the passage."
        done "The pose goes on as before; lengths of this passage on the map are unknown."
        remedy "Record odometry.";
    "N098" ["pose: the odometry moved by", "the scans by"]
        seen "For metres, odometry and scans show different motions."
        done "The scans are believed, until both agree again; the note says which is the case."
        remedy "Look at the odometry: its scale, its frame, its clock.";
    "N095" ["pose: a slip or a jump"]
        seen "Over the last metres the scans show another motion than the odometry, as where wheels slip; without odometry, the scan shows a jump."
        done "The motion that the scan shows is used."
        remedy "Look at the odometry if this is often so.";
    "N099" ["no picture of W and L"]
        seen "The revolution has more returns than a picture has pixels."
        done "W and L are not drawn; the count is not affected."
        remedy "Thin the cloud for looking at it: `ingest.rings`, `ingest.max_range_m`.";
    "N100" ["injected"]
        seen "The prompt of `crosscut debug` put W, U or the labels into the scan."
        done "The stages after it worked on them."
        remedy "Nothing.";
}

impl NoteCode {
    /// The entry of this code, in capitals or not.
    pub fn of_code(code: &str) -> Option<&'static Self> {
        NOTE_CODES.iter().find(|entry| entry.code.eq_ignore_ascii_case(code))
    }

    /// The entry of the kind that `note` is of: the first whose parts it contains in order.
    pub fn of_note(note: &str) -> Option<&'static Self> {
        NOTE_CODES.iter().find(|entry| entry.is_of(note))
    }

    fn is_of(&self, note: &str) -> bool {
        let mut rest = note;
        self.contains.iter().all(|part| match rest.split_once(part) {
            Some((_, after)) => {
                rest = after;
                true
            }
            None => false,
        })
    }

    /// The entry as Markdown, under a heading.
    pub fn to_markdown(&self) -> String {
        let Self { code, contains, seen, done, remedy } = self;
        let note = contains.join(" … ");
        format!("## {code}\n\n`{note}`\n\n- Seen: {seen}\n- Done: {done}\n- To do: {remedy}\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_codes_are_the_same_and_each_finds_its_entry() {
        let codes: BTreeSet<&str> = NOTE_CODES.iter().map(|entry| entry.code).collect();
        assert_eq!(codes.len(), NOTE_CODES.len());
        for entry in NOTE_CODES {
            let note = format!("1 {} 2", entry.contains.join(" 3 "));
            assert_eq!(NoteCode::of_note(&note), Some(entry), "{note}");
            assert_eq!(NoteCode::of_code(&entry.code.to_lowercase()), Some(entry));
        }
        assert_eq!((NoteCode::of_note("all is well"), NoteCode::of_code("N000")), (None, None));
    }
}
