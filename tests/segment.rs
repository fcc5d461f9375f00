//! Segmentation by several cameras of a made scene: a person-sized ellipsoid before a textured wall.

use std::convert::Infallible;
use std::sync::Mutex;

use maquette::camera::{Camera, Rig};
use maquette::image::{Mask, Picture, Plane};
use maquette::pipeline::segment::{Cut, SegmentOptions, Segmented, Segmenter, Training, segment};
use maquette::pipeline::{Beside, MemoryPictures, NoProgress, Person};
use maquette::silhouette::{
    Detection, FrameIndex, Keypoint, ShrunkSize, Support, SupportOptions, Volume,
};
use maquette::synth::Ring;
use nalgebra::{Point2, Point3, Vector3};

const SIZE: (u32, u32) = (120, 100);
const FRAMES: usize = 12;

/// The pixels of a picture, row by row.
fn pixels() -> impl Iterator<Item = (usize, usize)> {
    (0..SIZE.1 as usize).flat_map(|y| (0..SIZE.0 as usize).map(move |x| (x, y)))
}

fn rig() -> Rig {
    let ring = Ring {
        cameras: 4,
        radius: 4.0,
        height: 1.2,
        target_world: Point3::new(0.0, 0.0, 0.9),
        focal_px: 75.0,
        width_px: SIZE.0,
        height_px: SIZE.1,
        ..Ring::default()
    };
    ring.regular()
}

/// Whether a camera sees the ellipsoid of a frame in a pixel.
fn is_person(rig: &Rig, camera: usize, frame: usize, pixel: (usize, usize)) -> bool {
    is_ellipsoid(rig, camera, &walking(frame), pixel)
}

/// The middle of one who walks.
fn walking(frame: usize) -> Point3<f64> {
    Point3::new(0.09 * frame as f64 - 0.5, 0.05 * frame as f64 - 0.3, 0.9)
}

/// Whether a camera sees an ellipsoid about a middle in a pixel.
fn is_ellipsoid(rig: &Rig, camera: usize, centre: &Point3<f64>, (x, y): (usize, usize)) -> bool {
    let ray = rig.cameras[camera].ray(&Point2::new(x as f64, y as f64));
    let scale = Vector3::new(0.25, 0.25, 0.85);
    let from = (ray.origin_world - centre).component_div(&scale);
    let along = ray.direction_world.component_div(&scale);
    let t = -from.dot(&along) / along.norm_squared();
    (from + along * t).norm() < 1.0
}

fn picture(camera: usize, frame: usize, is_foreground: impl Fn(usize, usize) -> bool) -> Picture {
    let mut random = (camera * 1009 + frame * 31 + 1) as u32;
    let colours = pixels().map(|(x, y)| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let grain = (random >> 24) as i32 % 7 - 3;
        let tile = ((x / 10 + y / 8 + camera) % 3) as i32 * 35;
        let colour = match is_foreground(x, y) {
            true => [190, 80 + (y % 3) as i32 * 10, 60],
            false => [60 + tile, 90 + tile, 110 + tile / 2],
        };
        colour.map(|value| (value + grain).clamp(0, 255) as u8)
    });
    let pixels: Vec<[u8; 3]> = colours.collect();
    Picture::from_values(SIZE.0 as usize, SIZE.1 as usize, pixels).expect("a picture")
}

/// The pictures of a frame; in the first camera a second, smaller thing comes and goes above the person.
fn pictures(rig: &Rig, frame: usize) -> Vec<Option<Picture>> {
    let cameras = 0..rig.cameras.len();
    let stranger = |c: usize, x: usize, y: usize| {
        c == 0 && frame % 3 == 2 && (30..44).contains(&x) && (8..24).contains(&y)
    };
    cameras
        .map(|c| {
            Some(picture(c, frame, |x, y| is_person(rig, c, frame, (x, y)) || stranger(c, x, y)))
        })
        .collect()
}

fn learned(rig: &Rig, options: SegmentOptions) -> Segmenter {
    let mut training = Training::new(rig, FRAMES, options);
    for frame in 0..FRAMES {
        training.add(FrameIndex(frame), &pictures(rig, frame));
    }
    training.learn()
}

fn overlap(rig: &Rig, camera: usize, frame: usize, mask: &Mask) -> f64 {
    let (mut common, mut all) = (0.0, 0.0);
    for y in 0..mask.height() {
        for x in 0..mask.width() {
            let (found, truth) = (mask.is_foreground(x, y), is_person(rig, camera, frame, (x, y)));
            common += f64::from(u8::from(found && truth));
            all += f64::from(u8::from(found || truth));
        }
    }
    common / all
}

