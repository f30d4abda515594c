//! The recurrences of the Taylor series: order 0, and a function for each further one.

use super::{Emitter, body};
use crate::equations::series::{Factor, Outputs, Place, Rule, Series, Slope, is_number, symbol, tail};
use crate::equations::solve::entry;
use crate::graph::{Graph, Id, Number, Symbol, Value, stable_map::StableMap};
use crate::model::Model;
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// Systems of at most this many products of series have their orders written out one by one by the optimiser, which makes
/// of rows values in registers and of sums straight lines; others loop.
const STRAIGHT: usize = 40;

/// Where the coefficients and the numbers of the recurrences are.
struct Places<'a> {
    emitter: &'a Emitter<'a>,
    series: &'a Series,
    /// Rows of the nodes.
    rows: StableMap<Id, usize>,
    /// Rows of the nodes that velocities move, found from the momenta made of them.
    moved: Vec<usize>,
    /// Products whose coefficients of the order before give those of functions, as `before[i]`.
    before: Vec<Id>,
    /// The different factors of products.
    factors: Vec<Factor>,
    /// Numbers, as variables.
    numbers: StableMap<Value, TokenStream>,
    /// Reciprocals of leading coefficients, as variables, by nodes.
    reciprocals: StableMap<Id, TokenStream>,
}

fn at(i: usize) -> Literal {
    Literal::usize_unsuffixed(i)
}

fn row_name(row: usize) -> Ident {
    format_ident!("x{row}")
}

/// Side by side are as many as a vector of the processor's may hold, if there are as many.
fn blocks(n: usize) -> (usize, usize) {
    let side = n.next_power_of_two().clamp(1, 8);
    (side, n.div_ceil(side))
}

