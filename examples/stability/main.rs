//! The step at which each method must blow up, from its coefficients and from its steps:
//! `cargo run --release --example stability`.
//!
//! On the undamped oscillator the limit is of hω, on the overdamped one of h|λ| for the faster rate λ. A symplectic method of
//! fixed steps cannot know that its step is too long: what it promises holds below the limit.

mod limits;
mod systems;

use comfy_table::{Table, presets};
use limits::{Measured, limits};

fn main() -> std::process::ExitCode {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header(["method", "oscillator", "theory", "measured", "within 1 %"]);
    let mut all_agree = true;
    for limit in limits() {
        let theory = limit.theory.map_or("not public".into(), |theory| format!("{theory:.4}"));
        let measured = match limit.measured {
            Measured::Grows(h) => format!("{h:.4}"),
            Measured::Never => "no limit".into(),
            Measured::Fails(h, failure) => format!("fails from {h:.2}: {failure}"),
        };
        let agrees = limit.agrees();
        all_agree &= agrees;
        let verdict = if agrees { "yes" } else { "NO" };
        table.add_row([limit.method, limit.axis, &theory, &measured, verdict]);
    }
    println!("{table}");
    if all_agree { std::process::ExitCode::SUCCESS } else { std::process::ExitCode::FAILURE }
}