#[test]
fn a_person_is_cut_out_without_any_picture_of_the_empty_scene() {
    let rig = rig();
    let segmenter = learned(&rig, SegmentOptions::default());
    assert!(segmenter.is_consistent());
    for frame in [0, 5, 11] {
        for (c, cut) in
            segmenter.segment(FrameIndex(frame), &pictures(&rig, frame)).iter().enumerate()
        {
            let cut = cut.as_ref().expect("a picture, so a mask");
            let overlap = overlap(&rig, c, frame, &cut.mask);
            assert!(overlap > 0.85, "frame {frame}, camera {c}: {overlap}");
        }
    }
}

#[test]
fn what_no_other_camera_supports_is_removed() {
    let rig = rig();
    let is_stranger = |segmenter: &Segmenter| {
        let cuts = segmenter.segment(FrameIndex(5), &pictures(&rig, 5));
        let cut = cuts[0].as_ref().expect("a mask");
        (cut.mask.is_foreground(37, 16), cut.quality.unsupported)
    };
    let together = learned(&rig, SegmentOptions::default());
    let (is_kept, unsupported) = is_stranger(&together);
    assert!(!is_kept && unsupported > 0.05, "{unsupported}");
    let alone = SegmentOptions { against_weight: 0.0, ..SegmentOptions::default() };
    assert!(is_stranger(&learned(&rig, alone)).0, "without the others it stays");
}

#[test]
fn a_camera_without_a_picture_has_no_mask_and_the_others_have() {
    let rig = rig();
    let segmenter = learned(&rig, SegmentOptions::default());
    let mut some = pictures(&rig, 5);
    some[2] = None;
    let cuts = segmenter.segment(FrameIndex(5), &some);
    assert!(cuts[2].is_none());
    let cut = cuts[1].as_ref().expect("a mask");
    assert!(overlap(&rig, 1, 5, &cut.mask) > 0.85);
}

#[test]
fn an_overexposed_picture_has_no_mask_and_speaks_against_nobody() {
    let rig = rig();
    let segmenter = learned(&rig, SegmentOptions::default());
    let mut some = pictures(&rig, 5);
    some[2] = Some(Picture::filled(SIZE.0 as usize, SIZE.1 as usize, [255; 3]));
    let cuts = segmenter.segment(FrameIndex(5), &some);
    assert!(cuts[2].is_none());
    some[2] = None;
    for (cut, without) in cuts.iter().zip(segmenter.segment(FrameIndex(5), &some)) {
        assert_eq!(cut.as_ref().map(|c| &c.mask), without.as_ref().map(|c| &c.mask));
    }
}

#[test]
fn a_recording_in_memory_is_segmented_frame_by_frame_and_what_is_odd_is_noted() {
    let rig = rig();
    let mut recording = MemoryPictures {
        frames: (0..FRAMES).map(|frame| (FrameIndex(frame), pictures(&rig, frame))).collect(),
        fps: 25.0,
        rig: rig.clone(),
        ..MemoryPictures::default()
    };
    let bright = Picture::filled(SIZE.0 as usize, SIZE.1 as usize, [255; 3]);
    recording.frames.entry(FrameIndex(5)).or_default()[2] = Some(bright);

    let taken = Mutex::new(Vec::new());
    let options = SegmentOptions::default();
    let segmented = segment(&recording, &[], 4..=6, options, &NoProgress, |frame| {
        let cut = frame.cuts[1].as_ref().expect("a mask");
        let overlap = overlap(&rig, 1, frame.frame.0, &cut.mask);
        taken.lock().expect("no panic").push((frame.frame.0, overlap));
        Ok::<(), Infallible>(())
    });
    let Ok(Segmented { masks, notes }) = segmented;

    let mut taken = taken.into_inner().expect("no panic");
    taken.sort_by_key(|(frame, _)| *frame);
    assert!(taken.iter().map(|(frame, _)| *frame).eq(4..=6));
    assert!(taken.iter().all(|(_, overlap)| *overlap > 0.85), "{taken:?}");
    assert_eq!(masks.len(), 3 * 4 - 1);
    assert!(masks.is_sorted_by_key(|mask| (mask.frame, mask.camera)));
    let refused = format!("camera {}: 1 picture (5) with more than half", rig.cameras[2].name);
    assert!(notes[0].starts_with(&refused), "{notes:?}");
}

#[test]
fn nothing_in_the_pictures_is_no_fault() {
    let rig = rig();
    let empty = |frame| (0..4).map(|c| Some(picture(c, frame, |_, _| false))).collect::<Vec<_>>();
    let mut training = Training::new(&rig, 3, SegmentOptions::default());
    (0..3).for_each(|frame| training.add(FrameIndex(frame), &empty(frame)));
    let segmenter = training.learn();
    assert!(!segmenter.is_consistent());
    for cut in segmenter.segment(FrameIndex(1), &empty(1)) {
        assert_eq!(cut.expect("a mask").quality.area_px, 0);
    }
    let never = Training::new(&rig, 0, SegmentOptions::default()).learn();
    assert_eq!(never.segment(FrameIndex(0), &vec![None; 4]).iter().flatten().count(), 0);
}

