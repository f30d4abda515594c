//! The documentation of a generated type: its Lagrangian, its equations of motion, and the facts found.

use super::attitudes::turned_name;
use super::mathml::{Writer, identifier, velocity};
use crate::equations::constraints::{ConstraintKind, Redundancy, Rows};
use crate::equations::restriction::invariant;
use crate::equations::scaling::Scalings;
use crate::equations::solve::entry;
use crate::equations::symmetry::CommonSymmetry;
use crate::equations::{Derived, Equations};
use crate::graph::normal::EXPANSIONS;
use crate::graph::{Graph, Number, Symbol, Value};
use crate::model::submodel::{Made, Origin};
use crate::model::{Attitude, Coordinate, Model, NamedEvent, Reduction, indexed};
use crate::program::count::Operations;
use crate::syntax::{Direction, Kind};
use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use std::borrow::Cow;
use std::ffi::OsString;
use std::path::PathBuf;

/// Systems of more coordinates show no equations, which nobody reads, and L as it was written.
const MAX_SHOWN_COORDINATES: usize = 6;

/// Values in the forms in which they are shown.
struct Shown {
    lagrangian: Value,
    /// M q̈ − right − Aᵀ λ, of few coordinates.
    residuals: Vec<Value>,
    /// Velocities of the coordinates that were removed.
    velocities: Vec<Value>,
    constraints: Vec<Value>,
    reactions: Vec<Value>,
    events: Vec<Value>,
}

/// Returns whether anybody reads the documentation that this program compiles: rustdoc and editors show it, rustc and
/// Clippy do not.
///
/// Multiplying out L and the residuals is 3 % of the instructions of the macro for one link, 10 % for two and 29 %
/// for six (docs/lab/performance.md).
fn is_read(program: Option<OsString>) -> bool {
    let name = program.map(PathBuf::from);
    !name.is_some_and(|path| path.file_stem().is_some_and(|name| name == "rustc" || name == "clippy-driver"))
}

/// Lines, each a doc attribute.
pub fn documentation(d: &Derived) -> Vec<String> {
    if !is_read(std::env::args_os().next()) {
        return vec!["The Lagrangian, the equations of motion and the facts are in the documentation that `cargo doc` makes.".into()];
    }
    let model = &d.model;
    // Multiplied-out forms are nodes of a graph of their own.
    let mut graph = Cow::Borrowed(&d.graph);
    let shown = shown(&mut graph, d);
    let writer = Writer::new(&graph, model);
    let (title, letter) = match model.reduction {
        None => ("# Lagrangian", "<mi>L</mi>"),
        Some(_) => ("# Routhian", "<mi>R</mi>"),
    };
    let mut lines = reduction(model, &shown.velocities, &writer);
    lines.extend(restriction(d, &writer));
    lines.extend([String::new(), title.into(), String::new()]);
    let printed = writer.equation(letter, shown.lagrangian);
    let short = printed.is_some() && shown.residuals.iter().all(|r| writer.vanishing(*r).is_some());
    if model.framed || printed.is_none() {
        lines.extend(written(model));
    }
    lines.extend(printed);
    lines.extend([String::new(), "# Equations of motion".into(), String::new()]);
    let residuals = if short || !model.framed { &shown.residuals[..] } else { &[] };
    if residuals.is_empty() {
        let (reaction, function) = match d.model.constraints.is_empty() {
            true => ("", ""),
            false => (" + Aᵀ λ", ", A of `constraint_jacobian` and λ of `multipliers`"),
        };
        lines.push(format!(
            "The equations are too long to print. They are M q̈ + b = f{reaction}, with M of the function `inertia`, b of \
             `convective_momentum_rate`, f of `momentum_rate`{function}."
        ));
    }
    for residual in residuals {
        lines.push(writer.vanishing(*residual).unwrap_or_else(|| TOO_LONG.into()));
        lines.push(String::new());
    }
    lines.extend(constraints(d, &shown, &writer));
    lines.extend([String::new(), "# Facts".into(), String::new()]);
    lines.extend(facts(d, &writer));
    lines.extend(usage(model));
    lines.extend(states(model));
    lines.extend(inputs(model));
    lines.extend(events(model, &shown.events, &writer));
    lines
}

