//! The recurrences of the Taylor series: order 0, and a function for each further one.

use super::{
    Emitter, Results,
    body::{body, list},
    forced_inlining,
};
use crate::equations::series::{CONVOLUTIONS_PER_VECTOR, MAX_UNROLLED_CONVOLUTIONS, Recurrence, Series};
use crate::model::Model;
use proc_macro2::TokenStream;
use quote::quote;

const ZERO: &str = "S::zero()";

/// Elements and number of the vectors that so many numbers stand in: elements are as many as a vector of the
/// processor's may hold, if there are as many numbers; twice that in loops, which take turns less often.
fn blocks(n: usize) -> (usize, usize) {
    let side = n.next_power_of_two().clamp(
        1,
        if n <= MAX_UNROLLED_CONVOLUTIONS { CONVOLUTIONS_PER_VECTOR } else { 2 * CONVOLUTIONS_PER_VECTOR },
    );
    (side, n.div_ceil(side))
}

/// Expressions in blocks, the last one filled up.
fn in_blocks(all: &[String], filling: &str) -> String {
    let (side, _) = blocks(all.len());
    list(all.chunks(side).map(|block| {
        let rest = std::iter::repeat_n(filling, side - block.len());
        list(block.iter().map(String::as_str).chain(rest))
    }))
}

/// `[name_0, name_1, …]`, as which arrays are taken apart: each look into an array costs the compiler as much as ten
/// looks at variables.
fn variables(name: &str, n: usize) -> String {
    list((0..n).map(|i| format!("{name}_{i}")))
}

/// `[name[0], name[1], …]`
fn elements(name: &str, n: usize) -> Vec<String> {
    (0..n).map(|i| format!("{name}[{i}]")).collect()
}

/// Coefficients of one order, as they are written.
struct Order {
    factors: Vec<String>,
    memory: Vec<String>,
    accelerations: Vec<String>,
    velocities: Vec<String>,
    coordinates: Vec<String>,
    switching: Vec<String>,
}

impl Order {
    fn of(recurrence: &Recurrence, results: &[String]) -> Order {
        let mut results = results.iter().cloned();
        let mut next = |n: usize| -> Vec<String> { results.by_ref().take(n).collect() };
        Order {
            factors: next(recurrence.factors.len()),
            memory: next(recurrence.memory.len()),
            switching: next(recurrence.switching.len()),
            accelerations: next(recurrence.accelerations.len()),
            velocities: next(recurrence.velocities.len()),
            coordinates: results.collect(),
        }
    }

    /// The factors of convolutions, on the left and on the right, and of squares, in blocks.
    fn sides(&self, recurrence: &Recurrence, [products, squares]: &[Vec<usize>; 2]) -> [String; 3] {
        let factor = |place: &usize, side: usize| self.factors[recurrence.convolutions[*place][side]].clone();
        let side =
            |of: &[usize], side| in_blocks(&of.iter().map(|i| factor(i, side)).collect::<Vec<_>>(), ZERO);
        [side(products, 0), side(products, 1), side(squares, 0)]
    }
}

