//! Colours of walls, the same in every view.
//!
//! Points and lines carry class ids; one annotation context at the root of the recording says what colour a class has.
//! The colours are those of Okabe and Ito that stand out on black as well as on white: views have the ground of the
//! viewer's theme, dark or light.

use rerun::components::InterpolationMode;
use rerun::{AnnotationContext, ClassDescription, Color, Rgba32, SeriesLines};

/// Okabe and Ito's colours, without black and yellow; repeated when there are more walls.
const WALLS: [(&str, u32); COLORS as usize] = [
    ("blue", 0x56B4_E9FF),
    ("orange", 0xE69F_00FF),
    ("green", 0x009E_73FF),
    ("pink", 0xCC79_A7FF),
    ("red", 0xD55E_00FF),
    ("dark blue", 0x0072_B2FF),
];

/// How many walls can be told apart by their colour.
pub(crate) const COLORS: u16 = 6;

/// Classes that have a name and a colour of their own. Rerun gives the classes beyond them a colour.
const NAMED_CLASSES: u16 = 256;

/// The class of returns that belong to no wall.
pub(crate) const NO_WALL: u16 = u16::MAX;

/// Returns of no wall, and what is only there to measure by.
pub(crate) const GREY: u32 = 0x8C8C_8CFF;
/// Words in a view. The viewer puts them on 0x161616 or on 0xEFEFEF, and this contrasts nearly as much with both.
pub(crate) const WORDS: u32 = 0x7C7C_7CFF;
/// Words in a picture of a matrix, which is dark in both themes.
pub(crate) const WORDS_ON_PICTURES: u32 = 0xFFFF_FFFF;
/// Lines to measure by.
pub(crate) const GRID: u32 = 0x8080_80FF;
/// The weakest link inside a wall: Okabe and Ito's yellow.
pub(crate) const WEAKEST: u32 = 0xF0E4_42FF;
/// The strongest link between two walls.
pub(crate) const STRONGEST: u32 = 0xFFFF_FFFF;
/// Around both of them, as white and yellow are lost on white.
pub(crate) const LINK_EDGE: u32 = 0x0000_00FF;
/// Links of a sparse W: a strong one, a weak one.
pub(crate) const LINK: u32 = 0x8C8C_8C80;
pub(crate) const WEAK_LINK: u32 = 0xF0E4_4280;
/// Openings, in no wall's colour.
pub(crate) const OPENING: u32 = 0xE830_8CFF;
/// The tolerance.
pub(crate) const TOLERANCE: u32 = 0xE830_8CFF;
/// What the numbers say before clean-up: k, the zeros.
pub(crate) const ZEROS: u32 = 0x56B4_E9FF;
/// What is reported.
pub(crate) const REPORTED: u32 = 0xE69F_00FF;
/// What is there for an axis to reach it.
pub(crate) const UNSEEN: u32 = 0;
/// One per step, in the order of the steps.
pub(crate) const STEPS: [u32; 5] = [GREY, 0x56B4_E9FF, 0xE69F_00FF, 0x009E_73FF, 0xCC79_A7FF];

/// Nine colours of the map that pictures are drawn with, from 1e-16 or less to 1.
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

/// Places by name, the more ways on the warmer.
pub(crate) const PLACES: [(&str, u32); 8] = [
    ("closed", 0x4A4A_4AFF),
    ("dead_end", 0x8C8C_8CFF),
    ("corridor", 0x0072_B2FF),
    ("bend", 0x56B4_E9FF),
    ("tee", 0x009E_73FF),
    ("cross", 0xE69F_00FF),
    ("junction_5", 0xD55E_00FF),
    ("partial_view", 0xCC79_A7FF),
];

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

/// What a class is called in words.
pub(crate) fn name_of(class: u16) -> &'static str {
    if class == NO_WALL { "grey" } else { WALLS[usize::from(class % COLORS)].0 }
}

/// Name and colour of each class.
pub(crate) fn annotation_context() -> AnnotationContext {
    let wall = |id: u16| class(id, name_of(id), WALLS[usize::from(id % COLORS)].1);
    AnnotationContext::new((0..NAMED_CLASSES).map(wall).chain([class(NO_WALL, "no wall", GREY)]))
}

fn class(id: u16, label: &str, rgba: u32) -> ClassDescription {
    (id, label, Rgba32::from_u32(rgba)).into()
}
