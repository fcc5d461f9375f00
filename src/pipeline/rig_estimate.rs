//! Where the cameras of one rig are, from several recordings of it.
//!
//! c holds the turn, the displacement and the focal length ζ of every camera against its calibration, seven numbers each. Recording r ended at ĉ_r with the
//! covariance Σ_r ([`CameraCovariances::poses`](super::CameraCovariances::poses)), both of data and prior together:
//!
//! E_r(c) + ρ(c),  E_r the data's part with body, motions and clocks left free, ρ = Σ ½(1 + 6) ln(1 + z²) − ln p(ζ) the priors of a
//! camera ([`camera_prior`](crate::inference::camera_prior), [`lens_prior`]), z² = ‖ω‖²/σ_ω² + ‖t‖²/σ_t².
//!
//! The prior belongs to the rig and not to a recording: it is to be counted once. Its Gauss–Newton matrix at c is W(c), diagonal, with
//! 7/(1 + z²)/σ² of each component, the weight of p at ζ, and its gradient W(c)c. So the data's own matrix is L_r = Σ_r⁻¹ − W(ĉ_r), and because ĉ_r is an
//! optimum, their gradient there is −W(ĉ_r)ĉ_r:
//!
//! ∇E_r(c) = L_r(c − ĉ_r) − W(ĉ_r)ĉ_r.
//!
//! The sum over recordings and the prior once is 0 where
//!
//! (Σ L_r + W(c)) c = Σ (L_r + W(ĉ_r)) ĉ_r,
//!
//! which is solved by turns with W(c), from the mean of all ĉ_r on. One recording gives ĉ_r back. The covariance is (Σ L_r + W(c))⁻¹. A camera that was held
//! in a recording is told nothing of by it. Where rounding makes L_r indefinite, its negative eigenvalues are taken for 0.
//!
//! # What the motion determines
//! Of a camera's seven numbers the data determine tr(1 − (Σ L_r + W₀)⁻¹W₀) over its block, W₀ with 1/σ² of each component: 0 where
//! the usual errors of a calibration say all, 7 where they say nothing. W(c) would not do: Student's prior holds a camera that is
//! found at its calibration by seven times as much, as if less had been seen of it.
//!
//! # Whether recordings agree
//! If nothing was touched between them, ĉ_r − c has about the covariance Σ_r − Σ, c being made of ĉ_r too.
//!
//! # Source
//! What is determined: Rodgers 2000, *Inverse methods for atmospheric sounding*, §2.4; the difference: Hausman 1978, *Specification tests
//! in econometrics*.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::camera_covariance::POSE;
use crate::inference::camera_offset::ZOOM;
use crate::inference::camera_prior::{DISPLACEMENT_SD_M, TURN_SD};
use crate::inference::lens_prior::{self, ZOOM_SD};

/// What a recording says of the cameras whose poses it estimated.
#[derive(Debug, Clone, PartialEq)]
pub struct RigEvidence {
    /// Which cameras, by their position in the rig.
    pub cameras: Vec<usize>,
    /// ĉ_r: turns (rad), displacements (m) and ζ, seven numbers each.
    pub found: DVector<f64>,
    /// Σ_r.
    pub covariance: DMatrix<f64>,
}

/// Where the cameras of a rig are.
#[derive(Debug, Clone, PartialEq)]
pub struct RigEstimate {
    /// c: turns (rad), displacements (m) and ζ of all cameras of the rig, 0 of those that no recording estimated.
    pub found: DVector<f64>,
    /// Σ.
    pub covariance: DMatrix<f64>,
    /// How many of the seven numbers of each camera the data determine.
    pub determined: Vec<f64>,
    /// Pairs of a recording and a camera of which that recording says something else than all together.
    pub disagreeing: Vec<(usize, usize)>,
}

/// A covariance that has no inverse: nothing is known of its recording, by its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Singular(
    /// The recording.
    pub usize,
);

