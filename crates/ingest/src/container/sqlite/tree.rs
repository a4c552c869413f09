//! The leaf pages of a table, in the order of its rows.

use super::pages::Pages;
use super::rows::{cell_places, header_at, is_table_leaf, u32_at};
use crate::Damage;

const TABLE_INTERIOR: u8 = 0x05;
const INTERIOR_HEADER_BYTES: usize = 12;
/// A tree of 32-bit page numbers cannot be deeper.
const DEEPEST: usize = 32;

/// A walk through the leaves of a table.
pub(crate) struct Leaves {
    /// Pages that are still to be visited on each level, the next one last.
    levels: Vec<Vec<u32>>,
    visited: u32,
}

impl Leaves {
    /// From the root page of a table.
    pub(crate) fn of(root: u32) -> Self {
        Self { levels: vec![vec![root]], visited: 0 }
    }

    /// Reads the next leaf into `page` and gives its number; `None` after the last.
    ///
    /// # Errors
    /// At a page that cannot be read or is none of a table, with its number. The walk can go on behind it.
    pub(crate) fn next(&mut self, pages: &mut Pages, page: &mut Vec<u8>) -> Result<Option<u32>, (u32, Damage)> {
        while let Some(level) = self.levels.last_mut() {
            let Some(number) = level.pop() else {
                self.levels.pop();
                continue;
            };
            self.visited += 1;
            if self.visited > pages.count() {
                self.levels.clear();
                return Err((number, Damage::Record("its pages lead in a circle".to_owned())));
            }
            pages.read(number, page).map_err(|damage| (number, damage))?;
            if is_table_leaf(page, number) {
                return Ok(Some(number));
            }
            let children = children_of(page, number).filter(|_| self.levels.len() < DEEPEST);
            let no_page = || (number, Damage::Record(format!("page {number} is none of a table")));
            self.levels.push(children.ok_or_else(no_page)?);
        }
        Ok(None)
    }
}

/// The pages below an interior page, the last one first.
fn children_of(page: &[u8], number: u32) -> Option<Vec<u32>> {
    let header_at = header_at(number);
    if page.get(header_at) != Some(&TABLE_INTERIOR) {
        return None;
    }
    let places = cell_places(page, header_at, INTERIOR_HEADER_BYTES)?;
    let last = u32_at(page, header_at + 8)?;
    let others: Option<Vec<u32>> = places.into_iter().rev().map(|place| u32_at(page, place)).collect();
    Some(std::iter::once(last).chain(others?).collect())
}
