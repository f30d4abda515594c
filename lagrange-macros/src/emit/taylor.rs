//! The recurrences of the Taylor series: order 0, and a function for each further one.

use super::forced_inlining;
use super::{
    Emitter,
    body::{RUNTIME, constant, list},
};
use crate::equations::series::{
    Balance, Base, Factor, Outputs, Place, Right, Rule, SIDE, STRAIGHT, Series, Slope, Substitution,
    is_number, symbol, tail, term_pair,
};
use crate::equations::solve::entry;
use crate::graph::{
    Comparison, Graph, Id, Number, Symbol, Value,
    stable_map::{IdMap, StableMap},
};
use crate::model::Model;
use proc_macro2::TokenStream;
use quote::quote;

/// Where the coefficients and the numbers of the recurrences are.
struct Places<'a> {
    emitter: &'a Emitter<'a>,
    series: &'a Series,
    /// Rows of the nodes.
    rows: IdMap<usize>,
    /// Rows of the nodes that velocities move, found from the momenta made of them.
    moved: Vec<usize>,
    /// Products whose coefficients of the order before give those of functions, as `before[i]`.
    before: Vec<Id>,
    /// The different factors of products, and where each of them is.
    factors: Vec<Factor>,
    places: StableMap<Factor, usize>,
    /// Numbers, as variables.
    numbers: StableMap<Value, String>,
    /// Reciprocals of leading coefficients, as variables, by nodes.
    reciprocals: IdMap<String>,
}

/// Names of variables and functions of the recurrences.
pub const VARIABLES: &[&str] = &[
    "rows",
    "motion",
    "unknowns",
    "solver",
    "sides",
    "switching",
    "over",
    "level",
    "order",
    "numbers",
    "reciprocals",
    "zeroth",
    "before",
    "ends",
    "products",
    "squares",
    "factors",
    "accelerations",
    "found",
    "changes",
    "columns",
    "unit",
    "advance",
    "respond",
    "rates",
];

const ZERO: &str = "S::zero()";

/// Side by side are as many as a vector of the processor's may hold, if there are as many; twice that in loops, which take turns less often.
fn blocks(n: usize) -> (usize, usize) {
    let side = n.next_power_of_two().clamp(1, if n <= STRAIGHT { SIDE } else { 2 * SIDE });
    (side, n.div_ceil(side))
}

/// Expressions in blocks, the last one filled up with zeros.
fn in_blocks(all: &[String]) -> String {
    let (side, _) = blocks(all.len());
    list(all.chunks(side).map(|block| {
        let rest = std::iter::repeat_n(ZERO, side - block.len());
        list(block.iter().map(String::as_str).chain(rest))
    }))
}

/// `[name[0], name[1], …]`
fn elements(name: &str, n: usize) -> String {
    list((0..n).map(|i| format!("{name}[{i}]")))
}

/// `[name_0, name_1, …]`, as which arrays are taken apart: each look into an array costs the compiler as much as ten looks at variables.
fn variables(name: &str, n: usize) -> String {
    list((0..n).map(|i| format!("{name}_{i}")))
}

/// The same of numbers in blocks.
fn variables_in_blocks(name: &str, n: usize) -> String {
    let (side, deep) = blocks(n);
    list((0..deep).map(|b| list((0..side).map(|i| format!("{name}_{}", b * side + i)))))
}

