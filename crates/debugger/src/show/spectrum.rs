//! Eigenvalues as bars of their powers of ten, with the tolerance between them.

use crosscut_stage::Spectrum;

/// Most eigenvalues that are shown.
const MOST: usize = 16;
/// Two characters a decade, from 1e-17 on.
const FLOOR_DECADE: f64 = -17.0;

pub(super) fn bars(spectrum: &Spectrum) -> String {
    let bar = |value: f64| "#".repeat((2.0 * (value.abs().log10() - FLOOR_DECADE)).clamp(0.0, 36.0).round() as usize);
    let tolerance = format!("{:>5}  {:>8.1e}  {}", "τ", spectrum.tolerance, bar(spectrum.tolerance).replace('#', "-"));
    let mut lines = Vec::new();
    for (i, value) in spectrum.eigenvalues.iter().take(MOST).enumerate() {
        if i == spectrum.k {
            lines.push(tolerance.clone());
        }
        lines.push(format!("{:>5}  {value:>8.1e}  {}", format!("λ{}", i + 1), bar(*value)).trim_end().to_owned());
    }
    if lines.len() <= spectrum.k {
        lines.push(tolerance);
    }
    lines.push(format!("{} below τ: k = {}; two characters a decade", spectrum.k, spectrum.k));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tolerance_stands_between_zeros_and_the_next() {
        let spectrum = Spectrum { eigenvalues: vec![1e-16, 1e-9, 0.1], tolerance: 1e-7, k: 2, ..Spectrum::default() };
        let text = bars(&spectrum);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[2].contains('τ') && lines[3].contains("λ3"), "{text}");
        assert_eq!(lines[2].matches('-').count() - 1, 20, "ten decades above the floor: {text}");
        assert!(bars(&Spectrum { k: 3, ..spectrum }).contains('τ'), "a k beyond the eigenvalues breaks nothing");
    }
}
