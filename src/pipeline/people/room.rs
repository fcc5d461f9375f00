//! The room in voxels, and which part of it the masks leave.

use nalgebra::{Point2, Point3, Vector3};
use rayon::prelude::*;

use crate::camera::{Camera, CameraId, Ray, Rig, closest_point};
use crate::inference::hull::nearly_all;
use crate::silhouette::{FrameObservations, Silhouette};

/// Edge of a voxel, metres: half of a forearm's width is not needed to tell people apart, half of a leg's is.
const VOXEL_M: f64 = 0.06;
/// Most voxels; in a larger room they are made larger.
const MOST_VOXELS: f64 = 1_500_000.0;
/// The room reaches so far to each side of where the lines of sight to the masks' middles meet, and above and below, metres.
const REACH_M: [f64; 3] = [2.5, 2.5, 1.6];
/// The cell of a voxel that a camera does not see.
const UNSEEN: u32 = u32::MAX;

/// The voxels, and where each camera sees them.
pub(super) struct Room {
    low: Point3<f64>,
    pub(super) voxel_m: f64,
    /// Along x, y, z.
    pub(super) counts: [usize; 3],
    cameras: Vec<Cells>,
}

/// A camera's picture in cells of about half a voxel's size.
struct Cells {
    side_px: f64,
    width: usize,
    /// The middle of each, undistorted pixels; `None` beyond the lens.
    middles: Vec<Option<Point2<f64>>>,
    of_voxel: Vec<u32>,
}

/// Whose a cell of a picture may be: bit p for person p.
pub(super) struct PersonCells<'a> {
    cells: &'a Cells,
    camera: &'a Camera,
    height: usize,
    bits: Vec<u32>,
}

impl Room {
    /// The room around where the masks' lines of sight meet; `None` if they never do.
    pub(super) fn new(rig: &Rig, frames: &[FrameObservations]) -> Option<Self> {
        let middle = |frame: &FrameObservations| {
            let sights = frame.views.iter().map(|(id, s)| rig.cameras[id.0].ray(&s.centroid));
            let sights: Vec<Ray> = sights.collect();
            (sights.len() >= 2).then(|| closest_point(&sights)).flatten()
        };
        let reach = Vector3::from(REACH_M);
        let boxes = frames.iter().filter_map(middle).map(|p| (p - reach, p + reach));
        let (low, high) = boxes.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))?;

        let size = high - low;
        let voxel_m = VOXEL_M.max((size.product() / MOST_VOXELS).cbrt());
        let counts = [0, 1, 2].map(|axis| (size[axis] / voxel_m).ceil() as usize);
        let mut room = Self { low, voxel_m, counts, cameras: Vec::new() };
        let places: Vec<Point3<f64>> =
            (0..counts.iter().product()).map(|v| room.place(v)).collect();
        let cells = rig.cameras.par_iter().map(|camera| Cells::new(camera, &places, voxel_m));
        room.cameras = cells.collect();
        Some(room)
    }

    /// The column of a voxel, x first, and its height in the column.
    pub(super) fn column(&self, voxel: usize) -> (usize, usize) {
        (voxel % (self.counts[0] * self.counts[1]), voxel / (self.counts[0] * self.counts[1]))
    }

    /// The middle of a voxel.
    pub(super) fn place(&self, voxel: usize) -> Point3<f64> {
        let (column, z) = self.column(voxel);
        let (x, y) = (column % self.counts[0], column / self.counts[0]);
        let steps = [x, y, z].map(|i| (i as f64 + 0.5) * self.voxel_m);
        self.low + Vector3::from(steps)
    }

    /// The voxels that the masks of a frame leave: two cameras or more see them, and all of these show somebody there.
    pub(super) fn occupied(&self, frame: &FrameObservations) -> Vec<usize> {
        let shown = frame.views.iter().map(|(id, silhouette)| {
            let cells = &self.cameras[id.0];
            (cells, cells.foreground(silhouette))
        });
        let shown: Vec<(&Cells, Vec<bool>)> = shown.collect();
        let is_occupied = |voxel: &usize| {
            let at = |cells: &Cells| cells.of_voxel[*voxel] as usize;
            nearly_all(shown.iter().filter_map(|(cells, shown)| shown.get(at(cells)).copied()))
        };
        (0..self.counts.iter().product()).filter(is_occupied).collect()
    }

    /// Whose each cell of a camera's picture may be, of people who fill these voxels.
    pub(super) fn person_cells<'a>(
        &'a self,
        rig: &'a Rig,
        id: CameraId,
        people: &[&[usize]],
    ) -> PersonCells<'a> {
        let cells = &self.cameras[id.0];
        let mut bits = vec![0; cells.middles.len()];
        for (person, voxels) in people.iter().enumerate() {
            for voxel in *voxels {
                if let Some(cell) = bits.get_mut(cells.of_voxel[*voxel] as usize) {
                    *cell |= 1 << person;
                }
            }
        }
        let height = cells.middles.len() / cells.width;
        PersonCells { cells, camera: &rig.cameras[id.0], height, bits }
    }
}