impl Emitter<'_> {
    /// The implementation of the runtime's `Analytic`.
    pub fn analytic(&self) -> TokenStream {
        let Some(series) = &self.d.equations.series else { return TokenStream::new() };
        let (Model { name, runtime, .. }, g) = (&self.d.model, &self.d.graph);
        let n = self.n();
        let numbers = series.numbers(g);
        let nodes = series.rules.iter().map(|(id, _)| Value::from(*id));
        let of_orders = series.solution.numbers();
        // What orders are solved by, and those of order 0 that are not made of the nodes.
        let outputs = match &series.outputs {
            Outputs::Accelerations(accelerations) => accelerations,
            Outputs::System { right, .. } => right,
            Outputs::Conserved { accelerations, .. } => &accelerations.iter().map(|a| a.1).collect(),
            Outputs::Momenta { .. } | Outputs::Bindings(_) => &Vec::new(),
        };
        let all = nodes.chain(numbers.iter().copied()).chain(outputs.iter().copied());
        let all: Vec<Value> = all.chain(of_orders.iter().copied()).map(|v| series.started(v)).collect();
        let (statements, values) = self.statements(&all);
        let (of_nodes, rest) = values.written().split_at(series.rules.len());
        let (of_numbers, rest) = rest.split_at(numbers.len());
        let (of_outputs, of_solution) = rest.split_at(outputs.len());

        let tokens = |text: &str| self.names.tokens(text);
        let mut places = Places::new(self, series);
        for (i, number) in numbers.iter().enumerate() {
            places.numbers.insert(*number, format!("number_{i}"));
        }
        let mut reciprocals = Vec::new();
        for (id, rule) in &series.rules {
            let of = match rule {
                Rule::Quotient(_, under) => *under,
                Rule::Root(_) => *id,
                Rule::Power(base, _) => *base,
                _ => continue,
            };
            if places.reciprocals.get(&of).is_none() {
                places.reciprocals.insert(of, format!("reciprocal_{}", reciprocals.len()));
                reciprocals.push(format!("S::one() / {}", places.zeroth(of)));
            }
        }
        let (known_count, reciprocal_count) = (numbers.len(), reciprocals.len());
        let known = list(numbers.iter().filter_map(|v| places.numbers.get(v)));
        let known_reciprocals = list((0..reciprocal_count).map(|i| format!("reciprocal_{i}")));
        let names = tokens(&format!("let {known} = *numbers;\nlet {known_reciprocals} = *reciprocals;"));
        let (rules, before_count) = (series.rules.len(), places.before.len());
        let zeroth_count = rules + 2 * n + 1;
        let arguments = quote! {
            numbers: &[S; #known_count], reciprocals: &[S; #reciprocal_count], zeroth: &[S; #zeroth_count]
        };

        let before_zeroth = tokens(&list(places.before.iter().map(|id| places.zeroth(*id))));
        let before = tokens(&list(places.before.iter().map(|id| places.order(*id))));
        let Solving { unknowns, changed, first, next, last, after } = match &series.outputs {
            Outputs::Bindings(balance) => places.balancing(balance, &names),
            _ => places.solving(of_outputs, &arguments, &names),
        };
        let inline = forced_inlining();
        // The equations of an order, where there are any.
        let (solver, solver_type, respond, solver_zeroth) = match unknowns {
            Some(unknowns) => {
                let (count, found) = (of_solution.len(), series.solution.unknowns.len());
                let (given, constants) = (series.given(), tokens(&list(of_solution)));
                let statements = tokens(&substituted(&series.solution));
                let respond = quote! {
                    /// The unknowns of an order, for what is given.
                    #inline
                    fn respond<S: #runtime::Scalar>(constants: &[S; #count], given: [S; #given]) -> [S; #found] {
                        #statements
                    }
                };
                let solver_type = quote!(solver: &[S; #count], unknowns: &mut [S; #unknowns],);
                (quote!(&solver, &mut unknowns,), solver_type, respond, quote!(let solver = #constants;))
            }
            None => Default::default(),
        };
        let factor_count = places.factors.len();
        let lasts = tokens(&list(places.factors.iter().map(|f| places.factor(*f))));
        let (wide, deep) = blocks(series.products.len());
        let row = if wide == 2 { quote!(S::Pair) } else { quote!([S; #wide]) };
        let (square_wide, square_deep) = blocks(series.squares.len());
        let factors = |order: &dyn Fn(Factor) -> String| {
            let side = |i: usize| in_blocks(&series.products.iter().map(|p| order(p[i])).collect::<Vec<_>>());
            let squares = in_blocks(&series.squares.iter().map(|f| order(*f)).collect::<Vec<_>>());
            [side(0), side(1), squares].map(|text| tokens(&text))
        };
        let factors_zeroth = tokens(&list(places.factors.iter().map(|f| places.factor_zeroth(*f))));
        let (product_count, square_count) = (series.products.len(), series.squares.len());
        let pairs = tokens(&list(series.products.iter().map(|pair| list(pair.map(|f| places.place(f))))));
        let squared = tokens(&list(series.squares.iter().map(|f| places.place(*f))));
        let [left, right, of_squares] = factors(&|f| places.factor(f));
        let [left_zeroth, right_zeroth, squares_zeroth] = factors(&|f| places.factor_zeroth(f));
        let zeroth_names = tokens(&variables("zeroth", zeroth_count));
        let taken_apart = [
            (variables("zeroth", zeroth_count), "*zeroth"),
            (variables("q", n), "motion.q[level]"),
            (list([variables("slower", n), variables("qd", n)]), "*rates"),
            (variables("first", factor_count), "*first"),
            (variables("last", factor_count), "*last"),
            (variables("before", before_count), "*before"),
            (variables_in_blocks("product", product_count), "product"),
            (variables_in_blocks("square", square_count), "square"),
        ];
        let taken_apart = taken_apart.map(|(names, array)| format!("let {names} = {array};\n")).concat();
        let taken_apart = tokens(&taken_apart);
        let advance = quote! {
            advance(
                level, &numbers, &reciprocals, &zeroth, #solver &mut before, &mut ends, &mut products, &mut squares, &mut factors, &mut rates,
                motion, &mut switching
            )
        };
        // Momenta give velocities, whose last coefficient is one order further than that of accelerations.
        let end = match series.outputs {
            Outputs::Momenta { .. } | Outputs::Bindings(_) | Outputs::Conserved { .. } => {
                quote!((order + 1).min(K))
            }
            _ => quote!(order.min(K)),
        };
        let orders = if series.straight() {
            // Vectors need no straight lines, which would take long to compile.
            quote! {
                if S::WIDE || !#runtime::series::UNROLLED {
                    for level in 1..#end { #advance; }
                } else {
                    #runtime::series::orders!(1..#end, level => #advance);
                }
            }
        } else {
            quote!(for level in 1..#end { #advance; })
        };
        let zeroth = of_nodes.iter().cloned();
        let zeroth =
            zeroth.chain(["q", "qd"].into_iter().flat_map(|x| (0..n).map(move |i| format!("{x}[{i}]"))));
        let zeroth = tokens(&list(zeroth.chain(["t".to_string()])));
        let (of_numbers, reciprocals) = (tokens(&list(of_numbers)), tokens(&list(reciprocals)));
        // Where there are switches to be located, each number is compared for itself.
        let switches = series.switches.len();
        let (bound, sides, switching) = if switches == 0 {
            (quote!(Scalar), quote!(#runtime::series::Smooth), quote!(#runtime::series::Smooth))
        } else {
            let (statements, values) = self.statements(&series.switches);
            let values = values.array();
            let switching = quote! {
                let (q, qd, t) = (&at.q, &at.qd, at.t);
                #statements
                #runtime::series::Sides(#values)
            };
            (quote!(Numbers), quote!(#runtime::series::Sides<S, #switches>), switching)
        };
        let roots = series.has_roots(g).then(|| {
            quote!(
                const ROOTS: bool = true;
            )
        });
        let sides_at = |order: &dyn Fn(Id) -> String| {
            let all = series.switches.iter().map(|v| v.node.map_or(ZERO.to_string(), order));
            (switches > 0).then(|| tokens(&list(all)))
        };
        let switching_zeroth = sides_at(&|id| places.zeroth(id));
        let switching_zeroth =
            switching_zeroth.map(|sides| quote!(switching[0] = #runtime::series::Sides(#sides);));
        let switching_next = sides_at(&|id| places.order(id));
        let switching_next =
            switching_next.map(|sides| quote!(switching[level] = #runtime::series::Sides(#sides);));
        // In braces, since a type of the user's may be called K as well.
        quote! {
            impl<S: #runtime::#bound> #runtime::Analytic<#n> for #name<S> {
                type Sides = #sides;
                #roots
                #[inline]
                fn switching(&self, at: &#runtime::State<S, #n>, sides: &#sides) -> #sides {
                    #switching
                }
                #inline
                fn series_within<const K: usize>(
                    &self,
                    at: &#runtime::State<S, #n>,
                    order: usize,
                    sides: &#sides,
                    motion: &mut #runtime::Series<S, #n, { K }>,
                ) -> [#sides; K] {
                    use #runtime::series::{Factors, Over, Products, Squares};
                    /// Factors of the products, and of the squares.
                    const PAIRS: [[usize; 2]; #product_count] = #pairs;
                    const SQUARED: [usize; #square_count] = #squared;
                    #respond
                    #changed
                    /// The coefficients of order `level` from those before.
                    #inline
                    fn advance<S: #runtime::#bound, const K: usize>(
                        level: usize,
                        #arguments,
                        #solver_type
                        before: &mut [S; #before_count],
                        ends: &mut [[S; #factor_count]; 2],
                        products: &mut Products<#row, #deep, { K }>,
                        squares: &mut Squares<S, #square_wide, #square_deep, { K }>,
                        factors: &mut Factors<S, #factor_count, { K }>,
                        rates: &mut [[S; #n]; 2],
                        motion: &mut #runtime::Series<S, #n, { K }>,
                        switching: &mut [#sides; K],
                    ) {
                        let (weight, over) = (S::from_f64(level as f64), Over::<S>::new(level));
                        let clock = S::from_f64(if level == 1 { 1.0 } else { 0.0 });
                        let (product, square) = if S::WIDE {
                            (factors.products(level, &PAIRS), factors.squares(level, &SQUARED))
                        } else {
                            (products.middle(level), squares.middle(level))
                        };
                        let known = *ends;
                        let [first, last] = if S::WIDE { factors.ends(level) } else { [&known[0], &known[1]] };
                        #taken_apart
                        #names
                        #next
                        #switching_next
                        *before = #before;
                        let newest = #lasts;
                        if S::WIDE {
                            factors.push(&newest);
                        } else {
                            if level == 2 {
                                ends[0] = known[1];
                            }
                            ends[1] = newest;
                            products.push(level, #left, #right);
                            squares.push(level, #of_squares);
                        }
                        #last
                    }
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    #statements
                    let numbers = #of_numbers;
                    let zeroth = #zeroth;
                    let #zeroth_names = zeroth;
                    let reciprocals = #reciprocals;
                    motion.begin(at);
                    let mut switching = [<#sides as #runtime::series::Switches<S>>::zero(); K];
                    #switching_zeroth
                    #solver_zeroth
                    #first
                    let mut before = #before_zeroth;
                    // Of order 1, which is known to be such from order 3 on, and of the order before.
                    let mut ends = [[S::zero(); #factor_count]; 2];
                    let mut products = Products::<#row, #deep, { K }>::new();
                    let mut squares = Squares::<S, #square_wide, #square_deep, { K }>::new();
                    let mut factors = Factors::<S, #factor_count, { K }>::new();
                    if S::WIDE {
                        factors.push(&#factors_zeroth);
                    } else {
                        products.keep();
                        products.push(0, #left_zeroth, #right_zeroth);
                        squares.push(0, #squares_zeroth);
                    }
                    #orders
                    #after
                    switching
                }
            }
        }
    }
}

/// The unknowns of an order as an array, after what they are made of.
fn substituted(solution: &Substitution) -> String {
    let (rows, all) = (solution.rows.len(), solution.rows.len() + solution.unknowns.len());
    // Sums of the same products, those of an inverse, are vectors to the optimiser if all their products are added to something.
    let of_vectors = |place: usize| rows == 0 && solution.unknowns[place].len() > 1;
    let (mut sums, mut known) = (vec![None::<String>; all], 0);
    for (place, (number, base)) in solution.in_order() {
        let base = match base {
            Base::Given(i) => format!("given[{i}]"),
            Base::Row(i) => format!("row_{i}"),
        };
        let sum = sums[place].take();
        sums[place] = Some(if !number.is_constant() {
            known += 1;
            let number = format!("constants[{}]", known - 1);
            match sum {
                Some(sum) => format!("{number}.mul_add({base}, {sum})"),
                None if of_vectors(place) => format!("{number}.mul_add({base}, {ZERO})"),
                None => format!("{number} * {base}"),
            }
        } else if number.k.is_unit() {
            let sign = if number.k.is_one() { "+" } else { "-" };
            match (sum, sign) {
                (None, "+") => base,
                (None, _) => format!("-{base}"),
                (Some(sum), _) => format!("{sum} {sign} {base}"),
            }
        } else {
            format!("{} + {} * {base}", sum.unwrap_or_else(|| ZERO.into()), constant(number.k))
        });
    }
    let mut sums = sums.into_iter().map(|sum| sum.unwrap_or_else(|| ZERO.into()));
    let rows: String =
        sums.by_ref().take(rows).enumerate().map(|(i, sum)| format!("let row_{i} = {sum};\n")).collect();
    rows + &list(sums)
}

/// How an order follows from the one before.
#[derive(Default)]
struct Solving {
    /// How many numbers of an order the equations of the next one need to know, where there are equations.
    unknowns: Option<usize>,
    /// A function: what velocities do to the nodes.
    changed: TokenStream,
    /// Order 0, with the rates of the first orders.
    first: TokenStream,
    /// Order k, and what the next one needs to know.
    next: TokenStream,
    last: TokenStream,
    /// What is left to do after the last order.
    after: TokenStream,
}

impl<'a> Places<'a> {
    fn new(emitter: &'a Emitter<'a>, series: &'a Series) -> Self {
        let mut rows = IdMap::default();
        for (row, (id, _)) in series.rules.iter().enumerate() {
            rows.insert(*id, row);
        }
        let mut before: Vec<Id> = Vec::new();
        for (_, rule) in &series.rules {
            let Rule::Function(slopes) = rule else { continue };
            for slope in slopes {
                if let Slope::Known(_, product) = slope
                    && !before.contains(product)
                {
                    before.push(*product);
                }
            }
        }
        let moved = match series.outputs {
            Outputs::Momenta { ref momenta, .. } => series.moved(&emitter.d.graph, Some(momenta)),
            _ => Vec::new(),
        };
        let mut factors: Vec<Factor> = Vec::new();
        let mut places: StableMap<Factor, usize> = StableMap::default();
        for factor in series.products.iter().flatten().chain(&series.squares) {
            if places.get(factor).is_none() {
                places.insert(*factor, factors.len());
                factors.push(*factor);
            }
        }
        Places {
            emitter,
            series,
            factors,
            places,
            rows,
            moved,
            before,
            numbers: StableMap::default(),
            reciprocals: IdMap::default(),
        }
    }

    fn graph(&self) -> &Graph {
        &self.emitter.d.graph
    }

    fn row(&self, id: Id) -> usize {
        *self.rows.get(&id).expect("operands have rules")
    }

    /// The coefficient of order 0 of a node.
    fn zeroth(&self, id: Id) -> String {
        let (rules, n) = (self.series.rules.len(), self.emitter.n());
        let place = match symbol(self.graph(), id) {
            Some(Symbol::Coordinate(i)) => rules + i,
            Some(Symbol::Velocity(i)) => rules + n + i,
            Some(_) => rules + 2 * n,
            None => self.row(id),
        };
        format!("zeroth_{place}")
    }

    /// The coefficient of order `level` of a node.
    fn order(&self, id: Id) -> String {
        match symbol(self.graph(), id) {
            Some(Symbol::Coordinate(i)) => format!("q_{i}"),
            Some(Symbol::Velocity(i)) => format!("qd_{i}"),
            Some(_) => "clock".into(),
            None => format!("x{}", self.row(id)),
        }
    }

    /// Where a factor of products is among all of them.
    fn place(&self, factor: Factor) -> usize {
        *self.places.get(&factor).expect("every factor has a place")
    }

    /// The coefficient of order `level` of a factor of products.
    fn factor(&self, factor: Factor) -> String {
        match factor {
            Factor::Of(id) => self.order(id),
            Factor::Rate(id) => match symbol(self.graph(), id) {
                Some(Symbol::Coordinate(i)) => format!("slower_{i}"),
                _ => format!("weight * {}", self.order(id)),
            },
            Factor::Unknown(i) => format!("found_{i}"),
        }
    }

    fn factor_zeroth(&self, factor: Factor) -> String {
        match factor {
            Factor::Of(id) => self.zeroth(id),
            Factor::Rate(_) => ZERO.into(),
            // Counted one order later than they belong.
            Factor::Unknown(_) if matches!(self.series.outputs, Outputs::Bindings(_)) => ZERO.into(),
            Factor::Unknown(i) => format!("unknowns[{i}]"),
        }
    }

    /// The inner sum of a product of series.
    fn inner(&self, pair: [Factor; 2]) -> String {
        match self.series.place(pair) {
            Place::Product(i) => format!("product_{i}"),
            Place::Square(i) => format!("square_{i}"),
        }
    }

    /// `Σ_{0<j<k}` of a product of series: the inner sum, and what order 1 and the order before contribute.
    fn middle(&self, pair: [Factor; 2]) -> String {
        let inner = self.inner(pair);
        let [a, b] = pair.map(|factor| self.place(factor));
        if pair[0] == pair[1] {
            return format!("(first_{a} + first_{a}).mul_add(last_{a}, {inner})");
        }
        format!("first_{b}.mul_add(last_{a}, first_{a}.mul_add(last_{b}, {inner}))")
    }

    /// `(1/k) Σ_{0<j≤k} j a_j s_{k−j}` of a rate of a and a slope s. What order 1 of the rate contributes is divided on its own, and in advance, so
    /// that sines need not wait for a division of the cosines of the order before.
    fn by_rate(&self, pair: [Factor; 2], newest: Option<String>, slope: String, of: Id) -> String {
        let inner = self.inner(pair);
        let [a, b] = pair.map(|factor| self.place(factor));
        let early = format!("first_{b}.mul_add(last_{a}, {inner})");
        let Some(newest) = newest else {
            return format!("last_{b}.mul_add(over.of(first_{a}), over.of({early}))");
        };
        // What is known last is added last: coordinates are known for longer than what is computed in this order.
        if matches!(symbol(self.graph(), of), Some(Symbol::Coordinate(_))) {
            format!("last_{b}.mul_add(over.of(first_{a}), over.add({early}, {newest} * {slope}))")
        } else {
            format!("{newest}.mul_add({slope}, over.add({early}, last_{b} * over.of(first_{a})))")
        }
    }

    /// A constant factor in front of what binds at least as tightly as a product.
    fn scaled(&self, k: Number, text: String) -> String {
        if k.is_one() {
            return text;
        }
        if k.is_unit() {
            return format!("-{text}");
        }
        format!("{} * {text}", constant(k))
    }

    /// A number as a variable or literal.
    fn number(&self, v: Value) -> String {
        self.numbers.get(&v).cloned().unwrap_or_else(|| constant(v.k))
    }

    fn reciprocal(&self, id: Id) -> String {
        self.reciprocals.get(&id).cloned().expect("what divides has a reciprocal")
    }

    /// A value of order 0.
    fn value_zeroth(&self, v: Value) -> String {
        match v.node {
            Some(id) if !is_number(self.graph(), v) => self.scaled(v.k, self.zeroth(id)),
            _ => self.number(v),
        }
    }

    /// The statements of some rows.
    fn steps(&self, rows: impl Iterator<Item = usize>, velocities: Velocities) -> TokenStream {
        let steps = rows.map(|row| {
            let (id, rule) = &self.series.rules[row];
            format!("let {} = {};\n", self.order(*id), self.coefficient(*id, rule, velocities))
        });
        self.emitter.names.tokens(&steps.collect::<String>())
    }

    /// The coefficient of order `level` of a node, if there is one.
    fn present(&self, id: Id, velocities: Velocities) -> Option<String> {
        let velocity = matches!(symbol(self.graph(), id), Some(Symbol::Velocity(_)));
        (velocities == Velocities::Known || !velocity).then(|| self.order(id))
    }

    /// The coefficient of order `level` of a value that moves.
    fn value(&self, v: Value, velocities: Velocities) -> Option<String> {
        let id = v.node.filter(|_| !is_number(self.graph(), v))?;
        Some(self.scaled(v.k, self.present(id, velocities)?))
    }

    fn value_or_zero(&self, v: Value, velocities: Velocities) -> String {
        self.value(v, velocities).unwrap_or_else(|| ZERO.into())
    }

    /// A sum of values that move, each times a number.
    fn linear(&self, terms: &[(Value, Value)], value: impl Fn(Value) -> Option<String>) -> String {
        sum(terms.iter().filter_map(|(factor, x)| {
            let x = value(*x)?;
            Some(if *factor == Value::ONE { x } else { format!("{} * {x}", self.number(*factor)) })
        }))
    }

    /// The coefficient of order `level`.
    fn coefficient(&self, own: Id, rule: &Rule, velocities: Velocities) -> String {
        let convolutions = rule.convolutions(own);
        let middle = |i: usize| self.middle(convolutions[i]);
        let present = |id: Id| self.present(id, velocities);
        // `sum`, and a node's coefficient times another's of order 0.
        let with = |sum: String, of: Id, other: Id| match present(of) {
            Some(x) => format!("{x}.mul_add({}, {sum})", self.zeroth(other)),
            None => sum,
        };
        match rule {
            Rule::Linear(terms) => self.linear(terms, |x| self.value(x, velocities)),
            Rule::Product(a, b) => {
                // The operand that is known last is added last.
                let (early, late) = if a > b { (*b, *a) } else { (*a, *b) };
                with(with(middle(0), early, late), late, early)
            }
            Rule::Square(a) => match present(*a) {
                Some(x) => format!("({x} + {x}).mul_add({}, {})", self.zeroth(*a), middle(0)),
                None => middle(0),
            },
            Rule::Quotient(a, b) => {
                let (sum, over) = (with(middle(0), *b, own), self.reciprocal(*b));
                format!("({} - {sum}) * {over}", self.value_or_zero(*a, velocities))
            }
            Rule::Root(a) => {
                let (sum, over) = (middle(0), self.reciprocal(own));
                format!("({} - {sum}) * (S::from_f64(0.5) * {over})", self.value_or_zero(*a, velocities))
            }
            Rule::Power(a, r) => {
                let (rates, sum, own, r) = (middle(0), middle(1), self.zeroth(own), self.number(*r));
                let over = self.reciprocal(*a);
                let newest = present(*a).map_or(String::new(), |x| format!("+ {r} * {x} * {own}"));
                format!("(over.of(({r} + S::one()) * {rates}) - {sum} {newest}) * {over}")
            }
            Rule::Choice(comparison, values) => {
                self.choice(*comparison, values, |v| self.value_or_zero(v, velocities))
            }
            Rule::Function(slopes) => {
                let mut next = 0;
                sum(slopes.iter().filter_map(|slope| match slope {
                    Slope::Number(slope, x) => {
                        Some(format!("{} * {}", self.number(*slope), self.value(*x, velocities)?))
                    }
                    Slope::Known(k, product) => {
                        let i = self
                            .before
                            .iter()
                            .position(|id| id == product)
                            .expect("a slope is one of the products");
                        Some(self.scaled(*k, format!("over.of(before_{i})")))
                    }
                    Slope::Rate(k, a, slope) => {
                        let pair = convolutions[next];
                        next += 1;
                        Some(self.scaled(*k, self.by_rate(pair, present(*a), self.zeroth(*slope), *a)))
                    }
                }))
            }
        }
    }

    fn choice(&self, comparison: Comparison, values: &[Value; 4], of: impl Fn(Value) -> String) -> String {
        let ([a, b], [yes, no]) =
            ([values[0], values[1]].map(|v| self.number(v)), [values[2], values[3]].map(of));
        format!("S::select({RUNTIME}::Comparison::{comparison:?}, {a}, {b}, {yes}, {no})")
    }

    /// What velocities `given` add to a value, by names of the nodes' changes.
    fn change(&self, v: Value) -> Option<String> {
        let id = v.node?;
        let change = match symbol(self.graph(), id) {
            Some(Symbol::Velocity(i)) => format!("given[{i}]"),
            Some(_) => return None,
            None => {
                let row = *self.rows.get(&id)?;
                self.moved.binary_search(&row).ok()?;
                format!("x{row}")
            }
        };
        Some(self.scaled(v.k, change))
    }

    fn change_by(&self, own: Id, rule: &Rule) -> String {
        let of = |id: Id| self.change(id.into());
        // The rules that are no sums have an operand that moves, or they would not be asked.
        let moving = |id: Id| of(id).unwrap_or_else(|| ZERO.into());
        match rule {
            Rule::Linear(terms) => self.linear(terms, |x| self.change(x)),
            Rule::Product(a, b) => sum([(a, b), (b, a)]
                .into_iter()
                .filter_map(|(a, b)| Some(format!("{} * {}", of(*a)?, self.zeroth(*b))))),
            Rule::Square(a) => {
                let leading = self.zeroth(*a);
                format!("{} * ({leading} + {leading})", moving(*a))
            }
            Rule::Quotient(a, b) => {
                let own = self.zeroth(own);
                let under = of(*b).map(|change| format!("-{change} * {own}"));
                format!("({}) * {}", sum(self.change(*a).into_iter().chain(under)), self.reciprocal(*b))
            }
            Rule::Root(a) => {
                let change = self.change(*a).unwrap_or_else(|| ZERO.into());
                format!("{change} * (S::from_f64(0.5) * {})", self.reciprocal(own))
            }
            Rule::Power(a, r) => {
                let (r, own, over) = (self.number(*r), self.zeroth(own), self.reciprocal(*a));
                format!("{} * ({r} * {own} * {over})", moving(*a))
            }
            Rule::Choice(comparison, values) => {
                self.choice(*comparison, values, |v| self.change(v).unwrap_or_else(|| ZERO.into()))
            }
            Rule::Function(slopes) => sum(slopes.iter().filter_map(|slope| match slope {
                Slope::Number(slope, x) => Some(format!("{} * {}", self.number(*slope), self.change(*x)?)),
                Slope::Known(..) => None,
                Slope::Rate(k, a, slope) => {
                    Some(self.scaled(*k, format!("{} * {}", of(*a)?, self.zeroth(*slope))))
                }
            })),
        }
    }

    fn solving(&self, firsts: &[String], arguments: &TokenStream, names: &TokenStream) -> Solving {
        let (g, n) = (self.graph(), self.emitter.n());
        let runtime = &self.emitter.d.model.runtime;
        let tokens = |text: &str| self.emitter.names.tokens(text);
        let value = |v: &Value| self.value_or_zero(*v, Velocities::Known);
        let (velocities, qd) = (tokens(&elements("qd", n)), tokens(&variables("qd", n)));
        let all = self.steps(0..self.series.rules.len(), Velocities::Known);
        match &self.series.outputs {
            Outputs::Accelerations(accel) => {
                let (firsts, next) = (tokens(&list(firsts)), tokens(&list(accel.iter().map(value))));
                Solving {
                    first: quote!(let mut rates = [#velocities, motion.push(0, #firsts)];),
                    next: quote!(#all let accelerations = #next;),
                    last: quote!(*rates = [#qd, motion.push(level, accelerations)];),
                    ..Solving::default()
                }
            }
            Outputs::System { matrix, right } => {
                let size = right.len();
                let rights = tokens(&list(firsts));
                let next = (0..size).map(|i| {
                    let mut sum = value(&right[i]);
                    for j in 0..size {
                        let m = entry(matrix, i, j);
                        let (Some(pair), Some(id)) = (tail(g, m, j), m.node) else { continue };
                        let (middle, x) = (self.middle(pair), self.order(id));
                        let product = self.scaled(m.k, format!("{x}.mul_add(unknowns[{j}], {middle})"));
                        sum = format!("{sum} - {product}");
                    }
                    sum
                });
                let next = tokens(&list(next));
                let accelerations = tokens(&elements("found", n));
                let found = tokens(&variables("found", size));
                Solving {
                    unknowns: Some(size),
                    first: quote! {
                        let mut unknowns = respond(&solver, #rights);
                        let found = unknowns;
                        let mut rates = [#velocities, motion.push(0, #accelerations)];
                    },
                    next: quote!(#all let found = respond(solver, #next); let #found = found;),
                    last: quote!(*rates = [#qd, motion.push(level, #accelerations)];),
                    ..Solving::default()
                }
            }
            Outputs::Bindings(_) => unreachable!("has a solution of its own"),
            Outputs::Conserved { velocities: ignorable, accelerations } => {
                let firsts = tokens(&list(firsts));
                let next = tokens(&list(accelerations.iter().map(|a| value(&a.1))));
                let kept: Vec<usize> = accelerations.iter().map(|a| a.0).collect();
                // Of the others no rates are handed on: they have rules.
                let handed = (0..n).map(|i| match kept.iter().position(|k| *k == i) {
                    Some(place) => format!("further[{place}]"),
                    None => ZERO.into(),
                });
                let handed = tokens(&list(handed));
                let given = tokens(&list(ignorable.iter().map(|v| format!("qd_{}", v.index))));
                let ignorable = ignorable.iter().map(|v| v.index);
                Solving {
                    first: quote! {
                        let further = motion.push_of(0, &[#(#kept),*], #firsts);
                        let mut rates = [#velocities, #handed];
                    },
                    next: quote!(#all let accelerations = #next;),
                    last: quote! {
                        motion.push_velocities_of(level, &[#(#ignorable),*], #given);
                        let further = motion.push_of(level, &[#(#kept),*], accelerations);
                        *rates = [#qd, #handed];
                    },
                    // Those that are kept are known one order further.
                    after: quote! {
                        if order + 2 < K {
                            #(motion.q[order + 2][#kept] = S::zero();)*
                        }
                    },
                    ..Solving::default()
                }
            }
            Outputs::Momenta { momenta, force } => {
                let (count, rules) = (self.moved.len(), &self.series.rules);
                let changes = self.moved.iter().map(|&row| {
                    let (id, rule) = &rules[row];
                    format!("let x{row} = {};\n", self.change_by(*id, rule))
                });
                let changes = tokens(&changes.collect::<String>());
                let named = tokens(&list(self.moved.iter().map(|row| format!("x{row}"))));
                let zeroth_count = rules.len() + 2 * n + 1;
                let apart = tokens(&format!("let {} = *zeroth;", variables("zeroth", zeroth_count)));
                let inline = forced_inlining();
                let changed = quote! {
                    /// What velocities do to the nodes that momenta are made of.
                    #inline
                    fn changed<S: #runtime::Scalar>(#arguments, given: &[S; #n]) -> [S; #count] {
                        #names
                        #apart
                        #changes
                        #named
                    }
                };
                let force_zeroth = tokens(&list(force.iter().map(|f| self.value_zeroth(*f))));
                // What does not move with the velocities, or is in the momenta, comes first.
                let all_moved = self.series.moved(g, None);
                let (early, late): (Vec<usize>, Vec<usize>) = (0..rules.len()).partition(|row| {
                    self.moved.binary_search(row).is_ok() || all_moved.binary_search(row).is_err()
                });
                let (early, late) = (
                    self.steps(early.into_iter(), Velocities::Unknown),
                    self.steps(late.into_iter(), Velocities::Known),
                );
                let rights = momenta.iter().enumerate().map(|(i, p)| {
                    let without = self.value(*p, Velocities::Unknown);
                    format!("given[{i}]{}", without.map_or(String::new(), |p| format!(" - ({p})")))
                });
                let rights = tokens(&list(rights));
                let corrected = self.moved.iter().enumerate();
                let corrected = corrected.map(|(i, row)| format!("let x{row} = x{row} + changes[{i}];\n"));
                let corrected = tokens(&corrected.collect::<String>());
                let next_force = tokens(&list(force.iter().map(value)));
                Solving {
                    unknowns: Some(n),
                    changed,
                    first: quote! {
                        let mut rates = [#velocities; 2];
                        let mut unknowns = {
                            let (numbers, reciprocals) = (&numbers, &reciprocals);
                            #names
                            #force_zeroth
                        };
                    },
                    next: quote! {
                        #early
                        let given = #runtime::series::divided(*unknowns, level);
                        let velocities = respond(solver, #rights);
                        let #qd = velocities;
                        let changes = changed(numbers, reciprocals, zeroth, &velocities);
                        #corrected
                        #late
                        *unknowns = #next_force;
                    },
                    last: quote! {
                        motion.push_velocities(level, velocities);
                        *rates = [velocities; 2];
                    },
                    ..Solving::default()
                }
            }
        }
    }
}

impl Places<'_> {
    /// Orders by the equations at the bindings.
    fn balancing(&self, balance: &Balance, names: &TokenStream) -> Solving {
        let (g, n) = (self.graph(), self.emitter.n());
        let runtime = &self.emitter.d.model.runtime;
        let tokens = |text: &str| self.emitter.names.tokens(text);
        let found = balance.solution.len();
        let (velocities, qd) = (tokens(&elements("qd", n)), tokens(&variables("qd", n)));

        let forces = balance.rights.iter().filter_map(|right| match right {
            Right::Forces { force, .. } => Some(*force),
            Right::Definition { .. } => None,
        });
        let forces: Vec<Value> = forces.collect();
        let forces_count = forces.len();
        let zeroth = tokens(&list(forces.iter().map(|f| self.value_zeroth(*f))));
        let next = tokens(&list(forces.iter().map(|f| self.value_or_zero(*f, Velocities::Known))));
        let rights = balance.rights.iter().enumerate().map(|(i, right)| match right {
            Right::Forces { tails, .. } => {
                let tails = tails.iter().filter_map(|(v, x)| {
                    Some(self.scaled(v.k, self.middle([Factor::Of(v.node?), Factor::Unknown(*x)])))
                });
                sum(std::iter::once(format!("unknowns[{i}]")).chain(tails))
            }
            Right::Definition { explicit, terms } => {
                let explicit = self.value(*explicit, Velocities::Known);
                let terms = terms.iter().filter_map(|&[slope, rate]| {
                    let of = self.order(slope.node?);
                    let Some(pair) = term_pair(g, [slope, rate]) else {
                        return Some(self.scaled(slope.k, format!("{of} * {}", self.number(rate))));
                    };
                    let (middle, zeroth) = (self.middle(pair), self.zeroth(rate.node?));
                    Some(self.scaled(slope.k.mul(rate.k), format!("{of}.mul_add({zeroth}, {middle})")))
                });
                format!("weight * ({})", sum(explicit.into_iter().chain(terms)))
            }
        });
        let rights = tokens(&list(rights));
        let all_moved = self.series.moved(g, None);
        let (late, early): (Vec<usize>, Vec<usize>) =
            (0..self.series.rules.len()).partition(|row| all_moved.binary_search(row).is_ok());
        let (early, late) = (
            self.steps(early.into_iter(), Velocities::Known),
            self.steps(late.into_iter(), Velocities::Known),
        );
        let accelerations = tokens(&variables("found", n));
        let all_found = tokens(&variables("found", found));
        Solving {
            unknowns: Some(forces_count),
            first: quote! {
                let mut rates = [#velocities; 2];
                let mut unknowns = {
                    let (numbers, reciprocals) = (&numbers, &reciprocals);
                    #names
                    #zeroth
                };
            },
            next: quote! {
                #early
                let #all_found = respond(solver, #rights);
                let velocities = #runtime::series::divided(#accelerations, level);
                let #qd = velocities;
                #late
                *unknowns = #next;
            },
            last: quote! {
                motion.push_velocities(level, velocities);
                *rates = [velocities; 2];
            },
            ..Solving::default()
        }
    }
}

/// Are those of this order known yet?
#[derive(Clone, Copy, PartialEq)]
enum Velocities {
    Known,
    Unknown,
}

fn sum(terms: impl Iterator<Item = String>) -> String {
    let terms: Vec<String> = terms.collect();
    if terms.is_empty() { ZERO.into() } else { terms.join(" + ") }
}
