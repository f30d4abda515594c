//! The recurrences of the Taylor series: order 0, and a function for each further one.

use super::{Emitter, body};
use crate::equations::series::{
    Balance, Factor, Outputs, Place, Right, Rule, Series, Slope, is_number, symbol, tail, term_pair,
};
use crate::equations::solve::entry;
use crate::graph::{Comparison, Graph, Id, Number, Symbol, Value, stable_map::StableMap};
use crate::model::Model;
use crate::schedule::{Program, schedule_given};
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// Systems of at most this many products of series have their orders written out one by one by the optimiser, which makes
/// of rows values in registers and of sums straight lines; others loop.
const STRAIGHT: usize = 15;

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
        let solution = match &series.outputs {
            Outputs::Bindings(balance) => Some(schedule_given(g, &balance.solution)),
            _ => None,
        };
        // Those of momenta are made of the nodes.
        let outputs = match (&series.outputs, &solution) {
            (_, Some(program)) => program.constants.clone(),
            (Outputs::Momenta { .. }, _) => Vec::new(),
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
        let Solving { solver, respond, first, next, last } = match (&series.outputs, &solution) {
            (Outputs::Bindings(balance), Some(program)) => {
                places.balancing(balance, program, of_outputs, &names)
            }
            _ => places.solving(of_outputs, &arguments, &names),
        };
        let (solver, solver_type) = match solver {
            Some((solver, size)) => {
                (quote!(&solver, &mut unknowns,), quote!(solver: &#solver, unknowns: &mut [S; #size],))
            }
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
        let factors_zeroth = places.factors.iter().map(|f| places.factor_zeroth(*f));
        let place = |factor: &Factor| at(places.factors.iter().position(|f| f == factor).unwrap_or(0));
        let (product_count, square_count) = (series.products.len(), series.squares.len());
        let pairs = series.products.iter().map(|pair| {
            let [a, b] = [place(&pair[0]), place(&pair[1])];
            quote!([#a, #b])
        });
        let squared = series.squares.iter().map(place);
        let (left, right, of_squares) = factors(&|f| places.factor(f));
        let (left_zeroth, right_zeroth, squares_zeroth) = factors(&|f| places.factor_zeroth(f));
        let advance = quote! {
            advance(
                level, &numbers, &reciprocals, &zeroth, #solver &mut before, &mut ends, &mut products, &mut squares, &mut factors, &mut rates,
                &mut motion, &mut switching
            )
        };
        // Momenta give velocities, whose last coefficient is one order further than that of accelerations.
        let end = match series.outputs {
            Outputs::Momenta { .. } | Outputs::Bindings(_) => quote!((order + 1).min(K)),
            _ => quote!(order.min(K)),
        };
        let orders = if series.products.len() + series.squares.len() <= STRAIGHT {
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
        // Where there are switches to be located, numbers have to be compared.
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
            (quote!(Real), quote!(#runtime::series::Sides<S, #switches>), switching)
        };
        let sides_at = |order: &dyn Fn(Value) -> TokenStream| {
            let all = series.switches.iter().map(|v| order(*v));
            (switches > 0).then(|| quote!(#runtime::series::Sides([#(#all),*])))
        };
        let switching_zeroth = sides_at(&|v| v.node.map_or(quote!(S::zero()), |id| places.zeroth(id)));
        let switching_zeroth = switching_zeroth.map(|sides| quote!(switching[0] = #sides;));
        let switching_next = sides_at(&|v| v.node.map_or(quote!(S::zero()), |id| places.order(id)));
        let switching_next = switching_next.map(|sides| quote!(switching[level] = #sides;));
        quote! {
            impl<S: #runtime::#bound> #runtime::Analytic<#n> for #name<S> {
                type Sides = #sides;
                #[inline]
                fn switching(&self, at: &#runtime::State<S, #n>, sides: &#sides) -> #sides {
                    #switching
                }
                #[inline(always)]
                fn series_within<const K: usize>(
                    &self,
                    at: &#runtime::State<S, #n>,
                    order: usize,
                    sides: &#sides,
                ) -> (#runtime::Series<S, #n, K>, [#sides; K]) {
                    use #runtime::series::{Factors, Products, Squares, over};
                    /// Factors of the products, and of the squares.
                    const PAIRS: [[usize; 2]; #product_count] = [#(#pairs),*];
                    const SQUARED: [usize; #square_count] = [#(#squared),*];
                    #respond
                    /// The coefficients of order `level` from those before.
                    #[inline(always)]
                    fn advance<S: #runtime::#bound, const K: usize>(
                        level: usize,
                        #arguments,
                        #solver_type
                        before: &mut [S; #before_count],
                        [first, last]: &mut [[S; #factor_count]; 2],
                        products: &mut Products<S, #wide, #deep, K>,
                        squares: &mut Squares<S, #square_wide, #square_deep, K>,
                        factors: &mut Factors<S, #factor_count, K>,
                        rates: &mut [[S; #n]; 2],
                        motion: &mut #runtime::Series<S, #n, K>,
                        switching: &mut [#sides; K],
                    ) {
                        let (weight, over) = (S::from_f64(level as f64), over::<S>(level));
                        let clock = S::from_f64(if level == 1 { 1.0 } else { 0.0 });
                        let (product, square) = if S::WIDE {
                            (factors.products(level, &PAIRS), factors.squares(level, &SQUARED))
                        } else {
                            (products.middle(level), squares.middle(level))
                        };
                        let (q, [slower, qd]) = (motion.q[level], *rates);
                        #names
                        #next
                        #switching_next
                        *before = [#(#before),*];
                        if level == 2 {
                            *first = *last;
                        }
                        *last = [#(#lasts),*];
                        if S::WIDE {
                            factors.push(level, last);
                        } else {
                            products.push(level, #left, #right);
                            squares.push(level, #of_squares);
                        }
                        #last
                    }
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    #statements
                    let numbers = [#(#of_numbers),*];
                    let zeroth = [#(#of_nodes,)* #(#coordinates,)* #(#velocities,)* t];
                    let reciprocals = [#(#reciprocals),*];
                    let mut motion = #runtime::Series::new(at);
                    let mut switching = [<#sides as #runtime::series::Switches<S>>::zero(); K];
                    #switching_zeroth
                    #first
                    let mut before = [#(#before_zeroth),*];
                    // Of order 1, which is known to be such from order 3 on, and of the order before.
                    let mut ends = [[S::zero(); #factor_count]; 2];
                    let mut products = Products::<S, #wide, #deep, K>::new();
                    let mut squares = Squares::<S, #square_wide, #square_deep, K>::new();
                    let mut factors = Factors::<S, #factor_count, K>::new();
                    if S::WIDE {
                        factors.push(0, &[#(#factors_zeroth),*]);
                    } else {
                        products.keep();
                        products.push(0, #left_zeroth, #right_zeroth);
                        squares.push(0, #squares_zeroth);
                    }
                    #orders
                    (motion, switching)
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
            Rule::Choice(_, values) => values[..2].iter().for_each(|v| note(*v)),
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
    if let Outputs::Momenta { .. } | Outputs::Bindings(_) = &series.outputs {
        series.outputs.values().into_iter().for_each(note);
    }
    numbers
}

/// How an order follows from the one before.
struct Solving {
    /// The type of what solves the equations of an order, and how many they are.
    solver: Option<(TokenStream, usize)>,
    /// A function for it: what velocities do to the nodes and to the momenta, or the solution itself.
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
            // Counted one order later than they belong.
            Factor::Unknown(_) if matches!(self.series.outputs, Outputs::Bindings(_)) => quote!(S::zero()),
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
            Rule::Choice(comparison, values) => {
                let of = |v: Value| self.value(v, velocities).unwrap_or(quote!(S::zero()));
                self.choice(*comparison, values, of)
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

    fn choice(
        &self,
        comparison: Comparison,
        values: &[Value; 4],
        of: impl Fn(Value) -> TokenStream,
    ) -> TokenStream {
        let runtime = &self.emitter.e.model.runtime;
        let comparison = format_ident!("{comparison:?}");
        let ([a, b], [yes, no]) =
            ([values[0], values[1]].map(|v| self.number(v)), [values[2], values[3]].map(of));
        quote!(S::select(#runtime::Comparison::#comparison, #a, #b, #yes, #no))
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
            Rule::Choice(comparison, values) => {
                self.choice(*comparison, values, |v| self.change(v).unwrap_or(quote!(S::zero())))
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
                    solver: None,
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
                    solver: Some((quote!(#runtime::series::Solver<S, #size>), size)),
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
            Outputs::Bindings(_) => unreachable!("has a solution of its own"),
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
                    solver: Some((quote!(#runtime::series::Solver<S, #n>), n)),
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

impl Places<'_> {
    /// Orders by the equations at the bindings.
    fn balancing(
        &self,
        balance: &Balance,
        program: &Program,
        constants: &[TokenStream],
        names: &TokenStream,
    ) -> Solving {
        let (g, n) = (self.graph(), self.emitter.n());
        let runtime = &self.emitter.e.model.runtime;
        let (given, found, count) = (balance.rights.len(), balance.solution.len(), constants.len());
        let (statements, solution) = body::body(g, self.emitter.names, program);
        let solution = solution.array();
        let velocities = (0..n).map(|i| {
            let i = at(i);
            quote!(qd[#i])
        });
        let velocities = quote!([#(#velocities),*]);

        let forces = || {
            balance.rights.iter().filter_map(|right| match right {
                Right::Forces { force, .. } => Some(*force),
                Right::Definition { .. } => None,
            })
        };
        let zeroth = forces().map(|f| match f.node {
            Some(id) if !is_number(g, f) => self.scaled(f.k, self.zeroth(id)),
            _ => self.number(f),
        });
        let next = forces().map(|f| self.value(f, Velocities::Known).unwrap_or(quote!(S::zero())));
        let rights = balance.rights.iter().enumerate().map(|(i, right)| match right {
            Right::Forces { tails, .. } => {
                let tails = tails.iter().filter_map(|(v, x)| {
                    Some(self.scaled(v.k, self.middle([Factor::Of(v.node?), Factor::Unknown(*x)])))
                });
                let i = at(i);
                let all = sum(std::iter::once(quote!(unknowns[#i])).chain(tails));
                quote!(#all)
            }
            Right::Definition { explicit, terms } => {
                let explicit = self.value(*explicit, Velocities::Known);
                let terms = terms.iter().filter_map(|&[slope, rate]| {
                    let of = self.order(slope.node?);
                    let Some(pair) = term_pair(g, [slope, rate]) else {
                        let rate = self.number(rate);
                        return Some(self.scaled(slope.k, quote!(#of * #rate)));
                    };
                    let (middle, zeroth) = (self.middle(pair), self.zeroth(rate.node?));
                    Some(self.scaled(slope.k.mul(rate.k), quote!(#of.mul_add(#zeroth, #middle))))
                });
                let all = sum(explicit.into_iter().chain(terms));
                quote!(weight * (#all))
            }
        });
        let all_moved = self.series.moved(g, None);
        let (late, early): (Vec<usize>, Vec<usize>) =
            (0..self.series.rules.len()).partition(|row| all_moved.binary_search(row).is_ok());
        let (early, late) = (
            self.steps(early.into_iter(), Velocities::Known),
            self.steps(late.into_iter(), Velocities::Known),
        );
        let accelerations = (0..n).map(|i| {
            let i = at(i);
            quote!(found[#i])
        });
        let forces_count = forces().count();
        Solving {
            solver: Some((quote!([S; #count]), forces_count)),
            respond: quote! {
                /// Accelerations, and forces at the bindings, of given forces and rates.
                #[inline(always)]
                fn respond<S: #runtime::Scalar>(constants: &[S; #count], given: [S; #given]) -> [S; #found] {
                    #statements
                    #solution
                }
            },
            first: quote! {
                let solver = [#(#constants),*];
                let mut rates = [#velocities; 2];
                let mut unknowns = {
                    let (numbers, reciprocals) = (&numbers, &reciprocals);
                    #names
                    [#(#zeroth),*]
                };
            },
            next: quote! {
                #early
                let found = respond(solver, [#(#rights),*]);
                let qd = #runtime::series::divided([#(#accelerations),*], level);
                #late
                *unknowns = [#(#next),*];
            },
            last: quote! {
                motion.push_velocities(level, qd);
                *rates = [qd; 2];
            },
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
