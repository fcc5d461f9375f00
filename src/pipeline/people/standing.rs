//! Who stands where in one frame.
//!
//! Seen from above, the voxels that the masks leave are columns. V(x, y) is the volume of all columns within 0.12 m: a person is a peak of it.
//! From the highest column down, each joins the peak that it touches; where two peaks meet at a saddle that is higher than half of the lower
//! peak, they are one body (a leg ahead, an arm to the side), else two people (who may hold hands). What is lower than a child who walks is
//! part of the nearest person. What explains nothing in the pictures that the others do not is nobody: lines of sight cross where nobody stands.

use nalgebra::{Point3, Vector3};

use super::room::Room;
use crate::camera::Rig;
use crate::silhouette::FrameObservations;

/// What is within so far of a column belongs to one body, metres: half of a trunk's depth.
const AROUND_M: f64 = 0.12;
/// Two peaks are one body if the saddle between them is higher than this share of the lower.
const SADDLE: f64 = 0.5;
/// The smallest child who walks, metres.
const SMALLEST_M: f64 = 0.7;
/// A person fills so much of the pictures' cells alone, over all that they fill, in the camera where it is most.
const LEAST_OWN: f64 = 0.3;

/// One person of a frame.
#[derive(Debug, Clone)]
pub(super) struct Standing {
    /// The middle of their voxels.
    pub(super) place: Point3<f64>,
    /// From their lowest to their highest voxel, metres.
    pub(super) height_m: f64,
    pub(super) voxels: Vec<usize>,
}

impl Standing {
    pub(super) fn new(room: &Room, voxels: Vec<usize>) -> Self {
        let places = || voxels.iter().map(|v| room.place(*v));
        let sum: Vector3<f64> = places().map(|p| p.coords).sum();
        let height_m = extent(places().map(|p| p.z)) + room.voxel_m;
        Self { place: (sum / voxels.len().max(1) as f64).into(), height_m, voxels }
    }
}

/// The people of a frame.
pub(super) fn standing(room: &Room, rig: &Rig, frame: &FrameObservations) -> Vec<Standing> {
    let occupied = room.occupied(frame);
    let (peak_of, peaks) = Columns::new(room, &occupied).peaks();
    let mut bodies: Vec<Vec<usize>> = vec![Vec::new(); peaks];
    for voxel in occupied {
        bodies[peak_of[room.column(voxel).0]].push(voxel);
    }

    let bodies = bodies.into_iter().map(|voxels| Standing::new(room, voxels));
    let (mut people, rest): (Vec<Standing>, Vec<Standing>) =
        bodies.partition(|body| body.height_m >= SMALLEST_M);
    while let Some(ghost) = ghost(room, rig, frame, &people) {
        people.remove(ghost);
    }
    let mut there: Vec<&mut Standing> = people.iter_mut().collect();
    let rest = rest.into_iter().flat_map(|body| body.voxels);
    rest.for_each(|voxel| give(room, voxel, &mut there));
    people.into_iter().map(|person| Standing::new(room, person.voxels)).collect()
}

/// From the least to the largest of some heights; −∞ without any.
fn extent(heights: impl Iterator<Item = f64>) -> f64 {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = heights.fold(ends, |(low, high), z| (low.min(z), high.max(z)));
    high - low
}

