//! Calibration: parameters with which the curves of some packings meet a measured one.
//!
//! Gauss-Newton steps on logarithms of parameters and figures, which are nearly proportional. The first derivatives are finite
//! differences, later ones Broyden's updates (1965), so a step costs one test of each packing. A wide prior about the start
//! keeps a parameter in place that the curve hardly depends on. A step that makes things worse shrinks the next one.

use meso_concrete::PhysicalRange;

/// Peaks of concrete in a test of its strength.
const PEAK: PhysicalRange = PhysicalRange { least: 1.0, most: 300.0, unit: "MPa", others: PhysicalRange::STRESSES };
/// Strains at the peak, with the give of a machine.
const PEAK_STRAIN: PhysicalRange = PhysicalRange { least: 1e-4, most: 0.03, unit: "", others: PhysicalRange::STRAINS };

/// Figures of a curve that a fit compares, each with the relative error that counts as one.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    height_mm: f64,
    /// Shares of the peak that the measured curve falls to.
    levels: Vec<f64>,
    /// Logarithms of the measured figures.
    logs: Vec<f64>,
}

/// Shares of the peak at which displacements beyond it are compared.
const LEVELS: [f64; 4] = [0.9, 0.7, 0.5, 0.3];
/// Relative errors of the peak, its strain and a displacement that count alike.
const ERRORS: [f64; 3] = [0.02, 0.05, 0.2];
/// Least displacement beyond the peak over the height; a curve that drops at once has this one.
const LEAST: f64 = 1e-6;

impl Target {
    /// The figures of a measured curve, strain and stress in MPa, of a specimen of this height.
    ///
    /// # Errors
    /// A sentence where the curve has no rising part to a peak, or its peak or the strain there is none of concrete.
    pub fn new(curve: &[[f64; 2]], height_mm: f64) -> Result<Self, String> {
        let peak = peak(curve);
        let falls = curve.windows(2).any(|pair| pair[1][0] < pair[0][0]);
        if let Some(row) = curve.iter().position(|row| row.iter().any(|value| !value.is_finite())) {
            let [strain, stress] = curve[row];
            return Err(format!("its row {} is {strain}, {stress}; give finite numbers", row + 1));
        }
        if falls || peak == 0 || curve[peak][1] <= 0.0 || curve[peak][0] <= 0.0 {
            return Err("it must rise from its first row to a peak, with strains that never fall".to_owned());
        }
        let at_peak = [("strain at its peak", curve[peak][0], PEAK_STRAIN), ("peak stress", curve[peak][1], PEAK)];
        if let Some((name, value, range)) = at_peak.iter().find(|(_, value, range)| !range.has(*value)) {
            return Err(format!("the {name} is {value}; {}", range.refusal(*value)));
        }
        let least = curve[peak..].iter().fold(f64::INFINITY, |least, point| least.min(point[1])) / curve[peak][1];
        let levels: Vec<f64> = LEVELS.into_iter().filter(|level| *level >= least).collect();
        let logs = logs(curve, height_mm, &levels);
        Ok(Self { height_mm, levels, logs })
    }

    /// Names of the figures.
    pub fn names(&self) -> Vec<String> {
        let fixed = ["peak stress, MPa", "strain at the peak"].map(str::to_owned).into_iter();
        fixed
            .chain(self.levels.iter().map(|level| format!("displacement from the peak to {level} of it, mm")))
            .collect()
    }

    /// Measured figures.
    pub fn values(&self) -> Vec<f64> {
        self.logs.iter().map(|log| log.exp()).collect()
    }

    /// Figures of another curve.
    pub fn of(&self, curve: &[[f64; 2]]) -> Vec<f64> {
        logs(curve, self.height_mm, &self.levels).iter().map(|log| log.exp()).collect()
    }

    /// Errors of another curve, in units of those that count as one.
    pub fn residuals(&self, curve: &[[f64; 2]]) -> Vec<f64> {
        let errors = ERRORS[..2].iter().chain(std::iter::repeat(&ERRORS[2]));
        let logs = logs(curve, self.height_mm, &self.levels);
        logs.iter().zip(&self.logs).zip(errors).map(|((log, measured), error)| (log - measured) / error).collect()
    }
}

/// Number of the highest point, the first of them.
fn peak(curve: &[[f64; 2]]) -> usize {
    (0..curve.len()).fold(0, |best, i| if curve[i][1] > curve[best][1] { i } else { best })
}

fn logs(curve: &[[f64; 2]], height_mm: f64, levels: &[f64]) -> Vec<f64> {
    let Some(&[strain, stress]) = curve.get(peak(curve)) else { return vec![f64::NAN; levels.len() + 2] };
    let falling = &curve[peak(curve)..];
    let displacements = levels.iter().map(|level| height_mm * (fallen(falling, level * stress) - strain).max(LEAST));
    [stress, strain].into_iter().chain(displacements).map(f64::ln).collect()
}