fn shown(g: &mut Cow<Graph>, d: &Derived) -> Shown {
    let Derived { model, equations: e, .. } = d;
    let few = model.coordinates.len() <= MAX_SHOWN_COORDINATES;
    let all = |g: &mut Cow<Graph>, values: &[Value]| -> Vec<Value> {
        values.iter().map(|v| if few { readable(g.to_mut(), model, *v) } else { *v }).collect()
    };
    let lagrangian = all(g, &[e.formed.lagrangian])[0];
    let residuals = if few { residuals(g.to_mut(), e) } else { Vec::new() };
    let residuals = all(g, &residuals);
    let velocities = model.reduction.iter().flat_map(|r| r.removed.iter().map(|removed| removed.velocity));
    let velocities = all(g, &velocities.collect::<Vec<_>>());
    let Rows { kinds, values, rates, .. } = &e.formed.rows;
    let written =
        (0..kinds.len()).map(|j| if kinds[j] == ConstraintKind::Holonomic { values[j] } else { rates[j] });
    let constraints = all(g, &written.collect::<Vec<_>>());
    let reactions = all(g, &e.solved.relaxed);
    let events = all(g, &e.events.iter().flatten().map(|f| f.value).collect::<Vec<_>>());
    Shown { lagrangian, residuals, velocities, constraints, reactions, events }
}

/// Bindings and energies as they were written, and what stands for equations of frames that nobody would read.
fn written(model: &Model) -> Vec<String> {
    if model.written.is_empty() {
        return vec![TOO_LONG.into()];
    }
    let what = match (model.framed, &model.energies) {
        (true, _) => "Frames and bodies as they were written, with L = T − V:",
        (false, Some(_)) => "Energies as they were written, with L = T − V:",
        (false, None) => "L as it was written:",
    };
    let mut lines = vec![what.into(), String::new(), "```text".into()];
    lines.extend(model.written.iter().map(|(left, right)| format!("{left} = {};", spaced(right.clone()))));
    lines.extend(["```".into(), String::new()]);
    if model.framed {
        lines.push(
            "Each frame in space moves with the velocity v of its origin and the angular velocity ω in its own axes. The \
             equations were formed for these (Euler–Poincaré) and then carried to the coordinates."
                .into(),
        );
        lines.push(String::new());
    }
    lines
}

/// Tokens with spaces where a person would put them.
fn spaced(tokens: TokenStream) -> String {
    let mut text = String::new();
    // What stands before: nothing to the left of it, an operand, or something that stays with what follows.
    let (mut operand, mut joined, mut closure) = (false, true, false);
    for token in tokens {
        let after_operand = operand;
        match &token {
            TokenTree::Group(group) => {
                let inner = spaced(group.stream());
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Brace => ("{ ", " }"),
                    Delimiter::None => ("", ""),
                };
                let call = after_operand && matches!(open, "(" | "[");
                if !(joined || call) {
                    text.push(' ');
                }
                text.push_str(&format!("{open}{inner}{close}"));
                (operand, joined) = (true, false);
            }
            TokenTree::Punct(p) => {
                let sign = p.as_char();
                let bar = sign == '|';
                let prefix = !after_operand && matches!(sign, '-' | '!' | '*' | '&') || bar && !closure;
                let tight = matches!(sign, ',' | ';' | '.' | ':' | '?') || bar && closure;
                if !joined && !tight {
                    text.push(' ');
                }
                text.push(sign);
                closure ^= bar;
                joined = prefix || matches!(sign, '.' | ':') || p.spacing() == Spacing::Joint;
                operand = false;
            }
            TokenTree::Ident(_) | TokenTree::Literal(_) => {
                if !joined {
                    text.push(' ');
                }
                let word = token.to_string();
                operand = !matches!(word.as_str(), "if" | "else" | "let" | "in");
                text.push_str(&word);
                joined = false;
            }
        }
    }
    text
}

