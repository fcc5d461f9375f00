//! How far two rigs are apart, whose worlds are not the same.

use maquette::camera::Rig;
use maquette::pipeline::PlaceSd;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// How far the cameras of a rig are from the truth after the best similarity.
pub(crate) struct Apart {
    /// By camera.
    pub(crate) turns_deg: Vec<f64>,
    /// By camera, in the truth's metres.
    pub(crate) places_m: Vec<f64>,
    /// How many times as large the rig is as the truth.
    pub(crate) scale: f64,
    sds: Vec<PlaceSd>,
}

impl Apart {
    /// After the similarity that brings the centres together (Umeyama 1991).
    pub(crate) fn new(found: &Rig, truth: &Rig, sds: &[PlaceSd]) -> Option<Self> {
        let centres = |rig: &Rig| -> Vec<Vector3<f64>> {
            rig.cameras.iter().map(|camera| camera.centre_world().coords).collect()
        };
        let (from, to) = (centres(found), centres(truth));
        let middle =
            |all: &[Vector3<f64>]| all.iter().sum::<Vector3<f64>>() / all.len().max(1) as f64;
        let (from_middle, to_middle) = (middle(&from), middle(&to));
        let pairs = from.iter().zip(&to);
        let products = pairs.map(|(a, b)| (b - to_middle) * (a - from_middle).transpose());
        let product: Matrix3<f64> = products.sum();
        let svd = product.svd(true, true);
        let (u, v_t) = (svd.u?, svd.v_t?);
        let mut signs = Matrix3::identity();
        signs[(2, 2)] = (u * v_t).determinant().signum();
        let turn = Rotation3::from_matrix_unchecked(u * signs * v_t);
        let square: f64 = from.iter().map(|a| (a - from_middle).norm_squared()).sum();
        let shrink = (Matrix3::from_diagonal(&svd.singular_values) * signs).trace() / square;

        let place = |(a, b): (&Vector3<f64>, &Vector3<f64>)| {
            (turn * (a - from_middle) * shrink + to_middle - b).norm()
        };
        let turned = |(a, b): (&maquette::camera::Camera, &maquette::camera::Camera)| {
            let own = a.camera_from_world.rotation * nalgebra::UnitQuaternion::from(turn).inverse();
            own.angle_to(&b.camera_from_world.rotation).to_degrees()
        };
        Some(Self {
            turns_deg: found.cameras.iter().zip(&truth.cameras).map(turned).collect(),
            places_m: from.iter().zip(&to).map(place).collect(),
            scale: 1.0 / shrink,
            sds: sds.to_vec(),
        })
    }

    /// Turns over their standard deviations.
    pub(crate) fn turns_z(&self) -> Vec<f64> {
        self.turns_deg.iter().zip(&self.sds).map(|(off, sd)| off / sd.turn_deg).collect()
    }

    /// Displacements over their standard deviations.
    pub(crate) fn places_z(&self) -> Vec<f64> {
        self.places_m.iter().zip(&self.sds).map(|(off, sd)| off / sd.place_m).collect()
    }
}
