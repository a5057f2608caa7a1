//! The field of strengths: its covariance, its distribution and its weakest link, against formulas.
//!
//! Each bar is four standard errors away at least: numbers of seeds and places are chosen for that.

use meso_core::materials::{
    Covariance, LawName, Materials, Scatter, ScatteredPhase, StrengthDistribution, StrengthField,
};
use meso_core::math::Vec3;
use meso_core::mesh::{self, ItzForm, MeshOptions, Method, Phase, Tools};
use meso_core::specimen::Specimen;

const LENGTH_MM: f64 = 6.0;

fn scatter(coefficient_of_variation: f64) -> Scatter {
    Scatter {
        coefficient_of_variation,
        correlation_length_mm: LENGTH_MM,
        distribution: StrengthDistribution::Weibull,
        covariance: Covariance::SquaredExponential,
        phases: vec![ScatteredPhase::Mortar, ScatteredPhase::Itz],
        seed: 1,
    }
}

fn fields(of: &Scatter, seeds: u64) -> impl Iterator<Item = StrengthField> + use<'_> {
    (1..=seeds).map(|seed| Scatter { seed, ..of.clone() }.field())
}

/// Places that are 20 correlation lengths apart, and more.
fn apart(count: usize) -> Vec<Vec3> {
    let at = |i: usize| 20.0 * LENGTH_MM * Vec3::new((i % 4) as f64, (i / 4 % 4) as f64, (i / 16) as f64);
    (0..count).map(at).collect()
}

fn mean(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len() as f64
}

#[test]
fn the_covariance_of_places_at_any_distance_is_the_stated_one() {
    for covariance in [Covariance::SquaredExponential, Covariance::Exponential] {
        let of = Scatter { covariance, ..scatter(0.1) };
        let lags = [0.0, 0.3, 0.7, 1.0, 1.5, 3.0].map(|lag| lag * LENGTH_MM);
        let mut found = [0.0; 6];
        let (seeds, places) = (1500, apart(6));
        for field in fields(&of, seeds) {
            for (i, place) in places.iter().enumerate() {
                let along = Vec3::from_fn(|axis, _| if axis == i % 3 { 1.0 } else { 0.0 });
                let here = field.gaussian(place);
                for (found, lag) in found.iter_mut().zip(lags) {
                    *found += here * field.gaussian(&(place + lag * along)) / (seeds as f64 * places.len() as f64);
                }
            }
        }
        for (found, lag) in found.into_iter().zip(lags) {
            let r = lag / LENGTH_MM;
            let stated = if covariance == Covariance::Exponential { (-r).exp() } else { (-r * r).exp() };
            // The standard error is 0.015 at no distance, and less beyond.
            assert!(
                (found - stated).abs() < if lag == 0.0 { 0.045 } else { 0.02 },
                "{covariance:?} {r}: {found} {stated}"
            );
        }
    }
}

/// Centroids of some cells of a mesh of a cube.
fn centroids(element_size_mm: f64, count: usize) -> Vec<Vec3> {
    let options = MeshOptions { method: Method::FITTED, element_size_mm, itz: ItzForm::None, ..MeshOptions::default() };
    let mesh = mesh::build((&[], &Specimen::cube(36.0)), &options, &Tools::default()).unwrap();
    let centroid = |cell: &[u32]| cell.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / 4.0;
    let every = mesh.cell_count() / count;
    mesh.cells().step_by(every).map(centroid).collect()
}

