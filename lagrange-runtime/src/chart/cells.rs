//! Cells of a map over two quantities: each reaches half-way to its neighbours, along the axes.

use super::ink::{Canvas, Drawn, FINE, Pixel};
use super::{Chart, Style};
use plotters::prelude::*;

/// Places of the columns and rows of all cells of a chart, each in increasing order.
pub(super) struct Lattice {
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Lattice {
    /// `None` if the chart has no cells.
    pub(super) fn of(chart: &Chart) -> Option<Lattice> {
        let cells = chart.series.iter().filter(|series| series.style == Style::Cells);
        let places: Vec<_> =
            cells.flat_map(|series| &series.points).filter_map(|&at| chart.place(at)).collect();
        let sorted = |mut along: Vec<f64>| {
            along.sort_by(f64::total_cmp);
            along.dedup();
            along
        };
        let [x, y] =
            [places.iter().map(|at| at.0).collect(), places.iter().map(|at| at.1).collect()].map(sorted);
        (!x.is_empty()).then_some(Lattice { x, y })
    }

    /// The edges of all cells together.
    pub(super) fn extents(&self) -> [(f64, f64); 2] {
        [&self.x, &self.y].map(|along| (edges(along, 0).0, edges(along, along.len() - 1).1))
    }

    /// Fills the cell about a place.
    pub(super) fn paint(
        &self,
        canvas: &Canvas,
        (x, y): (f64, f64),
        colour: RGBColor,
        at: impl Fn(f64, f64) -> Pixel,
    ) -> Drawn {
        let of = |along: &[f64], place: f64| edges(along, along.partition_point(|other| *other < place));
        let (across, up) = (of(&self.x, x), of(&self.y, y));
        let [(left, top), (right, bottom)] = [at(across.0, up.1), at(across.1, up.0)];
        // A thin white line keeps neighbours apart.
        let rim = (0.5 * FINE) as i32;
        let corners = [(left + rim, top + rim), (right - rim, bottom - rim)];
        canvas.draw(&Rectangle::new(corners, colour.filled()))?;
        Ok(())
    }
}

/// The edges of the cell of that index: half-way to the neighbours, and as far on the other side where there is none.
fn edges(along: &[f64], index: usize) -> (f64, f64) {
    let place = along[index];
    let below = index.checked_sub(1).map(|i| 0.5 * (place - along[i]));
    let above = along.get(index + 1).map(|next| 0.5 * (next - place));
    let alone = if place == 0.0 { 0.5 } else { 0.05 * place.abs() };
    let (low, high) = (below.or(above).unwrap_or(alone), above.or(below).unwrap_or(alone));
    (place - low, place + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Axis, Series};

    #[test]
    fn cells_reach_half_way_to_their_neighbours() {
        let chart = Chart::new("", Axis::log("", ""), Axis::linear("", ""))
            .with(Series::cells("a", [(1.0, 0.0), (100.0, 0.0), (1.0, f64::NAN)]))
            .with(Series::cells("b", [(1.0, 3.0), (100.0, 1.0)]))
            .with(Series::line("no cells", [(1e9, 1e9)]));
        let lattice = Lattice::of(&chart).unwrap();
        assert_eq!((&*lattice.x, &*lattice.y), (&[0.0, 2.0][..], &[0.0, 1.0, 3.0][..]));
        assert_eq!(lattice.extents(), [(-1.0, 3.0), (-0.5, 4.0)]);
        assert_eq!(edges(&lattice.y, 1), (0.5, 2.0));
        assert_eq!((edges(&[0.0], 0), edges(&[2.0], 0)), ((-0.5, 0.5), (1.9, 2.1)));
    }
}
