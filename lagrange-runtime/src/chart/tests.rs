use super::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use tiny_skia::Pixmap;

fn example() -> Chart {
    Chart::new("Title", Axis::log("time", "s"), Axis::log("error", "rad"))
        .with(Series::new("RK4, h", [(1e-3, 1e-15), (0.1, f64::NAN), (0.25, -1.0), (1.0, 1e-1)]))
        .with(Series::line("", [(0.0, f64::INFINITY)]))
}

fn files(folder: &Path, stem: &str) -> [PathBuf; 3] {
    ["svg", "png", "csv"].map(|end| folder.join(format!("{stem}.{end}")))
}

#[test]
fn csv_has_every_point_with_every_digit() {
    assert_eq!(
        example().csv(),
        "series,time (s),error (rad)\n\
         \"RK4, h\",0.001,1e-15\n\
         \"RK4, h\",0.1,NaN\n\
         \"RK4, h\",0.25,-1.0\n\
         \"RK4, h\",1.0,0.1\n\
         ,0.0,inf\n"
    );
    assert_eq!(field("say \"g\""), "\"say \"\"g\"\"\"");
}

#[test]
fn svg_has_paths_and_no_text() {
    let svg = example().svg().unwrap();
    assert!(svg.contains("<path"));
    assert!(!svg.contains("M0 0M"), "points alone have no lines");
    assert!(!svg.contains("<text") && !svg.contains("font-family"));
    assert_eq!(svg, example().svg().unwrap(), "the same chart is the same file");
}

/// Names and outlines of what an SVG defines, after it was found to be well-formed and to use nothing else.
fn definitions(svg: &str) -> BTreeMap<String, String> {
    let document = roxmltree::Document::parse(svg).expect("well-formed");
    let all = || document.descendants();
    let glyphs = |node: roxmltree::Node| {
        format!("{:?}", node.children().map(|c| c.attributes().collect::<Vec<_>>()).collect::<Vec<_>>())
    };
    let outline = |node: roxmltree::Node| node.attribute("d").map_or_else(|| glyphs(node), str::to_owned);
    let named = all().filter_map(|node| Some((node.attribute("id")?.to_owned(), outline(node))));
    let named: BTreeMap<_, _> = named.collect();
    for used in all().filter_map(|node| node.attribute("href")) {
        assert!(named.contains_key(&used[1..]), "{used}");
    }
    named
}

/// Panels as large as those of the example `work_precision -- --all`: six families of six methods, 17 runs of each.
fn atlas() -> Panels {
    let curve = |method: u32| {
        (0..17).map(move |k| {
            (1e-5 * 1.5_f64.powi(k), 10_f64.powf(-0.9 * f64::from(k) - 0.01 * f64::from(method)))
        })
    };
    let panel = |family: u32| {
        let chart = Chart::new(format!("Family {family}"), Axis::log("time", "s"), Axis::log("error", ""));
        let chart = (0..36).fold(chart, |chart, method| chart.with(Series::context(curve(method))));
        let own = 6 * family..6 * family + 6;
        own.fold(chart, |chart, method| chart.with(Series::new(format!("Method {method}"), curve(method))))
    };
    Panels::new("Error against time", (0..6).map(panel)).subtitle("a motion from a start to its end")
}

#[test]
fn an_svg_is_short() {
    let (outlines, text) = (atlas().svg().unwrap(), atlas().svg_with_text().unwrap());
    assert!(outlines.len() < 250_000, "{}", outlines.len());
    assert!(text.len() < 200_000, "{}", text.len());
    for svg in [outlines, text] {
        definitions(&svg);
    }
}

#[test]
fn pictures_of_one_page_agree_on_names() {
    let panels = definitions(&atlas().svg().unwrap());
    let chart = definitions(&Chart { title: "Another <&> title".into(), ..example() }.svg().unwrap());
    let shared: Vec<_> = chart.keys().filter(|name| panels.contains_key(*name)).collect();
    assert!(shared.len() > 10, "{shared:?}");
    assert!(shared.iter().all(|name| panels[*name] == chart[*name]));
}

#[test]
fn each_outline_is_there_once() {
    let names = definitions(&atlas().svg().unwrap());
    let mut outlines: Vec<_> = names.values().collect();
    outlines.sort();
    outlines.dedup();
    assert_eq!(outlines.len(), names.len());
}

