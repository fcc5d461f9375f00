//! The same two cameras in every format, literally, and what they are.

use maquette::camera::{Camera, Distortion, Intrinsics, Rig};
use maquette::io::calibration::{CalibrationError, CalibrationOptions, read};
use maquette::math::Rigid3;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// k₁ k₂ p₁ p₂ k₃ of both cameras, in the formats that know distortion.
pub(crate) const LENS: [f64; 5] = [-0.05, 0.14, 0.0006, -0.0007, 0.01];

/// The two cameras, written down independently of the files.
pub(crate) fn expected(lens: Distortion) -> Rig {
    let camera = |name: &str, k: [f64; 4], rotation: [f64; 3], translation: [f64; 3]| Camera {
        name: name.into(),
        width_px: 800,
        height_px: 600,
        intrinsics: Intrinsics { fx_px: k[0], fy_px: k[1], cx_px: k[2], cy_px: k[3], skew_px: 0.0 },
        distortion: lens,
        camera_from_world: Rigid3::from_parts(
            Translation3::from(Vector3::from(translation)),
            UnitQuaternion::from_scaled_axis(Vector3::from(rotation)),
        ),
    };
    Rig {
        cameras: vec![
            camera(
                "cam1",
                [1000.0, 1010.0, 402.5, 297.25],
                [1.5547493448357081, 0.8320765978759244, -0.7246509717556328],
                [0.0, 0.9905211130872971, 3.7774155085889483],
            ),
            camera(
                "cam2",
                [980.0, 990.0, 395.0, 305.5],
                [0.29277017652890674, -2.1687599452152937, 1.9934909482252179],
                [0.09642053928037919, 0.8990430711623794, 4.212472508610567],
            ),
        ],
    }
}

pub(crate) fn lens() -> Distortion {
    Distortion::brown_conrady(&LENS).expect("five coefficients")
}

/// A folder with these files.
pub(crate) fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file in it");
    }
    folder
}

/// Reads a text as if it stood in a file of this name.
pub(crate) fn read_text(
    name: &str,
    text: &str,
    options: &CalibrationOptions,
) -> Result<Rig, CalibrationError> {
    let folder = folder(&[(name, text)]);
    read(&folder.path().join(name), options)
}

/// Options that state the size of both images.
pub(crate) fn with_sizes() -> CalibrationOptions {
    let sizes = ["cam1", "cam2"].map(|name| (name.to_owned(), [800, 600]));
    CalibrationOptions { image_sizes_px: sizes.into(), ..CalibrationOptions::default() }
}

/// The largest differences that printing and converting may leave.
pub(crate) fn assert_same(read: &Rig, expected: &Rig) {
    assert_eq!(read.names().collect::<Vec<_>>(), expected.names().collect::<Vec<_>>());
    for (a, b) in read.cameras.iter().zip(&expected.cameras) {
        assert_eq!((a.width_px, a.height_px), (b.width_px, b.height_px), "{}", a.name);
        let matrices = (a.intrinsics.matrix() - b.intrinsics.matrix()).amax();
        assert!(matrices < 1e-8, "{}: K differs by {matrices:e}", a.name);
        let turn = a.camera_from_world.rotation.angle_to(&b.camera_from_world.rotation);
        assert!(turn < 1e-8, "{}: turned by {turn:e}", a.name);
        let shift = (a.centre_world() - b.centre_world()).norm();
        assert!(shift < 1e-8, "{}: moved by {shift:e} m", a.name);
        let point = nalgebra::Vector2::new(0.31, -0.22);
        let lens = (a.distortion.distort(&point) - b.distortion.distort(&point)).norm();
        assert!(lens < 1e-12, "{}: lens differs by {lens:e}", a.name);
    }
}

/// Where the shared data sets are, if they are.
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let root = std::env::var("MAQUETTE_SHARED").unwrap_or_else(|_| default.into());
    let path = PathBuf::from(root).join("data").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not here", path.display());
    None
}

pub(crate) const POSE2SIM: &str = r#"[cam_01]
name = "cam1"
size = [ 800.0, 600.0]
matrix = [ [ 1000.0, 0.0, 402.5], [ 0.0, 1010.0, 297.25], [ 0.0, 0.0, 1.0]]
distortions = [ -0.05, 0.14, 0.0006, -0.0007, 0.01]
rotation = [ 1.5547493448357081, 0.8320765978759244, -0.7246509717556328]
translation = [ 0.0, 0.9905211130872971, 3.7774155085889483]
fisheye = false