/// Strain at which a falling curve first reaches `stress`. A curve that ends above it goes on along the line from its peak.
fn fallen(falling: &[[f64; 2]], stress: f64) -> f64 {
    let reached = falling.windows(2).find(|pair| pair[1][1] <= stress && pair[0][1] > pair[1][1]);
    let end = falling.len() - 1;
    let [[from, above], [to, below]] = reached.map_or([falling[0], falling[end]], |pair| [pair[0], pair[1]]);
    if above > below { from + (above - stress) / (above - below) * (to - from) } else { 4.0 * to - 3.0 * from }
}

/// A fit on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Logarithms of the parameters at the start and at the best point.
    start: Vec<f64>,
    best: Vec<f64>,
    /// Residuals of every packing at the best point, and their derivatives by the parameters.
    packings: Vec<Packing>,
    /// Largest change of a logarithm in a step.
    reach: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct Packing {
    residuals: Vec<f64>,
    /// Row by row, as many as residuals.
    derivatives: Vec<Vec<f64>>,
}

/// A parameter as the fit has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Relative scatter: standard deviation of the values that each packing alone asks for.
    pub over_packings: f64,
    /// Relative error that the curve leaves, if its figures have the errors that count as one.
    pub of_curve: f64,
}

/// Relative change of a parameter for its derivative.
const DIFFERENCE: f64 = 0.15;
/// Largest change of a logarithm in the first step, and in any.
const REACHES: [f64; 2] = [0.5, 0.7];
/// Standard deviation of the prior: a factor of 3.
const PRIOR: f64 = 1.1;
/// A proposed step that changes no parameter by more than this ends the fit.
const SETTLED: f64 = 0.01;

impl Calibration {
    /// Points whose residuals a fit from `start` begins with: the start, and one with every parameter changed.
    pub fn points(start: &[f64]) -> Vec<Vec<f64>> {
        let changed = |j: usize| {
            let mut point = start.to_vec();
            point[j] *= 1.0 + DIFFERENCE;
            point
        };
        std::iter::once(start.to_vec()).chain((0..start.len()).map(changed)).collect()
    }

    /// A fit with the residuals at [`points`](Self::points), point by point and packing by packing.
    pub fn new(start: &[f64], residuals: &[Vec<Vec<f64>>]) -> Self {
        let step = DIFFERENCE.ln_1p();
        let packing = |number: usize| {
            let at = |point: usize| &residuals[point][number];
            let slope = |row: usize, j: usize| (at(j + 1)[row] - at(0)[row]) / step;
            let derivatives = (0..at(0).len()).map(|row| (0..start.len()).map(|j| slope(row, j)).collect()).collect();
            Packing { residuals: at(0).clone(), derivatives }
        };
        let logs: Vec<f64> = start.iter().map(|value| value.ln()).collect();
        let packings = (0..residuals[0].len()).map(packing).collect();
        Self { start: logs.clone(), best: logs, packings, reach: REACHES[0] }
    }

    /// The next point to try; `None` where the step to it is too small to matter.
    pub fn next(&self) -> Option<Vec<f64>> {
        let step = self.step(&mean(&self.packings));
        let largest = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let share = (self.reach / largest).min(1.0);
        let point = || self.best.iter().zip(&step).map(|(x, step)| (x + share * step).exp()).collect();
        (largest.is_finite() && share * largest > SETTLED).then(point)
    }

    /// Takes in the residuals of every packing at `point`; whether they are better than before.
    pub fn learn(&mut self, point: &[f64], residuals: &[Vec<f64>]) -> bool {
        let logs: Vec<f64> = point.iter().map(|value| value.ln()).collect();
        let step: Vec<f64> = logs.iter().zip(&self.best).map(|(new, old)| new - old).collect();
        let before = self.misfit();
        for (packing, new) in self.packings.iter_mut().zip(residuals) {
            packing.update(&step, new);
        }
        let mut there = self.clone();
        there.best = logs;
        there.packings.iter_mut().zip(residuals).for_each(|(packing, new)| packing.residuals.clone_from(new));
        let is_better = there.misfit() < before;
        if is_better {
            *self = there;
        }
        self.reach = if is_better { (1.5 * self.reach).min(REACHES[1]) } else { 0.4 * self.reach };
        is_better
    }

    /// Sum of squares of the mean residuals, and of the distance from the start.
    pub fn misfit(&self) -> f64 {
        let of_curve: f64 = mean(&self.packings).residuals.iter().map(|r| r * r).sum();
        of_curve + self.best.iter().zip(&self.start).map(|(x, start)| ((x - start) / PRIOR).powi(2)).sum::<f64>()
    }