/// Documentation of a reduced system: what was removed, and how it moves.
fn reduction(model: &Model, velocities: &[Value], writer: &Writer) -> Vec<String> {
    let Some(Reduction { of, removed, .. }) = &model.reduction else { return Vec::new() };
    let labels: Vec<String> = removed.iter().map(|r| format!("`{}`", r.label)).collect();
    let momenta: Vec<String> = removed.iter().map(|r| format!("`{}`", r.momentum)).collect();
    let s = if removed.len() == 1 { "" } else { "s" };
    let mut lines = vec![
        String::new(),
        format!(
            "[`{of}`] without the ignorable coordinate{s} {}: the Routhian R = L − Σ pᵢ q̇ᵢ with the constant \
             moment{} {} is its Lagrangian. The velocit{} that {} removed:",
            labels.join(", "),
            if removed.len() == 1 { "um" } else { "a" },
            momenta.join(", "),
            if removed.len() == 1 { "y" } else { "ies" },
            if removed.len() == 1 { "was" } else { "were" },
        ),
    ];
    for (r, value) in removed.iter().zip(velocities) {
        let left = velocity(&r.label);
        let equation = writer.equation(&left, *value).unwrap_or_else(|| TOO_LONG.into());
        lines.extend([String::new(), equation]);
    }
    lines
}

/// Documentation of a restricted or simplified system: where coordinates are held, and what was left out.
fn restriction(d: &Derived, writer: &Writer) -> Vec<String> {
    let Some(Origin { of, exact, held, moves, .. }) = &d.model.origin else { return Vec::new() };
    let inline = |value: Value| writer.inline(value).unwrap_or_else(|| TOO_LONG.into());
    let places = held.iter().zip(&d.equations.quantities.held[0]);
    let places: Vec<String> =
        places.map(|(held, value)| format!("`{}` = {}", held.label, inline(*value))).collect();
    let at = if places.is_empty() { String::new() } else { format!(" at {}", places.join(", ")) };
    if *exact {
        let text = format!(
            "[`{of}`]{at}. This system is exact: a motion that starts there is proved to stay there."
        );
        return vec![String::new(), text];
    }
    let mut lines = vec![
        String::new(),
        format!(
            "[`{of}`]{at}, simplified. The error of this system grows with the terms that these moves leave out:"
        ),
        String::new(),
    ];
    lines.extend(moves.iter().map(|Made { words, remainders }| {
        let terms: Vec<String> =
            remainders.iter().map(|(letter, value)| format!("{} of {letter}", inline(*value))).collect();
        let without = match (terms.is_empty(), words.starts_with("expand")) {
            (true, _) => String::new(),
            (false, true) => format!(", without terms that begin with {}", terms.join(", ")),
            (false, false) => format!(", without {}", terms.join(", ")),
        };
        format!("- `{words}`{without}")
    }));
    lines
}

/// The value as it is or multiplied out, whichever is shortest in print.
fn readable(g: &mut Graph, model: &Model, value: Value) -> Value {
    let expanded = EXPANSIONS.map(|how| g.expanded(&[value], MAX_SHOWN_TERMS, how));
    let writer = Writer::new(g, model);
    let forms = expanded.into_iter().flatten().map(|v| v[0]);
    forms.fold(value, |best, form| if writer.length(form) < writer.length(best) { form } else { best })
}

/// Multiplied-out formulas of more terms are not shown.
const MAX_SHOWN_TERMS: usize = 40;

const TOO_LONG: &str = "Too long to print.";

/// M q̈ − right − Aᵀ λ.
fn residuals(g: &mut Graph, e: &Equations) -> Vec<Value> {
    let n = e.solved.accel.len();
    let a: Vec<Value> = (0..n).map(|i| g.symbol(Symbol::Acceleration(i))).collect();
    (0..n)
        .map(|i| {
            let mut sum = Value::ZERO;
            for (j, a) in a.iter().enumerate() {
                let term = g.mul(entry(&e.solved.inertia, i, j), *a);
                sum = g.add(sum, term);
            }
            let mut residual = g.sub(sum, e.solved.right[i]);
            for (j, row) in e.formed.rows.jacobian.iter().enumerate() {
                let multiplier = g.symbol(Symbol::Multiplier(j));
                let force = g.mul(row[i], multiplier);
                residual = g.sub(residual, force);
            }
            residual
        })
        .collect()
}

