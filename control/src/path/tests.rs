#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use std::f64::consts::{PI, SQRT_2};

/// A target of a circle of 40 mm, with this instead of parts of its text.
fn changed(from: &str, to: &str) -> Result<TargetPath> {
    let text = format!("{HEADER}name = \"one\"\nlaps = 2\n\n[curve]\nfamily = \"circle\"\nsize_mm = 40\n");
    assert!(text.contains(from), "{from}");
    TargetPath::from_toml(&text.replacen(from, to, 1), Path::new(""))
}

fn curve(lines: &str) -> Result<TargetPath> {
    changed("laps = 2\n\n[curve]\nfamily = \"circle\"\nsize_mm = 40\n", &format!("\n[curve]\n{lines}"))
}

/// Message of the error.
fn refusal(target: Result<TargetPath>) -> String {
    target.unwrap_err().bad_input().unwrap().to_string()
}

/// Largest extent in x and in y [m].
fn extent(target: &TargetPath) -> [f64; 2] {
    [0, 1].map(|c| {
        let values = || target.outline.points().iter().map(move |point| point[c]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    })
}

#[test]
fn sizes_are_those_of_the_paper() {
    // Polygons of 4096 sides cut off 3e-7 of a radius.
    for (named, size, length) in [
        ("circle:40", [0.040, 0.040], 0.040 * PI),
        ("diamond:60", [0.060, 0.060], 0.060 * 2.0 * SQRT_2),
        ("square:50", [0.050, 0.050], 0.2),
        // Length of the lemniscate of half width 1: 5.244115108584 (Gauss).
        ("figure_eight:60", [0.060, 0.060 / 8f64.sqrt()], 0.030 * 5.244_115_108_584),
        // 4 a E(e) with e² = 1 - 0.6², and 4 k a E with e² = 1 - 1/k²: complete elliptic integrals of the second kind.
        ("ellipse:40", [0.040, 0.024], 0.020 * 4.0 * 1.276349943170),
        ("rose:40", [0.040, 0.040], 0.020 * 8.0 * 1.211056027568),
    ] {
        let target = TargetPath::named(named).unwrap();
        for (extent, size) in extent(&target).into_iter().zip(size) {
            assert!((extent - size).abs() < 1e-6 * size, "{named} {extent}");
        }
        assert!((target.outline.length() - length).abs() < 1e-6 * length, "{named}");
        assert!(target.outline.is_closed() && target.is_planar);
    }
    let lissajous = TargetPath::named("lissajous:56").unwrap();
    let [width, height] = extent(&lissajous);
    assert!((height - 0.056).abs() < 1e-8 && (width - 0.9 * 0.056).abs() < 1e-8);
    assert_eq!(lissajous.outline.crossing().map(|at| at.map(|c| c.abs() < 1e-9)), Some([true; 2]));
    let spiral = TargetPath::named("spiral:40").unwrap();
    assert!(!spiral.outline.is_closed() && (extent(&spiral)[0] - 0.036).abs() < 0.004);
}

#[test]
fn the_tip_rests_goes_over_runs_evenly_and_comes_back() {
    let target = changed("laps = 2", "laps = 2\ncentre_mm = [5, -3]\nrotation_deg = 30").unwrap();
    let points = target.points();
    let last = points.len() - 1;
    assert_eq!((points[0], points[100], points[last]), ([0.0; 3], [0.0; 3], [0.0; 3]));
    assert_eq!(target.rest(), 0..101);
    assert_eq!(*target.curve().start(), 400);
    assert_eq!(target.time(last), 8.0 + (target.curve().end() - target.curve().start()) as f64 / 100.0);
    let start = [5e-3 + 20e-3 * (PI / 6.0).cos(), -3e-3 + 20e-3 * 0.5, 0.0];
    assert!(outline::distance(points[400], start) < 1e-12);
    assert!(outline::distance(points[*target.curve().end()], start) < 1e-9);

    // Distances on the curve: those of a circle, up to what its polygon cuts off.
    for i in target.curve() {
        let radius = outline::distance(points[i], [5e-3, -3e-3, 0.0]);
        assert!((radius - 20e-3).abs() < 20e-3 * 4e-7, "{i} {radius}");
    }
    // Speeds from sample to sample: at most the one asked for, even between the ramps, and without jumps; the
    // largest acceleration is that of a lead, π²/2 of its length (here 27 mm) over its time squared, or of a ramp.
    let speed: Vec<f64> = points.windows(2).map(|w| 100.0 * outline::distance(w[0], w[1])).collect();
    let curve = *target.curve().start()..*target.curve().end();
    let even = &speed[curve.start + 100..curve.end - 100];
    assert!(even.iter().all(|v| (v - even[0]).abs() < 1e-5 * even[0] && *v <= 10e-3), "{even:?}");
    let acceleration = (0.5 * PI * PI * 28e-3 / 9.0_f64).max(0.5 * PI * 10e-3);
    for (i, pair) in speed.windows(2).enumerate() {
        assert!((pair[1] - pair[0]).abs() <= acceleration / 100.0, "{i}: {pair:?}");
    }
}

#[test]
fn laps_divide_the_curve() {
    let target = changed("laps = 2", "laps = 3").unwrap();
    let laps: Vec<_> = target.laps().collect();
    assert_eq!(laps.len(), 3);
    assert_eq!((laps[0].start(), laps[2].end()), (target.curve().start(), target.curve().end()));
    // A lap begins with its first sample: less than a sample, 0.1 mm, after the start of the curve.
    for pair in laps.windows(2) {
        assert_eq!(pair[0].end(), pair[1].start());
        let away = outline::distance(target.points()[*pair[1].start()], target.outline.at(0.0));
        assert!(away <= 0.1e-3, "{away}");
    }
}

#[test]
fn direction_and_points_are_kept() {
    let there = changed("laps = 2", "").unwrap();
    let back = changed("laps = 2", "direction = \"clockwise\"").unwrap();
    let quarter = |target: &TargetPath| target.outline.at(0.25 * target.outline.length());
    assert!((quarter(&there)[1] - 0.02).abs() < 1e-9 && (quarter(&back)[1] + 0.02).abs() < 1e-9);
    assert_ne!(there.hash, back.hash);

    let solid = curve("family = \"polyline\"\npoints_mm = [[0, 0, 0], [10, 0, -1], [10, 10, -2]]\n").unwrap();
    assert!(!solid.is_planar && !solid.outline.is_closed());
    assert_eq!(solid.outline.points()[2], [10e-3, 10e-3, -2e-3]);
    assert!(solid.recording().unwrap().tip().is_some());
    let closed = curve("family = \"polyline\"\npoints_mm = [[0, 0], [10, 0], [10, 10], [0, 0]]\n").unwrap();
    assert!(closed.outline.is_closed() && closed.is_planar);
}

#[test]
fn a_recording_gives_the_target_back() {
    let target = changed("laps = 2", "laps = 2\ncentre_mm = [5, -3]").unwrap();
    let recording = target.recording().unwrap();
    assert_eq!(recording.channels().len(), 2);
    let folder = tempfile::tempdir().unwrap();
    for name in ["target.csv", "target.parquet"] {
        let path = folder.path().join(name);
        recording.write(&path).unwrap();
        let back = TargetPath::open(path.to_str().unwrap()).unwrap();
        assert_eq!(back.points(), target.points());
        assert_eq!((back.laps().collect::<Vec<_>>(), &back.hash), (target.laps().collect(), &target.hash));
        // Its outline is that of samples 0.1 mm apart: a circle's length less (spacing / r)² / 24.
        assert!((back.outline.length() / target.outline.length() - 1.0).abs() < 2e-6);
    }
    let plain = Recording::new(vec![0.0, 1.0], vec![], vec![], Metadata::default()).unwrap();
    assert!(TargetPath::from_recording(&plain).unwrap_err().expected.contains("tip_x_m"));
}

#[test]
fn what_cannot_be_a_target_is_refused() {
    for (from, to, part) in [
        ("hysteron-target", "hysteron-plan", "format: expected \"hysteron-target\""),
        ("version = 1", "version = 2", "version: expected 1"),
        ("rate_hz = 100", "rate_hz = 0", "rate_hz"),
        ("size_mm = 40", "size_mm = -40", "curve.size_mm: expected a number from"),
        ("size_mm = 40", "size_m = 40", "curve.size_m"),
        ("size_mm = 40", "", "curve.size_mm: expected this key for circle"),
        ("size_mm = 40", "size_mm = 40\nturns = 2", "curve.turns: expected no such key for circle"),
        ("size_mm = 40", "size_mm = 1e300", "curve.size_mm: expected a number from"),
        ("speed_mm_s = 10", "speed_mm_s = 200", "speed_mm_s: expected at most 125.66"),
        ("speed_mm_s = 10", "speed_mm_s = 1e-9", "speed_mm_s"),
        ("ramp_s = 1", "ramp_s = 26", "ramp_s: expected at most 25.13"),
        ("ramp_s = 1", "ramp_s = 0", "ramp_s"),
        ("lead_in_s = 3", "lead_in_s = 0.05", "lead_in_s"),
        ("rest_s = 1", "rest_s = -1", "rest_s"),
        ("rest_s = 1", "rest_s = 1e5", "target: expected fewer than"),
        ("laps = 2", "laps = 0", "laps"),
        ("laps = 2", "centre_mm = [1, 2, 3]", "centre_mm: expected [x, y]"),
        ("name = \"one\"", "", "name: expected this key"),
    ] {
        let message = refusal(changed(from, to));
        assert!(message.contains(part), "{part} in {message}");
    }
    for (lines, part) in [
        ("family = \"polyline\"\npoints_mm = [[0, 0], [1, 0]]", "at least three"),
        ("family = \"polyline\"\npoints_mm = [[0, 0], [1, 0, 2], [1, 1]]", "points_mm[1]"),
        (
            "family = \"polyline\"\npoints_mm = [[0, 0], [9, 9], [9, 0], [0, 9]]",
            "crossing at (4.50, 4.50) mm",
        ),
        ("family = \"lissajous\"\nsize_mm = 9\nwidth_mm = 9\ncycles = [2, 4]\nphase_deg = 0", "curve.cycles"),
        ("family = \"spiral\"\nsize_mm = 9\nturns = 101", "curve.turns"),
        ("family = \"ellipse\"\nsize_mm = 9\naspect = 1.1", "curve.aspect"),
        ("family = \"ellipse\"\nsize_mm = 9", "curve.aspect"),
        ("family = \"rose\"\nsize_mm = 9\nk = 1", "curve.k"),
        ("family = \"circle\"\nsize_mm = 9\nk = 2", "curve.k"),
        ("family = \"outline\"\nfile = \"a.png\"", "curve.file"),
        ("family = \"outline\"\nfile = \"none.csv\"", "nothing there"),
    ] {
        let message = refusal(curve(lines));
        assert!(message.contains(part), "{part} in {message}");
    }
    let crossing = "family = \"polyline\"\npoints_mm = [[0, 0], [9, 9], [9, 0], [0, 9]]\nmay_cross = true";
    assert!(curve(crossing).is_ok());
    let message = refusal(changed("[curve]\nfamily = \"circle\"", "[curve]\nfamily = \"spiral\"\nturns = 3"));
    assert!(message.contains("laps: expected 1 for an open curve"), "{message}");
    for named in ["circle", "circle:", "oval:40", "circle:forty", "target.json"] {
        assert!(refusal(TargetPath::open(named)).contains("circle:SIZE"), "{named}");
    }
    assert!(refusal(TargetPath::open("circle:-1")).contains("target circle:-1: curve.size_mm"));
}

/// The outline in a drawing, through its file.
fn drawing(ending: &str, text: &str) -> Result<TargetPath> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("mine.{ending}"));
    std::fs::write(&path, text).unwrap();
    TargetPath::open(path.to_str().unwrap())
}

