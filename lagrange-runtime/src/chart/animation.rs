//! Mechanisms in motion: moving points, joined by bars, as an SVG that moves by itself (SMIL: W3C, *SVG 1.1*, 2011,
//! ch. 19). Every browser plays it; what cannot play it shows the first frame.

use super::ink::{Canvas, Drawn, INK, Pixel, fine, write};
use super::layout::{ALONE, CAPTION, MARGIN, SUBTITLE, SUBTITLE_LINE, TICK, TITLE, TITLE_LINE};
use super::palette::{CONTEXT, colour};
use super::picture::headings;
use super::sheet::{FINE, Sheet};
use super::svg::{Letters, between};
use super::{ChartError, field, write_each};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::fmt::Write as _;
use std::path::Path;

/// Largest height of the moving picture, in pixels.
const TALLEST: f64 = 620.0;
/// Number of pictures in the PNG, which shows the motion at some of its times, and of its columns.
const STILLS: usize = 6;
const COLUMNS: usize = 3;
const GAP: f64 = 18.0;
/// Opacity of bodies.
const BODY: f64 = 0.3;

/// A motion as a moving picture, over and over again. One unit is as long upwards as across.
///
/// ```
/// use lagrange_runtime::chart::{Animation, Part};
/// let swing = |k: i32| (f64::from(k) * 0.1).cos() * 0.5;
/// let bob = |k: i32| (swing(k).sin(), -swing(k).cos());
/// let rods = (0..=63).map(|k| vec![(0.0, 0.0), bob(k)]);
/// let animation = Animation::new("A pendulum", 2.0)
///     .with(Part::path("path", (0..=63).map(bob)))
///     .with(Part::bars("rod", rods.clone()))
///     .with(Part::joints("bob", (0..=63).map(|k| vec![bob(k)])).width(18.0).colour(1));
/// assert!(animation.svg()?.contains("<animate"));
/// # Ok::<(), lagrange_runtime::chart::ChartError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// Heading.
    pub title: String,
    /// Subtitle. May be empty.
    pub subtitle: String,
    /// Seconds from the first frame to the last.
    pub duration: f64,
    /// Speed of the playback; 1 is real time.
    pub speed: f64,
    /// The parts, from the background to the foreground.
    pub parts: Vec<Part>,
}

/// Points of an [`Animation`] that move together.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its name, in the CSV and for who points at it.
    pub name: String,
    /// The points `(x, y)` at equal distances of time; one frame alone is at rest. Every frame has as many points.
    /// One that is not finite interrupts the bars, and has to do so in every frame.
    pub frames: Vec<Vec<(f64, f64)>>,
    /// Shape drawn at the points.
    pub shape: Shape,
    /// Width of bars and outlines, diameter of joints, in pixels.
    pub width: f64,
    /// A colour by its number in the palette of the charts; `None` is the light grey of what is only there for
    /// comparison.
    pub colour: Option<usize>,
}

/// Shape drawn at the points of a [`Part`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A bar from each to the next.
    Bars,
    /// A disk at each.
    Joints,
    /// The body whose corners they are.
    Body,
}

impl Animation {
    /// A picture without parts; its frames take `duration` seconds.
    pub fn new(title: impl Into<String>, duration: f64) -> Self {
        Self { title: title.into(), subtitle: String::new(), duration, speed: 1.0, parts: Vec::new() }
    }

    /// Sets the subtitle.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Played at that speed: 0.25 is four times slower than real time.
    #[must_use]
    pub fn speed(mut self, speed: f64) -> Self {
        self.speed = speed;
        self
    }

    /// Adds a part in front of the others.
    #[must_use]
    pub fn with(mut self, part: Part) -> Self {
        self.parts.push(part);
        self
    }

    /// Writes `stem.svg`, which moves, `stem.png` with the motion at some of its times, and `stem.csv` into the folder
    /// `dir`, which must exist.
    ///
    /// # Errors
    /// If there is nothing to draw or its frames do not fit together (then nothing is written), or if a file cannot be
    /// written.
    pub fn write(&self, dir: impl AsRef<Path>, stem: &str) -> Result<(), ChartError> {
        write_each(dir.as_ref(), stem, &self.svg()?, &self.png()?, &self.csv())
    }