/// The constraints with their multipliers, and the reactions at prescribed coordinates.
fn constraints(d: &Derived, shown: &Shown, writer: &Writer) -> Vec<String> {
    let mut lines = Vec::new();
    if !shown.constraints.is_empty() {
        lines.extend([String::new(), "# Constraints".into(), String::new()]);
    }
    for (j, (constraint, kind)) in d.model.constraints.iter().zip(&d.equations.formed.rows.kinds).enumerate()
    {
        let kind = match kind {
            ConstraintKind::Holonomic => "holonomic",
            ConstraintKind::Integrable => "on velocities, integrable: holonomic but for a constant",
            ConstraintKind::Nonholonomic => "on velocities, nonholonomic",
        };
        let label = constraint.label();
        lines.push(format!("`{label}`, {kind}, with the multiplier {}:", writer.multiplier(j)));
        lines.push(String::new());
        lines.push(writer.vanishing(shown.constraints[j]).unwrap_or_else(|| TOO_LONG.into()));
        lines.push(String::new());
    }
    if let Some(redundancy) = &d.equations.formed.rows.redundancy {
        lines.push(format!(
            "Redundant: {}. Multipliers are those of least norm; the accelerations do not depend on this choice, and reactions of single joints do.",
            redundancy.sentence(&d.model)
        ));
        lines.push(String::new());
    }
    if !shown.reactions.is_empty() {
        lines.extend([String::new(), "# Reactions".into(), String::new()]);
    }
    for (prescribed, reaction) in d.model.prescribed.iter().zip(&shown.reactions) {
        let label = format!("<msub><mi>R</mi>{}</msub>", identifier(&prescribed.name));
        lines.push(writer.equation(&label, *reaction).unwrap_or_else(|| TOO_LONG.into()));
        lines.push(String::new());
    }
    lines
}

fn facts(d: &Derived, writer: &Writer) -> Vec<String> {
    let Derived { model, equations: e, .. } = d;
    let (f, n, m) = (&e.facts, model.mechanical(), model.constraints.len());
    let listed = |indices: &[usize]| -> String {
        indices.iter().map(|i| writer.coordinate(*i)).collect::<Vec<_>>().join(", ")
    };
    let mut lines = Vec::new();
    let all: Vec<usize> = (0..n).collect();
    let names = if n <= 12 { listed(&all) } else { String::new() };
    let coordinates = match (m, n <= 12) {
        (0, true) => format!(" ({names})"),
        (0, false) => String::new(),
        (_, true) => format!(" ({n} coordinates: {names}; constraints: {m})"),
        (_, false) => format!(" ({n} coordinates; constraints: {m})"),
    };
    let freedoms = match &e.formed.rows.redundancy {
        None => (n - m).to_string(),
        Some(Redundancy { rank: Some(rank), .. }) => (n - rank).to_string(),
        Some(_) => "by the rank of the constraints at run time".into(),
    };
    lines.push(format!("- Degrees of freedom: {freedoms}{coordinates}."));
    lines.push(match f.scleronomic {
        true => "- Scleronomic: time does not enter the kinematics.".into(),
        false => "- Rheonomic: time enters the kinematics.".into(),
    });
    lines.push(match (f.conservative, f.scleronomic && model.energies.is_some()) {
        (true, true) => "- Conservative: the energy E = T + V is constant.".into(),
        (true, false) => "- Conservative: the energy function h = p·q̇ − L is constant.".into(),
        (false, _) => "- Not conservative: h = p·q̇ − L changes.".into(),
    });
    for &i in &f.ignorable {
        let label = identifier(&model.coordinates[i].label());
        let momentum = writer.inline(e.quantities.momenta[i]).map_or(String::new(), |p| format!(" = {p}"));
        lines.push(format!(
            "- Ignorable: {}; its momentum <math><msub><mi>p</mi>{label}</msub></math>{momentum} is constant.",
            writer.coordinate(i)
        ));
    }
    for attitude in &model.attitudes {
        let of = indexed(&attitude.name.to_string(), attitude.index);
        let constant = conserved(d, attitude);
        if !constant.is_empty() {
            lines.push(format!("- Angular momentum of `{of}`: {constant}."));
        }
    }
    if !e.symmetries.common.is_empty() {
        lines.push(format!("- Constant angular momenta of parts that turn together: {}.", common(d)));
    }
    if n <= MAX_SHOWN_COORDINATES && n > 1 {
        for i in invariant(d) {
            lines.push(format!(
                "- Invariant: {} = 0, where it stays once it rests there.",
                writer.coordinate(i)
            ));
        }
    }
    lines.extend(properties(e));
    if f.blocks.len() > 1 && n <= 12 {
        let blocks: Vec<String> = f.blocks.iter().map(|block| format!("{{{}}}", listed(block))).collect();
        lines.push(format!("- Independent blocks: {}.", blocks.join(", ")));
    }
    if f.cascade.len() > f.blocks.len() && n <= 12 {
        let groups: Vec<String> = f.cascade.iter().map(|group| format!("{{{}}}", listed(group))).collect();
        lines.push(format!(
            "- One-way coupling: {}, each driven by those before it at most.",
            groups.join(", ")
        ));
    }
    lines.extend(scales(d));
    let counts = counts(&e.solved.operations);
    lines.push(format!("- Operations of `accel`: {counts}."));
    lines
}

