//! One small chart, as SVG. Only this file names the plotting library.

use std::fmt;
use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::{BandPlot, LinePlot};
use kuva::render::annotations::ReferenceLine;
use kuva::render::figure::Figure as Sheet;
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::theme::Theme;
use maud::{Markup, PreEscaped, html};

use super::Words;
use crate::gait::Side;

/// A colour, red, green and blue; written `#rrggbb`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Colour([u8; 3]);

/// Healthy people.
pub(super) const NORM: Colour = Colour([0x8a; 3]);
/// Neither side.
pub(super) const BOTH: Colour = Colour([0x33; 3]);

impl From<Side> for Colour {
    fn from(side: Side) -> Self {
        Self(side.colour())
    }
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.0;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

/// The colours of the sides as the page's style has them: `--left`, `--right`, and for colour-blind readers others, which
/// also replace those in the charts (Okabe & Ito 2008). In the dark they are lighter, but for what is drawn on white.
pub(super) fn style_of_sides() -> String {
    let [left, right] = Side::BOTH.map(Colour::from);
    let mut style = format!(
        ":root {{ --left: {left}; --right: {right} }} .cb {{ --left: #d55e00; --right: #0072b2 }} \
         .cb [stroke=\"{left}\"] {{ stroke-dasharray: 6 3 }} \
         @media screen and (prefers-color-scheme: dark) {{ \
         :root {{ --left: #ff8a96; --right: #7db3ff }} .cb {{ --left: #f29a4a; --right: #5ab4ec }} \
         .chart, #curves, .stage {{ --left: {left}; --right: {right}; --ink: #1c1f24 }} \
         .cb .chart, .cb #curves, .cb .stage {{ --left: #d55e00; --right: #0072b2 }} }}"
    );
    for (side, colour) in [("left", left), ("right", right)] {
        for what in ["stroke", "fill"] {
            style += &format!(" .cb [{what}=\"{colour}\"] {{ {what}: var(--{side}) }}");
        }
    }
    style
}

/// One axis: its label and range.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) range: (f64, f64),
    /// Distance of its ticks.
    pub(super) step: f64,
}

/// One chart.
pub(super) struct Figure {
    title: String,
    axes: [Axis; 2],
    size_px: (f64, f64),
    plots: Vec<Plot>,
    rules: Vec<ReferenceLine>,
}

impl fmt::Debug for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Figure({:?}, {} plots)", self.title, self.plots.len())
    }
}

impl Figure {
    /// An empty chart.
    pub(super) fn new(title: &str, x: Axis, y: Axis) -> Self {
        Self {
            title: title.to_owned(),
            axes: [x, y],
            size_px: (280.0, 206.0),
            plots: Vec::new(),
            rules: Vec::new(),
        }
    }

    /// Makes it wide and low.
    pub(super) fn wide(mut self) -> Self {
        self.size_px = (840.0, 220.0);
        self
    }

    /// Adds a line of a width in pixels; it breaks where a value is not finite.
    pub(super) fn line(mut self, colour: Colour, width_px: f64, points: &[(f64, f64)]) -> Self {
        let is_known = |p: &(f64, f64)| p.1.is_finite();
        for run in points.chunk_by(|a, b| is_known(a) && is_known(b)) {
            if run.len() > 1 {
                let line = LinePlot::new().with_data(run.iter().copied());
                let line = line.with_color(colour.to_string()).with_stroke_width(width_px);
                self.plots.push(Plot::Line(line));
            }
        }
        self
    }

    /// Adds the area between two curves, (x, low, high); it breaks where one of them is not finite.
    pub(super) fn band(mut self, colour: Colour, opacity: f64, points: &[(f64, f64, f64)]) -> Self {
        let is_known = |p: &(f64, f64, f64)| p.1.is_finite() && p.2.is_finite();
        for run in points.chunk_by(|a, b| is_known(a) && is_known(b)) {
            if run.len() > 1 {
                let xs = run.iter().map(|p| p.0);
                let band = BandPlot::new(xs, run.iter().map(|p| p.1), run.iter().map(|p| p.2));
                let band = band.with_color(colour.to_string()).with_opacity(opacity);
                self.plots.push(Plot::Band(band));
            }
        }
        self
    }

    /// Adds a dashed vertical line.
    pub(super) fn rule(mut self, colour: Colour, x: f64) -> Self {
        self.rules.push(ReferenceLine::vertical(x).with_color(colour.to_string()));
        self
    }

    /// The range of its upright axis.
    pub(super) fn height(&self) -> (f64, f64) {
        self.axes[1].range
    }

    /// Whether nothing is drawn in it.
    pub(super) fn is_empty(&self) -> bool {
        self.plots.is_empty()
    }