    /// The moving picture as SVG, its text as paths.
    ///
    /// # Errors
    /// If there is nothing to draw, or if frames do not fit together.
    pub fn svg(&self) -> Result<String, ChartError> {
        let stage = Stage::of(self)?;
        let heading = Heading::of(self);
        let size = (ALONE.width, (heading.height + stage.height + 2.0 * MARGIN).ceil());
        let still = Sheet::painted(size, |canvas| {
            canvas.fill(&WHITE)?;
            headings(&heading.title, &heading.subtitle, canvas)
        })?;
        let still = still.svg(Letters::Outlines);
        let seconds = self.duration / self.speed;
        let mut moving = format!("<g transform=\"translate(0 {:.1})\">\n", heading.height);
        for part in &self.parts {
            moving += &stage.moving(part, seconds);
        }
        if stage.frames > 1 {
            let width = ALONE.width - 2.0 * MARGIN;
            let _ = writeln!(
                moving,
                "<rect x=\"{MARGIN}\" y=\"{:.1}\" width=\"0\" height=\"3\" fill=\"{}\"><title>time</title>\
                 <animate attributeName=\"width\" values=\"0;{width}\" dur=\"{seconds}s\" repeatCount=\"indefinite\"/></rect>",
                stage.height + MARGIN - 8.0,
                hexadecimal(CONTEXT.colour),
            );
        }
        let end = still.rfind("</svg>").unwrap_or(still.len());
        Ok(format!("{}{moving}</g>\n{}", &still[..end], &still[end..]))
    }

    /// The motion at some of its times, side by side, as PNG.
    ///
    /// # Errors
    /// If there is nothing to draw, or if frames do not fit together.
    pub fn png(&self) -> Result<Vec<u8>, ChartError> {
        let stage = Stage::of(self)?;
        let heading = Heading::of(self);
        let stills = stage.frames.min(STILLS);
        let columns = stills.min(COLUMNS);
        let width = (ALONE.width - 2.0 * MARGIN - GAP * (columns - 1) as f64) / columns as f64;
        let scale = width / ALONE.width;
        let row = stage.height * scale + CAPTION.size + GAP;
        let size = (ALONE.width, (heading.height + row * stills.div_ceil(columns) as f64 + MARGIN).ceil());
        let corner = |still: usize| {
            let (column, line) = (still % columns, still / columns);
            (MARGIN + (width + GAP) * column as f64, heading.height + row * line as f64)
        };
        let frame = |still: usize| still * (stage.frames - 1) / (stills - 1).max(1);
        let time = |still| self.duration * frame(still) as f64 / (stage.frames - 1).max(1) as f64;
        let sheet = Sheet::painted(size, |canvas| {
            canvas.fill(&WHITE)?;
            headings(&heading.title, &heading.subtitle, canvas)?;
            for still in 0..stills {
                let (x, y) = corner(still);
                for part in &self.parts {
                    stage.still(part, frame(still), canvas, (x, y), scale)?;
                }
                if stage.frames > 1 {
                    let below = (x + 0.5 * width, y + stage.height * scale + CAPTION.size);
                    write(canvas, &format!("{:.2} s", time(still)), below, TICK, INK, HPos::Center)?;
                }
            }
            Ok(())
        })?;
        sheet.png()
    }

    /// All points as comma-separated values (RFC 4180): part, time, number of the point, x, y. Parts at rest have no
    /// time.
    pub fn csv(&self) -> String {
        let mut csv = String::from("part,time (s),point,x,y\n");
        for part in &self.parts {
            let (name, last) = (field(&part.name), part.frames.len().saturating_sub(1));
            for (k, frame) in part.frames.iter().enumerate() {
                let time = if last == 0 {
                    String::new()
                } else {
                    format!("{:?}", self.duration * k as f64 / last as f64)
                };
                for (point, (x, y)) in frame.iter().enumerate() {
                    let _ = writeln!(csv, "{name},{time},{point},{x:?},{y:?}");
                }
            }
        }
        csv
    }
}

impl Part {
    /// Bars from each point to the next, by frames.
    pub fn bars(name: impl Into<String>, frames: impl IntoIterator<Item = Vec<(f64, f64)>>) -> Self {
        let frames = frames.into_iter().collect();
        Self { name: name.into(), frames, shape: Shape::Bars, width: 3.0, colour: Some(0) }
    }

    /// A disk at each point, by frames.
    pub fn joints(name: impl Into<String>, frames: impl IntoIterator<Item = Vec<(f64, f64)>>) -> Self {
        Self { shape: Shape::Joints, width: 8.0, ..Self::bars(name, frames) }
    }

    /// A body by its corners, by frames.
    pub fn body(name: impl Into<String>, frames: impl IntoIterator<Item = Vec<(f64, f64)>>) -> Self {
        Self { shape: Shape::Body, width: 1.5, ..Self::bars(name, frames) }
    }