/// Steps at most; a camera's weight changes by a thousandth of what it did after ten.
const MOST_STEPS: usize = 200;
/// Below this change, in radians and metres, nothing changes any more.
const STILL: f64 = 1e-12;
/// What differs by so many standard deviations differs, as for a camera that was touched.
const SURE: f64 = 3.0;

/// Where the cameras of a rig are, from what recordings say of it.
///
/// # Errors
/// [`Singular`] for the first covariance that has no inverse.
pub fn rig_estimate(cameras: usize, recordings: &[RigEvidence]) -> Result<RigEstimate, Singular> {
    let n = POSE * cameras;
    let (mut data, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for (r, recording) in recordings.iter().enumerate() {
        add(recording, &mut data, &mut right).ok_or(Singular(r))?;
    }

    // c and the prior's weights at it, by turns
    let mut found = mean_found(cameras, recordings);
    for _ in 0..MOST_STEPS {
        let next = solve(&data, &prior(&found), &right).ok_or(Singular(0))?;
        let change = (&next - &found).amax();
        found = next;
        if change < STILL {
            break;
        }
    }

    let covariance = inverse(&data, &prior(&found)).ok_or(Singular(0))?;
    let usual = usual(n);
    let by_usual = inverse(&data, &usual).ok_or(Singular(0))?;
    let determined = |camera: usize| {
        let own = POSE * camera..POSE * (camera + 1);
        own.map(|k| 1.0 - by_usual[(k, k)] * usual[k]).sum()
    };
    let determined = (0..cameras).map(determined).collect();
    let disagreeing = disagreeing(recordings, &found, &covariance);
    Ok(RigEstimate { determined, disagreeing, found, covariance })
}

/// The mean of what the recordings found of each camera, 0 of those that none estimated.
fn mean_found(cameras: usize, recordings: &[RigEvidence]) -> DVector<f64> {
    let (mut sum, mut count) = (DVector::zeros(POSE * cameras), vec![0.0; cameras]);
    for recording in recordings {
        for (i, camera) in recording.cameras.iter().enumerate() {
            let mut own = sum.rows_mut(POSE * camera, POSE);
            own += recording.found.rows(POSE * i, POSE);
            count[*camera] += 1.0;
        }
    }
    DVector::from_fn(sum.len(), |k, _| sum[k] / f64::max(count[k / POSE], 1.0))
}

/// Adds L_r and (L_r + W)ĉ_r; `None` where Σ_r has no inverse.
fn add(recording: &RigEvidence, data: &mut DMatrix<f64>, right: &mut DVector<f64>) -> Option<()> {
    let weights = prior(&recording.found);
    let mut own = recording.covariance.clone().cholesky()?.inverse();
    own -= DMatrix::from_diagonal(&weights);
    let mut eigen = SymmetricEigen::new(own);
    eigen.eigenvalues.apply(|value| *value = value.max(0.0));
    let own = eigen.recompose();

    let told = &own * &recording.found + weights.component_mul(&recording.found);
    let place = |i: usize| POSE * recording.cameras[i / POSE] + i % POSE;
    for i in 0..told.len() {
        right[place(i)] += told[i];
        for j in 0..told.len() {
            data[(place(i), place(j))] += own[(i, j)];
        }
    }
    Some(())
}

/// The diagonal of W₀, of so many components.
fn usual(n: usize) -> DVector<f64> {
    let sd = |k: usize| match k % POSE {
        0..3 => TURN_SD,
        ZOOM => ZOOM_SD,
        _ => DISPLACEMENT_SD_M,
    };
    DVector::from_fn(n, |k, _| sd(k).powi(-2))
}

/// The diagonal of W(c).
fn prior(found: &DVector<f64>) -> DVector<f64> {
    let mut weights = DVector::zeros(found.len());
    for first in (0..found.len()).step_by(POSE) {
        let (turn, place) = (found.rows(first, 3), found.rows(first + 3, 3));
        let square = turn.norm_squared() / TURN_SD.powi(2)
            + place.norm_squared() / DISPLACEMENT_SD_M.powi(2);
        let weight = (1.0 + ZOOM as f64) / (1.0 + square);
        weights.rows_mut(first, 3).fill(weight / TURN_SD.powi(2));
        weights.rows_mut(first + 3, 3).fill(weight / DISPLACEMENT_SD_M.powi(2));
        weights[first + ZOOM] = lens_prior::weight(found[first + ZOOM]);
    }
    weights
}

fn solve(
    data: &DMatrix<f64>,
    weights: &DVector<f64>,
    right: &DVector<f64>,
) -> Option<DVector<f64>> {
    let all = data + DMatrix::from_diagonal(weights);
    Some(all.cholesky()?.solve(right))
}

fn inverse(data: &DMatrix<f64>, weights: &DVector<f64>) -> Option<DMatrix<f64>> {
    let all = data + DMatrix::from_diagonal(weights);
    Some(all.cholesky()?.inverse())
}

/// Cameras of which a recording says surely something else, by more than a usual calibration is off.
fn disagreeing(
    recordings: &[RigEvidence],
    found: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Vec<(usize, usize)> {
    let differs = |recording: &RigEvidence, i: usize| {
        let camera = recording.cameras[i];
        let (own, all) = (POSE * i, POSE * camera);
        let difference = recording.found.rows(own, POSE) - found.rows(all, POSE);
        let is_sure = |k: &usize| {
            let of_own = recording.covariance[(own + k, own + k)];
            let variance = of_own - covariance[(all + k, all + k)];
            difference[*k].abs() > SURE * variance.max(0.0).sqrt()
        };
        let sure = |rows: std::ops::Range<usize>| rows.into_iter().any(|k| is_sure(&k));
        let (turn, place) = (difference.rows(0, 3).norm(), difference.rows(3, 3).norm());
        let is_zoomed = difference[ZOOM].abs() > ZOOM_SD && is_sure(&ZOOM);
        turn > TURN_SD && sure(0..3) || place > DISPLACEMENT_SD_M && sure(3..6) || is_zoomed
    };
    let of_recording = |(r, recording): (usize, &RigEvidence)| {
        let which = (0..recording.cameras.len()).filter(|i| differs(recording, *i));
        which.map(|i| (r, recording.cameras[i])).collect::<Vec<_>>()
    };
    recordings.iter().enumerate().flat_map(of_recording).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Data that see combinations of the numbers of `cameras`, and the posterior's optimum and covariance with the prior.
    struct Seen {
        /// L.
        data: DMatrix<f64>,
        /// What the data alone say.
        said: DVector<f64>,
    }

    impl Seen {
        fn new(seed: u64, cameras: usize, truth: &DVector<f64>) -> Self {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let n = POSE * cameras;
            // each row looks at turns in hundredths of a degree, places in millimetres and focal lengths in thousandths
            let unit = |k: usize| if k % POSE < 3 { 2e-4 } else { 1e-3 };
            let rows = DMatrix::from_fn(2 * n, n, |_, k| rng.random_range(-1.0..1.0) / unit(k));
            Self { data: rows.transpose() * rows, said: truth.clone() }
        }

        /// The optimum and its covariance, by a thousand damped steps of the same equation for one recording.
        fn evidence(&self, cameras: &[usize]) -> RigEvidence {
            let mut found = self.said.clone();
            for _ in 0..1000 {
                found = solve(&self.data, &prior(&found), &(&self.data * &self.said)).unwrap();
            }
            let covariance = inverse(&self.data, &prior(&found)).unwrap();
            RigEvidence { cameras: cameras.to_vec(), found, covariance }
        }
    }

    fn truth(cameras: usize) -> DVector<f64> {
        let touched = [0.017, 0.0, 0.002, 0.0, 0.02, -0.004, 0.01];
        let values = [touched, [1e-4, 0.0, 0.0, 0.0, 1e-3, 0.0, -1e-3]].concat();
        DVector::from_iterator(POSE * cameras, values.into_iter().cycle().take(POSE * cameras))
    }

    #[test]
    fn one_recording_gives_back_what_it_said() {
        let evidence = Seen::new(1, 3, &truth(3)).evidence(&[0, 1, 2]);
        let estimate = rig_estimate(3, std::slice::from_ref(&evidence)).unwrap();
        approx::assert_relative_eq!(estimate.found, evidence.found, epsilon = 1e-9);
        approx::assert_relative_eq!(estimate.covariance, evidence.covariance, epsilon = 1e-12);
        assert!(estimate.disagreeing.is_empty());
        assert!(estimate.determined.iter().all(|d| (3.0..=7.0).contains(d)), "{estimate:?}");
    }

    #[test]
    fn several_recordings_are_one_recording_of_all_their_data() {
        let (a, b) = (Seen::new(2, 2, &truth(2)), Seen::new(3, 2, &truth(2)));
        let all = Seen { data: &a.data + &b.data, said: truth(2) }.evidence(&[0, 1]);
        let estimate = rig_estimate(2, &[a.evidence(&[0, 1]), b.evidence(&[0, 1])]).unwrap();
        // the same optimum, which a prior that counts twice would not give
        approx::assert_relative_eq!(estimate.found, all.found, epsilon = 1e-7);
        approx::assert_relative_eq!(
            estimate.covariance,
            all.covariance,
            max_relative = 1e-4,
            epsilon = 1e-10
        );
        let own = b.evidence(&[0, 1]).covariance;
        assert!((0..2 * POSE).all(|k| estimate.covariance[(k, k)] < own[(k, k)]));
    }

    #[test]
    fn a_camera_of_which_nothing_is_said_stays_and_one_that_nothing_shows_is_not_determined() {
        let seen = Seen::new(4, 2, &truth(2));
        let estimate = rig_estimate(3, &[seen.evidence(&[2, 0])]).unwrap();
        assert!(estimate.found.rows(POSE, POSE).amax() <= 0.0);
        assert!(estimate.determined[1].abs() < 1e-9, "{estimate:?}");
        approx::assert_relative_eq!(
            estimate.found[2 * POSE],
            seen.evidence(&[2, 0]).found[0],
            epsilon = 1e-9
        );

        let nothing =
            Seen { data: DMatrix::zeros(POSE, POSE), said: DVector::zeros(POSE) }.evidence(&[0]);
        let estimate = rig_estimate(1, &[nothing]).unwrap();
        assert!(estimate.determined[0].abs() < 1e-6, "{estimate:?}");
    }

    #[test]
    fn a_camera_that_was_touched_between_two_recordings_is_named() {
        let before = Seen::new(5, 2, &truth(2)).evidence(&[0, 1]);
        let mut moved = truth(2);
        moved[POSE + 4] += 0.03;
        let after = Seen::new(6, 2, &moved).evidence(&[0, 1]);
        let estimate = rig_estimate(2, &[before.clone(), after]).unwrap();
        assert!(estimate.disagreeing.contains(&(0, 1)), "{:?}", estimate.disagreeing);
        assert!(
            !estimate.disagreeing.iter().any(|(_, camera)| *camera == 0),
            "{:?}",
            estimate.disagreeing
        );
        let same = rig_estimate(2, &[before.clone(), before]).unwrap();
        assert!(same.disagreeing.is_empty());
    }

    #[test]
    fn a_covariance_without_inverse_is_named() {
        let mut evidence = Seen::new(7, 1, &truth(1)).evidence(&[0]);
        let right = evidence.clone();
        evidence.covariance.fill(0.0);
        assert_eq!(rig_estimate(1, &[right, evidence]), Err(Singular(1)));
    }
}
