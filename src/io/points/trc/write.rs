//! Trajectories as Pose2Sim writes them.

use std::fmt::Write;

use nalgebra::Point3;

use super::Trajectories;
use crate::camera::UpAxis;

/// The text of a TRC file in Pose2Sim's layout: metres, Y up; frame 0 stands there as 1, at 0 s.
///
/// The first line repeats `file_name`. Numbers have six decimals (1 µm); a missing point is three empty cells.
pub fn write_trc(trajectories: &Trajectories, file_name: &str) -> String {
    let Trajectories { rate_hz, first_frame, names, frames } = trajectories;

    let (count, points) = (frames.len(), names.len());
    let mut text = format!("PathFileType\t4\t(X/Y/Z)\t{}\n", cell(file_name));
    text.push_str(
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n",
    );
    push(
        &mut text,
        format_args!(
            "{rate_hz}\t{rate_hz}\t{count}\t{points}\tm\t{rate_hz}\t{first_frame}\t{count}\n"
        ),
    );

    text.push_str("Frame#\tTime");
    for name in names {
        push(&mut text, format_args!("\t{}\t\t", cell(name)));
    }
    text.push_str("\t\n\t");
    for i in 1..=points {
        push(&mut text, format_args!("\tX{i}\tY{i}\tZ{i}"));
    }
    text.push_str("\t\n");

    for (k, frame) in (*first_frame..).zip(frames) {
        push(&mut text, format_args!("{}\t{:.6}", k + 1, k as f64 / rate_hz));
        for point in frame {
            push_point(&mut text, point.as_ref());
        }
        text.push('\n');
    }

    text
}

fn push_point(text: &mut String, point_world: Option<&Point3<f64>>) {
    match point_world {
        Some(p) if p.iter().all(|v| v.is_finite()) => {
            let p = UpAxis::Y.to_export(&p.coords);
            push(text, format_args!("\t{:.6}\t{:.6}\t{:.6}", p.x, p.y, p.z));
        }
        _ => text.push_str("\t\t\t"),
    }
}

/// Writing to a string does not fail.
fn push(text: &mut String, what: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(what);
}

/// A name without what would end its cell.
fn cell(name: &str) -> String {
    name.replace(|c: char| c.is_control(), " ")
}