/// Properties of the equations that are proved, as items of a list.
fn properties(e: &Equations) -> impl Iterator<Item = String> {
    let f = &e.facts;
    let roots = e.series.as_ref().is_some_and(|series| series.has_roots);
    [
        (f.constant_inertia, "the inertia matrix is constant"),
        (f.separable, "separable, T(q̇) + V(q)"),
        (f.linear, "linear equations of motion with constant coefficients"),
        (e.analytic() && !roots, "analytic: the motion has Taylor series"),
        (
            e.analytic() && roots,
            "analytic, but where the argument of a root vanishes: the motion has Taylor series elsewhere",
        ),
        (!f.autonomous, "time appears in the equations of motion"),
        (!f.quadratic, "L is not quadratic in the velocities"),
    ]
    .into_iter()
    .filter(|p| p.0)
    .map(|(_, text)| {
        let mut text = text.to_string();
        text[..1].make_ascii_uppercase();
        format!("- {text}.")
    })
}

fn counts(o: &Operations) -> String {
    let counts = [
        (o.additions, "addition"),
        (o.multiplications, "multiplication"),
        (o.divisions, "division"),
        (o.sin_cos, "sine–cosine pair"),
        (o.functions, "other function"),
    ];
    let counts: Vec<String> = counts
        .iter()
        .filter(|c| c.0 > 0)
        .map(|(n, what)| format!("{n} {what}{}", if *n == 1 { "" } else { "s" }))
        .collect();
    if counts.is_empty() { "none".into() } else { counts.join(", ") }
}

/// Groups of parameters, units that they give, and scalings of motions.
fn scales(d: &Derived) -> Vec<String> {
    let Derived { model, equations: Equations { scalings, .. }, .. } = d;
    let Some(Scalings { groups, units, similar }) = scalings else { return Vec::new() };
    let labels = model.parameter_labels();
    let mut lines = Vec::new();
    if groups.len() <= MAX_SHOWN_GROUPS && !groups.is_empty() {
        let groups: Vec<String> =
            groups.iter().map(|group| format!("`{}`", powers(&labels, group))).collect();
        lines.push(format!("- Dimensionless groups of parameters: {}.", groups.join(", ")));
    }
    if groups.len() > MAX_SHOWN_GROUPS {
        lines.push(format!("- Dimensionless groups of parameters: {} of {}.", groups.len(), labels.len()));
    }
    let shown = units.iter().take(1 + MAX_SHOWN_COORDINATES).enumerate();
    let variables: Vec<String> = shown
        .filter_map(|(i, unit)| {
            let unit = unit.as_ref().filter(|unit| !unit.is_empty())?;
            let variable = if i == 0 { "t".into() } else { model.coordinates[i - 1].label() };
            Some(format!("`{}`", over(&labels, variable, unit)))
        })
        .collect();
    if !variables.is_empty() {
        lines.push(format!("- Dimensionless variables: {}.", variables.join(", ")));
    }
    if similar.len() <= MAX_SHOWN_GROUPS && model.coordinates.len() <= MAX_SHOWN_COORDINATES {
        lines.extend(similar.iter().map(|exponents| {
            let names = ["t".into()].into_iter().chain(model.coordinates.iter().map(Coordinate::label));
            let scaled = names.zip(exponents).filter(|(_, k)| !k.is_zero());
            let scaled: Vec<String> = scaled.map(|(name, k)| format!("`{name}` × λ{}", power(*k))).collect();
            format!("- Similar motions, for each λ > 0: {}.", scaled.join(", "))
        }));
    }
    lines
}

