//! A pose graph as a g2o text file: `VERTEX_SE2 id x y yaw`, `EDGE_SE2 from to x y yaw I_xx I_xy I_xθ I_yy I_yθ I_θθ`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::str::SplitAsciiWhitespace;

use nalgebra::{Isometry2, Matrix3, Vector2};

use crate::{Constraint, PoseGraph};

/// What is wrong with a line of a g2o file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}")]
pub struct G2oError {
    /// The line, counted from 1.
    pub line: usize,
    /// What is wrong with it.
    pub what: String,
}

/// The text of a graph. Poses are numbered by their index; numbers read back as the same values.
pub fn write_g2o(graph: &PoseGraph) -> String {
    let mut text = String::new();
    let numbers = |pose: &Isometry2<f64>| {
        format!("{:?} {:?} {:?}", pose.translation.x, pose.translation.y, pose.rotation.angle())
    };
    for (id, pose) in graph.poses.iter().enumerate() {
        writeln!(text, "VERTEX_SE2 {id} {}", numbers(pose)).expect("a String takes all that is written");
    }
    for Constraint { from, to, measured, information } in &graph.edges {
        write!(text, "EDGE_SE2 {from} {to} {}", numbers(measured)).expect("a String takes all that is written");
        for (row, column) in upper_triangle() {
            write!(text, " {:?}", information[(row, column)]).expect("a String takes all that is written");
        }
        text.push('\n');
    }
    text
}

/// The graph in a g2o text. Poses get the numbers 0, 1... in the order of their ids; comments, empty lines and `FIX` are passed over.
///
/// # Errors
/// At the first line that is no vertex and no edge of SE2, that lacks a number, or that names no vertex.
pub fn read_g2o(text: &str) -> Result<PoseGraph, G2oError> {
    let mut poses = BTreeMap::new();
    let mut edges = Vec::new();
    for (at, content) in text.lines().enumerate() {
        let line = at + 1;
        let mut words = LineWords { words: content.split_ascii_whitespace(), line };
        match words.words.next() {
            None | Some("FIX") => {}
            Some(comment) if comment.starts_with('#') => {}
            Some("VERTEX_SE2") => {
                let id = words.id()?;
                if poses.insert(id, words.pose()?).is_some() {
                    return Err(G2oError { line, what: format!("vertex {id} stands in the file twice") });
                }
            }
            Some("EDGE_SE2") => edges.push((line, words.id()?, words.id()?, words.pose()?, words.information()?)),
            Some(other) => return Err(G2oError { line, what: format!("`{other}` is not a vertex or an edge of SE2") }),
        }
    }
    let index: BTreeMap<u64, usize> = poses.keys().enumerate().map(|(index, &id)| (id, index)).collect();
    let named = |line, id| index.get(&id).copied().ok_or_else(|| G2oError { line, what: format!("no vertex {id}") });
    let edge = |(line, from, to, measured, information)| {
        Ok(Constraint { from: named(line, from)?, to: named(line, to)?, measured, information })
    };
    Ok(PoseGraph {
        edges: edges.into_iter().map(edge).collect::<Result<_, _>>()?,
        poses: poses.into_values().collect(),
    })
}

fn upper_triangle() -> impl Iterator<Item = (usize, usize)> {
    (0..3).flat_map(|row| (row..3).map(move |column| (row, column)))
}

/// The words of one line.
struct LineWords<'a> {
    words: SplitAsciiWhitespace<'a>,
    line: usize,
}

impl LineWords<'_> {
    fn id(&mut self) -> Result<u64, G2oError> {
        self.parse("a vertex id")
    }

    fn number(&mut self) -> Result<f64, G2oError> {
        let number: f64 = self.parse("a number")?;
        let what = || format!("{number} is not finite");
        if number.is_finite() { Ok(number) } else { Err(G2oError { line: self.line, what: what() }) }
    }

    fn pose(&mut self) -> Result<Isometry2<f64>, G2oError> {
        let position_m = Vector2::new(self.number()?, self.number()?);
        Ok(Isometry2::new(position_m, self.number()?))
    }

    fn information(&mut self) -> Result<Matrix3<f64>, G2oError> {
        let mut information = Matrix3::zeros();
        for (row, column) in upper_triangle() {
            let entry = self.number()?;
            information[(row, column)] = entry;
            information[(column, row)] = entry;
        }
        Ok(information)
    }

    fn parse<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, G2oError> {
        let word = self.words.next();
        word.and_then(|word| word.parse().ok()).ok_or_else(|| {
            let found = word.map_or_else(|| "the line ends".to_owned(), |word| format!("found `{word}`"));
            G2oError { line: self.line, what: format!("expected {expected}, {found}") }
        })
    }
}