#[test]
fn outlines_come_as_csv() {
    let target = drawing("csv", "# a triangle\nx_mm,y_mm\n0,0\n30,0\n0,40\n0,0\n").unwrap();
    assert_eq!(target.outline.points().len(), 4);
    assert!((target.outline.length() - 0.12).abs() < 1e-15 && target.outline.is_closed());
    assert_eq!((target.name.as_str(), target.family.as_str()), ("mine", "outline"));
    let solid = drawing("csv", "y_m,x_m,z_mm\n0,0,1\n0.03,0,1\n0,0.04,1\n").unwrap();
    assert_eq!(solid.outline.points()[1], [0.0, 0.03, 1e-3]);
    assert!(!solid.is_planar && !solid.outline.is_closed());
    for (text, part) in [
        ("x,y\n0,0\n1,0\n1,1\n", "header: expected x, y and perhaps z with their unit"),
        ("x_mm,y_s\n0,0\n", "header"),
        ("x_mm\n0\n", "header"),
        ("x_mm,x_m\n0,0\n", "header"),
        ("x_mm,y_mm\n0,0\n1,no\n", "line 3: expected a finite number"),
        ("x_mm,y_mm\n0,0\n1\n", "line 3: expected CSV"),
        ("x_mm,y_mm\n0,0\n1,0\n", "at least three"),
    ] {
        let message = refusal(drawing("csv", text));
        assert!(message.contains(part), "{part} in {message}");
    }
}

