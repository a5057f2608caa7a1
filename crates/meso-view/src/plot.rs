//! Curves over axes with round ticks, as SVG.

use std::io::{self, Write};

/// A plot of a few curves; the y axis begins at 0, or below the least value.
pub struct Plot<'a> {
    /// Title above the axes.
    pub title: &'a str,
    /// Label of the x axis, with its unit.
    pub x: &'a str,
    /// Label of the y axis.
    pub y: &'a str,
    /// Whether the x axis is logarithmic.
    pub log_x: bool,
    /// The curves, at most three in different colours.
    pub curves: Vec<Series<'a>>,
    /// Width and height, pixels.
    pub size: [f64; 2],
}

/// A named curve, or dots.
pub struct Series<'a> {
    name: &'a str,
    points: Vec<(f64, f64)>,
    drawn: Drawn,
}

/// Form of a series.
#[derive(Clone, Copy, PartialEq)]
enum Drawn {
    Line,
    Dots,
    /// One dot, which a script moves from point to point.
    Moving,
}

/// Colours that differ for every eye (Okabe and Ito 2008).
const COLOURS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
/// Margins, pixels; the legend lies between the title and the axes.
const LEFT: f64 = 48.0;
const RIGHT: f64 = 12.0;
const TITLE: f64 = 20.0;
const BOTTOM: f64 = 40.0;
/// Width of a legend's colour, mean width of a letter, and height of a line, pixels.
const SWATCH: f64 = 19.0;
const LETTER: f64 = 6.4;
/// Mean width of a letter in a plot that is wider than a phone, and that a phone reduces: its letters are larger there.
const REDUCED_LETTER: f64 = 8.8;
const ROW: f64 = 16.0;

impl<'a> Series<'a> {
    /// A line through `points`.
    pub fn line(name: &'a str, points: Vec<(f64, f64)>) -> Self {
        Self { name, points, drawn: Drawn::Line }
    }

    /// A dot at each of `points`.
    pub fn dots(name: &'a str, points: Vec<(f64, f64)>) -> Self {
        Self { name, points, drawn: Drawn::Dots }
    }

    /// A dot at the last of `points`, of the class `now`. Its attribute `data-at` has the places of all of them, for a script
    /// that moves it.
    pub fn moving(name: &'a str, points: Vec<(f64, f64)>) -> Self {
        Self { name, points, drawn: Drawn::Moving }
    }
}

/// The part of an axis that is shown, and where its ends lie, pixels.
struct Axis {
    from: f64,
    to: f64,
    pixels: [f64; 2],
    log: bool,
}

impl Axis {
    fn at(&self, value: f64) -> f64 {
        let scaled = |x: f64| if self.log { libm::log(x) } else { x };
        let share = (scaled(value) - scaled(self.from)) / (scaled(self.to) - scaled(self.from));
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// Round values within the axis, about five.
    fn ticks(&self) -> Vec<f64> {
        let rough = (self.to - self.from) / 5.0;
        let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
        let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= rough).unwrap_or(rough);
        let first = (self.from / step).ceil() as i64;
        (first..first + 20).map(|i| i as f64 * step).take_while(|&x| x <= self.to * (1.0 + 1e-9)).collect()
    }
}