#[test]
fn two_meshes_have_the_stated_covariance_and_mean() {
    let of = scatter(0.15);
    for size in [4.0, 3.0] {
        let places = centroids(size, 180);
        let expected = |a: &Vec3, b: &Vec3| (-(a - b).norm_squared() / (LENGTH_MM * LENGTH_MM)).exp();
        let pairs: Vec<(usize, usize, f64)> = (0..places.len())
            .flat_map(|a| (0..a).map(move |b| (a, b)))
            .map(|(a, b)| (a, b, expected(&places[a], &places[b])))
            .filter(|(.., expected)| (0.2..0.8).contains(expected))
            .collect();
        assert!(pairs.len() > 100, "{}", pairs.len());
        let stated = mean(&pairs.iter().map(|pair| pair.2).collect::<Vec<_>>());
        let (mut covariances, mut means) = (Vec::new(), Vec::new());
        for field in fields(&of, 600) {
            let g: Vec<f64> = places.iter().map(|place| field.gaussian(place)).collect();
            covariances.push(mean(&pairs.iter().map(|&(a, b, _)| g[a] * g[b]).collect::<Vec<_>>()));
            means.push(mean(&places.iter().step_by(3).map(|place| field.factor(place)).collect::<Vec<_>>()));
        }
        let found = mean(&covariances);
        let spread = mean(&covariances.iter().map(|x| (x - found).powi(2)).collect::<Vec<_>>()).sqrt();
        assert!(spread / 24.5 < 0.006, "{spread}");
        assert!((found - stated).abs() < 0.02, "{size}: {found} instead of {stated}");
        assert!((mean(&means) - 1.0).abs() < 0.01, "{size}: {}", mean(&means));
    }
}

/// Factors of some seeds at places that are far apart.
fn factors(of: &Scatter, seeds: u64, count: usize) -> Vec<Vec<f64>> {
    let places = apart(count);
    fields(of, seeds).map(|field| places.iter().map(|place| field.factor(place)).collect()).collect()
}

/// Largest distance of the values' distribution from another one (Kolmogorov and Smirnov).
fn distance(mut values: Vec<f64>, probability: impl Fn(f64) -> f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let off = |(i, x): (usize, &f64)| {
        let p = probability(*x);
        (p - i as f64 / count).abs().max((p - (i + 1) as f64 / count).abs())
    };
    values.iter().enumerate().map(off).fold(0.0, f64::max)
}

#[test]
fn strengths_have_their_distribution_with_its_mean_and_variation() {
    for (distribution, cv) in [(StrengthDistribution::Weibull, 0.25), (StrengthDistribution::Lognormal, 0.25)] {
        let of = Scatter { distribution, ..scatter(cv) };
        let values = factors(&of, 1200, 16).concat();
        let average = mean(&values);
        let deviation = mean(&values.iter().map(|x| (x - average).powi(2)).collect::<Vec<_>>()).sqrt();
        assert!((average - 1.0).abs() < 0.01, "{distribution:?} {average}");
        assert!((deviation / cv - 1.0).abs() < 0.03, "{distribution:?} {deviation}");
        let m = of.weibull_modulus();
        let gamma = libm::tgamma(1.0 + 1.0 / m);
        let sigma = (1.0 + cv * cv).ln().sqrt();
        let off = match distribution {
            StrengthDistribution::Weibull => distance(values, |x| 1.0 - (-(x * gamma).powf(m)).exp()),
            StrengthDistribution::Lognormal => {
                let normal = |x: f64| (x.ln() + 0.5 * sigma * sigma) / sigma;
                distance(values, |x| 0.5 * libm::erfc(-normal(x) / std::f64::consts::SQRT_2))
            }
        };
        // 1.63 / sqrt(19,200): exceeded by one sample of a hundred.
        assert!(off < 0.0118, "{distribution:?} {off}");
    }
}

#[test]
fn a_chain_of_links_is_as_strong_as_its_weakest_one() {
    let of = scatter(0.2);
    let m = of.weibull_modulus();
    let all = factors(&of, 1500, 32);
    for links in [4, 8, 32] {
        let weakest: Vec<f64> = all
            .iter()
            .flat_map(|values| values.chunks(links))
            .map(|chain| chain.iter().copied().fold(f64::INFINITY, f64::min))
            .collect();
        let expected = (links as f64).powf(-1.0 / m);
        assert!((mean(&weakest) / expected - 1.0).abs() < 0.02, "{links}: {} {expected}", mean(&weakest));
    }
}