#[test]
fn overexposed_pictures_and_pictures_of_one_grey_are_no_fault() {
    let rig = rig();
    for grey in [0, 128, 255] {
        let flat = || vec![Some(Picture::filled(SIZE.0 as usize, SIZE.1 as usize, [grey; 3])); 4];
        let mut training = Training::new(&rig, 4, SegmentOptions::default());
        (0..4).for_each(|frame| training.add(FrameIndex(frame), &flat()));
        let cuts = training.learn().segment(FrameIndex(1), &flat());
        assert!(cuts.iter().flatten().all(|cut| cut.quality.area_px == 0));
    }
}

/// Joints of both sides within an ellipsoid: names, how far left or right of its middle, and above it, metres.
const JOINTS: [([&str; 2], f64, f64); 6] = [
    (["LShoulder", "RShoulder"], 0.14, 0.45),
    (["LElbow", "RElbow"], 0.2, 0.15),
    (["LWrist", "RWrist"], 0.2, -0.1),
    (["LHip", "RHip"], 0.1, -0.05),
    (["LKnee", "RKnee"], 0.1, -0.4),
    (["LAnkle", "RAnkle"], 0.06, -0.75),
];

/// What a detector shows of somebody whose middle is `at` in each frame.
fn person(rig: &Rig, at: impl Fn(usize) -> Point3<f64>) -> Person {
    let seen = |frame: usize, camera: &Camera| {
        let keypoint = |name: &'static str, aside: f64, above: f64| {
            let place = at(frame) + Vector3::new(0.0, aside, above);
            let pixel = camera.project_undistorted(&place).expect("before the camera");
            Keypoint { name, pixel, confidence: 0.9 }
        };
        let joints = JOINTS.iter().flat_map(|([left, right], aside, above)| {
            [keypoint(left, *aside, *above), keypoint(right, -aside, *above)]
        });
        Detection::new(joints.collect()).expect("joints")
    };
    let of_frame = |frame| {
        let cameras = rig.iter().map(|(id, camera)| (id, seen(frame, camera)));
        (FrameIndex(frame), cameras.collect())
    };
    Person { detections: (0..FRAMES).map(of_frame).collect(), beside: Beside::default() }
}

/// The masks of a frame of a recording of people at these places, who were detected.
fn cuts(
    rig: &Rig,
    at: &[&dyn Fn(usize) -> Point3<f64>],
    people: &[Person],
    frame: usize,
) -> Vec<Cut> {
    let pictures = |frame: usize| -> Vec<Option<Picture>> {
        let shows = |c, pixel| at.iter().any(|at| is_ellipsoid(rig, c, &at(frame), pixel));
        (0..4).map(|c| Some(picture(c, frame, |x, y| shows(c, (x, y))))).collect()
    };
    let mut training = Training::new(rig, FRAMES, SegmentOptions::default()).told(people);
    (0..FRAMES).for_each(|frame| training.add(FrameIndex(frame), &pictures(frame)));
    let cuts = training.learn().segment(FrameIndex(frame), &pictures(frame));
    cuts.into_iter().map(|cut| cut.expect("a mask")).collect()
}

/// The share of somebody's pixels that `is_theirs`.
fn share(
    rig: &Rig,
    camera: usize,
    at: &Point3<f64>,
    is_theirs: impl Fn(usize, usize) -> bool,
) -> f64 {
    let own: Vec<_> = pixels().filter(|pixel| is_ellipsoid(rig, camera, at, *pixel)).collect();
    own.iter().filter(|(x, y)| is_theirs(*x, *y)).count() as f64 / own.len() as f64
}

/// A camera that sees two people beside each other.
fn apart(rig: &Rig, one: &Point3<f64>, other: &Point3<f64>) -> usize {
    let both = |c: &usize| share(rig, *c, one, |x, y| is_ellipsoid(rig, *c, other, (x, y)));
    (0..4).find(|c| both(c) <= 0.0).expect("one of four cameras around")
}

/// The share of a mask's pixels that are somebody's.
fn share_of(mask: &Mask, is_theirs: impl Fn(usize, usize) -> bool) -> f64 {
    let of_mask: Vec<_> = pixels().filter(|(x, y)| mask.is_foreground(*x, *y)).collect();
    let theirs = of_mask.iter().filter(|(x, y)| is_theirs(*x, *y));
    theirs.count() as f64 / of_mask.len().max(1) as f64
}

