use super::*;
use crate::math::central_differences;
use nalgebra::DVector;

/// The lenses whose values OpenCV was asked for, and some stronger ones.
fn lenses() -> Vec<(&'static str, Distortion)> {
    let brown = |c: &[f64]| Distortion::brown_conrady(c).unwrap();
    vec![
        ("4", brown(&[-0.046183, 0.139983, 0.000608, 0.00069])),
        ("5", brown(&SEATED)),
        ("8", brown(&[0.31, -0.12, 0.0011, -0.0007, 0.02, 0.65, -0.05, 0.013])),
        ("fisheye", Distortion::fisheye(&[-0.013, 0.021, -0.017, 0.004]).unwrap()),
        ("pincushion", brown(&[0.4, 0.1, -0.002, 0.003])),
        (
            "vicon",
            Distortion::RadialCorrection {
                centre_x: 0.01,
                centre_y: -0.02,
                k1: 0.12,
                k2: -0.03,
                k3: 0.002,
            },
        ),
    ]
}

const SEATED: [f64; 5] = [
    -0.36491489942628114,
    0.1812198965472627,
    -6.701829328307362e-5,
    4.936832499178645e-5,
    -0.04933601187120767,
];

#[test]
fn distorted_points_are_those_of_opencv() {
    // from tests/oracles/opencv_distortion.py, OpenCV 5.0.0, for (0.3, −0.2), (−0.55, 0.41) and (0.1, 0.62)
    let points = [[0.3, -0.2], [-0.55, 0.41], [0.1, 0.62]];
    let expected = [
        [
            [0.29904951680999997, -0.19922750454000002],
            [-0.554629183138234, 0.4139790299394107],
            [0.10071732508268799, 0.6229999675126656],
        ],
        [
            [0.28667793280838677, -0.19112305566221868],
            [-0.47471129224578357, 0.3538614707213721],
            [0.08813613071799026, 0.5462968590589328],
        ],
        [
            [0.2870917190532255, -0.19131214603548374],
            [-0.47708652306229354, 0.35591840955552784],
            [0.08827616905268192, 0.5494577841266277],
        ],
        [
            [0.28755876044028506, -0.1917058402935234],
            [-0.48076898550725766, 0.3583914255599556],
            [0.08906832793651881, 0.5522236332064167],
        ],
    ];
    for ((name, lens), expected) in lenses().iter().zip(&expected) {
        for (point, expected) in points.iter().zip(expected) {
            let distorted = lens.distort(&Vector2::from(*point));
            let error = (distorted - Vector2::from(*expected)).norm();
            assert!(error < 1e-14, "{name}: {point:?} is {error:e} from OpenCV's");
        }
    }
}

#[test]
fn undistort_undoes_distort_over_the_whole_view() {
    for (name, lens) in lenses() {
        for (i, j) in (-20..=20).flat_map(|i| (-20..=20).map(move |j| (i, j))) {
            let point = Vector2::new(f64::from(i), f64::from(j)) * 0.035;
            let Some(distorted) = lens.distort_in_view(&point) else {
                // the seated cameras' lens folds outside its image, at a radius of about 1.2
                assert!(point.norm() > 0.9, "{name} folds at {point:?}");
                continue;
            };
            let back = lens.undistort(&distorted).unwrap();
            assert!((back - point).norm() < 1e-12, "{name}: {point:?} {back:?}");
        }
    }
}

#[test]
fn the_jacobian_of_newtons_iteration_is_that_of_central_differences() {
    for (name, lens) in lenses() {
        let Lens::BrownConrady(lens) = lens.lens() else {
            continue;
        };
        for point in [[0.4, -0.3], [1e-9, 0.0], [0.0, 0.0], [-0.1, 0.6]].map(Vector2::from) {
            let numeric = central_differences(2, 1e-3, |d| {
                let (value, _) = lens.distort(&(point + Vector2::new(d[0], d[1])));
                DVector::from_column_slice(value.as_slice())
            });
            let error = (numeric - lens.distort(&point).1).amax();
            assert!(error < 1e-9, "{name} at {point:?}: {error:e}");
        }
    }
}

#[test]
fn a_point_beyond_the_fold_is_not_in_view() {
    let barrel = Distortion::brown_conrady(&[-0.3, 0.0, 0.0, 0.0]).unwrap();
    // r − 0.3r³ rises until r = 1.054, and is back at the image of r = 0.5 at r = 1.53
    let far = Vector2::new(1.53, 0.0);
    assert!((barrel.distort(&far) - barrel.distort(&Vector2::new(0.5, 0.0))).norm() < 0.02);
    assert_eq!(barrel.distort_in_view(&far), None);
    assert!(barrel.distort_in_view(&Vector2::new(1.05, 0.0)).is_some());
    assert_eq!(barrel.undistort(&Vector2::new(0.8, 0.0)), None);
}

#[test]
fn a_fisheye_at_ninety_degrees_has_no_undistorted_pixel() {
    let fisheye = Distortion::fisheye(&[0.0; 4]).unwrap();
    assert_eq!(fisheye.undistort(&Vector2::new(1.6, 0.0)), None);
    let nearly = fisheye.undistort(&Vector2::new(1.5, 0.0)).unwrap();
    approx::assert_relative_eq!(nearly.x, 1.5_f64.tan(), epsilon = 1e-10);
}

#[test]
fn not_a_number_has_no_undistorted_point() {
    for (name, lens) in lenses() {
        let undistorted = lens.undistort(&Vector2::new(f64::NAN, 0.1));
        assert_eq!(undistorted, None, "{name}");
    }
}

#[test]
fn the_number_of_coefficients_is_one_of_opencvs() {
    let zeros_after_eight = [&[0.1; 8][..], &[0.0; 6]].concat();
    assert!(Distortion::brown_conrady(&zeros_after_eight).is_some());
    assert_eq!(Distortion::brown_conrady(&[0.1; 14]), None);
    assert_eq!(Distortion::brown_conrady(&[0.1; 3]), None);
    assert_eq!(Distortion::brown_conrady(&[0.0; 5]), Some(Distortion::None));
    assert_eq!(Distortion::brown_conrady(&[]), Some(Distortion::None));
    assert_eq!(Distortion::fisheye(&[0.1; 5]), None);
}
