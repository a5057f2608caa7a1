//! The page about a model: whole in itself, the same on any number of threads.

use crate::command::{Folder, assert_whole};

#[test]
fn a_report_is_one_page_that_loads_nothing() {
    let folder = Folder::with_model();
    let run = folder.run(&["report", "small.json", "-o", "page.html"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, "wrote page.html\n"));
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert_whole(&page);
    assert!(!page.contains("<img") && !page.contains("src="));
    assert_eq!(page.matches("<canvas").count(), 1);
    // Three sections, the block, three plots.
    assert_eq!(page.matches("<svg").count(), 7);
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
    assert_eq!(page.matches("<g ").count(), page.matches("</g>").count());
    for part in ["Packing of ", "6 to 9", "9 to 12", "sphericity after Wadell", "lineal path", "\"seed\": 1"] {
        assert!(page.contains(part), "the page lacks {part:?}");
    }
}

#[test]
fn the_sections_hold_the_specimens_fraction_of_aggregate() {
    let folder = Folder::with_model();
    folder.run(&["report", "small.json", "-o", "page.html"]);
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    // The outlines (class "i") of the three sections through the middle: their mean share is near the fraction, 0.3.
    let sections: Vec<&str> =
        page.split("<figure>").skip(1).filter_map(|part| part.split("</figure>").next()).collect();
    let area: f64 =
        sections.iter().flat_map(|section| section.split("class=\"i\" d=\"M").skip(1)).map(outline_area).sum();
    let share = area / (3.0 * 40.0 * 40.0);
    assert!((0.2..0.4).contains(&share), "{share}");
}

/// Area of the polygon whose coordinates `text` begins with.
fn outline_area(text: &str) -> f64 {
    let numbers: Vec<f64> = text.split('z').next().unwrap().split_whitespace().map(|n| n.parse().unwrap()).collect();
    let corners: Vec<&[f64]> = numbers.chunks(2).collect();
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
}

#[test]
fn a_report_is_the_same_on_1_and_2_threads() {
    let folder = Folder::with_model();
    let page = |threads| folder.run(&["report", "small.json", "-o", "-", "--threads", threads]).stdout;
    let one = page("1");
    assert!(one.starts_with(b"<!DOCTYPE") && one == page("2"));
}

#[test]
fn a_report_in_json_holds_the_statistics() {
    let folder = Folder::with_model();
    let run = folder.run(&["report", "small.json", "-o", "figures.json"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, "wrote figures.json\n"));
    let figures: serde_json::Value = serde_json::from_slice(&folder.read("figures.json")).unwrap();
    for part in ["classes", "shapes", "orientation", "wall_effect", "nearest_distance_mm", "correlation"] {
        assert!(!figures[part].is_null(), "{part} is missing");
    }
    let (f, s2) = (figures["fraction"].as_f64().unwrap(), figures["correlation"]["two_point"][0].as_f64().unwrap());
    assert!((s2 / f - 1.0).abs() < 0.02, "S2(0) is {s2}, f is {f}");
}

#[test]
fn a_report_is_a_page_by_name() {
    let folder = Folder::with_model();
    let run = folder.run(&["report", "small.json", "-o", "page.pdf"]);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr
            .contains("'page.pdf' for '--output <FILE>': unknown report; the extension must be one of .html, .json"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_page_lists_the_beginning_of_a_long_surface() {
    let folder = Folder::new();
    let ring = |z: f64| (0..12).map(move |k| (f64::from(k) * std::f64::consts::FRAC_PI_6, z));
    let corners: Vec<String> = ring(0.0)
        .chain(ring(40.0))
        .map(|(a, z)| format!("[{:.3}, {:.3}, {z}]", 20.0 * a.cos(), 20.0 * a.sin()))
        .collect();
    let corners = corners.join(", ");
    folder.write(
        "column.toml",
        format!("fraction = 0.2\nspecimen = {{ kind = 'polyhedron', vertices_mm = [{corners}] }}\n[grading]\nd_min_mm = 5\nd_max_mm = 9\n"),
    );
    assert_eq!(folder.run(&["pack", "column.toml", "-o", "column.json"]).code, 0);
    assert_eq!(folder.run(&["report", "column.json", "-o", "column.html"]).code, 0);
    let page = String::from_utf8(folder.read("column.html")).unwrap();
    assert!(page.contains("the first 20 are listed; the saved model has them all"));
    let (_, listed) = page.split_once("\"vertices_mm\": [").unwrap();
    let (listed, _) = listed.split_once("]\n").unwrap();
    assert_eq!(listed.matches('[').count(), 20);
    let whole = Folder::with_model();
    whole.run(&["report", "small.json", "-o", "page.html"]);
    assert!(!String::from_utf8(whole.read("page.html")).unwrap().contains("are listed"));
}