/// More groups, or similarities, are counted and not shown.
const MAX_SHOWN_GROUPS: usize = 8;

/// A variable over its unit: `t √(g / l)`, `r / l`.
fn over(labels: &[String], variable: String, unit: &[(usize, Number)]) -> String {
    let inverse = |k: i64| unit.iter().map(|(i, x)| (*i, x.mul((-k).into()))).collect::<Vec<_>>();
    let is_whole = |k: i64| inverse(k).iter().all(|(_, x)| x.integer().is_some());
    if !is_whole(1) && is_whole(2) {
        return match &inverse(2)[..] {
            [(i, Number::ONE)] => format!("{variable} √{}", labels[*i]),
            square => format!("{variable} √({})", powers(labels, square)),
        };
    }
    let all = [&[(labels.len(), Number::ONE)], &inverse(1)[..]].concat();
    powers(&[labels, &[variable]].concat(), &all)
}

/// `k l² / (m g)`
fn powers(labels: &[String], monomial: &[(usize, Number)]) -> String {
    let side = |above: bool| -> Vec<String> {
        let factors = monomial.iter().filter(|(_, k)| k.is_negative() != above);
        factors.map(|(i, k)| format!("{}{}", labels[*i], power(k.abs()))).collect()
    };
    let (above, below) = (side(true), side(false));
    let numerator = if above.is_empty() { "1".into() } else { above.join(" ") };
    match &below[..] {
        [] => numerator,
        [one] => format!("{numerator} / {one}"),
        all => format!("{numerator} / ({})", all.join(" ")),
    }
}

/// The exponent, as it is written.
fn power(k: Number) -> String {
    match k {
        Number::ONE => String::new(),
        Number::Ratio(n, 1) => superscript(n),
        Number::Ratio(n, d) => format!("^({n}/{d})"),
        Number::Float(..) => format!("^{}", k.to_f64()),
    }
}

fn superscript(n: i64) -> String {
    let digit = |c: char| match c.to_digit(10) {
        None => '⁻',
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
    };
    n.to_string().chars().map(digit).collect()
}

/// The coordinates in their order, with their units; of many, those of one name by the first and the last.
fn usage(model: &Model) -> Vec<String> {
    let mut runs: Vec<(&Coordinate, &Coordinate)> = Vec::new();
    for c in &model.coordinates {
        match runs.last_mut() {
            Some((first, last)) if model.coordinates.len() > 12 && first.name == c.name => *last = c,
            _ => runs.push((c, c)),
        }
    }
    let run = |(first, last): &(&Coordinate, &Coordinate)| match (first.label(), last.label()) {
        (first, last) if first == last => format!("`{first}`"),
        (first, last) => format!("`{first}` to `{last}`"),
    };
    let unit = |kind: Kind| match kind {
        Kind::Angle => " (rad)",
        Kind::Length => " (m)",
        Kind::Rotation => " (parameters without unit)",
        Kind::Direction => " (components without unit)",
        Kind::Plain | Kind::State => "",
    };
    let alike: Vec<String> = runs
        .chunk_by(|a, b| a.0.kind == b.0.kind)
        .map(|runs| runs.iter().map(run).collect::<Vec<_>>().join(", ") + unit(runs[0].0.kind))
        .collect();
    let multipliers = match model.constraints.is_empty() {
        true => "",
        false => ", a multiplier in J per unit of its constraint, or in W per unit of one on velocities",
    };
    vec![
        String::new(),
        format!("The order of coordinates in every vector is {}.", alike.join(", ")),
        String::new(),
        format!(
            "Units are those of the SI, unless the definition is written in others: t in s, energies in J, a velocity in the \
             unit of its coordinate per s, a generalized force in J per unit of its coordinate (N of a length, N m of an \
             angle), a momentum in J s per unit of its coordinate{multipliers}."
        ),
    ]
}

