//! Breakdown maps: which of several models is enough, over two quantities of a scene.

use super::{Axis, Chart, ChartError, Series, field, write_files};
use std::fmt::Write as _;
use std::path::Path;

/// A breakdown map of models. At each place, say an amplitude and a parameter, it shows the first model of the list
/// whose error is within what is allowed: list the smallest model first, and the whole system last.
///
/// ```
/// use lagrange_runtime::chart::{Axis, Breakdown};
/// // Terms of the sine's series as models of it.
/// let axes = [Axis::log("factor", ""), Axis::log("angle", "rad")];
/// let mut map = Breakdown::new("Sine", axes, ["first order", "third order", "sine"], 0.01);
/// for angle in [0.1, 0.3, 1.0f64] {
///     for factor in [0.1, 1.0, 10.0] {
///         let sine = angle.sin();
///         let models = [angle, angle - angle.powi(3) / 6.0, sine];
///         map = map.with((factor, angle), models.map(|model| factor * (model - sine).abs()));
///     }
/// }
/// assert_eq!((map.limit(0, 1.0), map.limit(1, 1.0)), (Some(0.3), Some(1.0)));
/// assert!(map.svg()?.contains("<svg"));
/// # Ok::<(), lagrange_runtime::chart::ChartError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Breakdown {
    /// Heading.
    pub title: String,
    /// Subtitle. May be empty.
    pub subtitle: String,
    /// Horizontal and vertical axis.
    pub axes: [Axis; 2],
    /// Names of the models, the smallest first.
    pub models: Vec<String>,
    /// The error up to which a model holds.
    pub allowed: f64,
    /// Places of the map, and the error of each model there.
    pub places: Vec<((f64, f64), Vec<f64>)>,
}

impl Breakdown {
    /// A map without places.
    pub fn new<Name: Into<String>>(
        title: impl Into<String>,
        axes: [Axis; 2],
        models: impl IntoIterator<Item = Name>,
        allowed: f64,
    ) -> Self {
        let (title, models) = (title.into(), models.into_iter().map(Into::into).collect());
        Breakdown { title, subtitle: String::new(), axes, models, allowed, places: Vec::new() }
    }

    /// Sets the subtitle.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Adds a place with the error of each model, in the order of the models; NaN and infinity are never allowed.
    #[must_use]
    pub fn with(mut self, place: (f64, f64), errors: impl IntoIterator<Item = f64>) -> Self {
        self.places.push((place, errors.into_iter().collect()));
        self
    }

    /// Index of the first model that holds at a place of these errors; `None` if there is none.
    fn enough(&self, errors: &[f64]) -> Option<usize> {
        errors.iter().take(self.models.len()).position(|error| *error <= self.allowed)
    }

    /// Largest y up to which a model of this index holds wherever the map has a place of this x; `None` if it does
    /// not hold at the smallest one.
    pub fn limit(&self, model: usize, x: f64) -> Option<f64> {
        let column = self.places.iter().filter(|((at, _), _)| *at == x);
        let mut column: Vec<(f64, f64)> =
            column.map(|((_, y), errors)| (*y, errors.get(model).copied().unwrap_or(f64::NAN))).collect();
        column.sort_by(|a, b| a.0.total_cmp(&b.0));
        let holds = column.iter().take_while(|(_, error)| *error <= self.allowed);
        holds.last().map(|(y, _)| *y)
    }

    /// The map as a chart, with cells for each model, as [`Panels`](super::Panels) take it.
    pub fn chart(&self) -> Chart {
        let [x, y] = self.axes.clone();
        let of = |model: Option<usize>| {
            let places = self.places.iter().filter(move |(_, errors)| self.enough(errors) == model);
            places.map(|(place, _)| *place)
        };
        let mut chart = Chart::new(&*self.title, x, y).subtitle(&*self.subtitle);
        for (model, name) in self.models.iter().enumerate() {
            chart = chart.with(Series::cells(name, of(Some(model))));
        }
        let none: Vec<_> = of(None).collect();
        if none.is_empty() { chart } else { chart.with(Series::cells("none of them", none)) }
    }

    /// The map as SVG, its text as paths.
    ///
    /// # Errors
    /// If there is nothing to draw.
    pub fn svg(&self) -> Result<String, ChartError> {
        self.chart().svg()
    }

    /// Writes `stem.svg`, `stem.png` and `stem.csv` into the folder `dir`, which must exist.
    ///
    /// # Errors
    /// If there is nothing to draw (then nothing is written), or if a file cannot be written.
    pub fn write(&self, dir: impl AsRef<Path>, stem: &str) -> Result<(), ChartError> {
        write_files(dir.as_ref(), stem, &self.chart().sheet()?, &self.csv())
    }

    /// All places as comma-separated values: both quantities, the model that is enough, and the error of each model.
    pub fn csv(&self) -> String {
        let [x, y] = [&self.axes[0], &self.axes[1]].map(|axis| field(&axis.caption()));
        let mut csv = format!("{x},{y},enough");
        for model in &self.models {
            let _ = write!(csv, ",{}", field(&format!("error: {model}")));
        }
        csv.push('\n');
        for ((x, y), errors) in &self.places {
            let enough = self.enough(errors).map_or("none", |model| &self.models[model]);
            let _ = write!(csv, "{x:?},{y:?},{}", field(enough));
            for error in errors {
                let _ = write!(csv, ",{error:?}");
            }
            csv.push('\n');
        }
        csv
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> Breakdown {
        Breakdown::new("Map", [Axis::log("a", "rad"), Axis::linear("b", "")], ["small", "whole, too"], 0.1)
            .with((1.0, 2.0), [0.2, 0.0])
            .with((1.0, 1.0), [0.1, 0.0])
            .with((10.0, 1.0), [f64::NAN, f64::INFINITY])
    }

    #[test]
    fn the_first_model_that_holds_is_shown() {
        let series = map().chart().series;
        let of = |name: &str| series.iter().find(|series| series.name == name).unwrap().points.clone();
        assert_eq!(of("small"), [(1.0, 1.0)]);
        assert_eq!(of("whole, too"), [(1.0, 2.0)]);
        assert_eq!(of("none of them"), [(10.0, 1.0)]);
    }

    #[test]
    fn limits_are_those_of_all_smaller_places() {
        let map = map().with((1.0, 3.0), [0.0, 0.0]);
        assert_eq!((map.limit(0, 1.0), map.limit(1, 1.0)), (Some(1.0), Some(3.0)));
        assert_eq!((map.limit(0, 10.0), map.limit(0, 5.0), map.limit(7, 1.0)), (None, None, None));
    }

    #[test]
    fn csv_has_all_errors() {
        assert_eq!(
            map().csv(),
            "a (rad),b,enough,error: small,\"error: whole, too\"\n1.0,2.0,\"whole, too\",0.2,0.0\n\
             1.0,1.0,small,0.1,0.0\n10.0,1.0,none,NaN,inf\n"
        );
    }

    #[test]
    fn a_map_without_places_is_an_error() {
        let map = Breakdown::new("", [Axis::log("", ""), Axis::log("", "")], ["a"], 1.0);
        assert!(matches!(map.svg(), Err(ChartError::NoPoints)));
    }
}