#[test]
fn the_modulus_has_the_coefficient_of_variation() {
    for (cv, modulus) in [(0.5, 2.1013), (0.1, 12.1534), (0.01, 127.55), (0.001, 1281.8)] {
        let found = scatter(cv).weibull_modulus();
        assert!((found / modulus - 1.0).abs() < 1e-3, "{cv}: {found}");
    }
}

#[test]
fn a_seed_gives_one_field_and_another_seed_another_one() {
    let place = Vec3::new(3.0, 4.0, 5.0);
    let of = |seed| Scatter { seed, ..scatter(0.1) }.field().factor(&place);
    assert_eq!(of(1).to_bits(), of(1).to_bits());
    assert_ne!(of(1), of(2));
}

#[test]
fn a_scatter_that_cannot_be_is_refused_with_a_remedy() {
    let of = |scatter: Scatter, law| {
        let materials = Materials { scatter: Some(scatter), ..Materials::default() };
        materials.validate_scatter(law).err().map(|error| error.to_string()).unwrap_or_default()
    };
    let variation = "materials.scatter.coefficient_of_variation is";
    for cv in [-0.1, f64::NAN, 10.0, 1e-5] {
        let text = of(scatter(cv), LawName::Meso);
        assert_eq!(text, format!("{variation} {cv}; it must be 0, or 0.001 to 0.5: 0.1 is 10 %"));
    }
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let text = of(Scatter { correlation_length_mm: length, ..scatter(0.1) }, LawName::Meso);
        assert_eq!(text, format!("materials.scatter.correlation_length_mm is {length}; it must be a positive number"));
    }
    let text = of(Scatter { phases: Vec::new(), ..scatter(0.1) }, LawName::Meso);
    assert_eq!(text, r#"materials.scatter.phases is []; name "mortar", "itz" or each of them once"#);
    for law in [LawName::Cdp, LawName::Cdpm2] {
        let text = of(scatter(0.1), law);
        let remedy =
            "strengths scatter in tests with the law meso only; for decks and other laws set 0, or remove the table";
        assert_eq!(text, format!("{variation} 0.1; {remedy}"));
        assert_eq!(of(scatter(0.0), law), "");
    }
    assert_eq!(of(scatter(0.1), LawName::Elastic), "");
}

#[test]
fn a_correlation_length_beside_the_elements_and_the_specimen_is_refused_or_doubted() {
    let of = |correlation_length_mm| Scatter { correlation_length_mm, ..scatter(0.1) };
    let text = of(0.5).suits(2.0, false).unwrap_err().to_string();
    assert!(
        text.starts_with("materials.scatter.correlation_length_mm is 0.5; with elements of 2 mm it must be 1 or more"),
        "{text}"
    );
    assert!(text.ends_with("elements of 0.25 mm resolve it"), "{text}");
    assert!(of(1.0).suits(2.0, false).is_ok());
    let text = of(4.0).suits(2.0, true).unwrap_err().to_string();
    assert!(
        text.contains(r#"scatter.phases is ["mortar", "itz"]; strengths of a cohesive ITZ do not scatter"#),
        "{text}"
    );
    assert!(Scatter { phases: vec![ScatteredPhase::Mortar], ..of(4.0) }.suits(2.0, true).is_ok());
    let text = of(3.0).doubt(2.0, 50.0).unwrap();
    assert!(text.ends_with("take elements of 1.5 mm"), "{text}");
    assert_eq!(of(4.0).doubt(2.0, 50.0), None);
    assert!(of(600.0).doubt(2.0, 50.0).unwrap().contains("far more than the specimen's 50 mm"));
    assert!(of(4.0).has(Phase::Mortar) && of(4.0).has(Phase::Itz) && !of(4.0).has(Phase::Aggregate));
}
