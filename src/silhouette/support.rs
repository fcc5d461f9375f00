//! The other cameras' evidence along a line of sight.
//!
//! A pixel of one camera can only show the person if somewhere along its line of sight all other cameras show the
//! person too. Space is cut into voxels; each camera's evidence at a voxel's image is added up, and a pixel's support
//! is the best sum of the *others'* evidence along its line of sight. Support is negative where no other camera's
//! silhouette agrees (a passer-by outside the common volume, a reflection), and positive on a part of the person that one
//! camera cannot tell from the background.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::camera::{Camera, Rig};
use crate::image::{Plane, enlarge};

/// The cell of a voxel that a camera does not see.
const UNSEEN: u32 = u32::MAX;

/// Evidence of a camera that does not see a voxel, as a share of the most: people are recorded where the cameras look.
const OUT_OF_VIEW: f32 = -0.5;

/// Settings of a [`Support`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportOptions {
    /// Edge of a voxel, metres (default 0.03: half of a forearm).
    pub voxel: f64,
    /// Most voxels; in a larger volume they are made larger (default 1 200 000).
    pub most_voxels: usize,
    /// The most that the evidence of one camera counts, for or against (default 4).
    pub most_evidence: f32,
}

impl Default for SupportOptions {
    fn default() -> Self {
        Self { voxel: 0.03, most_voxels: 1_200_000, most_evidence: 4.0 }
    }
}

/// A box in the world, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Least x, y, z.
    pub low: Point3<f64>,
    /// Largest x, y, z.
    pub high: Point3<f64>,
}

/// Size of a picture that was shrunk from the recorded one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShrunkSize {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Recorded pixels along each side of one of its pixels.
    pub factor: usize,
}

/// The voxels, and where each camera sees them.
#[derive(Clone, Debug)]
pub struct Support {
    cameras: Vec<Cells>,
    options: SupportOptions,
}

/// One camera's picture in cells of about a voxel's size.
#[derive(Clone, Debug)]
struct Cells {
    picture: ShrunkSize,
    /// Pixels of the shrunk picture along each side of a cell.
    cell: usize,
    width: usize,
    height: usize,
    /// For each voxel the cell that shows its centre.
    cell_of_voxel: Vec<u32>,
}

impl Support {
    /// Projects the voxels of a volume into the shrunk pictures of all cameras.
    pub fn new(
        rig: &Rig,
        pictures: &[ShrunkSize],
        volume: &Volume,
        options: SupportOptions,
    ) -> Self {
        let size = (volume.high - volume.low).map(|length| length.max(options.voxel));
        let wanted = (size.x * size.y * size.z / options.most_voxels.max(1) as f64).cbrt();
        let voxel = options.voxel.max(wanted);
        let counts = size.map(|length| (length / voxel).ceil().max(1.0) as usize);
        let centres = (0..counts.x * counts.y * counts.z).map(|i| {
            let x = i / (counts.y * counts.z);
            let (y, z) = (i / counts.z % counts.y, i % counts.z);
            let steps = Vector3::new(x as f64, y as f64, z as f64).add_scalar(0.5);
            volume.low + steps * voxel
        });
        let centres: Vec<Point3<f64>> = centres.collect();

        let cameras = rig.cameras.par_iter().zip(pictures);
        let cells = cameras.map(|(camera, picture)| Cells::new(camera, *picture, &centres, voxel));
        Self { cameras: cells.collect(), options }
    }

    /// For each camera and pixel of its shrunk picture the best mean of the other cameras' evidence along the line of
    /// sight, from −1 (against) to 1 (for); −1 where the line of sight misses the volume.
    ///
    /// `None` for the evidence of a camera that has no picture, and then for its support.
    pub fn by_others(&self, evidence: &[Option<Plane<f32>>]) -> Vec<Option<Plane<f32>>> {
        let most = self.options.most_evidence;

        // the evidence of each camera, cell by cell
        let means = self.cameras.par_iter().zip(evidence);
        let means = means.map(|(cells, evidence)| Some(cells.means(evidence.as_ref()?, most)));
        let means: Vec<Option<Vec<f32>>> = means.collect();

        // that of all cameras, voxel by voxel
        let looking = self.cameras.iter().zip(&means);
        let looking = looking.filter_map(|(cells, means)| Some((cells, means.as_ref()?)));
        let looking: Vec<(&Cells, &Vec<f32>)> = looking.collect();
        let voxels = self.cameras.first();
        let voxels = voxels.map_or(0, |cells| cells.cell_of_voxel.len());
        let sums = (0..voxels).into_par_iter().map(|voxel| {
            let evidence = looking.iter().map(|(cells, means)| {
                let mean = means.get(cells.cell_of_voxel[voxel] as usize).copied();
                mean.unwrap_or(OUT_OF_VIEW * most)
            });
            evidence.sum()
        });
        let sums: Vec<f32> = sums.collect();

        // for each camera, without its own, the best along each line of sight
        let others = looking.len().saturating_sub(1).max(1) as f32;
        let supports = self.cameras.par_iter().zip(&means);
        let supports =
            supports.map(|(cells, means)| Some(cells.best(&sums, means.as_ref()?, most * others)));
        supports.collect()
    }
}