#[test]
fn png_shows_title_labels_and_legend() {
    let picture = Pixmap::decode_png(&example().png().unwrap()).unwrap();
    let (width, height) = (picture.width(), picture.height());
    let dark = |x: std::ops::Range<u32>, y: std::ops::Range<u32>| {
        let pixels = y.flat_map(|y| x.clone().map(move |x| (x, y)));
        pixels.filter(|&(x, y)| picture.pixel(x, y).is_some_and(|pixel| pixel.red() < 0x80)).count()
    };
    assert!(dark(30..140, 30..80) > 200, "title");
    assert!(dark(0..70, 100..height - 100) > 200, "caption of the vertical axis");
    assert!(dark(width / 4..width / 2, height - 80..height) > 100, "caption of the horizontal axis");
    assert!(dark(width - 150..width, 80..150) > 100, "legend");
    // Nothing touches the edge.
    assert_eq!(dark(0..width, 0..16) + dark(0..width, height - 16..height), 0);
    assert_eq!(dark(0..16, 0..height) + dark(width - 16..width, 0..height), 0);
    let corner = picture.pixel(0, 0).unwrap();
    assert_eq!((corner.red(), corner.green(), corner.blue(), corner.alpha()), (255, 255, 255, 255));
}

#[test]
fn three_files_are_written() {
    let folder = std::env::temp_dir();
    let stem = format!("lagrange-chart-{}", std::process::id());
    example().write(&folder, &stem).unwrap();
    for path in files(&folder, &stem) {
        assert!(std::fs::metadata(&path).unwrap().len() > 50, "{}", path.display());
        std::fs::remove_file(path).unwrap();
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_an_error() {
    // A file is no folder.
    let blocked = std::env::temp_dir().join(format!("lagrange-chart-blocked-{}", std::process::id()));
    std::fs::write(&blocked, "").unwrap();
    let error = example().write(&blocked, "chart").unwrap_err();
    std::fs::remove_file(&blocked).unwrap();
    assert!(matches!(&error, ChartError::Write { path, .. } if path.ends_with("chart.svg")));
    assert!(error.to_string().starts_with("cannot write"));
    assert!(std::error::Error::source(&error).is_some());
    let missing = std::env::temp_dir().join("lagrange-chart-missing");
    assert!(example().write(missing, "chart").unwrap_err().to_string().ends_with("the folder has to exist"));
}

#[test]
fn nothing_to_draw_is_an_error_and_writes_nothing() {
    let axes = || Chart::new("", Axis::log("", ""), Axis::linear("", ""));
    for chart in [
        axes(),
        axes().with(Series::new("empty", [])),
        axes().with(Series::new("not positive", [(0.0, 1.0), (-1.0, 1.0), (1.0, f64::NAN)])),
    ] {
        let stem = format!("lagrange-chart-none-{}", std::process::id());
        assert!(matches!(chart.write(std::env::temp_dir(), &stem), Err(ChartError::NoPoints)));
        assert!(files(&std::env::temp_dir(), &stem).iter().all(|path| !path.exists()));
    }
}

#[test]
fn odd_charts_are_drawn_all_the_same() {
    let axes = || Chart::new("<&>", Axis::linear("x", ""), Axis::linear("y", "")).equal_aspect();
    for chart in [
        axes().with(Series::new("one point", [(1.0, 0.0)])),
        axes().with(Series::line("flat", [(0.0, 3.0), (1e-9, 3.0)])),
        axes().with(Series::markers("many", (0..500).map(|i| (f64::from(i), f64::from(i * i % 97))))),
        axes().with(Series::new("huge", [(-1e300, 1e300), (1e300, -1e300)])),
        axes().with(Series::new("long name ".repeat(30), [(0.0, 0.0), (1.0, 1.0)])),
        Chart::new("t".repeat(300), Axis::log("x".repeat(200), ""), Axis::log("y".repeat(200), ""))
            .with(Series::new("", [(1e-300, 1e-320), (1e300, 1e300)])),
    ] {
        assert!(chart.svg().is_ok(), "{:?}", chart.series[0].name);
    }
}