/// Which of some places is nearest to a voxel, seen from above.
pub(super) fn nearest(
    room: &Room,
    voxel: usize,
    places: impl Iterator<Item = (usize, Point3<f64>)>,
) -> Option<usize> {
    let at = room.place(voxel);
    let off = places.map(|(index, place)| (index, (place - at).xy().norm()));
    off.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

/// Gives a voxel to the nearest of some people.
pub(super) fn give(room: &Room, voxel: usize, people: &mut [&mut Standing]) {
    let places = people.iter().map(|person| person.place).enumerate();
    if let Some(person) = nearest(room, voxel, places) {
        people[person].voxels.push(voxel);
    }
}

/// Whether somebody may stand at a place: voxels near it reach as high as the smallest person.
pub(super) fn is_filled(room: &Room, voxels: &[usize], place: &Point3<f64>) -> bool {
    let near = voxels.iter().map(|voxel| room.place(*voxel));
    let near = near.filter(|at| (at - place).xy().norm() <= AROUND_M);
    extent(near.map(|at| at.z)) >= SMALLEST_M
}

/// The one who explains least of the pictures alone, if it is too little.
fn ghost(room: &Room, rig: &Rig, frame: &FrameObservations, people: &[Standing]) -> Option<usize> {
    if people.len() < 2 {
        return None;
    }
    let voxels: Vec<&[usize]> = people.iter().map(|person| person.voxels.as_slice()).collect();
    let cells = frame.views.iter().map(|(id, _)| room.person_cells(rig, *id, &voxels));
    let cells: Vec<_> = cells.collect();
    let own = |person: usize| {
        let views = cells.iter().zip(&frame.views);
        let shares = views.map(|(cells, (_, silhouette))| cells.own_share(silhouette, person));
        shares.fold(0.0, f64::max)
    };
    let all = (0..people.len()).map(|person| (person, own(person)));
    let least = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (least.1 < LEAST_OWN).then_some(least.0)
}

/// The room from above.
struct Columns {
    width: usize,
    /// Voxels within reach of each column; 0 of an empty one.
    volume: Vec<usize>,
}

impl Columns {
    fn new(room: &Room, occupied: &[usize]) -> Self {
        let (width, height) = (room.counts[0], room.counts[1]);
        let mut own = vec![0_usize; width * height];
        occupied.iter().for_each(|voxel| own[room.column(*voxel).0] += 1);

        let reach = AROUND_M / room.voxel_m;
        let whole = reach as isize;
        let disc = (-whole..=whole).flat_map(|j| (-whole..=whole).map(move |i| (i, j)));
        let disc: Vec<(isize, isize)> =
            disc.filter(|(i, j)| ((i * i + j * j) as f64).sqrt() <= reach).collect();
        let around = |column: usize| {
            let (x, y) = ((column % width) as isize, (column / width) as isize);
            let near = disc.iter().map(|(i, j)| (x + i, y + j));
            let near = near.filter(|(x, y)| {
                (0..width as isize).contains(x) && (0..height as isize).contains(y)
            });
            near.map(|(x, y)| own[y as usize * width + x as usize]).sum()
        };
        let volume = (0..own.len()).map(|c| if own[c] > 0 { around(c) } else { 0 });
        Self { width, volume: volume.collect() }
    }

    /// The peak that each column belongs to, and how many there are.
    fn peaks(&self) -> (Vec<usize>, usize) {
        let mut columns: Vec<usize> =
            (0..self.volume.len()).filter(|column| self.volume[*column] > 0).collect();
        columns.sort_by_key(|column| std::cmp::Reverse(self.volume[*column]));

        // each column's peak, and each peak's height and what it was merged into
        let mut of_column: Vec<Option<usize>> = vec![None; self.volume.len()];
        let mut heights: Vec<usize> = Vec::new();
        let mut into: Vec<usize> = Vec::new();
        for column in columns {
            let mut touched: Vec<usize> = self.around(column);
            touched.retain(|beside| of_column[*beside].is_some());
            let mut touched: Vec<usize> = touched
                .iter()
                .filter_map(|beside| of_column[*beside])
                .map(|p| root(&into, p))
                .collect();
            touched.sort_unstable();
            touched.dedup();
            touched.sort_by_key(|peak| std::cmp::Reverse(heights[*peak]));
            let Some(highest) = touched.first().copied() else {
                of_column[column] = Some(heights.len());
                into.push(heights.len());
                heights.push(self.volume[column]);
                continue;
            };
            of_column[column] = Some(highest);
            for lower in &touched[1..] {
                if self.volume[column] as f64 > SADDLE * heights[*lower] as f64 {
                    into[*lower] = highest;
                }
            }
        }

        // numbered without gaps
        let mut roots: Vec<usize> = (0..into.len()).filter(|peak| into[*peak] == *peak).collect();
        roots.sort_by_key(|peak| std::cmp::Reverse(heights[*peak]));
        let number = |peak: usize| roots.iter().position(|r| *r == root(&into, peak)).unwrap_or(0);
        let of_column = of_column.into_iter().map(|peak| peak.map_or(0, number)).collect();
        (of_column, roots.len())
    }

    fn around(&self, column: usize) -> Vec<usize> {
        let (x, y) = ((column % self.width) as isize, (column / self.width) as isize);
        let height = (self.volume.len() / self.width) as isize;
        let near = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j)));
        let near =
            near.filter(|(x, y)| (0..self.width as isize).contains(x) && (0..height).contains(y));
        near.map(|(x, y)| y as usize * self.width + x as usize).collect()
    }
}

/// The peak that a peak was merged into.
fn root(into: &[usize], mut peak: usize) -> usize {
    while into[peak] != peak {
        peak = into[peak];
    }
    peak
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Motion;
    use crate::pipeline::diagnosis::figures::{Figures, joined};

    /// The people whom the masks of bodies that stand at these places show.
    fn found(figures: &Figures, places: &[[f64; 2]]) -> Vec<Standing> {
        let bodies: Vec<Motion> = places.iter().map(|[x, y]| figures.standing(*x, *y)).collect();
        let masks = bodies.iter().map(|body| figures.masks(body));
        let masks = masks.reduce(|a, b| joined(&a, &b)).unwrap();
        let frame = figures.frame(0, &masks);
        let room = Room::new(&figures.rig, std::slice::from_ref(&frame)).unwrap();
        standing(&room, &figures.rig, &frame)
    }

    fn has(people: &[Standing], [x, y]: [f64; 2]) -> bool {
        people.iter().any(|person| (person.place.x - x).hypot(person.place.y - y) < 0.1)
    }

    #[test]
    fn one_who_stands_is_one_and_two_are_two_even_if_they_touch() {
        let figures = Figures::new();
        let alone = found(&figures, &[[0.1, 0.2]]);
        assert!(alone.len() == 1 && has(&alone, [0.1, 0.2]), "{:?}", alone[0].place);
        assert!((1.5..1.9).contains(&alone[0].height_m), "{}", alone[0].height_m);

        // shoulders and arms are 50 cm wide
        for apart in [0.6, 0.8, 1.2] {
            let places = [[0.0, -0.5 * apart], [0.1, 0.5 * apart]];
            let both = found(&figures, &places);
            assert_eq!(both.len(), 2, "{apart} m");
            assert!(places.iter().all(|place| has(&both, *place)), "{apart} m");
            let voxels = both.iter().map(|person| person.voxels.len() as f64);
            let [a, b] = voxels.collect::<Vec<_>>()[..] else { panic!("two") };
            assert!((a / b).max(b / a) < 1.3, "{a} and {b} voxels");
        }
    }

    #[test]
    fn three_are_three_and_where_lines_of_sight_cross_is_nobody() {
        let figures = Figures::new();
        let places = [[0.0, -0.7], [0.6, 0.4], [-0.7, 0.3]];
        let all = found(&figures, &places);
        let found: Vec<_> = all.iter().map(|person| person.place).collect();
        assert!(all.len() == 3 && places.iter().all(|place| has(&all, *place)), "{found:?}");
    }
}
