//! The points of one frame.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::math::Rigid3;

/// How far a measured point may lie from the true one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// The source does not say.
    Unknown,
    /// The same in all directions: a standard deviation, metres.
    Isotropic(f64),
    /// A covariance in the world frame, m²; positive definite.
    Full(Matrix3<f64>),
}

impl Spread {
    /// Standard deviation along a unit vector of the world, √(dᵀ Σ d), metres; `None` where it is not known.
    pub fn along(&self, direction_world: &Vector3<f64>) -> Option<f64> {
        match self {
            Self::Unknown => None,
            Self::Isotropic(sigma) => Some(*sigma),
            Self::Full(covariance) => {
                Some(direction_world.dot(&(covariance * direction_world)).sqrt())
            }
        }
    }

    /// Whether all numbers are finite and the spread is positive in every direction.
    fn is_usable(&self) -> bool {
        match self {
            Self::Unknown => true,
            Self::Isotropic(sigma) => sigma.is_finite() && *sigma > 0.0,
            Self::Full(covariance) => {
                covariance.iter().all(|v| v.is_finite()) && covariance.cholesky().is_some()
            }
        }
    }

    fn turned(self, by: &Matrix3<f64>) -> Self {
        match self {
            Self::Full(covariance) => Self::Full(by * covariance * by.transpose()),
            same => same,
        }
    }

    fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Unknown => Self::Unknown,
            Self::Isotropic(sigma) => Self::Isotropic(sigma * factor),
            Self::Full(covariance) => Self::Full(covariance * (factor * factor)),
        }
    }
}

/// A point measured on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudPoint {
    /// Where, metres.
    pub position_world: Point3<f64>,
    /// How far it may be from the true point.
    pub spread: Spread,
}

impl CloudPoint {
    /// Whether position and spread are finite and the spread is positive.
    fn is_usable(&self) -> bool {
        self.position_world.iter().all(|v| v.is_finite()) && self.spread.is_usable()
    }
}

/// How many points a source held beyond those that are used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Points with a number that is not finite, or a spread that is not positive.
    pub unusable: usize,
    /// Points left out because there were too many.
    pub thinned: usize,
}

/// The points of one frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cloud {
    /// The points, in the order of their source.
    pub points: Vec<CloudPoint>,
    /// How many points the source held besides.
    pub left_out: LeftOut,
}

impl Cloud {
    /// The usable points of a source; the others are counted.
    pub fn from_points(points: impl IntoIterator<Item = CloudPoint>) -> Self {
        let mut cloud = Self::default();
        for point in points {
            if point.is_usable() {
                cloud.points.push(point);
            } else {
                cloud.left_out.unusable += 1;
            }
        }
        cloud
    }

    /// The cloud with all lengths multiplied by `factor`: 0.001 turns millimetres into metres.
    pub fn scaled(mut self, factor: f64) -> Self {
        for point in &mut self.points {
            point.position_world *= factor;
            point.spread = point.spread.scaled(factor);
        }
        self
    }

    /// The cloud in another frame of reference.
    pub fn moved(mut self, world_from_cloud: &Rigid3) -> Self {
        let turn = world_from_cloud.rotation.to_rotation_matrix();
        for point in &mut self.points {
            point.position_world = world_from_cloud * point.position_world;
            point.spread = point.spread.turned(turn.matrix());
        }
        self
    }

    /// At most `most` points, chosen evenly: a point stands for its neighbours, and dense places stay denser than sparse ones.
    ///
    /// The points are put in Morton order, a line that fills space, and every n/`most`-th is kept. (A grid that keeps one
    /// point of each cell would keep every stray point and thin the surface alone.) The kept points stay in the order of
    /// their source, and the same points give the same choice.
    ///
    /// # Source
    /// Morton 1966, *A computer oriented geodetic data base*.
    pub fn thinned(mut self, most: usize) -> Self {
        let count = self.points.len();
        if count <= most {
            return self;
        }
        let (low, high) = self.bounds();
        let mut line: Vec<(u64, usize)> = self
            .points
            .iter()
            .enumerate()
            .map(|(i, point)| (morton(&point.position_world, &low, &high), i))
            .collect();
        line.sort_unstable();

        // the middle of each of `most` equal pieces of the line
        let middle = |k: usize| ((2 * k + 1) as u128 * count as u128 / (2 * most) as u128) as usize;
        let mut kept: Vec<usize> = (0..most).map(|k| line[middle(k)].1).collect();
        kept.sort_unstable();

        self.points = kept.into_iter().map(|i| self.points[i]).collect();
        self.left_out.thinned += count - most;
        self
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let mut places = self.points.iter().map(|point| point.position_world);
        let first = places.next().unwrap_or_default();
        places.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)))
    }
}

