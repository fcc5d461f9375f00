//! What is put wrong in the samples, and the line that must say so.

/// Text of the sample, what replaces it, and the message.
pub(crate) type Fault = (&'static str, &'static str, &'static str);

/// Faults of [`POSE2SIM`](crate::calibration_samples::POSE2SIM) as `a.toml`.
pub(crate) const TOML: &[Fault] = &[
    (
        "size = [ 800.0, 600.0]",
        "size = [ 800.0, 600.0",
        "a.toml:4: expected TOML, found missing comma between array elements, expected `,`",
    ),
    ("matrix = [", "matix = [", "a.toml:1: camera cam1: matrix is missing"),
    ("rotation", "Rotation", "a.toml:1: camera cam1: rotation is missing"),
    ("distortions", "distorsions", "a.toml:1: camera cam1: distortions is missing"),
    (
        "size",
        "Size",
        "a.toml:1: camera cam1: the file does not state the image size, and this camera has no masks, images or video to take it from",
    ),
    (
        "-0.0007, 0.01]",
        "-0.0007, 0.01, 1.0]",
        "a.toml:5: camera cam1: distortions: expected 0, 4, 5 or 8 numbers, found 6",
    ),
    ("[ 0.0, 0.0, 1.0]]", "]", "a.toml:4: camera cam1: matrix: expected 9 numbers, found 6"),
    (
        "0.8320765978759244, ",
        "",
        "a.toml:6: camera cam1: rotation: expected 3 or 9 numbers, found 2",
    ),
    (
        "1.5547493448357081",
        "\"north\"",
        "a.toml:6: camera cam1: rotation: expected a number, found \"north\"",
    ),
    (
        "1.5547493448357081",
        "nan",
        "a.toml:6: camera cam1: rotation: expected a finite number, found NaN",
    ),
    (
        "0.9905211130872971",
        "inf",
        "a.toml:7: camera cam1: translation: expected a finite number, found inf",
    ),
    ("1000.0", "0.0", "a.toml:4: camera cam1: focal length 0 px is not positive"),
    ("1010.0", "-1010.0", "a.toml:4: camera cam1: focal length -1010 px is not positive"),
    (
        "[ 0.0, 0.0, 1.0]",
        "[ 0.0, 0.0, 2.0]",
        "a.toml:4: camera cam1: matrix: expected 0 below the diagonal and 1 in the corner, found 2",
    ),
    (
        "800.0",
        "0.0",
        "a.toml:3: camera cam1: image size 0 × 600 is not between 1 × 1 and 65535 × 65535",
    ),
    ("800.0, 600.0", "800.0", "a.toml:3: camera cam1: size: expected 2 numbers, found 1"),
    (
        "name = \"cam2\"",
        "name = \"cam1\"",
        "a.toml:10: camera cam1: another camera has the same name",
    ),
    (
        "1.5547493448357081, 0.8320765978759244, -0.7246509717556328",
        "[1, 0, 0], [0, 1, 0], [0, 0, 1.5]",
        "a.toml:6: camera cam1: rotation is not a rotation: |RᵀR − I| = 1.2e0",
    ),
    (
        "1.5547493448357081, 0.8320765978759244, -0.7246509717556328",
        "[1, 0, 0], [0, 1, 0], [0, 0, -1]",
        "a.toml:6: camera cam1: rotation is a reflection, not a rotation: its determinant is −1",
    ),
];

/// Faults of the Qualisys sample as `a.qca.txt`.
pub(crate) const QUALISYS: &[Fault] = &[
    (
        "<cameras>",
        "<camras>",
        "a.qca.txt:17: expected XML, found expected 'camras' tag, not 'cameras' at 17:3",
    ),
    ("focalLengthU=\"62720.0\"", "", "a.qca.txt:8: camera cam2: focalLengthU is missing"),
    (
        "focalLengthU=\"62720.0\"",
        "focalLengthU=\"-64\"",
        "a.qca.txt:8: camera cam2: focal length -1 px is not positive",
    ),
    (
        "r33=\"0.08406930166863567\"",
        "r33=\"0.5\"",
        "a.qca.txt:7: camera cam2: r11 … r33 is not a rotation: |RᵀR − I| = 6.3e-1",
    ),
    (
        "x=\"-1000.0\"",
        "x=\"west\"",
        "a.qca.txt:7: camera cam2: x: expected a number, found \"west\"",
    ),
    (
        "<fov_video bottom=\"609\"",
        "<fov bottom=\"609\"",
        "a.qca.txt:5: camera cam2: <fov_video> is missing",
    ),
    (
        "radialDistortion1=\"-0.05\"",
        "radialDistortion1=\"NaN\"",
        "a.qca.txt:8: camera cam2: radialDistortion1: expected a finite number, found NaN",
    ),
];

/// Faults of the Vicon sample as `a.xcp`.
pub(crate) const VICON: &[Fault] = &[
    (
        "0.09053366717100488\"",
        "0.9\"",
        "a.xcp:5: camera cam2: ORIENTATION is not a rotation: |RᵀR − I| = 3.4e-1",
    ),
    (
        "PRINCIPAL_POINT=\"495 405.5\"",
        "PRINCIPAL_POINT=\"495\"",
        "a.xcp:5: camera cam2: PRINCIPAL_POINT: expected 2 numbers, found 1",
    ),
    ("VICON_RADIAL=\"0 0\" WORLD", "WORLD", "a.xcp:5: camera cam2: VICON_RADIAL is missing"),
    (
        "SENSOR_SIZE=\"1000 800\"",
        "",
        "a.xcp:3: camera cam2: the file does not state the image size, and this camera has no masks, images or video to take it from",
    ),
    (
        "</KeyFrames>",
        "<KeyFrame/></KeyFrames>",
        "a.xcp:3: camera cam2: expected a fixed camera, found 2 key frames",
    ),
    (
        "PIXEL_ASPECT_RATIO=\"0.98989898989898990\"",
        "PIXEL_ASPECT_RATIO=\"0\"",
        "a.xcp:5: camera cam2: FOCAL_LENGTH: expected a finite number, found inf",
    ),
];

/// Faults of the projection matrices as `a.txt`.
pub(crate) const MATRICES: &[Fault] = &[
    (
        "800 600",
        "",
        "a.txt:4: camera cam1: the file does not state the image size, and this camera has no masks, images or video to take it from",
    ),
    (
        " 1520.4097422070517",
        "",
        "a.txt:5: camera cam1: projection matrix row: expected 4 numbers, found 3",
    ),
    (
        "1520.4097422070517",
        "I520",
        "a.txt:5: projection matrix row: expected a number, found \"I520\"",
    ),
    (
        "1520.4097422070517",
        "NaN",
        "a.txt:4: camera cam1: projection matrix: expected a finite number, found NaN",
    ),
    (
        "-0.8241633836921342 0.5494422557947561 -0.13736056394868904 3.7774155085889483\n",
        "",
        "a.txt:4: camera cam1: projection matrix: expected 12 numbers, found 8",
    ),
    (
        "-0.8241633836921342 0.5494422557947561 -0.13736056394868904",
        "0 0 0",
        "a.txt:4: camera cam1: the projection matrix is singular: its left 3 × 3 block has no inverse",
    ),
    ("cam2:", "cam1", "a.txt:9: camera cam1: another camera has the same name"),
];
