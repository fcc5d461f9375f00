//! Places in a drawing, as SVG writes them.

use nalgebra::Vector2;

/// The points of a polyline.
pub(super) fn points(places: impl Iterator<Item = Vector2<f64>>) -> String {
    places.map(|p| format!("{},{}", number(p.x), number(p.y))).collect::<Vec<_>>().join(" ")
}

/// A coordinate.
pub(super) fn number(px: f64) -> String {
    format!("{px:.1}")
}
