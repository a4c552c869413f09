//! What would change the count: another tolerance, another scale.

use crosscut_stage::{Frame, Spectrum, Weights};

use crate::{Link, WallLinks};

/// Eigenvalue and Rayleigh quotient agree if they differ by no more than this factor.
const AGREES: f64 = 10.0;
/// W is exp(-σ d²) if σ = -ln W / d² is the same for its links to within this share.
const SAME_SCALE: f64 = 1e-6;
/// A σ that is farther from the present one than by this factor is not named: by then other links than this one decide.
const NEAR: f64 = 3.0;

/// A change that would give another count.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The count that it would give.
    pub k: usize,
    /// The eigenvalue that τ would have to pass.
    pub eigenvalue: f64,
    /// How far τ would have to move to it, in decades.
    pub decades: f64,
    /// The walls concerned: one that would break, or two that would be one; empty if no single link stands for it.
    pub walls: Vec<u32>,
    /// The link that stands for the eigenvalue, if one does.
    pub link: Option<Link>,
    /// The σ of W = exp(-σ d²) that would bring the eigenvalue to τ, in 1/m², if W is of that kind: about, and only if it is
    /// near the present one.
    pub sigma_per_m2: Option<f64>,
}

/// The least changes to one zero more and to one less, the nearer first.
pub(crate) fn changes(frame: &Frame, walls: &[WallLinks]) -> Vec<Change> {
    let spectrum = &frame.spectrum;
    let sigma = scale(frame, walls);
    let mut changes: Vec<Change> =
        [one_more(spectrum, walls), one_less(spectrum, frame.revolution.len(), walls)].into_iter().flatten().collect();
    for change in &mut changes {
        let reach = |link: Link| sigma_of(frame, link, link.weight * (spectrum.tolerance / change.eigenvalue));
        let is_near = |reached: &f64| sigma.is_some_and(|now| (now / NEAR..=now * NEAR).contains(reached));
        change.sigma_per_m2 = change.link.and_then(reach).filter(is_near);
    }
    changes.sort_by(|a, b| a.decades.total_cmp(&b.decades));
    changes
}

/// τ above λ_k+1: the wall that breaks most easily does.
fn one_more(spectrum: &Spectrum, walls: &[WallLinks]) -> Option<Change> {
    let eigenvalue = *spectrum.eigenvalues.get(spectrum.k)?;
    let breaks = walls.iter().filter(|wall| wall.weakest.is_some());
    let first = breaks.min_by(|a, b| a.breaks_at.total_cmp(&b.breaks_at));
    let first = first.filter(|wall| agrees(wall.breaks_at, eigenvalue));
    Some(Change {
        k: spectrum.k + 1,
        eigenvalue,
        decades: (eigenvalue / spectrum.tolerance).log10(),
        walls: first.map(|wall| wall.wall).into_iter().collect(),
        link: first.and_then(|wall| wall.weakest),
        sigma_per_m2: None,
    })
}

/// τ below λ_k: the wall that is least apart from the others joins them. No tolerance undoes a zero of rounding.
fn one_less(spectrum: &Spectrum, n: usize, walls: &[WallLinks]) -> Option<Change> {
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
    Some(Change {
        k,
        eigenvalue,
        decades: (spectrum.tolerance / eigenvalue).log10(),
        walls: joined.map_or_else(Vec::new, |(wall, (to, _))| vec![wall, to]),
        link: joined.map(|(_, (_, link))| link),
        sigma_per_m2: None,
    })
}

fn agrees(quotient: f64, eigenvalue: f64) -> bool {
    quotient > 0.0 && (eigenvalue / AGREES..=eigenvalue * AGREES).contains(&quotient)
}

/// σ, if W is exp(-σ d²): told from the links themselves, so that it holds whatever the stage is called.
fn scale(frame: &Frame, walls: &[WallLinks]) -> Option<f64> {
    if !matches!(frame.affinity.weights, Weights::Dense(_)) {
        return None;
    }
    let weakest = walls.iter().filter_map(|wall| wall.weakest);
    let links = weakest.chain(walls.iter().filter_map(|wall| wall.strongest.map(|(_, link)| link)));
    let sigmas: Vec<f64> = links.filter_map(|link| sigma_of(frame, link, link.weight)).collect();
    let (least, most) = (sigmas.iter().copied().reduce(f64::min)?, sigmas.iter().copied().reduce(f64::max)?);
    (sigmas.len() > 1 && least > 0.0 && most / least - 1.0 < SAME_SCALE).then_some(least)
}

/// The σ at which the link would have this weight.
fn sigma_of(frame: &Frame, link: Link, weight: f64) -> Option<f64> {
    let [a, b] = link.returns.map(|i| frame.revolution.points_m[i]);
    let squared_m2 = (a - b).norm_squared();
    (squared_m2 > 0.0 && weight > 0.0 && link.weight < 1.0).then(|| -weight.ln() / squared_m2)
}
