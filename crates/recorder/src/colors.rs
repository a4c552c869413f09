//! Colours of walls, the same in every view.
//!
//! Points and lines carry class ids; one annotation context at the root of the recording says what colour a class has.
//! The colours are those of Okabe and Ito that stand out on black as well as on white.

use rerun::components::InterpolationMode;
use rerun::{AnnotationContext, ClassDescription, Color, Rgba32, SeriesLines};

/// Okabe and Ito's colours, without black and yellow; repeated when there are more walls.
const WALLS: [u32; 6] = [0x56B4_E9FF, 0xE69F_00FF, 0x009E_73FF, 0xCC79_A7FF, 0xD55E_00FF, 0x0072_B2FF];

/// Classes that have a name and a colour of their own. Rerun gives the classes beyond them a colour.
const NAMED_CLASSES: u16 = 256;

/// The class of returns that belong to no wall.
pub(crate) const NO_WALL: u16 = u16::MAX;

/// Returns of no wall, and what is only there to measure by.
pub(crate) const GREY: u32 = 0x8C8C_8CFF;
/// Openings, in no wall's colour.
pub(crate) const OPENING: u32 = 0xE830_8CFF;
/// The tolerance.
pub(crate) const TOLERANCE: u32 = 0xE830_8CFF;
/// What the numbers say before clean-up: k, the zeros.
pub(crate) const ZEROS: u32 = 0x56B4_E9FF;
/// What is reported.
pub(crate) const REPORTED: u32 = 0xE69F_00FF;
/// One per step, in the order of the steps.
pub(crate) const STEPS: [u32; 5] = [GREY, 0x56B4_E9FF, 0xE69F_00FF, 0x009E_73FF, 0xCC79_A7FF];

/// A colour given as 0xRRGGBBAA.
pub(crate) fn color(rgba: u32) -> Color {
    Color::from_u32(rgba)
}

/// A line over revolutions: what holds at one of them holds until the next.
pub(crate) fn series(name: &str, rgba: u32, width: f32) -> SeriesLines {
    SeriesLines::new()
        .with_names([name])
        .with_colors([color(rgba)])
        .with_widths([width])
        .with_interpolation_mode(InterpolationMode::StepAfter)
}

/// The class of a wall or cluster: its number.
pub(crate) fn class_of(wall: Option<u32>) -> u16 {
    wall.map_or(NO_WALL, |id| u16::try_from(id).unwrap_or(NO_WALL - 1).min(NO_WALL - 1))
}

/// Name and colour of each class.
pub(crate) fn annotation_context() -> AnnotationContext {
    let wall = |id: u16| class(id, &format!("wall {id}"), WALLS[usize::from(id) % WALLS.len()]);
    AnnotationContext::new((0..NAMED_CLASSES).map(wall).chain([class(NO_WALL, "no wall", GREY)]))
}

fn class(id: u16, label: &str, rgba: u32) -> ClassDescription {
    (id, label, Rgba32::from_u32(rgba)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_wall_number_is_taken_for_no_wall() {
        assert_eq!(class_of(Some(0)), 0);
        assert_eq!(class_of(None), NO_WALL);
        assert_ne!(class_of(Some(u32::from(u16::MAX))), NO_WALL);
        assert_ne!(class_of(Some(u32::MAX)), NO_WALL);
    }
}
