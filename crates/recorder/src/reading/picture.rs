//! Pictures of W and L back to numbers. Both are symmetric; a picture may hold the upper triangle alone.

use rerun::external::image;
use rerun::{EncodedDepthImage, Loggable as _, components};

use super::rows::Cell;
use super::value::{Array, Numbers};
use crate::matrices::value_of_level;

/// The numbers that a PNG picture stands for, by the range of levels that stands beside it.
pub(super) fn numbers(cell: &Cell, beside: &[Cell]) -> Result<Array, String> {
    let blobs = components::Blob::from_arrow(&cell.values).map_err(|e| e.to_string())?;
    let blob = blobs.first().ok_or("no picture")?;
    let picture = image::load_from_memory(&blob.0.0).map_err(|e| e.to_string())?.to_luma8();
    let brightest = brightest_level(beside).ok_or("a picture without a range of levels")?;
    let values: Vec<f64> = (0..=u8::MAX).map(|level| value_of_level(level, brightest)).collect();
    let mirrored = |x: u32, y: u32| picture.get_pixel_checked(y, x).map_or(0, |level| level.0[0]);
    let level = |(x, y, level): (u32, u32, &image::Luma<u8>)| level.0[0].max(mirrored(x, y));
    let numbers = picture.enumerate_pixels().map(|pixel| values[usize::from(level(pixel))]).collect();
    Ok(Array {
        shape: vec![picture.height() as usize, picture.width() as usize],
        dims: vec!["row".to_owned(), "column".to_owned()],
        numbers: Numbers::F64(numbers),
    })
}

/// The level that stands for 1: the viewer is told the range of a grey PNG as 0 to 1.
fn brightest_level(beside: &[Cell]) -> Option<f64> {
    let name = EncodedDepthImage::descriptor_depth_range().component;
    let range = beside.iter().find(|cell| cell.component == name.as_str())?;
    let ranges = components::ValueRange::from_arrow(&range.values).ok()?;
    Some(ranges.first()?.0.0[1] * 255.0)
}
