//! The frontier of a chart of errors against costs: runs that no other run beats in both.

use super::{Chart, Series, Style};

impl Chart {
    /// The points that no other point of the chart beats in both coordinates, with the names of their series, by
    /// increasing x: of all models, methods and tolerances those that a scene should be computed by (Pareto's
    /// frontier). Points that cannot be drawn and series of [`Style::Context`] do not count; of equal points the first
    /// one does.
    pub fn frontier(&self) -> Vec<(&str, (f64, f64))> {
        let shown = self.series.iter().filter(|series| series.style != Style::Context);
        let mut points: Vec<(&str, (f64, f64))> = shown
            .flat_map(|series| series.points.iter().map(|point| (&*series.name, *point)))
            .filter(|(_, point)| self.place(*point).is_some())
            .collect();
        points.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut best = f64::INFINITY;
        points.retain(|(_, (_, y))| {
            let better = *y < best;
            best = best.min(*y);
            better
        });
        points
    }

    /// The chart with all of its series in grey, and in front of them the [frontier](Self::frontier): for each series
    /// that has a part in it, its points there, joined where no other series is better between them.
    #[must_use]
    pub fn with_frontier(self) -> Self {
        let mut front: Vec<Series> = Vec::new();
        let mut last = None;
        for (name, point) in self.frontier() {
            match front.iter_mut().find(|series| series.name == name) {
                Some(series) => {
                    // Lines end where another series is better.
                    series.points.extend((last != Some(name)).then_some((f64::NAN, f64::NAN)));
                    series.points.push(point);
                }
                None => front.push(Series::new(name, [point])),
            }
            last = Some(name);
        }
        let grey = self.series.into_iter().map(|series| Series { style: Style::Context, ..series });
        Chart { series: grey.chain(front).collect(), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Axis;

    #[test]
    fn the_frontier_has_what_nothing_beats() {
        let chart = Chart::new("", Axis::log("cost", ""), Axis::log("error", ""))
            .with(Series::new("small", [(1.0, 0.1), (2.0, 0.02), (4.0, 0.02)]))
            .with(Series::context([(0.1, 1e-9)]))
            .with(Series::new("whole", [(2.0, 0.5), (8.0, 1e-6), (9.0, f64::NAN), (4.0, 0.01), (1.0, 0.1)]));
        let front =
            [("small", (1.0, 0.1)), ("small", (2.0, 0.02)), ("whole", (4.0, 0.01)), ("whole", (8.0, 1e-6))];
        assert_eq!(chart.frontier(), front);
        let drawn = chart.with(Series::new("tiny", [(3.0, 0.019)])).with_frontier();
        assert_eq!(drawn.series.len(), 7);
        assert_eq!(drawn.series[4].points.len(), 2);
        assert_eq!(drawn.series[6], Series::new("whole", [(4.0, 0.01), (8.0, 1e-6)]));
        let gap = Chart::new("", Axis::log("", ""), Axis::log("", ""))
            .with(Series::new("a", [(1.0, 1.0), (3.0, 0.1)]))
            .with(Series::new("b", [(2.0, 0.5)]))
            .with_frontier();
        assert!(gap.series[2].points[1].0.is_nan() && gap.series[2].points.len() == 3);
    }
}