    /// A thin line at rest: the path of a point, a rail, a wall.
    pub fn path(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { width: 1.5, colour: None, ..Self::bars(name, [points.into_iter().collect()]) }
    }

    /// Sets the width of bars, or the diameter of joints, in pixels.
    #[must_use]
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }

    /// Sets the colour, by its index in the palette.
    #[must_use]
    pub fn colour(mut self, index: usize) -> Self {
        self.colour = Some(index);
        self
    }

    fn ink(&self) -> RGBColor {
        self.colour.map_or(CONTEXT.colour, colour)
    }

    /// SVG's path through the points of a frame, in fine pixels and from each point to the next: the shortest text.
    fn outline(&self, frame: usize, place: impl Fn((f64, f64)) -> (f64, f64)) -> String {
        let mut path = String::new();
        let points = &self.frames[frame.min(self.frames.len() - 1)];
        let mut before: Option<(i64, i64)> = None;
        for run in points.split(|point| !is_finite(point)).filter(|run| !run.is_empty()) {
            for (i, &point) in run.iter().enumerate() {
                let (x, y) = place(point);
                let (x, y) = ((x * FINE).round() as i64, (y * FINE).round() as i64);
                let (mut lead, dx, dy) = match before {
                    None => ("M", x, y),
                    Some((u, v)) => ("m", x - u, y - v),
                };
                if i > 0 && self.shape != Shape::Joints {
                    // Commands repeat by themselves, and after `M` this one would count from the corner.
                    lead = if i == 1 { "l" } else { between(dx) };
                }
                let _ = write!(path, "{lead}{dx}{}{dy}", between(dy));
                before = Some((x, y));
                if self.shape == Shape::Joints {
                    // A stroke of nearly no length has round ends: a disk.
                    path += "h1";
                    before = Some((x + 1, y));
                }
            }
            if self.shape == Shape::Body {
                path.push('Z');
                before = None;
            }
        }
        path
    }
}