[cam_02]
name = "cam2"
size = [ 800.0, 600.0]
matrix = [ [ 980.0, 0.0, 395.0], [ 0.0, 990.0, 305.5], [ 0.0, 0.0, 1.0]]
distortions = [ -0.05, 0.14, 0.0006, -0.0007, 0.01]
rotation = [ 0.29277017652890674, -2.1687599452152937, 1.9934909482252179]
translation = [ 0.09642053928037919, 0.8990430711623794, 4.212472508610567]
fisheye = false

[metadata]
adjusted = false
error = 0.0
"#;

/// Nested, without names, keys out of order, one camera ignored and one not posed.
pub(crate) const CALISCOPE: &str = r#"CreationDate = 2024-01-31T15:36:32
[cameras.cam10]
cam_id = 10
ignore = true
size = [1280, 720]
matrix = [[663.0, 0.0, 656.3], [0.0, 673.4, 342.1], [0.0, 0.0, 1.0]]
distortions = [0.2, -0.3, -0.004, -0.004, 0.15]
translation = [0.05, 0.002, 0.8]
rotation = [1.6, -0.3, 0.3]

[cameras.cam2]
cam_id =2
rotation_count = 0
error = 0.453
grid_count = 41
ignore = false
size = [800, 600]
matrix = [[980, 0, 395], [0.0, 990.0, 305.5], [0.0, 0.0, 1.0]]
distortions = [-0.05, 0.14, 0.0006, -0.0007, 0.01,]
translation = [0.09642053928037919, 0.8990430711623794, 4.212472508610567]
rotation = [0.29277017652890674, -2.1687599452152937, 1.9934909482252179]

[cameras.cam1]
cam_id = 1
exposure = "null"
size = [800, 600]
matrix = [[1000.0, 0.0, 402.5], [0.0, 1010.0, 297.25], [0.0, 0.0, 1.0]]
distortions = [-0.05, 0.14, 0.0006, -0.0007, 0.01]
translation = [0.0, 0.9905211130872971, 3.7774155085889483]
rotation = [1.5547493448357081, 0.8320765978759244, -0.7246509717556328]

[cameras.cam3]
cam_id = 3
size = [1280, 720]
matrix = [[663.0, 0.0, 656.3], [0.0, 673.4, 342.1], [0.0, 0.0, 1.0]]
distortions = [0.2, -0.3, -0.004, -0.004, 0.15]
translation = "null"
rotation = "null"

[charuco]
columns = 4
"#;