impl Cells {
    fn new(camera: &Camera, picture: ShrunkSize, centres: &[Point3<f64>], voxel: f64) -> Self {
        let cell = footprint(camera, centres, voxel) / (2 * picture.factor.max(1)) as f64;
        let cell = (cell.round() as usize).clamp(1, 64);
        let (width, height) = (picture.width.div_ceil(cell), picture.height.div_ceil(cell));

        let side = (cell * picture.factor.max(1)) as f64;
        let at = |x: f64, n: usize| (((x + 0.5) / side) as usize).min(n.saturating_sub(1));
        let cell_of_voxel = centres.iter().map(|centre| {
            let pixel = camera.project(centre);
            let pixel = pixel.filter(|pixel| camera.contains(pixel));
            pixel.map_or(UNSEEN, |pixel| (at(pixel.y, height) * width + at(pixel.x, width)) as u32)
        });

        Self { cell_of_voxel: cell_of_voxel.collect(), picture, cell, width, height }
    }

    /// Mean evidence of each cell, within ±`most`.
    fn means(&self, evidence: &Plane<f32>, most: f32) -> Vec<f32> {
        let mut sums = vec![(0.0_f32, 0.0_f32); self.width * self.height];
        for y in 0..evidence.height() {
            for (x, value) in evidence.row(y).iter().enumerate() {
                if let Some(sum) = sums.get_mut(y / self.cell * self.width + x / self.cell) {
                    *sum = (sum.0 + value, sum.1 + 1.0);
                }
            }
        }
        let mean = |(sum, count): (f32, f32)| (sum / count.max(1.0)).clamp(-most, most);
        sums.into_iter().map(mean).collect()
    }

    /// For every pixel the largest of the others' sums in its cell or one beside it, as a share of `full`.
    fn best(&self, sums: &[f32], own: &[f32], full: f32) -> Plane<f32> {
        let mut best = Plane::filled(self.width, self.height, -1.0_f32);
        let width = self.width.max(1);
        for (cell, sum) in self.cell_of_voxel.iter().zip(sums) {
            if let Some(own) = own.get(*cell as usize) {
                let (x, y) = (*cell as usize % width, *cell as usize / width);
                let value = &mut best.row_mut(y)[x];
                *value = value.max((sum - own) / full);
            }
        }
        let best = widened(&best);
        enlarge(&best, self.cell, self.picture.width, self.picture.height)
    }
}

/// Median length of a voxel's edge in recorded pixels, of some of the voxels.
fn footprint(camera: &Camera, centres: &[Point3<f64>], voxel: f64) -> f64 {
    let some = centres.iter().step_by((centres.len() / 1000).max(1));
    let mut lengths: Vec<f64> = some
        .filter(|centre| camera.project(centre).is_some_and(|p| camera.contains(&p)))
        .map(|centre| camera.intrinsics.fy_px * voxel / (camera.camera_from_world * centre).z)
        .collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied().unwrap_or(1.0)
}

/// The largest value of each cell and its eight neighbours.
fn widened(plane: &Plane<f32>) -> Plane<f32> {
    let mut wide = plane.clone();
    for y in 0..plane.height() {
        let rows = [y.saturating_sub(1), y, (y + 1).min(plane.height() - 1)].map(|y| plane.row(y));
        for (x, value) in wide.row_mut(y).iter_mut().enumerate() {
            let columns = x.saturating_sub(1)..(x + 2).min(plane.width());
            let around = rows.iter().flat_map(|row| &row[columns.clone()]);
            *value = around.fold(-1.0, |best, v| v.max(best));
        }
    }
    wide
}
