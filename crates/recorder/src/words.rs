//! Words in a view.

use rerun::{Points2D, Radius};

use crate::colors::{WORDS, color};

/// Each of these words below its place, without a point.
pub(crate) fn words<T: Into<rerun::components::Text>>(words: impl IntoIterator<Item = ([f32; 2], T)>) -> Points2D {
    let (at, words): (Vec<_>, Vec<_>) = words.into_iter().unzip();
    look(Points2D::new(at).with_labels(words))
}

/// The look of words that are placed later.
pub(crate) fn look(words: Points2D) -> Points2D {
    words.with_radii([Radius::new_ui_points(0.0)]).with_colors([color(WORDS)]).with_show_labels(true)
}