/// Millimetres, trailing commas as `toml.dump` writes them.
pub(crate) const FREEMOCAP: &str = r#"[cam_0]
name = "cam1"
size = [ 800, 600,]
matrix = [ [ 1000.0, 0.0, 402.5,], [ 0.0, 1010.0, 297.25,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.05, 0.14, 0.0006, -0.0007, 0.01,]
rotation = [ 1.5547493448357081, 0.8320765978759244, -0.7246509717556328,]
translation = [ 0.0, 990.5211130872971, 3777.4155085889483,]

[cam_1]
name = "cam2"
size = [ 800, 600,]
matrix = [ [ 980.0, 0.0, 395.0,], [ 0.0, 990.0, 305.5,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.05, 0.14, 0.0006, -0.0007, 0.01,]
rotation = [ 0.29277017652890674, -2.1687599452152937, 1.9934909482252179,]
translation = [ 96.42053928037919, 899.0430711623793, 4212.472508610567,]

[metadata]
charuco_square_size = 58.0
charuco_board_object = "<freemocap.charuco object>"
path_to_recorded_videos = "/recordings/calibration"
date_time_calibrated = "2023-06-29T17:13:41"
"#;

/// CRLF line ends, as EasyMocap writes them.
pub(crate) const INTRI: &str = "%YAML:1.0\r\n---\r\nnames:\r\n  - \"cam1\"\r\n  - \"cam2\"\r\n\
K_cam1: !!opencv-matrix\r\n  rows: 3\r\n  cols: 3\r\n  dt: d\r\n  data: [1000.000000, 0.000000, 402.500000, 0.000000, 1010.000000, 297.250000, 0.000000, 0.000000, 1.000000]\r\n\
dist_cam1: !!opencv-matrix\r\n  rows: 1\r\n  cols: 5\r\n  dt: d\r\n  data: [-0.050000, 0.140000, 0.000600, -0.000700, 0.010000]\r\n\
H_cam1: 600\r\nW_cam1: 800\r\n\
K_cam2: !!opencv-matrix\r\n  rows: 3\r\n  cols: 3\r\n  dt: d\r\n  data: [980.000000, 0.000000, 395.000000, 0.000000,\r\n     990.000000, 305.500000, 0.000000, 0.000000, 1.000000]\r\n\
dist_cam2: !!opencv-matrix\r\n  rows: 1\r\n  cols: 5\r\n  dt: d\r\n  data: [-0.050000, 0.140000, 0.000600, -0.000700, 0.010000]\r\n\
H_cam2: 600\r\nW_cam2: 800\r\n";

/// The first camera by Rodrigues vector and matrix, the second by matrix alone.
pub(crate) const EXTRI: &str = "%YAML:1.0\r\n---\r\nnames:\r\n  - \"cam1\"\r\n  - \"cam2\"\r\n\
R_cam1: !!opencv-matrix\r\n  rows: 3\r\n  cols: 1\r\n  dt: d\r\n  data: [1.5547493448357081, 0.8320765978759244, -0.7246509717556328]\r\n\
Rot_cam1: !!opencv-matrix\r\n  rows: 3\r\n  cols: 3\r\n  dt: d\r\n  data: [0.554700, 0.832050, 0.000000, 0.114291, -0.076194, -0.990521, -0.824163, 0.549442, -0.137361]\r\n\
T_cam1: !!opencv-matrix\r\n  rows: 3\r\n  cols: 1\r\n  dt: d\r\n  data: [0.0, 0.9905211130872971, 3.7774155085889483]\r\n\
Rot_cam2: !!opencv-matrix\r\n  rows: 3\r\n  cols: 3\r\n  dt: d\r\n  data: [-0.9642053928037904, -0.2651564830210424, 0.0, -0.022291520360490487, 0.0810600740381472, -0.996459910140367, 0.2642178052442836, -0.9607920190701221, -0.08406930166863567]\r\n\
T_cam2: !!opencv-matrix\r\n  rows: 3\r\n  cols: 1\r\n  dt: d\r\n  data: [0.09642053928037919, 0.8990430711623794, 4.212472508610567]\r\n";

/// One camera per file, in millimetres, as OpenCV's calibration sample names it; without image size.
pub(crate) const XML: [&str; 2] = [
    r#"<?xml version="1.0"?>
<opencv_storage>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    1.0000000000000000e+03 0. 4.0250000000000000e+02 0.
    1.0100000000000000e+03 2.9725000000000000e+02 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix">
  <rows>1</rows>
  <cols>5</cols>
  <dt>d</dt>
  <data>
    -0.05 0.14 0.0006 -0.0007 0.01</data></distortion_coefficients>
<rotation_vectors type_id="opencv-matrix">
  <rows>3</rows>
  <cols>1</cols>
  <dt>f</dt>
  <data>
    1.5547493448357081 0.8320765978759244 -0.7246509717556328</data></rotation_vectors>
<translation_vectors type_id="opencv-matrix">
  <rows>3</rows>
  <cols>1</cols>
  <dt>f</dt>
  <data>
    0. 990.5211130872971 3777.4155085889483</data></translation_vectors>
</opencv_storage>
"#,
    r#"<?xml version="1.0"?>
<opencv_storage>
<image_width>800</image_width>
<image_height>600</image_height>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>980. 0. 395. 0. 990. 305.5 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>1</rows><cols>5</cols><dt>d</dt>
  <data>-0.05 0.14 0.0006 -0.0007 0.01</data></distortion_coefficients>
<rotation_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>-0.9642053928037904 -0.2651564830210424 0.0 -0.022291520360490487 0.0810600740381472
    -0.996459910140367 0.2642178052442836 -0.9607920190701221 -0.08406930166863567</data></rotation_matrix>
<translation_vectors type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt>
  <data>96.42053928037919 899.0430711623793 4212.472508610567</data></translation_vectors>
</opencv_storage>
"#,
];

/// 1/64 pixel, a cropped field of view, a marker camera and one switched off.
pub(crate) const QUALISYS: &str = r#"<?xml version='1.0' encoding='ASCII'?>
<calibration created="sometimes ago" maximumFrames="none" qtm-version="none" source="a.qca.txt" type="regular" wandLength="none">
  <results min-max-diff="0." std-dev="0."/>
  <cameras>
    <camera active="1" avg-residual="0.44" model="Miqus Video" point-count="99" serial="cam2" viewrotation="0">
      <fov_video bottom="609" left="20" right="819" top="10"/>
      <transform r11="-0.9642053928037904" r12="-0.2651564830210424" r13="0.0" r21="0.022291520360490487" r22="-0.0810600740381472" r23="0.996459910140367" r31="-0.2642178052442836" r32="0.9607920190701221" r33="0.08406930166863567" x="-1000.0" y="4000.0" z="1250.0"/>
      <intrinsic centerPointU="26560.0" centerPointV="20192.0" focalLengthU="62720.0" focalLengthV="63360.0" focallength="9.3" radialDistortion1="-0.05" radialDistortion2="0.14" radialDistortion3="0.01" sensorMaxU="69568" sensorMaxV="122816" sensorMinU="0.0" sensorMinV="0.0" skew="0.0" tangentalDistortion1="0.0006" tangentalDistortion2="-0.0007"/>
    </camera>
    <camera active="1" avg-residual="0.4" model="Oqus 700" point-count="99" serial="m1" viewrotation="0"/>
    <camera active="0" avg-residual="0.4" model="Miqus Video" point-count="99" serial="cam3" viewrotation="0"/>
    <camera active="1" avg-residual="0.4" model="none" point-count="99" serial="cam1" viewrotation="0">
      <fov_video bottom="599" left="0" right="799" top="0"/>
      <transform r11="0.5547001962252291" r12="0.8320502943378437" r13="0.0" r21="-0.11429089766391892" r22="0.07619393177594594" r23="0.9905211130872972" r31="0.8241633836921342" r32="-0.5494422557947561" r33="0.13736056394868904" x="3000.0" y="-2000.0" z="1500.0"/>
      <intrinsic centerPointU="25760.0" centerPointV="19024.0" focalLengthU="64000.0" focalLengthV="64640.0" focallength="9.3" radialDistortion1="-0.05" radialDistortion2="0.14" radialDistortion3="0.01" sensorMaxU="69568" sensorMaxV="122816" sensorMinU="0.0" sensorMinV="0.0" skew="0.0" tangentalDistortion1="0.0006" tangentalDistortion2="-0.0007"/>
    </camera>
  </cameras>
</calibration>
"#;

/// Sensors of 1000 × 800, of which the middle 800 × 600 were recorded; an infrared camera and one not calibrated.
pub(crate) const VICON: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<Cameras NAME="" VERSION="1.0">
  <Camera DEVICEID="cam2" DISPLAY_TYPE="Vue" PIXEL_ASPECT_RATIO="0.98989898989898990" SENSOR_SIZE="1000 800" SKEW="0" SYSTEM="DV" USERID="2">
    <KeyFrames>
      <KeyFrame FOCAL_LENGTH="980" FRAME="0" IMAGE_ERROR="0.2" ORIENTATION="0.09849344499343368 -0.7296120147911789 0.6706481971005751 0.09053366717100488" POSITION="-1000 4000 1250" PRINCIPAL_POINT="495 405.5" VICON_RADIAL="0 0" WORLD_ERROR="0.3"/>
    </KeyFrames>
  </Camera>
  <Camera DEVICEID="2109" DISPLAY_TYPE="Vero" PIXEL_ASPECT_RATIO="1" SENSOR_SIZE="2048 1088" USERID="3">
    <KeyFrames><KeyFrame FOCAL_LENGTH="1400" ORIENTATION="0 0 0 1" POSITION="0 0 0" PRINCIPAL_POINT="1024 544"/></KeyFrames>
  </Camera>
  <Camera DEVICEID="cam9" DISPLAY_TYPE="Vue" PIXEL_ASPECT_RATIO="1" SENSOR_SIZE="1000 800" USERID="4"><KeyFrames/></Camera>
  <Camera DEVICEID="cam1" DISPLAY_TYPE="Vue" PIXEL_ASPECT_RATIO="0.9900990099009901" SENSOR_SIZE="1000 800" SKEW="0" SYSTEM="DV" USERID="1">
    <KeyFrames>
      <KeyFrame FOCAL_LENGTH="1000" FRAME="0" IMAGE_ERROR="0.2" ORIENTATION="0.6648786904296646 0.35583227648272503 -0.30989238922649737 0.5790392258950584" POSITION="3000 -2000 1500" PRINCIPAL_POINT="502.5 397.25" VICON_RADIAL="0 0" VICON_RADIAL2="ViconRadial2 502.5 397.25 0 0 0" WORLD_ERROR="0.3"/>
    </KeyFrames>
  </Camera>
</Cameras>
"#;

/// The second matrix is multiplied by −2.
pub(crate) const MATRICES: &str = "# width height
800 600

cam1
222.9744342891451 1053.2008022952332 -55.28762698934734 1520.4097422070517
-129.54875916192876, 86.36583944128587, -1041.256751851918, 2123.263084146235
-0.8241633836921342 0.5494422557947561 -0.13736056394868904 3.7774155085889483

cam2:
1681.110503752445 1278.7324017866396 66.41474831818222 -3516.8375387918914
-117.29986869048614 426.54497705631314 2024.3569653974628 -4353.925983662568
-0.5284356104885672 1.9215840381402442 0.16813860333727134 -8.424945017221134
";
