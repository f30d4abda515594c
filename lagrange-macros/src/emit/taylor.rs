//! The recurrences of the Taylor series: order 0, and a function for each further one.

use super::{Emitter, body};
use crate::equations::series::{Outputs, Rule, Series, is_number, symbol};
use crate::equations::solve::entry;
use crate::graph::{Id, Symbol, Value, stable_map::StableMap};
use crate::model::Model;
use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

/// Systems of at most this many products of series have their orders written out one by one by the optimiser, which makes
/// of rows values in registers and of sums straight lines; others loop.
const STRAIGHT: usize = 40;

/// Where the coefficients and the numbers of the recurrences are.
struct Places<'a> {
    emitter: &'a Emitter<'a>,
    /// Rows of the workspace, by nodes.
    rows: StableMap<Id, usize>,
    /// Rows of derivatives with respect to time, by nodes on which functions act.
    rates: StableMap<Id, usize>,
    /// Numbers, as variables.
    numbers: StableMap<Value, TokenStream>,
}

impl Emitter<'_> {
    /// The implementation of the runtime's `Analytic`.
    pub fn analytic(&self) -> TokenStream {
        let Some(series) = &self.e.series else { return TokenStream::new() };
        let Model { name, runtime, graph: g, .. } = &self.e.model;
        let n = self.n();

        // Order 0 by the functions themselves: every node that has a series, every number, every output.
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
                Rule::Function(slopes) => slopes.iter().for_each(|(_, slope)| note(*slope)),
                Rule::Product(..) | Rule::Square(_) | Rule::Quotient(..) => {}
            }
        }
        let outputs = series.outputs.values();
        let nodes = series.rules.iter().map(|(id, _)| Value::from(*id));
        let all: Vec<Value> = nodes.chain(numbers.iter().copied()).chain(outputs.iter().copied()).collect();
        let (statements, values) = self.statements(&all);
        let values = values.each();
        let (of_nodes, rest) = values.split_at(series.rules.len());
        let (of_numbers, of_outputs) = rest.split_at(numbers.len());

        let mut places = Places {
            emitter: self,
            rows: StableMap::default(),
            rates: StableMap::default(),
            numbers: StableMap::default(),
        };
        for (row, (id, _)) in series.rules.iter().enumerate() {
            places.rows.insert(*id, row);
        }
        let (mut count, mut symbols) = (series.rules.len(), Vec::new());
        for (_, rule) in &series.rules {
            let Rule::Function(slopes) = rule else { continue };
            for id in slopes.iter().filter(|(_, slope)| !is_number(g, *slope)).filter_map(|(x, _)| x.node) {
                // Of a coordinate it is the velocity.
                if !matches!(symbol(g, id), Some(Symbol::Coordinate(_))) && places.rates.get(&id).is_none() {
                    places.rates.insert(id, count);
                    count += 1;
                    if symbol(g, id).is_some() {
                        symbols.push(id);
                    }
                }
            }
        }
        let variables: Vec<_> = (0..numbers.len()).map(|i| format_ident!("number_{i}")).collect();
        for (number, variable) in numbers.iter().zip(&variables) {
            places.numbers.insert(*number, quote!(#variable));
        }
        let symbols = symbols.into_iter().filter_map(|id| places.next_rate(id));
        let firsts = of_nodes.iter().enumerate().map(|(row, value)| {
            let row = Literal::usize_unsuffixed(row);
            quote!(rows[#row][0] = #value;)
        });
        let steps = series.rules.iter().enumerate().map(|(row, (id, rule))| {
            let value = places.coefficient(row, rule);
            let row = Literal::usize_unsuffixed(row);
            let rate = places.next_rate(*id);
            quote!(rows[#row][level] = #value; #rate)
        });
        let Steps { size, prepared, first, next } = places.outputs(series, of_outputs);
        let (solver, solver_type) = match size {
            Some(size) => (
                quote!(, &solver, &mut unknowns),
                quote!(solver: &#runtime::series::Solver<S, #size>, unknowns: &mut [[S; K]; #size],),
            ),
            None => Default::default(),
        };
        let known = numbers.len();
        let advance = quote!(advance(level, &numbers, &mut rows, &mut motion #solver));
        let orders = if series.products(g) <= STRAIGHT {
            quote!(#runtime::series::orders!(1..order.min(K), level => #advance);)
        } else {
            quote!(for level in 1..order.min(K) { #advance; })
        };
        quote! {
            impl<S: #runtime::Scalar> #runtime::Analytic<#n> for #name<S> {
                fn series<const K: usize>(
                    &self,
                    at: &#runtime::State<S, #n>,
                    order: usize,
                ) -> #runtime::Series<S, #n, K> {
                    use #runtime::series::{power, product, quotient, square, tail};
                    /// The coefficients of order `level` from those before.
                    #[inline(always)]
                    fn advance<S: #runtime::Scalar, const K: usize>(
                        level: usize,
                        numbers: &[S; #known],
                        rows: &mut [[S; K]; #count],
                        motion: &mut #runtime::Series<S, #n, K>,
                        #solver_type
                    ) {
                        let weight = S::from_f64(level as f64);
                        let over = S::from_f64(1.0 / level as f64);
                        let [#(#variables),*] = *numbers;
                        #(#symbols)*
                        #(#steps)*
                        motion.push(level, #next);
                    }
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    #statements
                    let numbers = [#(#of_numbers),*];
                    let mut rows = [[S::zero(); K]; #count];
                    #(#firsts)*
                    let mut motion = #runtime::Series::new(at);
                    #prepared
                    motion.push(0, #first);
                    #orders
                    motion
                }
            }
        }
    }
}

/// What is done with the outputs of each order.
struct Steps {
    /// Of the matrix, if accelerations come from one.
    size: Option<usize>,
    prepared: TokenStream,
    /// Accelerations of order 0 and of order k.
    first: TokenStream,
    next: TokenStream,
}

impl Places<'_> {
    /// The series of a node, as an array.
    fn array(&self, id: Id) -> TokenStream {
        let at = Literal::usize_unsuffixed;
        match symbol(&self.emitter.e.model.graph, id) {
            Some(Symbol::Coordinate(i)) => {
                let i = at(i);
                quote!(motion.q[#i])
            }
            Some(Symbol::Velocity(i)) => {
                let i = at(i);
                quote!(motion.qd[#i])
            }
            Some(_) => quote!(motion.t),
            None => {
                let row = at(self.rows.get(&id).copied().unwrap_or(0));
                quote!(rows[#row])
            }
        }
    }

    /// The series of the derivative of a node with respect to time.
    fn rate(&self, id: Id) -> TokenStream {
        let at = Literal::usize_unsuffixed;
        match symbol(&self.emitter.e.model.graph, id) {
            Some(Symbol::Coordinate(i)) => {
                let i = at(i);
                quote!(motion.qd[#i])
            }
            _ => {
                let row = at(self.rates.get(&id).copied().unwrap_or(0));
                quote!(rows[#row])
            }
        }
    }

    /// The row of the product of a coordinate's velocity and a slope, if the equations have it anyway.
    fn known_rate(&self, id: Id, slope: Id) -> Option<Literal> {
        let g = &self.emitter.e.model.graph;
        let Some(Symbol::Coordinate(i)) = symbol(g, id) else { return None };
        let velocity = |id: Id| symbol(g, id) == Some(Symbol::Velocity(i));
        let mut rules = self.emitter.e.series.iter().flat_map(|series| &series.rules);
        let (product, _) = rules.find(|(_, rule)| {
            matches!(*rule, Rule::Product(a, b) if velocity(a) && b == slope || velocity(b) && a == slope)
        })?;
        self.rows.get(product).map(|row| Literal::usize_unsuffixed(*row))
    }

    /// The last coefficient of the derivative of a node, if a function asks for it.
    fn next_rate(&self, id: Id) -> Option<TokenStream> {
        let (row, array) = (Literal::usize_unsuffixed(*self.rates.get(&id)?), self.array(id));
        Some(quote!(rows[#row][level - 1] = weight * #array[level];))
    }

    /// A constant factor in front of tokens that bind at least as tightly as a product.
    fn scaled(&self, k: crate::graph::Number, tokens: TokenStream) -> TokenStream {
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

    /// The k-th coefficient of a value that moves; 0 of one that does not.
    fn at_k(&self, v: Value) -> Option<TokenStream> {
        let id = v.node.filter(|_| !is_number(&self.emitter.e.model.graph, v))?;
        let array = self.array(id);
        Some(self.scaled(v.k, quote!(#array[level])))
    }

    fn coefficient(&self, row: usize, rule: &Rule) -> TokenStream {
        let g = &self.emitter.e.model.graph;
        let own = {
            let row = Literal::usize_unsuffixed(row);
            quote!(rows[#row])
        };
        match rule {
            Rule::Linear(terms) => {
                let terms: Vec<TokenStream> = terms
                    .iter()
                    .filter_map(|(factor, x)| {
                        let x = self.at_k(*x)?;
                        Some(if *factor == Value::ONE {
                            x
                        } else {
                            let factor = self.number(*factor);
                            quote!(#factor * #x)
                        })
                    })
                    .collect();
                quote!(#(#terms)+*)
            }
            Rule::Product(a, b) => {
                let (a, b) = (self.array(*a), self.array(*b));
                quote!(product(&#a, &#b, level))
            }
            Rule::Square(a) => {
                let a = self.array(*a);
                quote!(square(&#a, level))
            }
            Rule::Quotient(a, b) => {
                let b = self.array(*b);
                let a = self.at_k(*a).unwrap_or(quote!(S::zero()));
                quote!(quotient(#a, &#b, &#own, level))
            }
            Rule::Power(a, r) => {
                let (Some(id), r) = (a.node, self.number(*r)) else { return quote!(S::zero()) };
                let a = self.array(id);
                quote!(power(&#a, #r, &#own, level))
            }
            Rule::Function(slopes) => {
                let terms = slopes.iter().filter_map(|(argument, slope)| {
                    let id = argument.node?;
                    let k = argument.k.mul(slope.k);
                    if is_number(g, *slope) {
                        let (slope, x) = (self.number(*slope), self.at_k(*argument)?);
                        return Some(quote!(#slope * #x));
                    }
                    let sum = match self.known_rate(id, slope.node?) {
                        Some(row) => quote!(rows[#row][level - 1]),
                        None => {
                            let (rate, slope) = (self.rate(id), self.array(slope.node?));
                            quote!(product(&#rate, &#slope, level - 1))
                        }
                    };
                    Some(self.scaled(k, quote!(#sum * over)))
                });
                quote!(#(#terms)+*)
            }
        }
    }

    fn outputs(&self, series: &Series, firsts: &[TokenStream]) -> Steps {
        let runtime = &self.emitter.e.model.runtime;
        let n = self.emitter.n();
        match &series.outputs {
            Outputs::Accelerations(accel) => {
                let next = accel.iter().map(|a| self.at_k(*a).unwrap_or(quote!(S::zero())));
                let (first, next) = (quote!([#(#firsts),*]), quote!([#(#next),*]));
                Steps { size: None, prepared: TokenStream::new(), first, next }
            }
            Outputs::System { matrix, right } => {
                let size = right.len();
                let g = &self.emitter.e.model.graph;
                let (entries, rights) = firsts.split_at(firsts.len() - size);
                let rows = (0..size).map(|i| {
                    // The lower triangle, by rows; only that is read.
                    let lower = &entries[i * (i + 1) / 2..][..=i];
                    let row = lower.iter().cloned().chain((i + 1..size).map(|_| quote!(S::zero())));
                    quote!([#(#row),*])
                });
                let next = (0..size).map(|i| {
                    let mut sum = self.at_k(right[i]).unwrap_or(quote!(S::zero()));
                    for j in 0..size {
                        let m = entry(matrix, i, j);
                        if is_number(g, m) {
                            continue;
                        }
                        let Some(id) = m.node else { continue };
                        let (array, j) = (self.array(id), Literal::usize_unsuffixed(j));
                        let product = self.scaled(m.k, quote!(tail(&#array, &unknowns[#j], level)));
                        sum = quote!(#sum - #product);
                    }
                    sum
                });
                let prepared = quote! {
                    let mut unknowns = [[S::zero(); K]; #size];
                    let solver = #runtime::series::Solver::<S, #size>::new([#(#rows),*]);
                };
                let first = quote!(solver.solve::<#n, K>(0, [#(#rights),*], &mut unknowns));
                let next = quote!({
                    let right = [#(#next),*];
                    solver.solve::<#n, K>(level, right, unknowns)
                });
                Steps { size: Some(size), prepared, first, next }
            }
        }
    }
}