/// The states of first order, if there are any.
fn states(model: &Model) -> Vec<String> {
    let labels = model.coordinates[model.mechanical()..].iter().map(|c| format!("`{}`", c.label()));
    let labels: Vec<String> = labels.collect();
    if labels.is_empty() {
        return Vec::new();
    }
    let text = "The states are the last elements of `qd`, each in its own unit, and their rates, in this unit per s, the last of \
                `accel`. The last elements of `q` are their time integrals, on which nothing depends. `momenta` has the states \
                in these places, and `inertia` 1 on its diagonal.";
    let labels = format!("States of first order: {}. {text}", labels.join(", "));
    vec![String::new(), "# States".into(), String::new(), labels]
}

/// The inputs, if there are any.
fn inputs(model: &Model) -> Vec<String> {
    let labels: Vec<String> = model.input_labels().iter().map(|label| format!("`{label}`")).collect();
    if labels.is_empty() {
        return Vec::new();
    }
    let text = "Inputs are constant within a step and set between steps, each in its own unit. The facts above hold while they are \
                constant.";
    let labels = format!("Order of the inputs: {}. {text}", labels.join(", "));
    vec![String::new(), "# Inputs".into(), String::new(), labels]
}

/// The events with their functions, if there are any.
fn events(model: &Model, functions: &[Value], writer: &Writer) -> Vec<String> {
    if model.events.is_empty() {
        return Vec::new();
    }
    let mut lines = vec![String::new(), "# Events".into()];
    let mut functions = functions.iter();
    for NamedEvent { written: event, values, .. } in &model.events {
        let way = match event.direction {
            Direction::Rising => ", rising",
            Direction::Falling => ", falling",
            Direction::Either => "",
        };
        let end = if event.terminal { ", where a run ends" } else { "" };
        lines.extend([String::new(), format!("`{}`{way}{end}:", event.constant())]);
        for value in functions.by_ref().take(values.len()) {
            lines.extend([String::new(), writer.vanishing(*value).unwrap_or_else(|| TOO_LONG.into())]);
        }
    }
    lines
}

/// The components of the angular momentum of a rotation that are constant; nothing if none is.
pub fn conserved(d: &Derived, attitude: &Attitude) -> String {
    let of = |own: bool| {
        let found = d
            .equations
            .symmetries
            .found
            .iter()
            .filter(move |s| s.own == own && d.model.attitudes[s.rotation].first == attitude.first);
        let axes: Vec<&str> = found.map(|s| ["x", "y", "z"][s.axis]).collect();
        (!axes.is_empty()).then(|| axes.join(", "))
    };
    let parent = of(false).map(|axes| format!("constant along {axes} of its parent"));
    let own = of(true).map(|axes| format!("constant along its own axes {axes}"));
    [parent, own].into_iter().flatten().collect::<Vec<_>>().join(", and ")
}

/// List of the symmetries of what turns together, with their axes.
pub fn common(d: &Derived) -> String {
    let of = |s: &CommonSymmetry| {
        let names: Vec<String> =
            s.turned.iter().map(|first| format!("`{}`", turned_name(&d.model, *first))).collect();
        format!("{} about {}", names.join(", "), ["x", "y", "z"][s.axis])
    };
    d.equations.symmetries.common.iter().map(of).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::{is_read, spaced};

    #[test]
    fn tokens_are_spaced_as_they_were_written() {
        let text = "|i| frame(if i == 0 { world } else { link[i - 1] }, [0, -0.03, -x[2]], (0..N).map(|j| 2 * q[j].sin()).sum())";
        assert_eq!(spaced(text.parse().unwrap()), text);
    }

    #[test]
    fn rustdoc_and_editors_read_documentation() {
        for (program, read) in [
            ("rustdoc", true),
            ("/opt/bin/rust-analyzer-proc-macro-srv", true),
            ("/opt/bin/rustc", false),
            ("rustc.exe", false),
            ("clippy-driver", false),
        ] {
            assert_eq!(is_read(Some(program.into())), read, "{program}");
        }
        assert!(is_read(None));
    }
}
