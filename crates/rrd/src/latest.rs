//! The values of a component as a viewer shows them: each holds until the next.

use std::iter::Peekable;

use crate::schema::Entity;
use crate::{ReadError, Recording, Rows, Value};

/// The values of a component at ascending revolutions.
pub struct Latest<'a> {
    /// `None` of an entity that the recording lacks.
    rows: Option<Peekable<Rows<'a>>>,
    component: &'static str,
    /// What was logged last, with its revolution.
    latest: Option<(i64, Value)>,
}

impl Recording {
    /// The values of an entity, from its first row on; none of one that the recording lacks.
    pub fn latest(&self, entity: Entity) -> Latest<'_> {
        let rows = self.rows(entity.path).ok().map(Iterator::peekable);
        Latest { rows, component: entity.values, latest: None }
    }
}

impl Latest<'_> {
    /// What was logged last up to this revolution, which is not before the one that was asked for last.
    ///
    /// # Errors
    /// When a row cannot be read.
    pub fn at(&mut self, revolution: i64) -> Result<Option<&Value>, ReadError> {
        self.go_to(revolution)?;
        Ok(self.latest.as_ref().map(|(_, value)| value))
    }

    /// What was logged at this revolution, likewise.
    ///
    /// # Errors
    /// When a row cannot be read.
    pub fn only_at(&mut self, revolution: i64) -> Result<Option<&Value>, ReadError> {
        self.go_to(revolution)?;
        Ok(self.latest.as_ref().filter(|(at, _)| *at == revolution).map(|(_, value)| value))
    }

    fn go_to(&mut self, revolution: i64) -> Result<(), ReadError> {
        let Some(rows) = &mut self.rows else { return Ok(()) };
        let mut last = None;
        while let Some(row) = rows.next_if(|row| row.as_ref().map_or(true, |row| row.revolution <= revolution)) {
            last = Some(row?);
        }
        if let Some(row) = last {
            self.latest = Some((row.revolution, row.value(self.component)?));
        }
        Ok(())
    }
}
