//! Values as files: NumPy arrays, CSV and texts.

use std::io::{Stdout, Write};
use std::path::Path;

use anyhow::{Context, bail};
use crosscut_outfile::{Keep, Whole};
use crosscut_rrd::{Row, Value};

use super::npy::NpyFile;
use super::table;
use crate::exit::UsageError;
use crate::interrupt;

/// Where values are written: a file, which replaces an older one when it is finished, or standard output.
pub(super) struct Output {
    format: Format,
    /// How many values were written.
    pub(super) values: usize,
}

/// The format, by the ending of the file.
enum Format {
    /// One array; of several revolutions along its first dimension.
    Npy(NpyFile),
    /// One number or text a line, with revolution, stamp and indices before it; 0 columns before the first value.
    Csv { file: Whole, columns: usize },
    /// Texts, those of several revolutions under headings.
    Markdown { out: Texts, one: bool },
}

/// Where texts go.
enum Texts {
    File(Whole),
    StandardOutput(Stdout),
}

impl Texts {
    fn as_write(&mut self) -> &mut dyn Write {
        match self {
            Self::File(file) => file,
            Self::StandardOutput(out) => out,
        }
    }
}

impl Output {
    /// Opens the file at `path`, or standard output for `-`. An array of `one` revolution has no dimension for revolutions.
    pub(super) fn create(path: &Path, one: bool) -> anyhow::Result<Self> {
        if path == Path::new("-") {
            let format = Format::Markdown { out: Texts::StandardOutput(std::io::stdout()), one };
            return Ok(Self { format, values: 0 });
        }
        let create = || {
            let created = Whole::create(path, Keep::ThroughKill);
            let file = created.with_context(|| format!("cannot write {}", path.display()))?;
            interrupt::quit_without(&file)?;
            Ok::<_, anyhow::Error>(file)
        };
        let format = match path.extension().and_then(|ending| ending.to_str()) {
            Some("npy") => Format::Npy(NpyFile::new(create()?, one)?),
            Some("csv") => Format::Csv { file: create()?, columns: 0 },
            Some("md") => Format::Markdown { out: Texts::File(create()?), one },
            _ => {
                let text = format!("{}: --out takes a file that ends in .npy, .csv or .md", path.display());
                return Err(UsageError(text).into());
            }
        };
        Ok(Self { format, values: 0 })
    }

    /// Adds the value of a revolution, or of the whole flight.
    pub(super) fn add(&mut self, of: Option<&Row>, value: &Value) -> anyhow::Result<()> {
        self.values += 1;
        match of {
            Some(row) => {
                let revolution = || format!("revolution {}", row.revolution);
                self.format.write(Some(row.revolution), row.stamp_ns, value).with_context(revolution)
            }
            None => self.format.write(None, None, value),
        }
    }

    /// Ends the file and gives it the name that was asked for.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        match self.format {
            Format::Npy(file) => file.finish(),
            Format::Csv { file, .. } | Format::Markdown { out: Texts::File(file), .. } => Ok(file.finish()?),
            Format::Markdown { out: Texts::StandardOutput(mut out), .. } => Ok(out.flush()?),
        }
    }
}

impl Format {
    fn write(&mut self, revolution: Option<i64>, stamp_ns: Option<i64>, value: &Value) -> anyhow::Result<()> {
        match self {
            Self::Npy(file) => match value {
                Value::Numbers(array) => file.add(array),
                other => bail!(UsageError(format!("{other} is no array of numbers: take .csv"))),
            },
            Self::Csv { file, columns } => {
                let names = table::columns(value)?;
                if *columns == 0 {
                    table::write_csv_header(file, &names)?;
                    *columns = names.len();
                }
                if names.len() != *columns {
                    bail!(UsageError("its dimensions differ from those before: take one with --at".to_owned()));
                }
                Ok(table::write_csv(file, [revolution, stamp_ns], value)?)
            }
            Self::Markdown { out, one } => match value {
                Value::Texts(texts) => {
                    let out = out.as_write();
                    if let Some(revolution) = revolution.filter(|_| !*one) {
                        writeln!(out, "# Revolution {revolution}\n")?;
                    }
                    texts.iter().try_for_each(|text| Ok(writeln!(out, "{}\n", text.trim_end())?))
                }
                other => bail!(UsageError(format!("{other} is no text: take a file .npy or .csv"))),
            },
        }
    }
}
