//! Panels of curves and bars in one style, as SVG.

use kuva::backend::svg::SvgBackend;
use kuva::plot::scatter::MarkerShape;
use kuva::plot::{BandPlot, BarPlot, LegendPosition, LinePlot, ScatterPlot};
use kuva::render::annotations::ReferenceLine;
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::theme::Theme;

/// Colours that stay apart for colour-blind eyes.
///
/// # Source
/// Okabe & Ito 2008, *Color universal design*.
pub mod colour {
    /// Ours.
    pub const BLUE: &str = "#0072B2";
    /// The published way.
    pub const ORANGE: &str = "#D55E00";
    /// Third.
    pub const GREEN: &str = "#009E73";
    /// Fourth.
    pub const PURPLE: &str = "#AA4499";
    /// Truth.
    pub const BLACK: &str = "#222222";
    /// What is only there to compare with.
    pub const GREY: &str = "#999999";
}

/// One coordinate system with what is drawn in it.
pub struct Panel {
    title: String,
    labels: (String, String),
    ranges: ((f64, f64), (f64, f64)),
    legend: Option<LegendPosition>,
    plots: Vec<Plot>,
    rules: Vec<ReferenceLine>,
    categories: Vec<String>,
    equal: Aspect,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Aspect {
    Free,
    Equal,
}

impl std::fmt::Debug for Panel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Panel({:?}, {} plots)", self.title, self.plots.len())
    }
}

impl Panel {
    /// An empty panel; labels carry their unit.
    pub fn new(title: &str, x_label: &str, y_label: &str) -> Self {
        Self {
            title: title.to_owned(),
            labels: (x_label.to_owned(), y_label.to_owned()),
            ranges: ((0.0, 1.0), (0.0, 1.0)),
            legend: None,
            plots: Vec::new(),
            rules: Vec::new(),
            categories: Vec::new(),
            equal: Aspect::Free,
        }
    }

    /// What the axes show.
    pub fn ranges(mut self, x: (f64, f64), y: (f64, f64)) -> Self {
        self.ranges = (x, y);
        self
    }

    /// Shows the legend.
    pub fn legend(mut self, position: LegendPosition) -> Self {
        self.legend = Some(position);
        self
    }

    /// A unit of x is as long as one of y.
    pub fn equal_aspect(mut self) -> Self {
        self.equal = Aspect::Equal;
        self
    }

    /// A curve; no legend entry for an empty name.
    pub fn curve(mut self, name: &str, colour: &str, points: &[(f64, f64)]) -> Self {
        let line = LinePlot::new()
            .with_data(points.iter().copied())
            .with_color(colour)
            .with_stroke_width(2.0);
        self.plots.push(Plot::Line(if name.is_empty() { line } else { line.with_legend(name) }));
        self
    }

    /// A dashed curve.
    pub fn dashed(mut self, name: &str, colour: &str, points: &[(f64, f64)]) -> Self {
        let line =
            LinePlot::new().with_data(points.iter().copied()).with_color(colour).with_dashed();
        self.plots.push(Plot::Line(if name.is_empty() { line } else { line.with_legend(name) }));
        self
    }

    /// Round marks.
    pub fn marks(mut self, name: &str, colour: &str, points: &[(f64, f64)]) -> Self {
        let marks = ScatterPlot::new()
            .with_data(points.iter().copied())
            .with_color(colour)
            .with_size(4.0)
            .with_marker(MarkerShape::Circle);
        self.plots.push(Plot::Scatter(if name.is_empty() {
            marks
        } else {
            marks.with_legend(name)
        }));
        self
    }

    /// A curve through marks with error bars (x, y, half height).
    pub fn measured(mut self, name: &str, colour: &str, points: &[(f64, f64, f64)]) -> Self {
        let line = LinePlot::new()
            .with_data(points.iter().map(|p| (p.0, p.1)))
            .with_color(colour)
            .with_y_err(points.iter().map(|p| p.2))
            .with_stroke_width(1.5);
        self.plots.push(Plot::Line(if name.is_empty() { line } else { line.with_legend(name) }));
        self
    }

    /// The area between two curves (x, low, high).
    pub fn band(mut self, name: &str, colour: &str, points: &[(f64, f64, f64)]) -> Self {
        let band = BandPlot::new(
            points.iter().map(|p| p.0),
            points.iter().map(|p| p.1),
            points.iter().map(|p| p.2),
        )
        .with_color(colour)
        .with_opacity(0.2);
        self.plots.push(Plot::Band(if name.is_empty() { band } else { band.with_legend(name) }));
        self
    }

    /// Groups of bars, one for each series (name, colour).
    pub fn bars(mut self, series: &[(&str, &str)], groups: &[(String, Vec<f64>)]) -> Self {
        let mut bars = BarPlot::new().with_width(0.8);
        for (label, values) in groups {
            let values = values
                .iter()
                .zip(series)
                .map(|(value, (_, colour))| (*value, (*colour).to_owned()));
            bars = bars.with_group(label.clone(), values.collect::<Vec<_>>());
        }
        let names: Vec<&str> = series.iter().map(|(name, _)| *name).collect();
        if self.legend.is_some() {
            bars = bars.with_legend(names);
        }
        self.categories = groups.iter().map(|(label, _)| label.clone()).collect();
        self.plots.push(Plot::Bar(bars));
        self
    }

    /// A vertical line at an abscissa.
    pub fn rule_at(mut self, x: f64, label: &str) -> Self {
        let rule = ReferenceLine::vertical(x).with_color(colour::BLACK);
        self.rules.push(if label.is_empty() { rule } else { rule.with_label(label) });
        self
    }

    fn layout(&self) -> Layout {
        let theme = Theme {
            grid_color: "#e4e4e4".into(),
            legend_border: "none".into(),
            font_family: Some("Helvetica, Arial, sans-serif".into()),
            ..Theme::light()
        };
        let mut layout = Layout::auto_from_plots(&self.plots);
        if self.categories.is_empty() {
            layout = layout.with_x_axis_min(self.ranges.0.0).with_x_axis_max(self.ranges.0.1);
        }
        layout = layout
            .with_y_axis_min(self.ranges.1.0)
            .with_y_axis_max(self.ranges.1.1)
            .with_theme(theme)
            .with_title(&self.title)
            .with_x_label(&self.labels.0)
            .with_y_label(&self.labels.1)
            .with_title_size(14)
            .with_label_size(13)
            .with_tick_size(11)
            .with_body_size(11);
        if let Some(position) = self.legend {
            layout = layout.with_legend_position(position);
        }
        if self.equal == Aspect::Equal {
            layout = layout.with_equal_aspect();
        }
        self.rules.iter().cloned().fold(layout, Layout::with_reference_line)
    }
}

/// Panels row by row, as SVG; every panel is `size` (width, height) pixels.
pub fn svg(columns: usize, size: (f64, f64), panels: Vec<Panel>) -> String {
    let rows = panels.len().div_ceil(columns);
    let layouts = panels.iter().map(Panel::layout).collect();
    let plots = panels.into_iter().map(|panel| panel.plots).collect();
    let figure = Figure::new(rows, columns)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_cell_size(size.0, size.1)
        .with_keep_panel_legends();
    SvgBackend.render_scene(&figure.render())
}
