//! The page is the one of `page.html`, small, and computes in a browser what this machine computes.

use lagrange_browser::*;
use std::process::Command;

const TEMPLATE: &str = include_str!("../page.html");
const PAGE: &str = include_str!("../../../docs/gallery/browser.html");
const MARK: &str = "const wasm = \"";

#[test]
fn the_page_is_made_of_its_template() {
    let without = |text: &str| {
        let (before, rest) = text.split_once(MARK).expect("the module");
        let (module, after) = rest.split_once('"').expect("its end");
        (before.to_owned(), module.len(), after.to_owned())
    };
    let ((before, module, after), (first, _, last)) = (without(PAGE), without(TEMPLATE));
    assert!(before == first && after == last, "run examples/browser/page");
    assert!(module > 10_000 && PAGE.len() < 1_000_000, "{} bytes", PAGE.len());
}

/// The same calls as those of `test` in the page.
fn computed() -> Vec<f64> {
    pendulum_start(2.0, 2.4);
    pendulum_advance(3.0);
    top_start(0.6, -1.5, 180.0);
    top_advance(1.0);
    let landed = shots_fire(1, 64, 0.01, 0.02);
    // Functions of the interface of C are no closures.
    #[allow(clippy::redundant_closure)]
    let mut values: Vec<f64> = (0..4).map(|i| pendulum(i)).chain((0..3).map(|i| top(i))).collect();
    values.extend([f64::from(landed), shot(0), shot(63)]);
    values
}

#[test]
fn scenes_keep_their_energy_and_ranges_their_scale() {
    let values = computed();
    assert!(pendulum(4).abs() < 1e-7 && top(4).abs() < 1e-8, "{} {}", pendulum(4), top(4));
    // Without drag the shot flies 2 · 0.6 · 0.8 v²/g.
    let vacuum = 2.0 * 0.6 * 0.8 * 2500.0 / 9.81;
    assert!(values[7] == 64.0 && (0.6 * vacuum..vacuum).contains(&values[8]), "{values:?}");
    assert!(shot(64).is_nan() && pendulum(5).is_nan());
    // Without tolerances all shots are one.
    assert_eq!(shots_fire(1, 64, 0.0, 0.0), 64);
    assert_eq!(shot(0), shot(63));
}

#[test]
#[ignore = "needs a headless Chromium"]
fn a_browser_computes_the_same() {
    let page = concat!("file://", env!("CARGO_MANIFEST_DIR"), "/../../docs/gallery/browser.html");
    let options =
        ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=4000", "--dump-dom", page];
    let output = Command::new("chromium").args(options).output().expect("chromium");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let found =
        text.split_once("id=\"test\">").and_then(|(_, rest)| rest.split_once('<')).expect("its numbers").0;
    let found: Vec<f64> =
        found.trim_matches(['[', ']']).split(',').map(|x| x.parse().expect("a number")).collect();
    let expected = computed();
    assert_eq!(found.len(), expected.len());
    for (x, y) in found.iter().zip(&expected) {
        // Sines of the browser's library differ from those of this machine in the last bit.
        assert!((x - y).abs() < 1e-8 * y.abs().max(1.0), "{found:?} {expected:?}");
    }
    let range = text.split_once("id=\"shots-said\"").and_then(|(_, rest)| rest.split_once(" shots: "));
    assert!(range.is_some(), "the scenes run");
}