impl Plot<'_> {
    /// Width and height of a plot that stands beside others, pixels.
    pub const SMALL: [f64; 2] = [350.0, 260.0];

    /// Writes the plot as SVG; its classes `f` and `g` are the frame and the grid.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let [width, height] = self.size;
        writeln!(
            out,
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"><text x=\"{LEFT}\" y=\"14\">{}</text>",
            escape(self.title)
        )?;
        let Some((x, y)) = self.axes() else {
            return writeln!(out, "<text x=\"{LEFT}\" y=\"60\">nothing to show</text></svg>");
        };
        self.frame(&x, &y, out)?;
        for (i, (curve, (tx, ty))) in self.curves.iter().zip(self.legend()).enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            draw(curve, colour, &x, &y, out)?;
            writeln!(out, "<rect x=\"{tx}\" y=\"{}\" width=\"14\" height=\"3\" fill=\"{colour}\"/>", ty - 5.0)?;
            writeln!(out, "<text x=\"{}\" y=\"{ty}\">{}</text>", tx + SWATCH, escape(curve.name))?;
        }
        writeln!(out, "</svg>")
    }

    /// Whether there is nothing to show: no points, or none beside 0.
    pub fn is_empty(&self) -> bool {
        self.axes().is_none()
    }

    /// Axes around all points, if there are any.
    fn axes(&self) -> Option<(Axis, Axis)> {
        let points =
            || self.curves.iter().flat_map(|curve| &curve.points).filter(|p| p.0.is_finite() && p.1.is_finite());
        let from = points().map(|p| p.0).fold(f64::INFINITY, f64::min);
        let to = points().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
        let [low, top] = [points().map(|p| p.1).fold(0.0, f64::min), points().map(|p| p.1).fold(0.0, f64::max)]
            .map(|end| end * 1.04);
        let [width, height] = self.size;
        let x = Axis { from, to, pixels: [LEFT, width - RIGHT], log: self.log_x };
        let y = Axis { from: low + 0.0, to: top, pixels: [height - BOTTOM, self.top()], log: false };
        (from < to && low < top).then_some((x, y))
    }

    /// Where the curves' names stand: in lines under the title, so that none lies on a curve, pixels.
    fn legend(&self) -> Vec<(f64, f64)> {
        let letter = if self.size[0] > Self::SMALL[0] { REDUCED_LETTER } else { LETTER };
        let (mut x, mut y) = (LEFT, TITLE + ROW - 4.0);
        let place = |series: &Series| {
            let wide = SWATCH + letter * series.name.chars().count() as f64 + 8.0;
            if x > LEFT && x + wide > self.size[0] {
                (x, y) = (LEFT, y + ROW);
            }
            let at = (x, y);
            x += wide;
            at
        };
        self.curves.iter().map(place).collect()
    }

    /// The upper end of the axes, below the legend, pixels.
    fn top(&self) -> f64 {
        self.legend().last().map_or(TITLE, |(_, y)| y + 8.0)
    }

    fn frame(&self, x: &Axis, y: &Axis, out: &mut impl Write) -> io::Result<()> {
        let [[left, right], [bottom, top]] = [x.pixels, y.pixels];
        for value in y.ticks() {
            let at = y.at(value);
            writeln!(out, "<path class=\"g\" d=\"M{left} {at:.1}H{right}\"/>")?;
            writeln!(
                out,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 5.0,
                at + 4.0,
                short(value)
            )?;
        }
        for value in x.ticks() {
            let at = x.at(value);
            writeln!(out, "<path class=\"g\" d=\"M{at:.1} {bottom}V{top}\"/>")?;
            writeln!(
                out,
                "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                bottom + 15.0,
                short(value)
            )?;
        }
        writeln!(out, "<path class=\"f\" d=\"M{left} {top}V{bottom}H{right}\"/>")?;
        let (middle, below) = ((left + right) / 2.0, bottom + 32.0);
        writeln!(out, "<text x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">{}</text>", self.x)?;
        let centre = (top + bottom) / 2.0;
        writeln!(out, "<text transform=\"translate(12 {centre}) rotate(-90)\" text-anchor=\"middle\">{}</text>", self.y)
    }
}