    /// The parameters at the best point, with their scatter.
    pub fn estimates(&self) -> Vec<Estimate> {
        let steps: Vec<Vec<f64>> = self.packings.iter().map(|packing| self.step(packing)).collect();
        let normal = self.normal(&mean(&self.packings));
        let estimate = |j: usize| {
            let count = steps.len() as f64;
            let middle = steps.iter().map(|step| step[j]).sum::<f64>() / count;
            let square = steps.iter().map(|step| (step[j] - middle).powi(2)).sum::<f64>();
            let unit: Vec<f64> = (0..self.best.len()).map(|i| f64::from(u8::from(i == j))).collect();
            Estimate {
                value: self.best[j].exp(),
                over_packings: if steps.len() > 1 { (square / (count - 1.0)).sqrt() } else { f64::NAN },
                of_curve: solved(normal.clone(), unit)[j].max(0.0).sqrt(),
            }
        };
        (0..self.best.len()).map(estimate).collect()
    }

    /// Gauss-Newton's step for some residuals.
    fn step(&self, packing: &Packing) -> Vec<f64> {
        let pulled = |j: usize| {
            let rows = packing.residuals.iter().zip(&packing.derivatives);
            let of_curve: f64 = rows.map(|(residual, slopes)| residual * slopes[j]).sum();
            -of_curve - (self.best[j] - self.start[j]) / (PRIOR * PRIOR)
        };
        solved(self.normal(packing), (0..self.best.len()).map(pulled).collect())
    }

    /// Matrix of the normal equations.
    fn normal(&self, packing: &Packing) -> Vec<Vec<f64>> {
        let entry = |i: usize, j: usize| {
            let of_curve: f64 = packing.derivatives.iter().map(|slopes| slopes[i] * slopes[j]).sum();
            of_curve + if i == j { 1.0 / (PRIOR * PRIOR) } else { 0.0 }
        };
        (0..self.best.len()).map(|i| (0..self.best.len()).map(|j| entry(i, j)).collect()).collect()
    }
}

impl Packing {
    /// Broyden's update: the derivatives give the residuals found after `step`.
    fn update(&mut self, step: &[f64], found: &[f64]) {
        let square: f64 = step.iter().map(|x| x * x).sum();
        if square == 0.0 {
            return;
        }
        for ((slopes, old), new) in self.derivatives.iter_mut().zip(&self.residuals).zip(found) {
            let expected: f64 = old + slopes.iter().zip(step).map(|(slope, x)| slope * x).sum::<f64>();
            slopes.iter_mut().zip(step).for_each(|(slope, x)| *slope += (new - expected) * x / square);
        }
    }
}

/// Means over the packings.
fn mean(packings: &[Packing]) -> Packing {
    let count = packings.len() as f64;
    let mut sum = packings[0].clone();
    for other in &packings[1..] {
        sum.residuals.iter_mut().zip(&other.residuals).for_each(|(a, b)| *a += b);
        let rows = sum.derivatives.iter_mut().zip(&other.derivatives);
        rows.for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| *a += b));
    }
    sum.residuals.iter_mut().chain(sum.derivatives.iter_mut().flatten()).for_each(|x| *x /= count);
    sum
}