fn is_finite((x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

/// Title and subtitle in lines.
struct Heading {
    title: Vec<String>,
    subtitle: Vec<String>,
    height: f64,
}

impl Heading {
    fn of(animation: &Animation) -> Self {
        let title = TITLE.wrap(&animation.title, ALONE.width - 2.0 * MARGIN);
        let subtitle = SUBTITLE.wrap(&animation.subtitle, ALONE.width - 2.0 * MARGIN);
        let lines = TITLE_LINE * title.len() as f64 + SUBTITLE_LINE * subtitle.len() as f64;
        Self { title, subtitle, height: MARGIN + lines + 8.0 }
    }
}

/// Transformation of points to pixels of the moving picture below its heading.
struct Stage {
    height: f64,
    /// Number of frames of the moving parts; 1 if nothing moves.
    frames: usize,
    /// Pixels for a unit, and the pixel of the origin.
    unit: f64,
    origin: (f64, f64),
}

impl Stage {
    fn of(animation: &Animation) -> Result<Self, ChartError> {
        let frames = checked(animation)?;
        let points = || animation.parts.iter().flat_map(|part| part.frames.iter().flatten());
        let range = |of: fn(&(f64, f64)) -> f64| {
            let values = points().filter(|point| is_finite(point)).map(of);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let ((left, right), (low, high)) = (range(|p| p.0), range(|p| p.1));
        if left > right {
            return Err(ChartError::NoPoints);
        }
        let thickest = animation.parts.iter().map(|part| part.width).fold(0.0, f64::max);
        let edge = MARGIN + 0.5 * thickest;
        let room = ALONE.width - 2.0 * edge;
        // Half of each, so that neither overflows.
        let (across, up) = (0.5 * right - 0.5 * left, 0.5 * high - 0.5 * low);
        let unit = (0.5 * room / across).min(0.5 * TALLEST / up);
        let unit = if unit.is_finite() { unit } else { 1.0 };
        let height = 2.0 * (up * unit + edge);
        let origin = (
            0.5 * ALONE.width - unit * (0.5 * left + 0.5 * right),
            0.5 * height + unit * (0.5 * low + 0.5 * high),
        );
        Ok(Stage { height, frames, unit, origin })
    }

    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.origin.0 + self.unit * x, self.origin.1 - self.unit * y)
    }

    /// The part as SVG, moving from its first frame on, for so many seconds.
    fn moving(&self, part: &Part, seconds: f64) -> String {
        let ink = hexadecimal(part.ink());
        let fill = match part.shape {
            Shape::Body => format!("{ink}\" fill-opacity=\"{BODY}"),
            _ => "none".to_owned(),
        };
        let outline = |frame| part.outline(frame, |point| self.place(point));
        let moving = match part.frames.len() {
            1 => String::new(),
            frames => format!(
                "<animate attributeName=\"d\" dur=\"{seconds}s\" repeatCount=\"indefinite\" values=\"{}\"/>",
                (0..frames).map(outline).collect::<Vec<_>>().join(";")
            ),
        };
        format!(
            "<path transform=\"scale({})\" d=\"{}\" fill=\"{fill}\" stroke=\"{ink}\" stroke-width=\"{}\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\"><title>{}</title>{moving}</path>\n",
            1.0 / FINE,
            outline(0),
            part.width * FINE,
            part.name.replace('&', "&amp;").replace('<', "&lt;"),
        )
    }

    /// The part in that frame, smaller by `scale`, with its corner at a pixel.
    fn still(&self, part: &Part, frame: usize, canvas: &Canvas, (x, y): (f64, f64), scale: f64) -> Drawn {
        let pixel = |&point: &(f64, f64)| {
            let (across, down) = self.place(point);
            (fine(x + scale * across), fine(y + scale * down))
        };
        let (ink, width) = (part.ink(), fine(scale * part.width));
        let disk = |at| canvas.draw(&Circle::new(at, width / 2, ink.filled()));
        let points = &part.frames[frame.min(part.frames.len() - 1)];
        for run in points.split(|point| !is_finite(point)).filter(|run| !run.is_empty()) {
            let mut run: Vec<Pixel> = run.iter().map(pixel).collect();
            if part.shape == Shape::Joints {
                run.into_iter().try_for_each(disk)?;
                continue;
            }
            if part.shape == Shape::Body {
                canvas.draw(&Polygon::new(run.clone(), ink.mix(BODY).filled()))?;
                run.push(run[0]);
            }
            // Lines have round ends.
            [run[0], run[run.len() - 1]].into_iter().try_for_each(disk)?;
            canvas.draw(&PathElement::new(run, ink.stroke_width(width as u32)))?;
        }
        Ok(())
    }
}

/// The number of frames, if all parts that move have as many, with points that correspond: otherwise players stand
/// still.
fn checked(animation: &Animation) -> Result<usize, ChartError> {
    let (seconds, speed) = (animation.duration, animation.speed);
    if !(seconds > 0.0 && speed > 0.0 && seconds.is_finite() && speed.is_finite()) {
        return Err(ChartError::Frames(format!(
            "{seconds} s at {speed} times their speed are no time to play them in"
        )));
    }
    let mut frames = 1;
    for Part { name, frames: all, .. } in &animation.parts {
        let Some(first) = all.first() else {
            return Err(ChartError::Frames(format!("`{name}` has no frame")));
        };
        if all.len() > 1 && frames > 1 && all.len() != frames {
            let count = all.len();
            return Err(ChartError::Frames(format!(
                "`{name}` has {count} frames, a part before it {frames}"
            )));
        }
        frames = frames.max(all.len());
        let pattern = |points: &[(f64, f64)]| points.iter().map(is_finite).collect::<Vec<_>>();
        if let Some(k) = all.iter().position(|points| pattern(points) != pattern(first)) {
            return Err(ChartError::Frames(format!(
                "frame {k} of `{name}` has not as many points as the first, or one that is not finite where that of the \
                 first is, or conversely"
            )));
        }
    }
    Ok(frames)
}

fn hexadecimal(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiny_skia::Pixmap;

    /// A bar that turns by a quarter about the origin, in front of a body at rest.
    fn example() -> Animation {
        let frames = [vec![(0.0, 0.0), (1.0, 0.0)], vec![(0.0, 0.0), (0.0, 1.0)]];
        Animation::new("Title", 1.5)
            .with(Part::body("ground", [vec![(-1.0, -0.5), (1.0, -0.5), (1.0, -1.0), (-1.0, -1.0)]]))
            .with(Part::bars("bar & <rod>", frames))
    }

    fn refused(animation: &Animation) -> String {
        let ChartError::Frames(reason) = animation.svg().unwrap_err() else { panic!("another error") };
        assert!(matches!(animation.png(), Err(ChartError::Frames(_))));
        reason
    }

    #[test]
    fn it_is_svg_that_moves() {
        let svg = example().svg().unwrap();
        assert_eq!(svg, example().svg().unwrap());
        assert!(roxmltree::Document::parse(&svg).is_ok(), "well-formed");
        assert_eq!(svg.matches("<animate ").count(), 2, "the bar, and time");
        assert!(example().speed(0.25).svg().unwrap().contains("dur=\"6s\""));
        assert!(svg.contains("dur=\"1.5s\"") && svg.contains("bar &amp; &lt;rod>"));
        assert!(!svg.contains("<text"));
    }

    #[test]
    fn a_unit_is_as_long_upwards_as_across() {
        let animation = example();
        let stage = Stage::of(&animation).unwrap();
        let at = |frame| animation.parts[1].outline(frame, |point| stage.place(point));
        // The second point is written from the first one on.
        let numbers = |path: String| -> [f64; 4] {
            let numbers = path[1..].replace('l', " ").replace('-', " -");
            let [x, y, dx, dy] =
                numbers.split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<_>>()[..]
            else {
                panic!("{path}")
            };
            [x, y, x + dx, y + dy].map(|fine: f64| fine / FINE)
        };
        assert!(at(0).starts_with('M') && at(0).contains('l'), "{}", at(0));
        let (flat, upright) = (numbers(at(0)), numbers(at(1)));
        assert_eq!(flat[..2], upright[..2]);
        assert_eq!((flat[1], upright[0]), (flat[3], upright[2]));
        assert!((flat[2] - flat[0] - (upright[1] - upright[3])).abs() < 0.11 && flat[2] > flat[0]);
        assert!(flat[2] < ALONE.width && upright[3] > 0.0);
    }

    #[test]
    fn png_shows_every_still() {
        let frames: Vec<_> = (0..=10).map(|k| vec![(0.0, 0.0), (1.0, 0.1 * f64::from(k))]).collect();
        let animation = Animation::new("", 1.0).with(Part::joints("dots", frames).width(60.0));
        let picture = Pixmap::decode_png(&animation.png().unwrap()).unwrap();
        let blue = |x: u32, y: u32| picture.pixel(x, y).is_some_and(|p| p.blue() > 0xA0 && p.red() < 0x40);
        for column in 0..3 {
            for row in 0..2 {
                let (wide, high) = (picture.width() / 3, picture.height() / 2);
                let pixels = (0..high).flat_map(|y| (0..wide).map(move |x| (x, y)));
                let count = pixels.filter(|&(x, y)| blue(column * wide + x, row * high + y)).count();
                assert!(count > 1000, "{column} {row}: {count}");
            }
        }
    }

    #[test]
    fn csv_has_parts_times_and_points() {
        let csv = example().csv();
        assert_eq!(csv.lines().count(), 1 + 4 + 4);
        assert!(csv.contains("\nground,,3,-1.0,-1.0\n") && csv.ends_with("\nbar & <rod>,1.5,1,0.0,1.0\n"));
    }

    #[test]
    fn frames_that_do_not_correspond_are_errors() {
        let moving = |frames: Vec<Vec<(f64, f64)>>| example().with(Part::bars("other", frames));
        let (a, b) = (vec![(0.0, 0.0), (1.0, 1.0)], vec![(0.0, 0.0), (1.0, f64::NAN)]);
        assert!(refused(&moving(vec![a.clone(), b.clone()])).starts_with("frame 1 of `other`"));
        assert!(refused(&moving(vec![a.clone(), a[..1].to_vec()])).starts_with("frame 1 of `other`"));
        assert_eq!(refused(&moving(vec![a.clone(); 3])), "`other` has 3 frames, a part before it 2");
        assert_eq!(refused(&moving(vec![])), "`other` has no frame");
        assert!(moving(vec![b.clone(), b]).svg().is_ok(), "a gap in every frame is a gap");
        assert!(refused(&Animation { duration: f64::NAN, ..example() }).starts_with("NaN s at 1 times"));
        assert!(refused(&example().speed(0.0)).starts_with("1.5 s at 0 times"));
    }

    #[test]
    fn odd_extents_are_drawn_and_nothing_is_an_error() {
        assert!(matches!(Animation::new("", 1.0).svg(), Err(ChartError::NoPoints)));
        for points in [vec![(3.0, 4.0)], vec![(0.0, 2.0), (1.0, 2.0)], vec![(-1e300, 1e308), (1e300, -1e308)]]
        {
            let animation = Animation::new("", 1.0).with(Part::bars("bar", [points.clone()]));
            let svg = animation.svg().unwrap();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{points:?}");
            assert!(animation.png().is_ok());
        }
    }
}