    /// The chart, with a text for those who do not see it.
    pub(super) fn markup(self, description: &str, words: &Words) -> Markup {
        let layout = self.layout(words);
        let sheet = Sheet::new(1, 1)
            .with_plots(vec![self.plots])
            .with_layouts(vec![layout])
            .with_padding(0.0)
            .with_cell_size(self.size_px.0, self.size_px.1);
        let svg = SvgBackend.render_scene(&sheet.render());
        // a drawing that scales with its frame
        let (width, height) = self.size_px;
        let fixed = format!(r#"width="{width}" height="{height}""#);
        let svg = svg.replacen(&fixed, &format!(r#"viewBox="0 0 {width} {height}""#), 1);
        html! {
            div class="chart" role="img" aria-label=(description) { (PreEscaped(svg)) }
        }
    }

    fn layout(&self, words: &Words) -> Layout {
        let ticks = match words.is_decimal_comma() {
            true => TickFormat::Custom(Arc::new(|value| {
                TickFormat::Auto.format(value).replace('.', ",")
            })),
            false => TickFormat::Auto,
        };
        let theme = Theme {
            grid_color: "#e6e6e6".into(),
            font_family: Some("Helvetica, Arial, sans-serif".into()),
            ..Theme::light()
        };
        let [x, y] = &self.axes;
        let layout = Layout::auto_from_plots(&self.plots)
            .with_x_axis_min(x.range.0)
            .with_x_axis_max(x.range.1)
            .with_y_axis_min(y.range.0)
            .with_y_axis_max(y.range.1)
            .with_x_tick_step(x.step)
            .with_y_tick_step(y.step)
            .with_tick_format(ticks)
            .with_theme(theme)
            .with_title(&self.title)
            .with_x_label(&x.label)
            .with_y_label(&y.label)
            .with_title_size(13)
            .with_label_size(11)
            .with_tick_size(10)
            // the same for all, so that the charts of a column align
            .with_force_margins(46.0, 12.0)
            // room for the title
            .with_force_margins_y(34.0, if x.label.is_empty() { 24.0 } else { 38.0 });
        let rules = self.rules.iter().cloned();
        rules.fold(layout, Layout::with_reference_line)
    }
}

/// The range of an axis that holds all finite values and `least` in whole steps, and the step: 4 to 8 ticks where that
/// leaves a choice.
pub(super) fn axis_range(
    values: impl Iterator<Item = f64>,
    least: (f64, f64),
) -> ((f64, f64), f64) {
    let known = values.filter(|v| v.is_finite());
    let (low, high) = known.fold(least, |(low, high), v| (low.min(v), high.max(v)));
    let rough = ((high - low) / 6.0).max(1e-6);
    let power = 10_f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let step = steps.into_iter().find(|s| *s >= rough * 0.999);
    let step = step.unwrap_or(10.0 * power);
    let range = ((low / step).floor() * step, (high / step).ceil() * step);
    (range, step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Language;

    fn axis(range: (f64, f64)) -> Axis {
        Axis { label: "a".into(), range, step: 0.5 * (range.1 - range.0) }
    }

    #[test]
    fn a_line_is_broken_where_nothing_is_known() {
        let points = [(0.0, 1.0), (1.0, 2.0), (2.0, f64::NAN), (3.0, 1.0), (4.0, 2.0)];
        let left = Colour::from(Side::Left);
        let band = points.map(|(x, y)| (x, 0.5 * y, y));
        let figure = Figure::new("t", axis((0.0, 4.0)), axis((0.0, 2.0))).line(left, 1.0, &points);
        let figure = figure.band(left, 0.2, &band);
        assert_eq!(figure.plots.len(), 4);
        let text = figure.markup("two pieces", &Words::new(Language::English)).into_string();
        assert!(text.contains("viewBox=\"0 0 280 206\""), "{text}");
        assert!(text.contains("aria-label=\"two pieces\"") && text.contains(&left.to_string()));
        assert!(!text.contains("NaN"));
    }

    #[test]
    fn the_page_has_the_colours_of_the_sides_and_finds_them_in_the_charts() {
        let style = style_of_sides();
        let [left, right] = Side::BOTH.map(|side| Colour::from(side).to_string());
        assert!(style.contains(&format!("--left: {left}; --right: {right}")), "{style}");
        assert!(style.contains(&format!("[fill=\"{right}\"] {{ fill: var(--right) }}")), "{style}");
    }

    #[test]
    fn a_range_holds_every_value_in_whole_steps() {
        let (range, step) = axis_range([-3.0, 61.0, f64::NAN].into_iter(), (0.0, 60.0));
        approx::assert_relative_eq!(step, 20.0);
        approx::assert_relative_eq!(range.0, -20.0);
        approx::assert_relative_eq!(range.1, 80.0);
        let (range, _) = axis_range([].into_iter(), (0.0, 0.0));
        assert!(range.0.is_finite() && range.1.is_finite());
    }
}