fn svg(head: &str, body: &str) -> Result<TargetPath> {
    drawing("svg", &format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {head}>{body}</svg>"))
}

const PAGE: &str = "width=\"100mm\" height=\"50mm\" viewBox=\"0 0 200 100\""; // a unit is half a millimetre

#[test]
fn every_shape_of_a_drawing_has_its_length_in_millimetres() {
    let arc = "M 40 0 A 40 40 0 1 1 -40 0 A 40 40 0 1 1 40 0 Z";
    for (body, length) in [
        ("<path d=\"M0 0 L60 0 H60 V80 Z\"/>".to_owned(), 120e-3),
        ("<path d=\"m0 0 60 0 0 80z\"/>".to_owned(), 120e-3),
        (format!("<path d=\"{arc}\"/>"), 40e-3 * PI),
        ("<path d=\"M0 0 Q50 0 100 0 T 200 0 L200 100 L0 100 Z\"/>".to_owned(), 300e-3),
        ("<path d=\"M0 0 C50 0 50 0 100 0 S150 0 200 0 L200 100 L0 100 Z\"/>".to_owned(), 300e-3),
        ("<polygon points=\"0,0 60,0 60,80\"/>".to_owned(), 120e-3),
        ("<polyline points=\"0,0 60,0 60,80\"/>".to_owned(), 70e-3),
        ("<circle cx=\"9\" r=\"40\"/>".to_owned(), 40e-3 * PI),
        ("<ellipse rx=\"40\" ry=\"40\"/>".to_owned(), 40e-3 * PI),
        ("<rect width=\"60\" height=\"80\"/>".to_owned(), 140e-3),
        ("<g transform=\"translate(3 4) scale(2)\"><rect transform=\"rotate(30)\" width=\"30\" height=\"40\"/></g>"
            .to_owned(), 140e-3),
    ] {
        let target = svg(PAGE, &body).unwrap();
        // Four Bézier curves for an arc's turn leave a circle by 2.7e-4 of its radius, lines by a micrometre more.
        let error = (target.outline.length() - length).abs() / length;
        assert!(error < 3.2e-4, "{body}: {}", target.outline.length());
        assert_eq!(target.outline.is_closed(), !body.contains("polyline"), "{body}");
        // Its bounding box is centred.
        let (min, max) = target.outline.points().iter().fold(([1.0; 2], [-1.0; 2]), |(min, max), p| {
            ([0, 1].map(|c| f64::min(min[c], p[c])), [0, 1].map(|c| f64::max(max[c], p[c])))
        });
        assert!((0..2).all(|c| (min[c] + max[c]).abs() < 2e-6), "{body}: {min:?} {max:?}");
    }
    // y points up.
    let up = svg(PAGE, "<polyline points=\"0,0 60,0 60,80\"/>").unwrap();
    assert!(up.outline.points()[2][1] < up.outline.points()[0][1]);
    // Without view box a unit is a CSS pixel.
    let pixels = svg("width=\"100mm\"", "<rect width=\"96\" height=\"96\"/>").unwrap();
    assert!((pixels.outline.length() - 4.0 * 25.4e-3).abs() < 1e-9);
}

#[test]
fn drawings_without_size_or_without_one_outline_are_refused() {
    let circle = "<circle r=\"40\"/>";
    for (head, body, part) in [
        ("viewBox=\"0 0 200 100\"", circle, "SVG: width: expected the width of the drawing in mm"),
        ("width=\"200\"", circle, "got 200"),
        ("width=\"100%\"", circle, "got 100%"),
        ("width=\"100mm\" height=\"90mm\" viewBox=\"0 0 200 100\"", circle, "one scale"),
        ("width=\"-1mm\"", circle, "a length from 0"),
        (PAGE, "", "one shape, got 0"),
        (PAGE, "<circle r=\"4\"/><rect/>", "one shape, got 2"),
        (PAGE, "<defs><circle r=\"4\"/></defs>", "one shape, got 0"),
        (PAGE, "<line x2=\"4\"/>", "<line>"),
        (PAGE, "<path d=\"M0 0 L1 0 L1 1 Z M5 5 L6 5 L6 6 Z\"/>", "a single subpath, got 2 subpaths"),
        (PAGE, "<path d=\"M0 0 X\"/>", "SVG: path.d"),
        (PAGE, "<circle r=\"4mm\"/>", "SVG: circle.r"),
        (PAGE, "<polygon points=\"0,0 9,9 9,0 0,9\"/>", "does not cross itself"),
        (PAGE, "<circle r=\"0\"/>", "at least three"),
        (PAGE, "<g>", "well-formed"),
    ] {
        let message = refusal(svg(head, body));
        assert!(message.contains(part), "{part} in {message}");
    }
}
