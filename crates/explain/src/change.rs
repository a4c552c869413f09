//! Changes of the tolerance or of σ that would give another count.

use crosscut_stage::{Frame, Spectrum, Weights};

use crate::wall_edges::{Edge, WallEdges};

/// Eigenvalue and Rayleigh quotient agree if they differ by at most this factor.
const AGREEMENT: f64 = 10.0;
/// W counts as exp(-σ d²) if σ = -ln W / d² varies by at most this share over its edges.
const SIGMA_SPREAD: f64 = 1e-6;
/// A σ that differs from the current one by more than this factor is not named: other edges would decide there.
const SIGMA_FACTOR: f64 = 3.0;

/// A change that would give another count.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The count that it would give.
    pub k: usize,
    /// The eigenvalue that τ would have to pass.
    pub eigenvalue: f64,
    /// The distance from τ to that eigenvalue, in decades.
    pub decades: f64,
    /// The walls concerned: one that would break, or two that would join; without an edge that explains the change, the two
    /// that are nearest to being one by U, or none.
    pub walls: Vec<u32>,
    /// The edge that explains the eigenvalue, if one does.
    pub edge: Option<Edge>,
    /// The σ of W = exp(-σ d²), in 1/m², that would bring the eigenvalue approximately to τ; only if W has that form and
    /// this σ is near the current one.
    pub sigma_per_m2: Option<f64>,
}

/// The smallest changes that give one zero more and one less, the smaller change first.
pub(crate) fn changes(frame: &Frame, walls: &[WallEdges]) -> Vec<Change> {
    let spectrum = &frame.spectrum;
    let sigma = sigma_of_weights(frame, walls);
    let mut changes: Vec<Change> = [one_more(spectrum, walls), one_less(frame, walls)].into_iter().flatten().collect();
    for change in &mut changes {
        let sigma_at_change =
            |edge: Edge| sigma_of(frame, edge, edge.weight * (spectrum.tolerance / change.eigenvalue));
        let is_near = |reached: &f64| {
            sigma.is_some_and(|current| (current / SIGMA_FACTOR..=current * SIGMA_FACTOR).contains(reached))
        };
        change.sigma_per_m2 = change.edge.and_then(sigma_at_change).filter(is_near);
    }
    changes.sort_by(|a, b| a.decades.total_cmp(&b.decades));
    changes
}

/// τ above λ_k+1: the wall that breaks most easily breaks.
fn one_more(spectrum: &Spectrum, walls: &[WallEdges]) -> Option<Change> {
    let eigenvalue = *spectrum.eigenvalues.get(spectrum.k)?;
    let breaks = walls.iter().filter(|wall| wall.weakest.is_some());
    let first = breaks.min_by(|a, b| a.breaks_at.total_cmp(&b.breaks_at));
    let first = first.filter(|wall| agrees(wall.breaks_at, eigenvalue));
    Some(Change {
        k: spectrum.k + 1,
        eigenvalue,
        decades: (eigenvalue / spectrum.tolerance).log10(),
        walls: first.map(|wall| wall.wall).into_iter().collect(),
        edge: first.and_then(|wall| wall.weakest),
        sigma_per_m2: None,
    })
}

/// τ below λ_k: the wall with the largest quotient joins another one. No τ is below a zero that is rounding error.
fn one_less(frame: &Frame, walls: &[WallEdges]) -> Option<Change> {
    let (spectrum, n) = (&frame.spectrum, frame.revolution.len());
    let k = spectrum.k.checked_sub(1)?;
    let eigenvalue = *spectrum.eigenvalues.get(k)?;
    if eigenvalue <= n as f64 * f64::EPSILON {
        return None;
    }
    let least_apart = walls.iter().filter(|wall| wall.strongest.is_some());
    let least_apart = least_apart.max_by(|a, b| a.parts_at.total_cmp(&b.parts_at));
    let joined = least_apart
        .filter(|wall| agrees(wall.parts_at, eigenvalue))
        .and_then(|wall| Some((wall.wall, wall.strongest?)));
    let by_rows = || nearest_by_rows(frame).map_or_else(Vec::new, |pair| pair.to_vec());
    Some(Change {
        k,
        eigenvalue,
        decades: (spectrum.tolerance / eigenvalue).log10(),
        walls: joined.map_or_else(by_rows, |(wall, (to, _))| vec![wall, to]),
        edge: joined.map(|(_, (_, edge))| edge),
        sigma_per_m2: None,
    })
}

/// The two walls whose mean rows in the first k - 1 columns of U point most in one direction, or in opposite ones: without the last
/// eigenvector they are the first to be taken for one.
fn nearest_by_rows(frame: &Frame) -> Option<[u32; 2]> {
    let (u, wall_of) = (&frame.spectrum.u, &frame.junction.wall_of_return);
    let columns = u.ncols().checked_sub(1).filter(|columns| *columns > 0 && u.nrows() == wall_of.len())?;
    let counted = frame.junction.walls.iter().filter(|wall| !wall.island);
    let means: Vec<(u32, Vec<f64>)> = counted
        .map(|wall| {
            let rows = || (0..u.nrows()).filter(|&i| wall_of[i] == Some(wall.id));
            (wall.id, (0..columns).map(|j| rows().map(|i| u[(i, j)]).sum()).collect())
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let alike = |a: &[f64], b: &[f64]| dot(a, b).abs() / (dot(a, a) * dot(b, b)).sqrt();
    let pairs = means.iter().enumerate().flat_map(|(at, a)| means[..at].iter().map(move |b| (a, b)));
    let pairs =
        pairs.map(|((a, of_a), (b, of_b))| (alike(of_a, of_b), [*b, *a])).filter(|(alike, _)| alike.is_finite());
    pairs.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, walls)| walls)
}

fn agrees(quotient: f64, eigenvalue: f64) -> bool {
    quotient > 0.0 && (eigenvalue / AGREEMENT..=eigenvalue * AGREEMENT).contains(&quotient)
}

/// σ, if W has the form exp(-σ d²). It follows from the edges, so that it does not depend on the kind of the stage.
fn sigma_of_weights(frame: &Frame, walls: &[WallEdges]) -> Option<f64> {
    if !matches!(frame.affinity.weights, Weights::Dense(_)) {
        return None;
    }
    let weakest = walls.iter().filter_map(|wall| wall.weakest);
    let edges = weakest.chain(walls.iter().filter_map(|wall| wall.strongest.map(|(_, edge)| edge)));
    let sigmas: Vec<f64> = edges.filter_map(|edge| sigma_of(frame, edge, edge.weight)).collect();
    let (least, most) = (sigmas.iter().copied().reduce(f64::min)?, sigmas.iter().copied().reduce(f64::max)?);
    (sigmas.len() > 1 && least > 0.0 && most / least - 1.0 < SIGMA_SPREAD).then_some(least)
}

/// The σ at which the edge would have this weight.
fn sigma_of(frame: &Frame, edge: Edge, weight: f64) -> Option<f64> {
    let [a, b] = edge.returns.map(|i| frame.revolution.points_m[i]);
    let squared_m2 = (a - b).norm_squared();
    (squared_m2 > 0.0 && weight > 0.0 && edge.weight < 1.0).then(|| -weight.ln() / squared_m2)
}