fn draw(curve: &Series, colour: &str, x: &Axis, y: &Axis, out: &mut impl Write) -> io::Result<()> {
    let points = curve.points.iter().filter(|p| p.1.is_finite()).map(|&(px, py)| (x.at(px), y.at(py)));
    match curve.drawn {
        Drawn::Line => {}
        Drawn::Dots => {
            return points.into_iter().try_for_each(|(px, py)| {
                writeln!(out, "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"3.5\" fill=\"{colour}\"/>")
            });
        }
        Drawn::Moving => {
            let at: Vec<String> = points.map(|(px, py)| format!("{px:.1},{py:.1}")).collect();
            let Some((x, y)) = at.last().and_then(|at| at.split_once(',')) else { return Ok(()) };
            let at = at.join(" ");
            return writeln!(
                out,
                "<circle class=\"now\" cx=\"{x}\" cy=\"{y}\" r=\"6\" fill=\"{colour}\" data-at=\"{at}\"/>"
            );
        }
    }
    write!(out, "<polyline fill=\"none\" stroke-width=\"1.8\" stroke=\"{colour}\" points=\"")?;
    for (px, py) in points {
        write!(out, "{px:.1},{py:.1} ")?;
    }
    writeln!(out, "\"/>")
}

/// A tick's number without the digits that multiplying left behind.
fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text as HTML shows it.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let axis = Axis { from: 5.0, to: 20.0, pixels: [0.0, 100.0], log: true };
        assert_eq!(axis.ticks(), [5.0, 10.0, 15.0, 20.0]);
        let axis = Axis { from: 0.0, to: 0.52, pixels: [100.0, 0.0], log: false };
        assert_eq!(axis.ticks().into_iter().map(short).collect::<Vec<_>>(), ["0", "0.2", "0.4"]);
        assert_eq!((axis.at(0.0), axis.at(0.52)), (100.0, 0.0));
    }

    fn plot(names: &[&'static str], points: &[(f64, f64)]) -> Plot<'static> {
        let curves = names.iter().map(|name| Series::line(name, points.to_vec())).collect();
        Plot { title: "", x: "", y: "", log_x: false, curves, size: Plot::SMALL }
    }

    #[test]
    fn names_stand_above_the_axes_and_within_the_plot() {
        let names = ["plates' work", "dissipated", "plate friction", "hourglass"];
        let plot = plot(&names, &[(0.0, 0.0), (1.0, 1.0)]);
        let (_, y) = plot.axes().unwrap();
        let legend = plot.legend();
        for ((x, at), name) in legend.iter().zip(names) {
            assert!(*at < y.pixels[1] && x + SWATCH + LETTER * name.len() as f64 <= Plot::SMALL[0], "{name}");
        }
        assert!(legend[0].1 < legend[3].1, "four names need two lines");
        // A phone draws a wide plot's letters larger: "peak" lay on the name after it.
        let wide = Plot { size: [560.0, 400.0], ..plot };
        let places = wide.legend();
        for (names, places) in names.windows(2).zip(places.windows(2)) {
            let end = places[0].0 + SWATCH + 8.5 * names[0].len() as f64;
            assert!(end < places[1].0 || places[0].1 < places[1].1, "{names:?}");
        }
    }

    #[test]
    fn an_axis_goes_down_to_negative_values() {
        let (_, y) = plot(&["lateral"], &[(0.0, 0.0), (1.0, -2e-4)]).axes().unwrap();
        assert!(y.from < -2e-4 && y.to == 0.0);
    }

    #[test]
    fn a_moving_dot_knows_all_its_places() {
        let plot = Plot { curves: vec![Series::moving("now", vec![(0.0, 1.0), (1.0, 2.0)])], ..plot(&[], &[]) };
        let mut text = Vec::new();
        plot.write(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let at = text.split("data-at=\"").nth(1).unwrap().split('"').next().unwrap();
        let last: Vec<&str> = at.split(' ').collect();
        assert_eq!(last.len(), 2);
        let (x, y) = last[1].split_once(',').unwrap();
        assert!(text.contains(&format!("cx=\"{x}\" cy=\"{y}\"")), "{text}");
    }

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(escape("<b> & </b>"), "&lt;b&gt; &amp; &lt;/b&gt;");
    }
}