/// The cell of a point, 2²¹ along each axis, with the bits of the three axes interleaved.
fn morton(point: &Point3<f64>, low: &Point3<f64>, high: &Point3<f64>) -> u64 {
    let longest = (high - low).max();
    (0..3).fold(0, |code, axis| {
        // 0/0 where all points are one: NaN becomes cell 0
        let cell = (point[axis] - low[axis]) / longest * ((1u32 << 21) - 1) as f64;
        code | spread_bits(cell as u64) << axis
    })
}

/// Two zero bits after each of the lowest 21 bits.
fn spread_bits(cell: u64) -> u64 {
    let mut bits = cell & 0x001f_ffff;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn at(x: f64, y: f64, z: f64) -> CloudPoint {
        CloudPoint { position_world: Point3::new(x, y, z), spread: Spread::Unknown }
    }

    #[test]
    fn what_is_not_finite_or_has_no_positive_spread_is_counted_and_left_out() {
        let with = |spread| CloudPoint { spread, ..at(0.0, 1.0, 2.0) };
        let cloud = Cloud::from_points([
            at(0.0, f64::NAN, 0.0),
            at(f64::INFINITY, 0.0, 0.0),
            with(Spread::Isotropic(0.0)),
            with(Spread::Isotropic(-0.1)),
            with(Spread::Full(Matrix3::from_diagonal_element(-1.0))),
            with(Spread::Isotropic(0.01)),
            with(Spread::Full(Matrix3::identity())),
            at(1.0, 1.0, 1.0),
        ]);
        assert_eq!((cloud.points.len(), cloud.left_out.unusable), (3, 5));
    }

    #[test]
    fn millimetres_become_metres_with_their_spread() {
        let mut points = vec![at(1000.0, 0.0, -500.0); 2];
        points[0].spread = Spread::Isotropic(3.0);
        points[1].spread = Spread::Full(Matrix3::identity() * 9.0);
        let cloud = Cloud::from_points(points).scaled(0.001);
        approx::assert_relative_eq!(
            cloud.points[0].position_world,
            Point3::new(1.0, 0.0, -0.5),
            epsilon = 1e-15
        );
        for point in &cloud.points {
            let sigma = point.spread.along(&Vector3::y()).unwrap();
            approx::assert_relative_eq!(sigma, 0.003, epsilon = 1e-15);
        }
    }

    #[test]
    fn thinning_keeps_the_shares_of_dense_and_sparse_places_and_says_how_many_it_took() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut draw = |low: f64, high: f64| {
            at(
                rng.random_range(low..high),
                rng.random_range(low..high),
                rng.random_range(low..high),
            )
        };
        let mut points: Vec<CloudPoint> = (0..9000).map(|_| draw(0.0, 0.1)).collect();
        points.extend((0..1000).map(|_| draw(0.5, 2.0)));
        let cloud = Cloud::from_points(points.clone()).thinned(500);
        assert_eq!((cloud.points.len(), cloud.left_out.thinned), (500, 9500));
        let sparse = cloud.points.iter().filter(|p| p.position_world.x > 0.4);
        assert!((48..=52).contains(&sparse.count()));
        // each octant of the dense cube has its share of 450/8 = 56
        for octant in 0..8 {
            let is_in = |p: &&CloudPoint| {
                let p = p.position_world;
                (0..3).all(|k| p[k] < 0.1 && (p[k] > 0.05) == (octant >> k & 1 == 1))
            };
            let count = cloud.points.iter().filter(is_in).count();
            assert!((45..=68).contains(&count), "{octant}: {count}");
        }
        assert_eq!(cloud, Cloud::from_points(points).thinned(500));
    }

    #[test]
    fn points_in_one_place_and_few_points_are_thinned_without_fuss() {
        let cloud = Cloud::from_points(vec![at(1.0, 1.0, 1.0); 10]);
        assert_eq!(cloud.clone().thinned(3).points.len(), 3);
        assert_eq!(cloud.clone().thinned(10), cloud);
        assert_eq!(cloud.thinned(0).left_out.thinned, 10);
    }
}
