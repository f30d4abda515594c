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
    /// Rows of the nodes that move with accelerations found from a balance.
    moved: Vec<usize>,
    /// Products whose coefficients of the order before give those of functions, as `before[i]`.
    before: Vec<Id>,
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
        let outputs = series.outputs.values();
        let numbers = numbers(g, series);
        let all: Vec<Value> = series.zeroth.iter().chain(&numbers).chain(&outputs).copied().collect();
        let all: Vec<Value> = match series.outputs {
            // The forces of order 0 are made of the nodes' values.
            Outputs::Balance(_) => all[..all.len() - outputs.len()].to_vec(),
            _ => all,
        };
        let (statements, values) = self.statements(&all);
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

        let steps = series.rules.iter().enumerate().map(|(row, (id, rule))| {
            let (name, value) = (row_name(row), places.coefficient(*id, rule));
            quote!(let #name = #value;)
        });
        let before_zeroth = places.before.iter().map(|id| places.zeroth(*id));
        let before = places.before.iter().map(|id| places.order(*id).unwrap_or(quote!(S::zero())));
        let Solving { size, respond, prepared, first, next } = places.solving(of_outputs, &arguments, &names);
        let (solver, solver_type) = match size {
            Some(size) => {
                (quote!(&solver, &unknowns,), quote!(solver: &#runtime::series::Solver<S, #size>, unknowns: &[S; #size],))
            }
            None => Default::default(),
        };
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
                level, &numbers, &reciprocals, &zeroth, #solver &mut before, &mut products, &mut squares, &mut rates,
                &mut motion
            )
        };
        let orders = if series.products.len() + series.squares.len() <= STRAIGHT {
            quote!(#runtime::series::orders!(1..order.min(K), level => #advance);)
        } else {
            quote!(for level in 1..order.min(K) { #advance; })
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
                        #(#steps)*
                        #next
                        *before = [#(#before),*];
                        products.push(level, #left, #right);
                        squares.push(level, #of_squares);
                        *rates = [qd, motion.push(level, accelerations)];
                    }
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    #statements
                    let numbers = [#(#of_numbers),*];
                    let zeroth = [#(#of_nodes,)* #(#coordinates,)* #(#velocities,)* t];
                    let reciprocals = [#(#reciprocals),*];
                    #prepared
                    #first
                    let mut before = [#(#before_zeroth),*];
                    let mut motion = #runtime::Series::new(at);
                    let mut products = Products::<S, #wide, #deep, K>::new();
                    let mut squares = Squares::<S, #square_wide, #square_deep, K>::new();
                    products.push(0, #left_zeroth, #right_zeroth);
                    squares.push(0, #squares_zeroth);
                    let mut rates = [[#(#velocities),*], motion.push(0, accelerations)];
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
    if let Outputs::Balance(forces) = &series.outputs {
        forces.iter().for_each(|force| note(*force));
    }
    numbers
}

/// How accelerations come from the nodes.
struct Solving {
    /// Of the matrix, if they come from one.
    size: Option<usize>,
    /// A function that says what accelerations do to the nodes and to the forces.
    respond: TokenStream,
    /// The solver.
    prepared: TokenStream,
    /// Accelerations of order 0 and of order k.
    first: TokenStream,
    next: TokenStream,
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
            Outputs::Balance(_) => series.moved(&emitter.e.model.graph),
            _ => Vec::new(),
        };
        Places {
            emitter,
            series,
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
            Some(Symbol::Acceleration(i)) => {
                let i = at(i);
                return quote!(unknowns[#i]);
            }
            Some(_) => rules + 2 * n,
            None => self.row(id),
        };
        let place = at(place);
        quote!(zeroth[#place])
    }

    /// The coefficient of order `level` of a node; none of an acceleration, which is found last.
    fn order(&self, id: Id) -> Option<TokenStream> {
        Some(match symbol(self.graph(), id) {
            Some(Symbol::Coordinate(i)) => {
                let i = at(i);
                quote!(q[#i])
            }
            Some(Symbol::Velocity(i)) => {
                let i = at(i);
                quote!(qd[#i])
            }
            Some(Symbol::Acceleration(_)) => return None,
            Some(_) => quote!(clock),
            None => {
                let name = row_name(self.row(id));
                quote!(#name)
            }
        })
    }

    /// The coefficient of order `level` of a factor of products, when all is known.
    fn factor(&self, factor: Factor) -> TokenStream {
        let unknown = |i: usize| {
            let i = at(i);
            quote!(found[#i])
        };
        match factor {
            Factor::Of(id) => match symbol(self.graph(), id) {
                Some(Symbol::Acceleration(i)) => unknown(i),
                _ => self.order(id).unwrap_or(quote!(S::zero())),
            },
            Factor::Rate(id) => match symbol(self.graph(), id) {
                Some(Symbol::Coordinate(i)) => {
                    let i = at(i);
                    quote!(slower[#i])
                }
                _ => {
                    let x = self.order(id).unwrap_or(quote!(S::zero()));
                    quote!(weight * #x)
                }
            },
            Factor::Unknown(i) => unknown(i),
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

    /// The inner sum of a product of series.
    fn middle(&self, pair: [Factor; 2]) -> TokenStream {
        let (name, i, count) = match self.series.place(pair) {
            Place::Product(i) => (quote!(product), i, self.series.products.len()),
            Place::Square(i) => (quote!(square), i, self.series.squares.len()),
        };
        let (side, _) = blocks(count);
        let (block, place) = (at(i / side), at(i % side));
        quote!(#name[#block][#place])
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

    /// The coefficient of order `level` of a value that moves.
    fn value(&self, v: Value) -> Option<TokenStream> {
        let id = v.node.filter(|_| !is_number(self.graph(), v))?;
        Some(self.scaled(v.k, self.order(id)?))
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
        let terms: Vec<TokenStream> = terms.collect();
        if terms.is_empty() { quote!(S::zero()) } else { quote!(#(#terms)+*) }
    }

    /// The coefficient of order `level`, accelerations of this order taken for zero.
    fn coefficient(&self, own: Id, rule: &Rule) -> TokenStream {
        let convolutions = rule.convolutions(own);
        let middle = |i: usize| self.middle(convolutions[i]);
        match rule {
            Rule::Linear(terms) => self.linear(terms, |x| self.value(x)),
            Rule::Product(a, b) => {
                // The operand that is known last is added last.
                let (early, late) = if a > b { (*b, *a) } else { (*a, *b) };
                let mut sum = middle(0);
                for (of, other) in [(early, late), (late, early)] {
                    if let Some(x) = self.order(of) {
                        let other = self.zeroth(other);
                        sum = quote!(#x.mul_add(#other, #sum));
                    }
                }
                sum
            }
            Rule::Square(a) => {
                let (sum, x, leading) = (middle(0), self.order(*a), self.zeroth(*a));
                quote!((#x + #x).mul_add(#leading, #sum))
            }
            Rule::Quotient(a, b) => {
                let (sum, own, over) = (middle(0), self.zeroth(own), self.reciprocal(*b));
                let a = self.value(*a).unwrap_or(quote!(S::zero()));
                let b = self.order(*b);
                quote!((#a - #b.mul_add(#own, #sum)) * #over)
            }
            Rule::Root(a) => {
                let (sum, over) = (middle(0), self.reciprocal(own));
                let a = self.value(*a).unwrap_or(quote!(S::zero()));
                quote!((#a - #sum) * (S::from_f64(0.5) * #over))
            }
            Rule::Power(a, r) => {
                let (rates, sum, own, r) = (middle(0), middle(1), self.zeroth(own), self.number(*r));
                let (x, over) = (self.order(*a), self.reciprocal(*a));
                quote!(((#r + S::one()) * over * #rates - #sum + #r * #x * #own) * #over)
            }
            Rule::Function(slopes) => {
                let mut next = 0;
                let terms = slopes.iter().filter_map(|slope| match slope {
                    Slope::Number(slope, x) => {
                        let (slope, x) = (self.number(*slope), self.value(*x)?);
                        Some(quote!(#slope * #x))
                    }
                    Slope::Known(k, product) => {
                        let i = at(self.before.iter().position(|id| id == product).unwrap_or(0));
                        Some(self.scaled(*k, quote!(before[#i] * over)))
                    }
                    Slope::Rate(k, a, slope) => {
                        let sum = middle(next);
                        next += 1;
                        let (x, slope) = (self.order(*a)?, self.zeroth(*slope));
                        Some(self.scaled(*k, quote!(#sum.mul_add(over, #x * #slope))))
                    }
                });
                let terms: Vec<TokenStream> = terms.collect();
                quote!(#(#terms)+*)
            }
        }
    }

    /// What accelerations `given` add to a value, by names of the nodes' changes.
    fn change(&self, v: Value) -> Option<TokenStream> {
        let id = v.node?;
        let change = match symbol(self.graph(), id) {
            Some(Symbol::Acceleration(i)) => {
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

    fn change_by(&self, rule: &Rule) -> TokenStream {
        match rule {
            Rule::Linear(terms) => self.linear(terms, |x| self.change(x)),
            Rule::Product(a, b) => {
                let (moving, still) = if self.change((*a).into()).is_some() { (*a, *b) } else { (*b, *a) };
                let (change, still) = (self.change(moving.into()), self.zeroth(still));
                quote!(#change * #still)
            }
            Rule::Quotient(a, b) => {
                let (change, over) = (self.change(*a), self.reciprocal(*b));
                quote!(#change * #over)
            }
            // Refused where accelerations are in them.
            Rule::Square(_) | Rule::Root(_) | Rule::Power(..) | Rule::Function(_) => quote!(S::zero()),
        }
    }

    fn solving(&self, firsts: &[TokenStream], arguments: &TokenStream, names: &TokenStream) -> Solving {
        let (g, n) = (self.graph(), self.emitter.n());
        let runtime = &self.emitter.e.model.runtime;
        let value = |v: &Value| self.value(*v).unwrap_or(quote!(S::zero()));
        match &self.series.outputs {
            Outputs::Accelerations(accel) => {
                let next = accel.iter().map(value);
                Solving {
                    size: None,
                    respond: TokenStream::new(),
                    prepared: TokenStream::new(),
                    first: quote!(let accelerations = [#(#firsts),*];),
                    next: quote!(let accelerations = [#(#next),*];),
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
                let accelerations = quote!(let accelerations = [#(#accelerations),*];);
                Solving {
                    size: Some(size),
                    respond: TokenStream::new(),
                    prepared: quote!(let solver = #runtime::series::Solver::<S, #size>::new([#(#rows),*]);),
                    first: quote! {
                        let unknowns = solver.solve([#(#rights),*]);
                        let found = unknowns;
                        #accelerations
                    },
                    next: quote! {
                        let found = solver.solve([#(#next),*]);
                        #accelerations
                    },
                }
            }
            Outputs::Balance(forces) => {
                let count = self.moved.len();
                let rules = &self.series.rules;
                let changes = self.moved.iter().map(|&row| {
                    let (name, change) = (row_name(row), self.change_by(&rules[row].1));
                    quote!(let #name = #change;)
                });
                let named = self.moved.iter().map(|&row| row_name(row));
                let changed_forces = forces.iter().map(|f| self.change(*f).unwrap_or(quote!(S::zero())));
                let respond = quote! {
                    /// What accelerations do to the nodes that move with them, and to the forces that are in balance.
                    #[inline(always)]
                    fn respond<S: #runtime::Scalar>(#arguments, given: &[S; #n]) -> ([S; #count], [S; #n]) {
                        #names
                        #(#changes)*
                        ([#(#named),*], [#(#changed_forces),*])
                    }
                };
                let respond_to = |given: TokenStream, by: TokenStream| {
                    quote!(respond(#by numbers, #by reciprocals, #by zeroth, #given))
                };
                let column = respond_to(quote!(&unit), quote!(&));
                let first = respond_to(quote!(&accelerations), quote!(&));
                let next_changes = respond_to(quote!(&found), quote!());
                let force_zeroth = |f: &Value| match f.node {
                    Some(id) if matches!(symbol(g, id), Some(Symbol::Acceleration(_))) => quote!(S::zero()),
                    Some(id) if !is_number(g, *f) => self.scaled(f.k, self.zeroth(id)),
                    _ => self.number(*f),
                };
                let firsts = forces.iter().map(force_zeroth);
                let next = forces.iter().map(value);
                let corrected_zeroth = self.moved.iter().enumerate().map(|(i, &row)| {
                    let (row, i) = (at(row), at(i));
                    quote!(zeroth[#row] += changes[#i];)
                });
                let corrected = self.moved.iter().enumerate().map(|(i, &row)| {
                    let (name, i) = (row_name(row), at(i));
                    quote!(let #name = #name + changes[#i];)
                });
                Solving {
                    size: Some(n),
                    respond,
                    prepared: quote! {
                        // M by columns: what unit accelerations take from the forces.
                        let mut columns = [[S::zero(); #n]; #n];
                        for j in 0..#n {
                            let mut unit = [S::zero(); #n];
                            unit[j] = S::one();
                            columns[j] = #column.1.map(|force| -force);
                        }
                        let solver = #runtime::series::Solver::<S, #n>::new(columns);
                    },
                    first: quote! {
                        let (numbers, reciprocals) = (&numbers, &reciprocals);
                        #names
                        let accelerations = solver.solve([#(#firsts),*]);
                        let unknowns = accelerations;
                        let changes = #first.0;
                        let mut zeroth = zeroth;
                        #(#corrected_zeroth)*
                    },
                    next: quote! {
                        let found = solver.solve([#(#next),*]);
                        let accelerations = found;
                        let changes = #next_changes.0;
                        #(#corrected)*
                    },
                }
            }
        }
    }
}