impl Emitter<'_> {
    /// The implementation of the runtime's `Analytic`.
    pub fn analytic(&self) -> TokenStream {
        let Some(series) = &self.d.equations.series else { return TokenStream::new() };
        let Model { name, runtime, .. } = &self.d.model;
        let n = self.n();
        // Where there are switches to be located, each number is compared for itself.
        let count = series.switches.len();
        let (bound, sides) = match count {
            0 => (quote!(Scalar), quote!(#runtime::series::Smooth)),
            _ => (quote!(SimdScalar), quote!(#runtime::series::Sides<S, #count>)),
        };
        let switching = self.switching(series);
        let roots = series.has_roots.then(|| {
            quote!(
                const ROOTS: bool = true;
            )
        });
        let long = series.is_long().then(|| {
            quote!(
                const LONG: bool = true;
            )
        });
        let inline = forced_inlining();
        let body = self.series(series, &bound, &sides);
        // In braces, since a type of the user's may be called K as well.
        quote! {
            impl<S: #runtime::#bound> #runtime::Analytic<#n> for #name<S> {
                type Sides = #sides;
                #roots
                #long
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
                    motion: &mut #runtime::TaylorSeries<S, #n, { K }>,
                ) -> [#sides; K] {
                    #body
                }
            }
        }
    }

    /// Values of the switching functions.
    fn switching(&self, series: &Series) -> TokenStream {
        let runtime = &self.d.model.runtime;
        if series.switches.is_empty() {
            return quote!(#runtime::series::Smooth);
        }
        let (statements, values) = self.statements(&series.switches);
        let values = values.array();
        quote! {
            let (q, qd, t) = (&at.q, &at.qd, at.t);
            #statements
            #runtime::series::Sides(#values)
        }
    }

    /// The body of `series_within`.
    fn series(&self, series: &Series, bound: &TokenStream, sides: &TokenStream) -> TokenStream {
        let (runtime, n) = (&self.d.model.runtime, self.n());
        let tokens = |text: &str| self.names.tokens(text);
        let (constant_count, recurrence) = (series.program.constants.len(), &series.recurrence);
        let (factor_count, memory_count) = (recurrence.factors.len(), recurrence.memory.len());
        let (statements, results) = self.statements(&series.start);
        let (constants, first) = results.written().split_at(constant_count);
        let first = Order::of(recurrence, first);

        let layout = recurrence.layout();
        let [products, squares] = &layout;
        let pairs = tokens(&list(products.iter().map(|i| list(recurrence.convolutions[*i]))));
        let squared = tokens(&list(squares.iter().map(|i| recurrence.convolutions[*i][0])));
        let (product_count, square_count) = (products.len(), squares.len());
        let (wide, deep) = blocks(product_count);
        let (square_wide, square_deep) = blocks(square_count);
        let row = if wide == 2 { quote!(S::Pair) } else { quote!([S; #wide]) };
        let [left, right, of_squares] = first.sides(recurrence, &layout).map(|text| tokens(&text));
        let advance = self.advance(series, (bound, sides, &row));

        let (kept, accelerations) = (recurrence.kept(), tokens(&list(&first.accelerations)));
        let rates = self.rates(recurrence, &elements("qd", n));
        let [factors, memory, constants] =
            [&first.factors[..], &first.memory, constants].map(|all| tokens(&list(all)));
        let switching = (!first.switching.is_empty()).then(|| {
            let values = tokens(&list(&first.switching));
            quote!(switching[0] = #runtime::series::Sides(#values);)
        });
        let call = quote! {
            advance(
                level, &constants, &mut before, &mut ends, &mut products, &mut squares, &mut factors, &mut rates,
                motion, &mut switching
            )
        };
        let end = match recurrence.further_orders() {
            0 => quote!(order.min(K)),
            1 => quote!((order + 1).min(K)),
            _ => quote!((order + 2).min(K)),
        };
        let orders = if recurrence.straight() {
            // Vectors need no straight lines, which would take long to compile.
            quote! {
                if S::WIDE || !#runtime::series::UNROLLED {
                    for level in 1..#end { #call; }
                } else {
                    #runtime::series::orders!(1..#end, level => #call);
                }
            }
        } else {
            quote!(for level in 1..#end { #call; })
        };
        let beyond = self.beyond(recurrence);
        let after = (!beyond.is_empty()).then(|| {
            quote! {
                if order + 2 < K {
                    #(motion.q[order + 2][#beyond] = S::zero();)*
                }
            }
        });
        quote! {
            use #runtime::series::{Factors, Over, Products, Squares};
            /// Factors of the products, and of the squares.
            const PAIRS: [[usize; 2]; #product_count] = #pairs;
            const SQUARED: [usize; #square_count] = #squared;
            #advance
            let (q, qd, t) = (&at.q, &at.qd, at.t);
            #statements
            let constants: [S; #constant_count] = #constants;
            motion.begin(at);
            let mut switching = [<#sides as #runtime::series::Switches<S>>::zero(); K];
            #switching
            let further = motion.push_of(0, &[#(#kept),*], #accelerations);
            let mut rates = #rates;
            let mut before: [S; #memory_count] = #memory;
            // Of order 1, which is known to be such from order 3 on, and of the order before.
            let mut ends = [[S::zero(); #factor_count]; 2];
            let mut products = Products::<#row, #deep, { K }>::new();
            let mut squares = Squares::<S, #square_wide, #square_deep, { K }>::new();
            let mut factors = Factors::<S, #factor_count, { K }>::new();
            if S::WIDE {
                factors.push(&#factors);
            } else {
                products.keep();
                products.push(0, #left, #right);
                squares.push(0, #of_squares);
            }
            #orders
            #after
            switching
        }
    }

    /// The coefficients of order `level` from those before.
    fn advance(
        &self,
        series: &Series,
        (bound, sides, row): (&TokenStream, &TokenStream, &TokenStream),
    ) -> TokenStream {
        let (runtime, n) = (&self.d.model.runtime, self.n());
        let tokens = |text: &str| self.names.tokens(text);
        let (statements, results): (TokenStream, Results) = body(self.names, &series.program);
        let (constant_count, recurrence) = (series.program.constants.len(), &series.recurrence);
        let (factor_count, memory_count) = (recurrence.factors.len(), recurrence.memory.len());
        let next = Order::of(recurrence, results.written());
        let layout = recurrence.layout();
        let [products, squares] = &layout;
        let inner = |of: &[usize]| {
            let names: Vec<String> = of.iter().map(|i| format!("inner_{i}")).collect();
            in_blocks(&names, "_")
        };
        let (deep, (square_wide, square_deep)) = (blocks(products.len()).1, blocks(squares.len()));
        let taken_apart = [
            (variables("q", n), "motion.q[level]"),
            (list([variables("slower", n), variables("qd", n)]), "*rates"),
            (variables("first", factor_count), "*first"),
            (variables("last", factor_count), "*last"),
            (variables("before", memory_count), "*before"),
            (inner(products), "product"),
            (inner(squares), "square"),
        ];
        let taken_apart = taken_apart.map(|(names, array)| format!("let {names} = {array};\n")).concat();
        let taken_apart = tokens(&taken_apart);
        let [left, right, of_squares] = next.sides(recurrence, &layout).map(|text| tokens(&text));
        let [newest, memory, accelerations, velocities] =
            [&next.factors, &next.memory, &next.accelerations, &next.velocities]
                .map(|all| tokens(&list(all)));
        let coordinates = (!next.coordinates.is_empty()).then(|| {
            let (values, which) =
                (tokens(&list(&next.coordinates)), recurrence.coordinates.iter().map(|c| c.0));
            quote!(motion.push_coordinates_of(level, &[#(#which),*], #values);)
        });
        let switching = (!next.switching.is_empty()).then(|| {
            let values = tokens(&list(&next.switching));
            quote!(switching[level] = #runtime::series::Sides(#values);)
        });
        let mut rates: Vec<String> = (0..n).map(|i| format!("qd_{i}")).collect();
        for (place, (i, _)) in recurrence.velocities.iter().enumerate() {
            rates[*i] = format!("velocities[{place}]");
        }
        let rates = self.rates(recurrence, &rates);
        let (kept, found) = (recurrence.kept(), recurrence.velocities.iter().map(|v| v.0));
        // Sums over orders are as long as all the rest together, and are a loop.
        let middle = if series.is_long() { quote!(middle_called) } else { quote!(middle) };
        let inline = forced_inlining();
        quote! {
            /// The coefficients of order `level` from those before.
            #inline
            fn advance<S: #runtime::#bound, const K: usize>(
                level: usize,
                constants: &[S; #constant_count],
                before: &mut [S; #memory_count],
                ends: &mut [[S; #factor_count]; 2],
                products: &mut Products<#row, #deep, { K }>,
                squares: &mut Squares<S, #square_wide, #square_deep, { K }>,
                factors: &mut Factors<S, #factor_count, { K }>,
                rates: &mut [[S; #n]; 2],
                motion: &mut #runtime::TaylorSeries<S, #n, { K }>,
                switching: &mut [#sides; K],
            ) {
                let (weight, over) = (S::from_f64(level as f64), Over::<S>::new(level));
                let clock = S::from_f64(if level == 1 { 1.0 } else { 0.0 });
                let (product, square) = if S::WIDE {
                    (factors.products(level, &PAIRS), factors.squares(level, &SQUARED))
                } else {
                    (products.#middle(level), squares.#middle(level))
                };
                let known = *ends;
                let [first, last] = if S::WIDE { factors.ends(level) } else { [&known[0], &known[1]] };
                #taken_apart
                #statements
                let (accelerations, velocities) = (#accelerations, #velocities);
                #switching
                #coordinates
                *before = #memory;
                let newest = #newest;
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
                motion.push_velocities_of(level, &[#(#found),*], velocities);
                let further = motion.push_of(level, &[#(#kept),*], accelerations);
                *rates = #rates;
            }
        }
    }

    /// Coordinates that have a coefficient more than was asked for, since others take a further order.
    fn beyond(&self, recurrence: &Recurrence) -> Vec<usize> {
        debug_assert!(recurrence.coordinates.is_empty() || recurrence.accelerations.is_empty());
        match recurrence.further_orders() {
            0 => Vec::new(),
            1 => recurrence.kept(),
            _ => recurrence.velocities.iter().map(|v| v.0).collect(),
        }
    }

    /// Velocities of an order, and those of the next one that accelerations give.
    fn rates(&self, recurrence: &Recurrence, velocities: &[String]) -> TokenStream {
        let mut further = vec![ZERO.to_string(); velocities.len()];
        for (place, i) in recurrence.kept().into_iter().enumerate() {
            further[i] = format!("further[{place}]");
        }
        self.names.tokens(&list([list(velocities), list(further)]))
    }
}