/// Solution of a positive definite system, by elimination.
fn solved(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for k in 0..n {
        for i in k + 1..n {
            let share = matrix[i][k] / matrix[k][k];
            let pivot = matrix[k].clone();
            matrix[i].iter_mut().zip(&pivot).skip(k).for_each(|(a, b)| *a -= share * b);
            right[i] -= share * right[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola to the peak, and an exponential beyond it with this length.
    fn curve(peak: f64, strain: f64, length_mm: f64, height_mm: f64) -> Vec<[f64; 2]> {
        let stress = |e: f64| {
            let x = e / strain;
            if x < 1.0 { peak * x * (2.0 - x) } else { peak * (-(e - strain) * height_mm / length_mm).exp() }
        };
        (0..400).map(|i| f64::from(i) * strain / 100.0).map(|e| [e, stress(e)]).collect()
    }

    #[test]
    fn a_target_has_the_figures_of_its_curve_and_no_levels_that_it_does_not_reach() {
        let target = Target::new(&curve(36.0, 0.002, 0.4, 100.0), 100.0).unwrap();
        let values = target.values();
        assert_eq!(target.names().len(), 6);
        let expected = [36.0, 0.002, 0.4 * (1.0 / 0.9_f64).ln(), 0.4 * (1.0 / 0.7_f64).ln(), 0.4 * 2_f64.ln()];
        for (value, expected) in values.iter().zip(expected) {
            assert!((value / expected - 1.0).abs() < 0.01, "{values:?}");
        }
        assert!(target.residuals(&curve(36.0, 0.002, 0.4, 100.0)).iter().all(|r| r.abs() < 1e-12));
        let short = &curve(36.0, 0.002, 0.4, 100.0)[..115];
        assert_eq!(Target::new(short, 100.0).unwrap().names().len(), 2);
        let refused = |strain: f64, stress: f64| {
            Target::new(&curve(36.0 * stress, 0.002 * strain, 0.4, 100.0), 100.0).unwrap_err()
        };
        assert!(refused(1.0, 145.04).ends_with("5221.44 psi are 36.0006 MPa"), "{}", refused(1.0, 145.04));
        assert!(refused(1.0, 1e-3).ends_with("0.036 GPa are 36 MPa"), "{}", refused(1.0, 1e-3));
        assert!(refused(1.0, 1e6).ends_with("3.6e7 Pa are 36 MPa"), "{}", refused(1.0, 1e6));
        assert!(refused(100.0, 1.0).contains("strain at its peak is 0.2; it must be 0.0001 to 0.03: 0.2 % are 0.002"));
        assert!(refused(1000.0, 1.0).ends_with("2 % are 0.02, 2 per mille are 0.002"), "{}", refused(1000.0, 1.0));
        assert!(refused(1e6, 1.0).ends_with("2000 microstrain are 0.002"), "{}", refused(1e6, 1.0));
        assert!(Target::new(&[], 100.0).is_err() && Target::new(&[[0.0, 1.0], [1.0, 0.5]], 100.0).is_err());
    }

    #[test]
    fn a_curve_that_ends_above_a_level_goes_on_along_its_line() {
        assert!((fallen(&[[0.0, 10.0], [1.0, 8.0]], 5.0) - 2.5).abs() < 1e-12);
        assert!((fallen(&[[0.0, 10.0], [1.0, 4.0], [2.0, 9.0]], 5.0) - 5.0 / 6.0).abs() < 1e-12);
        assert_eq!(fallen(&[[2.0, 10.0], [3.0, 10.0]], 5.0), 6.0);
    }

    /// Three packings whose curve follows four parameters by powers, not quite in proportion: the fit finds the parameters of
    /// the curve within 1 %, and the scatter of the packings' strengths.
    #[test]
    fn a_fit_finds_parameters_and_their_scatter_in_few_tests() {
        let truth = [40.0, 0.0025, 0.08, 3.0];
        let made = |p: &[f64], strength: f64| {
            let [fc, strain, gf, gc] = [p[0], p[1], p[2], p[3]];
            let peak = strength * 0.9 * fc * (gf / 0.08).powf(0.05) * (1.0 + 0.02 * (gc / 3.0).ln());
            curve(peak, 0.8 * strain * (gc / 3.0).powf(0.1), 0.08 * gc * (fc / 40.0).powf(-0.5), 100.0)
        };
        let target = Target::new(&made(&truth, 1.0), 100.0).unwrap();
        let strengths = [0.97, 1.0, 1.03];
        let asked = |p: &[f64]| strengths.map(|strength| target.residuals(&made(p, strength))).to_vec();
        let start = [30.0, 0.002, 0.08, 0.8];
        let first: Vec<Vec<Vec<f64>>> = Calibration::points(&start).iter().map(|point| asked(point)).collect();
        let mut fit = Calibration::new(&start, &first);
        let mut tests = first.len();
        while let Some(point) = fit.next().filter(|_| tests < 20) {
            fit.learn(&point, &asked(&point));
            tests += 1;
        }
        let estimates = fit.estimates();
        for (number, bar) in [(0, 0.02), (1, 0.02), (3, 0.05)] {
            let off = estimates[number].value / truth[number] - 1.0;
            assert!(off.abs() < bar, "{number}: {off} after {tests} tests, {estimates:?}");
        }
        // The packings' strengths scatter by 3 %.
        assert!((estimates[0].over_packings / 0.03 - 1.0).abs() < 0.2, "{estimates:?}");
        // Nothing in the curve tells the fracture energy from the strength: the prior's width is left.
        assert!(estimates[2].of_curve > 0.3 && estimates[0].of_curve < 0.1, "{estimates:?}");
        assert!(tests <= 14, "{tests}");
    }

    #[test]
    fn a_step_that_makes_things_worse_is_not_taken_and_the_next_is_shorter() {
        let residuals = vec![vec![vec![1.0]], vec![vec![0.9]]];
        let mut fit = Calibration::new(&[1.0], &residuals);
        let first = fit.next().unwrap();
        assert!(!fit.learn(&first, &[vec![5.0]]));
        let second = fit.next().unwrap();
        assert!((second[0].ln()).abs() < first[0].ln().abs() && fit.estimates()[0].value == 1.0);
    }
}