impl Cells {
    fn new(camera: &Camera, places: &[Point3<f64>], voxel_m: f64) -> Self {
        let depths = places.iter().step_by((places.len() / 1000).max(1));
        let mut depths: Vec<f64> =
            depths.map(|p| (camera.camera_from_world * p).z).filter(|z| *z > 0.0).collect();
        let depth_m = crate::math::stats::median(&mut depths).unwrap_or(1.0);
        let side_px = (0.5 * voxel_m * camera.intrinsics.focal_px() / depth_m).max(1.0);

        let count = |size: u32| (f64::from(size) / side_px).ceil() as usize;
        let (width, height) = (count(camera.width_px), count(camera.height_px));
        let middle = |cell: usize| {
            let at = [cell % width, cell / width].map(|i| (i as f64 + 0.5) * side_px - 0.5);
            camera.undistort(&Point2::from(at))
        };
        let cell = |place: &Point3<f64>| {
            let pixel = camera.project(place).filter(|pixel| camera.contains(pixel));
            let at = |pixel: f64| ((pixel + 0.5) / side_px) as usize;
            pixel.map_or(UNSEEN, |pixel| (at(pixel.y) * width + at(pixel.x)) as u32)
        };
        Self {
            side_px,
            width,
            middles: (0..width * height).map(middle).collect(),
            of_voxel: places.iter().map(cell).collect(),
        }
    }

    fn foreground(&self, silhouette: &Silhouette) -> Vec<bool> {
        let is_shown =
            |middle: &Option<Point2<f64>>| middle.is_some_and(|m| silhouette.contains(&m));
        self.middles.iter().map(is_shown).collect()
    }
}

impl PersonCells<'_> {
    /// Who may be seen at an undistorted pixel: bit p for person p.
    pub(super) fn at(&self, pixel: &Point2<f64>) -> u32 {
        let recorded = self.camera.distort(pixel);
        let at = |pixel: f64| ((pixel + 0.5) / self.cells.side_px).floor() as isize;
        self.around(at(recorded.x), at(recorded.y))
    }

    /// Who may be seen in a cell: a voxel covers the cells around its middle's.
    fn around(&self, x: isize, y: isize) -> u32 {
        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j)));
        let is_in = |(x, y): &(isize, isize)| {
            (0..self.cells.width as isize).contains(x) && (0..self.height as isize).contains(y)
        };
        let near = around.filter(is_in);
        let bits = near.map(|(x, y)| self.bits[y as usize * self.cells.width + x as usize]);
        bits.fold(0, |all, bits| all | bits)
    }

    /// The share of what a mask shows of a person's voxels that it shows of nobody else's; 0 if it shows nothing of them.
    pub(super) fn own_share(&self, silhouette: &Silhouette, person: usize) -> f64 {
        let (mut own, mut all) = (0_usize, 0_usize);
        for (cell, middle) in self.cells.middles.iter().enumerate() {
            let is_theirs = self.bits[cell] & 1 << person != 0;
            if is_theirs && middle.is_some_and(|middle| silhouette.contains(&middle)) {
                let (x, y) = (cell % self.cells.width, cell / self.cells.width);
                all += 1;
                own += usize::from(self.around(x as isize, y as isize) == 1 << person);
            }
        }
        own as f64 / all.max(1) as f64
    }
}
