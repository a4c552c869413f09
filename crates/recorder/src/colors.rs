//! Colours of walls, the same in every view.
//!
//! Points and lines carry class ids; one annotation context at the root of the recording gives each class its colour.
//! The colours are those of Okabe and Ito that can be seen on black and on white, since the background of a view follows
//! the viewer's theme.

use rerun::components::InterpolationMode;
use rerun::{AnnotationContext, ClassDescription, Color, Rgba32, SeriesLines};

/// Four of Okabe and Ito's colours, four others that differ from them, and all of these darker; repeated when there are more walls.
/// Pink is for annotations alone, yellow for weak edges and doubt.
const WALLS: [(&str, u32); COLORS as usize] = [
    ("blue", 0x56B4_E9FF),
    ("orange", 0xE69F_00FF),
    ("green", 0x009E_73FF),
    ("vermilion", 0xD55E_00FF),
    ("lime", 0x9BC5_3DFF),
    ("indigo", 0x6A6C_F0FF),
    ("sand", 0xC9A2_7EFF),
    ("brown", 0x9A64_3AFF),
    ("dark blue", 0x3072_93FF),
    ("dark orange", 0x8F63_00FF),
    ("dark green", 0x0063_48FF),
    ("dark vermilion", 0x853A_00FF),
    ("dark lime", 0x5F7A_22FF),
    ("dark indigo", 0x4042_98FF),
    ("dark sand", 0x7D64_4CFF),
    ("dark brown", 0x5E3C_22FF),
];

/// Number of different colours.
pub(crate) const COLORS: u16 = 16;

/// Classes with a name. Rerun chooses colours for the classes beyond them.
const NAMED_CLASSES: u16 = 256;

/// The class of returns that belong to no wall.
pub(crate) const NO_WALL: u16 = u16::MAX;

/// Returns of no wall, and secondary lines.
pub(crate) const GREY: u32 = 0x8C8C_8CFF;
/// Text in a view. The background is 0x161616 or 0xEFEFEF; this contrasts about equally with both.
pub(crate) const WORDS: u32 = 0x7C7C_7CFF;
/// Labels, which have a dark ground of their own.
pub(crate) const LABEL: u32 = 0xC8C8_C8FF;
/// Text on the picture of a matrix, which is dark in both themes.
pub(crate) const WORDS_ON_PICTURES: u32 = 0xFFFF_FFFF;
/// Grid lines and circles to read distances by.
pub(crate) const GRID: u32 = 0x8080_80FF;
/// The gap that is nearest to another count.
pub(crate) const NAMED: u32 = 0xE830_8CFF;
/// An edge that would change k, dark enough to be seen on white.
pub(crate) const OTHER: u32 = 0xD6C7_13FF;
/// A strong edge of a sparse W.
pub(crate) const EDGE: u32 = 0x8C8C_8C80;
/// A weak edge of a sparse W.
pub(crate) const WEAK_EDGE: u32 = 0xF0E4_4280;
/// Openings; no wall has this colour.
pub(crate) const OPENING: u32 = 0xE830_8CFF;
/// The zero tolerance τ.
pub(crate) const TOLERANCE: u32 = 0xE830_8CFF;
/// The zeros among the eigenvalues, and their number k.
pub(crate) const ZEROS: u32 = 0x56B4_E9FF;
/// The reported number of walls.
pub(crate) const REPORTED: u32 = 0xE69F_00FF;
/// The true number of walls.
pub(crate) const TRUTH: u32 = 0x009E_73FF;
/// The vehicle on the map; no wall has this colour.
pub(crate) const VEHICLE: u32 = 0x8F6B_E8FF;
/// Invisible points, which only widen the axis of a plot.
pub(crate) const INVISIBLE: u32 = 0;
/// A colour for each step, in their order.
pub(crate) const STEPS: [u32; 5] = [GREY, 0x56B4_E9FF, 0xE69F_00FF, 0x009E_73FF, 0xD55E_00FF];

/// Nine colours of the colour map of pictures, from 1e-16 or less to 1.
pub(crate) const VIRIDIS: [u32; 9] = [
    0x4401_54FF,
    0x472D_7BFF,
    0x3B52_8BFF,
    0x2C72_8EFF,
    0x2191_8CFF,
    0x28AE_80FF,
    0x5EC9_62FF,
    0xADDC_30FF,
    0xFDE7_25FF,
];

/// Names and colours of places: the more openings, the warmer.
pub(crate) const PLACES: [(&str, u32); 8] = [
    ("closed", 0x4A4A_4AFF),
    ("dead_end", 0x8C8C_8CFF),
    ("corridor", 0x0072_B2FF),
    ("bend", 0x56B4_E9FF),
    ("tee", 0x009E_73FF),
    ("cross", 0xE69F_00FF),
    ("junction_5", 0xD55E_00FF),
    ("partial_view", 0x8F6B_E8FF),
];

/// What is unsure, or judged and not seen.
pub(crate) const UNSURE: u32 = 0xD6C7_13FF;
/// Colours of both `wrong` and `unsure`, of either, and of neither.
pub(crate) const DOUBTS: [u32; 4] = [0xE07B_1FFF, 0xD32F_2FFF, UNSURE, 0x4A4A_4AFF];

/// A colour given as 0xRRGGBBAA.
pub(crate) fn color(rgba: u32) -> Color {
    Color::from_u32(rgba)
}

/// The look of a line over revolutions. It is drawn in steps: a value holds until the next revolution.
pub(crate) fn series(name: &str, rgba: u32, width: f32) -> SeriesLines {
    SeriesLines::new()
        .with_names([name])
        .with_colors([color(rgba)])
        .with_widths([width])
        .with_interpolation_mode(InterpolationMode::StepAfter)
}

/// The name of the colour of a class.
pub(crate) fn name_of(class: u16) -> &'static str {
    if class == NO_WALL { "grey" } else { WALLS[usize::from(class % COLORS)].0 }
}

/// Each class with the name and colour of another one, which follows it.
pub(crate) fn as_others(classes: &[[u16; 2]]) -> AnnotationContext {
    let wall = |[id, other]: &[u16; 2]| class(*id, name_of(*other), WALLS[usize::from(other % COLORS)].1);
    AnnotationContext::new(classes.iter().map(wall).chain([class(NO_WALL, "no wall", GREY)]))
}

/// Name and colour of each class.
pub(crate) fn annotation_context() -> AnnotationContext {
    as_others(&(0..NAMED_CLASSES).map(|class| [class; 2]).collect::<Vec<_>>())
}

fn class(id: u16, label: &str, rgba: u32) -> ClassDescription {
    (id, label, Rgba32::from_u32(rgba)).into()
}