#[test]
fn who_never_moves_is_found_where_detections_show_them() {
    let rig = rig();
    let still = |_| Point3::new(0.0, 0.0, 0.9);
    let told = cuts(&rig, &[&still], &[person(&rig, still)], 5);
    let untold = cuts(&rig, &[&still], &[], 5);
    for (c, (told, untold)) in told.iter().zip(&untold).enumerate() {
        let found = |cut: &Cut| share(&rig, c, &still(5), |x, y| cut.mask.is_foreground(x, y));
        assert!(found(told) > 0.5 && found(untold) < 0.1, "{c}: {} {}", found(told), found(untold));
        // and little else
        let all = told.quality.area_px as f64;
        let own = all * share_of(&told.mask, |x, y| is_ellipsoid(&rig, c, &still(5), (x, y)));
        assert!(own > 0.8 * all, "{c}: {own} of {all}");
    }
}

#[test]
fn who_is_far_from_all_joints_is_not_in_the_masks() {
    let rig = rig();
    let other = |frame: usize| Point3::new(0.4 - 0.09 * frame as f64, 0.9, 0.9);
    let told = cuts(&rig, &[&walking, &other], &[person(&rig, walking)], 1);
    let untold = cuts(&rig, &[&walking, &other], &[], 1);
    let found = |cut: &Cut, c: usize, at: &Point3<f64>| {
        share(&rig, c, at, |x, y| cut.mask.is_foreground(x, y))
    };
    let c = apart(&rig, &walking(1), &other(1));
    for cut in [&told[c], &untold[c]] {
        assert!(found(cut, c, &walking(1)) > 0.85, "{}", found(cut, c, &walking(1)));
    }
    assert!(found(&told[c], c, &other(1)) < 0.02, "{}", found(&told[c], c, &other(1)));
    assert!(found(&untold[c], c, &other(1)) > 0.85, "{}", found(&untold[c], c, &other(1)));
    assert!(told[c].labels.is_none());
}

#[test]
fn two_people_have_a_value_each() {
    let rig = rig();
    let other = |frame: usize| Point3::new(0.4 - 0.09 * frame as f64, 0.9, 0.9);
    let people = [person(&rig, walking), person(&rig, other)];
    let told = cuts(&rig, &[&walking, &other], &people, 1);
    let c = apart(&rig, &walking(1), &other(1));
    let labels = told[c].labels.as_ref().expect("two people");
    for (value, at) in [(1, walking(1)), (2, other(1))] {
        let found = share(&rig, c, &at, |x, y| labels.get(x, y) == Some(value));
        assert!(found > 0.85, "{value}: {found}");
    }
    assert_eq!(labels.get(2, 2), Some(0));
}

/// The second is detected by all cameras but this one, which has them in its mask.
#[test]
fn who_was_not_detected_in_a_picture_is_not_taken_for_who_was() {
    let rig = rig();
    let other = |frame: usize| Point3::new(0.4 - 0.09 * frame as f64, 0.9, 0.9);
    let c = apart(&rig, &walking(1), &other(1));
    let mut hidden = person(&rig, other);
    hidden.detections.iter_mut().for_each(|(_, seen)| seen.retain(|(camera, _)| camera.0 != c));
    let told = cuts(&rig, &[&walking, &other], &[person(&rig, walking), hidden], 1);

    let in_mask = share(&rig, c, &other(1), |x, y| told[c].mask.is_foreground(x, y));
    assert!(in_mask > 0.85, "{in_mask}");
    let labels = told[c].labels.as_ref().expect("two people");
    let first = |at: &Point3<f64>| share(&rig, c, at, |x, y| labels.get(x, y) == Some(1));
    assert!(first(&walking(1)) > 0.85, "{}", first(&walking(1)));
    assert!(first(&other(1)) < 0.1, "{}", first(&other(1)));
}

#[test]
fn support_is_high_where_all_others_agree_and_low_elsewhere() {
    let rig = rig();
    let shrunk = ShrunkSize { width: SIZE.0 as usize, height: SIZE.1 as usize, factor: 1 };
    let volume = Volume { low: Point3::new(-1.3, -1.3, -0.2), high: Point3::new(1.3, 1.3, 2.2) };
    let support = Support::new(&rig, &[shrunk; 4], &volume, SupportOptions::default());
    let evidence = |c: usize| {
        let values = pixels().map(|place| if is_person(&rig, c, 6, place) { 4.0 } else { -4.0 });
        Plane::from_values(shrunk.width, shrunk.height, values.collect())
    };
    // the first camera sees nobody: the others know better
    let nobody = Some(Plane::filled(shrunk.width, shrunk.height, -4.0));
    let evidence = [nobody, evidence(1), evidence(2), evidence(3)];
    let by_others = support.by_others(&evidence);
    let first = by_others[0].as_ref().expect("support");
    let middle = rig.cameras[0].project(&Point3::new(0.04, 0.0, 0.9)).expect("seen");
    assert_eq!(first.get(middle.x as usize, middle.y as usize), Some(1.0));
    assert_eq!(first.get(2, 50), Some(-1.0));
}