/// Tokens in blocks, the last one filled up with zeros.
fn in_blocks(all: &[TokenStream]) -> TokenStream {
    let (side, _) = blocks(all.len());
    let blocks = all.chunks(side).map(|block| {
        let rest = std::iter::repeat_n(quote!(S::zero()), side - block.len());
        let block = block.iter().cloned().chain(rest);
        quote!([#(#block),*])
    });
    quote!([#(#blocks),*])
}

impl Emitter<'_> {
    /// The implementation of the runtime's `Analytic`.
    pub fn analytic(&self) -> TokenStream {
        let Some(series) = &self.e.series else { return TokenStream::new() };
        let Model { name, runtime, graph: g, .. } = &self.e.model;
        let n = self.n();
        let numbers = numbers(g, series);
        let nodes = series.rules.iter().map(|(id, _)| Value::from(*id));
        // Those of momenta are made of the nodes.
        let outputs = match series.outputs {
            Outputs::Momenta { .. } => Vec::new(),
            _ => series.outputs.values(),
        };
        let all: Vec<Value> = nodes.chain(numbers.iter().copied()).chain(outputs).collect();
        let (statements, values) = self.statements(&all);
        let values = values.each();
        let (of_nodes, rest) = values.split_at(series.rules.len());
        let (of_numbers, of_outputs) = rest.split_at(numbers.len());

        let mut places = Places::new(self, series);
        for (i, number) in numbers.iter().enumerate() {
            let variable = format_ident!("number_{i}");
            places.numbers.insert(*number, quote!(#variable));
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
                let variable = format_ident!("reciprocal_{}", reciprocals.len());
                places.reciprocals.insert(of, quote!(#variable));
                let zeroth = places.zeroth(of);
                reciprocals.push(quote!(S::one() / #zeroth));
            }
        }
        let known: Vec<&TokenStream> = numbers.iter().filter_map(|v| places.numbers.get(v)).collect();
        let known_reciprocals = (0..reciprocals.len()).map(|i| format_ident!("reciprocal_{i}"));
        let (known_count, reciprocal_count) = (numbers.len(), reciprocals.len());
        let names = quote! {
            let [#(#known),*] = *numbers;
            let [#(#known_reciprocals),*] = *reciprocals;
        };
        let (rules, before_count) = (series.rules.len(), places.before.len());
        let zeroth_count = rules + 2 * n + 1;
        let arguments = quote! {
            numbers: &[S; #known_count], reciprocals: &[S; #reciprocal_count], zeroth: &[S; #zeroth_count]
        };

        let before_zeroth = places.before.iter().map(|id| places.zeroth(*id));
        let before = places.before.iter().map(|id| places.order(*id));
        let Solving { size, respond, first, next, last } = places.solving(of_outputs, &arguments, &names);
        let (solver, solver_type) = match size {
            Some(size) => (
                quote!(&solver, &mut unknowns,),
                quote!(solver: &#runtime::series::Solver<S, #size>, unknowns: &mut [S; #size],),
            ),
            None => Default::default(),
        };
        let (lasts, factor_count) = (places.factors.iter().map(|f| places.factor(*f)), places.factors.len());
        let (wide, deep) = blocks(series.products.len());
        let (square_wide, square_deep) = blocks(series.squares.len());
        let factors = |order: &dyn Fn(Factor) -> TokenStream| {
            let side = |i: usize| in_blocks(&series.products.iter().map(|p| order(p[i])).collect::<Vec<_>>());
            let (left, right) = (side(0), side(1));
            let squares = in_blocks(&series.squares.iter().map(|f| order(*f)).collect::<Vec<_>>());
            (left, right, squares)
        };
        let (left, right, of_squares) = factors(&|f| places.factor(f));
        let (left_zeroth, right_zeroth, squares_zeroth) = factors(&|f| places.factor_zeroth(f));
        let advance = quote! {
            advance(
                level, &numbers, &reciprocals, &zeroth, #solver &mut before, &mut ends, &mut products, &mut squares, &mut rates,
                &mut motion
            )
        };
        // Momenta give velocities, whose last coefficient is one order further than that of accelerations.
        let end = match series.outputs {
            Outputs::Momenta { .. } => quote!((order + 1).min(K)),
            _ => quote!(order.min(K)),
        };
        let orders = if series.products.len() + series.squares.len() <= STRAIGHT {
            quote!(#runtime::series::orders!(1..#end, level => #advance);)
        } else {
            quote!(for level in 1..#end { #advance; })
        };
        let coordinates = (0..n).map(|i| {
            let i = at(i);
            quote!(q[#i])
        });
        let velocities: Vec<TokenStream> = (0..n)
            .map(|i| {
                let i = at(i);
                quote!(qd[#i])
            })
            .collect();
        quote! {
            impl<S: #runtime::Scalar> #runtime::Analytic<#n> for #name<S> {
                fn series<const K: usize>(
                    &self,
                    at: &#runtime::State<S, #n>,
                    order: usize,
                ) -> #runtime::Series<S, #n, K> {
                    use #runtime::series::{Products, Squares, over};
                    #respond
                    /// The coefficients of order `level` from those before.
                    #[inline(always)]
                    fn advance<S: #runtime::Scalar, const K: usize>(
                        level: usize,
                        #arguments,
                        #solver_type
                        before: &mut [S; #before_count],
                        [first, last]: &mut [[S; #factor_count]; 2],
                        products: &mut Products<S, #wide, #deep, K>,
                        squares: &mut Squares<S, #square_wide, #square_deep, K>,
                        rates: &mut [[S; #n]; 2],
                        motion: &mut #runtime::Series<S, #n, K>,
                    ) {
                        let (weight, over) = (S::from_f64(level as f64), over::<S>(level));
                        let clock = S::from_f64(if level == 1 { 1.0 } else { 0.0 });
                        let (product, square) = (products.middle(level), squares.middle(level));
                        let (q, [slower, qd]) = (motion.q[level], *rates);
                        #names
                        #next
                        *before = [#(#before),*];
                        if level == 2 {
                            *first = *last;
                        }
                        *last = [#(#lasts),*];
                        products.push(level, #left, #right);
                        squares.push(level, #of_squares);
                        #last
                    }
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    #statements
                    let numbers = [#(#of_numbers),*];
                    let zeroth = [#(#of_nodes,)* #(#coordinates,)* #(#velocities,)* t];
                    let reciprocals = [#(#reciprocals),*];
                    let mut motion = #runtime::Series::new(at);
                    #first
                    let mut before = [#(#before_zeroth),*];
                    // Of order 1, which is known to be such from order 3 on, and of the order before.
                    let mut ends = [[S::zero(); #factor_count]; 2];
                    let mut products = Products::<S, #wide, #deep, K>::new();
                    products.keep();
                    let mut squares = Squares::<S, #square_wide, #square_deep, K>::new();
                    products.push(0, #left_zeroth, #right_zeroth);
                    squares.push(0, #squares_zeroth);
                    #orders
                    motion
                }
            }
        }
    }
}

/// Numbers of the rules that are not constants.
fn numbers(g: &Graph, series: &Series) -> Vec<Value> {
    let mut numbers: Vec<Value> = Vec::new();
    let mut note = |v: Value| {
        if !v.is_constant() && is_number(g, v) && !numbers.contains(&v) {
            numbers.push(v);
        }
    };
    for (_, rule) in &series.rules {
        match rule {
            Rule::Linear(terms) => terms.iter().for_each(|(factor, _)| note(*factor)),
            Rule::Power(_, r) => note(*r),
            Rule::Function(slopes) => {
                for slope in slopes {
                    if let Slope::Number(slope, _) = slope {
                        note(*slope);
                    }
                }
            }
            Rule::Product(..) | Rule::Square(_) | Rule::Quotient(..) | Rule::Root(_) => {}
        }
    }
    if let Outputs::Momenta { .. } = &series.outputs {
        series.outputs.values().into_iter().for_each(note);
    }
    numbers
}

/// How an order follows from the one before.
struct Solving {
    /// Of the matrix, if there is one.
    size: Option<usize>,
    /// A function that says what velocities do to the nodes and to the momenta.
    respond: TokenStream,
    /// Order 0, with the rates of the first orders.
    first: TokenStream,
    /// Order k, and what the next one needs to know.
    next: TokenStream,
    last: TokenStream,
}

impl<'a> Places<'a> {
    fn new(emitter: &'a Emitter<'a>, series: &'a Series) -> Self {
        let mut rows = StableMap::default();
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
            Outputs::Momenta { ref momenta, .. } => series.moved(&emitter.e.model.graph, Some(momenta)),
            _ => Vec::new(),
        };
        let mut factors: Vec<Factor> = Vec::new();
        for factor in series.products.iter().flatten().chain(&series.squares) {
            if !factors.contains(factor) {
                factors.push(*factor);
            }
        }
        Places {
            emitter,
            series,
            factors,
            rows,
            moved,
            before,
            numbers: StableMap::default(),
            reciprocals: StableMap::default(),
        }
    }

    fn graph(&self) -> &Graph {
        &self.emitter.e.model.graph
    }

    fn row(&self, id: Id) -> usize {
        self.rows.get(&id).copied().unwrap_or(0)
    }

    /// The coefficient of order 0 of a node.
    fn zeroth(&self, id: Id) -> TokenStream {
        let (rules, n) = (self.series.rules.len(), self.emitter.n());
        let place = match symbol(self.graph(), id) {
            Some(Symbol::Coordinate(i)) => rules + i,
            Some(Symbol::Velocity(i)) => rules + n + i,
            Some(_) => rules + 2 * n,
            None => self.row(id),
        };
        let place = at(place);
        quote!(zeroth[#place])
    }

    /// The coefficient of order `level` of a node.
    fn order(&self, id: Id) -> TokenStream {
        match symbol(self.graph(), id) {
            Some(Symbol::Coordinate(i)) => {
                let i = at(i);
                quote!(q[#i])
            }
            Some(Symbol::Velocity(i)) => {
                let i = at(i);
                quote!(qd[#i])
            }
            Some(_) => quote!(clock),
            None => {
                let name = row_name(self.row(id));
                quote!(#name)
            }
        }
    }

    /// The coefficient of order `level` of a factor of products.
    fn factor(&self, factor: Factor) -> TokenStream {
        match factor {
            Factor::Of(id) => self.order(id),
            Factor::Rate(id) => match symbol(self.graph(), id) {
                Some(Symbol::Coordinate(i)) => {
                    let i = at(i);
                    quote!(slower[#i])
                }
                _ => {
                    let x = self.order(id);
                    quote!(weight * #x)
                }
            },
            Factor::Unknown(i) => {
                let i = at(i);
                quote!(found[#i])
            }
        }
    }

    fn factor_zeroth(&self, factor: Factor) -> TokenStream {
        match factor {
            Factor::Of(id) => self.zeroth(id),
            Factor::Rate(_) => quote!(S::zero()),
            Factor::Unknown(i) => {
                let i = at(i);
                quote!(unknowns[#i])
            }
        }
    }

    /// `Σ_{0<j<k}` of a product of series: the inner sum, and what order 1 and the order before contribute.
    fn middle(&self, pair: [Factor; 2]) -> TokenStream {
        let (name, i, count) = match self.series.place(pair) {
            Place::Product(i) => (quote!(product), i, self.series.products.len()),
            Place::Square(i) => (quote!(square), i, self.series.squares.len()),
        };
        let (side, _) = blocks(count);
        let (block, place) = (at(i / side), at(i % side));
        let [a, b] = pair.map(|factor| at(self.factors.iter().position(|f| *f == factor).unwrap_or(0)));
        if pair[0] == pair[1] {
            return quote!((first[#a] + first[#a]).mul_add(last[#a], #name[#block][#place]));
        }
        quote!(first[#b].mul_add(last[#a], first[#a].mul_add(last[#b], #name[#block][#place])))
    }

    /// A constant factor in front of tokens that bind at least as tightly as a product.
    fn scaled(&self, k: Number, tokens: TokenStream) -> TokenStream {
        if k.is_one() {
            return tokens;
        }
        if k.is_unit() {
            return quote!(-#tokens);
        }
        let k = body::constant(k);
        quote!(#k * #tokens)
    }

    /// A number as a variable or literal.
    fn number(&self, v: Value) -> TokenStream {
        match self.numbers.get(&v) {
            Some(variable) => variable.clone(),
            None => body::constant(v.k),
        }
    }

    fn reciprocal(&self, id: Id) -> TokenStream {
        self.reciprocals.get(&id).cloned().unwrap_or(quote!(S::one()))
    }

    /// The statements of some rows.
    fn steps(&self, rows: impl Iterator<Item = usize>, velocities: Velocities) -> TokenStream {
        let steps = rows.map(|row| {
            let (id, rule) = &self.series.rules[row];
            let (name, value) = (row_name(row), self.coefficient(*id, rule, velocities));
            quote!(let #name = #value;)
        });
        quote!(#(#steps)*)
    }

    /// The coefficient of order `level` of a node, if there is one.
    fn present(&self, id: Id, velocities: Velocities) -> Option<TokenStream> {
        let velocity = matches!(symbol(self.graph(), id), Some(Symbol::Velocity(_)));
        (velocities == Velocities::Known || !velocity).then(|| self.order(id))
    }

    /// The coefficient of order `level` of a value that moves.
    fn value(&self, v: Value, velocities: Velocities) -> Option<TokenStream> {
        let id = v.node.filter(|_| !is_number(self.graph(), v))?;
        Some(self.scaled(v.k, self.present(id, velocities)?))
    }

    /// A sum of values that move, each times a number.
    fn linear(&self, terms: &[(Value, Value)], value: impl Fn(Value) -> Option<TokenStream>) -> TokenStream {
        let terms = terms.iter().filter_map(|(factor, x)| {
            let x = value(*x)?;
            Some(if *factor == Value::ONE {
                x
            } else {
                let factor = self.number(*factor);
                quote!(#factor * #x)
            })
        });
        sum(terms)
    }

    /// The coefficient of order `level`.
    fn coefficient(&self, own: Id, rule: &Rule, velocities: Velocities) -> TokenStream {
        let convolutions = rule.convolutions(own);
        let middle = |i: usize| self.middle(convolutions[i]);
        let present = |id: Id| self.present(id, velocities);
        // `sum`, and a node's coefficient times another's of order 0.
        let with = |sum: TokenStream, of: Id, other: Id| match present(of) {
            Some(x) => {
                let other = self.zeroth(other);
                quote!(#x.mul_add(#other, #sum))
            }
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
                Some(x) => {
                    let (sum, leading) = (middle(0), self.zeroth(*a));
                    quote!((#x + #x).mul_add(#leading, #sum))
                }
                None => middle(0),
            },
            Rule::Quotient(a, b) => {
                let (sum, over) = (with(middle(0), *b, own), self.reciprocal(*b));
                let a = self.value(*a, velocities).unwrap_or(quote!(S::zero()));
                quote!((#a - #sum) * #over)
            }
            Rule::Root(a) => {
                let (sum, over) = (middle(0), self.reciprocal(own));
                let a = self.value(*a, velocities).unwrap_or(quote!(S::zero()));
                quote!((#a - #sum) * (S::from_f64(0.5) * #over))
            }
            Rule::Power(a, r) => {
                let (rates, sum, own, r) = (middle(0), middle(1), self.zeroth(own), self.number(*r));
                let over = self.reciprocal(*a);
                let newest = present(*a).map(|x| quote!(+ #r * #x * #own));
                quote!(((#r + S::one()) * over * #rates - #sum #newest) * #over)
            }
            Rule::Function(slopes) => {
                let mut next = 0;
                sum(slopes.iter().filter_map(|slope| match slope {
                    Slope::Number(slope, x) => {
                        let (slope, x) = (self.number(*slope), self.value(*x, velocities)?);
                        Some(quote!(#slope * #x))
                    }
                    Slope::Known(k, product) => {
                        let i = at(self.before.iter().position(|id| id == product).unwrap_or(0));
                        Some(self.scaled(*k, quote!(before[#i] * over)))
                    }
                    Slope::Rate(k, a, slope) => {
                        let sum = middle(next);
                        next += 1;
                        let slope = self.zeroth(*slope);
                        let newest = match present(*a) {
                            Some(x) => quote!(#x * #slope),
                            None => quote!(S::zero()),
                        };
                        Some(self.scaled(*k, quote!(#sum.mul_add(over, #newest))))
                    }
                }))
            }
        }
    }

    /// What velocities `given` add to a value, by names of the nodes' changes.
    fn change(&self, v: Value) -> Option<TokenStream> {
        let id = v.node?;
        let change = match symbol(self.graph(), id) {
            Some(Symbol::Velocity(i)) => {
                let i = at(i);
                quote!(given[#i])
            }
            Some(_) => return None,
            None => {
                let row = *self.rows.get(&id)?;
                self.moved.binary_search(&row).ok()?;
                let name = row_name(row);
                quote!(#name)
            }
        };
        Some(self.scaled(v.k, change))
    }

    fn change_by(&self, own: Id, rule: &Rule) -> TokenStream {
        let of = |id: Id| self.change(id.into());
        match rule {
            Rule::Linear(terms) => self.linear(terms, |x| self.change(x)),
            Rule::Product(a, b) => sum([(a, b), (b, a)].into_iter().filter_map(|(a, b)| {
                let (change, other) = (of(*a)?, self.zeroth(*b));
                Some(quote!(#change * #other))
            })),
            Rule::Square(a) => {
                let (change, leading) = (of(*a), self.zeroth(*a));
                quote!(#change * (#leading + #leading))
            }
            Rule::Quotient(a, b) => {
                let (own, over) = (self.zeroth(own), self.reciprocal(*b));
                let under = of(*b).map(|change| quote!(-#change * #own));
                let changes = sum(self.change(*a).into_iter().chain(under));
                quote!((#changes) * #over)
            }
            Rule::Root(a) => {
                let (change, over) = (self.change(*a), self.reciprocal(own));
                quote!(#change * (S::from_f64(0.5) * #over))
            }
            Rule::Power(a, r) => {
                let (change, r, own, over) = (of(*a), self.number(*r), self.zeroth(own), self.reciprocal(*a));
                quote!(#change * (#r * #own * #over))
            }
            Rule::Function(slopes) => sum(slopes.iter().filter_map(|slope| match slope {
                Slope::Number(slope, x) => {
                    let (slope, change) = (self.number(*slope), self.change(*x)?);
                    Some(quote!(#slope * #change))
                }
                Slope::Known(..) => None,
                Slope::Rate(k, a, slope) => {
                    let (change, slope) = (of(*a)?, self.zeroth(*slope));
                    Some(self.scaled(*k, quote!(#change * #slope)))
                }
            })),
        }
    }

    fn solving(&self, firsts: &[TokenStream], arguments: &TokenStream, names: &TokenStream) -> Solving {
        let (g, n) = (self.graph(), self.emitter.n());
        let runtime = &self.emitter.e.model.runtime;
        let value = |v: &Value| self.value(*v, Velocities::Known).unwrap_or(quote!(S::zero()));
        let velocities = (0..n).map(|i| {
            let i = at(i);
            quote!(qd[#i])
        });
        let velocities = quote!([#(#velocities),*]);
        let all = self.steps(0..self.series.rules.len(), Velocities::Known);
        match &self.series.outputs {
            Outputs::Accelerations(accel) => {
                let next = accel.iter().map(value);
                Solving {
                    size: None,
                    respond: TokenStream::new(),
                    first: quote!(let mut rates = [#velocities, motion.push(0, [#(#firsts),*])];),
                    next: quote!(#all let accelerations = [#(#next),*];),
                    last: quote!(*rates = [qd, motion.push(level, accelerations)];),
                }
            }
            Outputs::System { matrix, right } => {
                let size = right.len();
                let (entries, rights) = firsts.split_at(firsts.len() - size);
                let rows = (0..size).map(|i| {
                    // The lower triangle, by rows; only that is read.
                    let lower = &entries[i * (i + 1) / 2..][..=i];
                    let row = lower.iter().cloned().chain((i + 1..size).map(|_| quote!(S::zero())));
                    quote!([#(#row),*])
                });
                let next = (0..size).map(|i| {
                    let mut sum = value(&right[i]);
                    for j in 0..size {
                        let m = entry(matrix, i, j);
                        let (Some(pair), Some(id)) = (tail(g, m, j), m.node) else { continue };
                        let (middle, x, j) = (self.middle(pair), self.order(id), at(j));
                        let product = self.scaled(m.k, quote!(#x.mul_add(unknowns[#j], #middle)));
                        sum = quote!(#sum - #product);
                    }
                    sum
                });
                let accelerations = (0..n).map(|i| {
                    let i = at(i);
                    quote!(found[#i])
                });
                let accelerations = quote!([#(#accelerations),*]);
                Solving {
                    size: Some(size),
                    respond: TokenStream::new(),
                    first: quote! {
                        let solver = #runtime::series::Solver::<S, #size>::new([#(#rows),*]);
                        let mut unknowns = solver.solve([#(#rights),*]);
                        let found = unknowns;
                        let mut rates = [#velocities, motion.push(0, #accelerations)];
                    },
                    next: quote!(#all let found = solver.solve([#(#next),*]);),
                    last: quote!(*rates = [qd, motion.push(level, #accelerations)];),
                }
            }
            Outputs::Momenta { momenta, force } => {
                let (count, rules) = (self.moved.len(), &self.series.rules);
                let changes = self.moved.iter().map(|&row| {
                    let (id, rule) = &rules[row];
                    let (name, change) = (row_name(row), self.change_by(*id, rule));
                    quote!(let #name = #change;)
                });
                let named = self.moved.iter().map(|&row| row_name(row));
                let changed = momenta.iter().map(|p| self.change(*p).unwrap_or(quote!(S::zero())));
                let respond = quote! {
                    /// What velocities do to the nodes that momenta are made of, and to the momenta.
                    #[inline(always)]
                    fn respond<S: #runtime::Scalar>(#arguments, given: &[S; #n]) -> ([S; #count], [S; #n]) {
                        #names
                        #(#changes)*
                        ([#(#named),*], [#(#changed),*])
                    }
                };
                let force_zeroth = force.iter().map(|f| match f.node {
                    Some(id) if !is_number(g, *f) => self.scaled(f.k, self.zeroth(id)),
                    _ => self.number(*f),
                });
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
                    let (i, without) = (at(i), self.value(*p, Velocities::Unknown).map(|p| quote!(- (#p))));
                    quote!(given[#i] #without)
                });
                let corrected = self.moved.iter().enumerate().map(|(i, &row)| {
                    let (name, i) = (row_name(row), at(i));
                    quote!(let #name = #name + changes[#i];)
                });
                let next_force = force.iter().map(value);
                Solving {
                    size: Some(n),
                    respond,
                    first: quote! {
                        // M by columns: the momenta of unit velocities.
                        let mut columns = [[S::zero(); #n]; #n];
                        for j in 0..#n {
                            let mut unit = [S::zero(); #n];
                            unit[j] = S::one();
                            columns[j] = respond(&numbers, &reciprocals, &zeroth, &unit).1;
                        }
                        let solver = #runtime::series::Solver::<S, #n>::new(columns);
                        let mut rates = [#velocities; 2];
                        let mut unknowns = {
                            let (numbers, reciprocals) = (&numbers, &reciprocals);
                            #names
                            [#(#force_zeroth),*]
                        };
                    },
                    next: quote! {
                        #early
                        let given = #runtime::series::divided(*unknowns, level);
                        let qd = solver.solve([#(#rights),*]);
                        let changes = respond(numbers, reciprocals, zeroth, &qd).0;
                        #(#corrected)*
                        #late
                        *unknowns = [#(#next_force),*];
                    },
                    last: quote! {
                        motion.push_velocities(level, qd);
                        *rates = [qd; 2];
                    },
                }
            }
        }
    }
}

/// Are those of this order known yet?
#[derive(Clone, Copy, PartialEq)]
enum Velocities {
    Known,
    Unknown,
}

fn sum(terms: impl Iterator<Item = TokenStream>) -> TokenStream {
    let terms: Vec<TokenStream> = terms.collect();
    if terms.is_empty() { quote!(S::zero()) } else { quote!(#(#terms)+*) }
}
