//! Gait analysis of walks that are known, and of what is no walk, and the exports.

#[cfg(feature = "report")]
#[path = "gait/compared.rs"]
mod compared;
#[path = "gait/exports.rs"]
mod exports;
#[path = "gait/stated.rs"]
mod stated;
#[allow(dead_code, reason = "a walker shared with the tests of the program")]
#[path = "gait/walker.rs"]
mod walker;

use maquette::gait::{
    Angle, Cycle, EventKind, GaitAnalysis, GaitError, GaitOptions, Landmark, Movement,
    MovementError, Paired, Parameter, Side, Surface, analyse, of_people,
};
use nalgebra::Vector3;
use walker::{STRIDE_S, Walker};

fn analysed(walker: &Walker) -> GaitAnalysis {
    let movement = walker.movement().expect("a body");
    analyse(&movement, &GaitOptions::default()).expect("a pelvis")
}

fn mean(gait: &GaitAnalysis, parameter: Parameter, side: Side) -> f64 {
    gait.parameters[&(parameter, side)].mean
}

#[test]
fn strides_and_steps_of_a_walk_are_those_it_was_made_with() {
    let walker = Walker::new(0.7);
    let gait = analysed(&walker);
    assert_eq!(gait.course.surface, Surface::Ground);
    for side in Side::BOTH {
        let stride_s = mean(&gait, Parameter::StrideTime, side);
        assert!((stride_s - STRIDE_S).abs() < 0.004, "{stride_s}");
        let ratio = mean(&gait, Parameter::StrideLength, side) / walker.stride_length();
        assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
        let steps = mean(&gait, Parameter::StepLength, side) / walker.stride_length();
        assert!((0.42..0.54).contains(&steps), "{steps}");
        let stance = mean(&gait, Parameter::Stance, side);
        assert!((55.0..68.0).contains(&stance), "{stance}");
        let support = mean(&gait, Parameter::SingleSupport, side);
        let double = mean(&gait, Parameter::DoubleSupport, side);
        approx::assert_relative_eq!(support + double, stance, epsilon = 1e-9);
    }
    // sides alike: so the events come half a cycle apart
    let step_s = mean(&gait, Parameter::StepTime, Side::Left);
    assert!((step_s - 0.5 * STRIDE_S).abs() < 0.004, "{step_s}");
}

#[test]
fn a_treadmill_is_found_and_gives_the_parameters_of_the_same_walk_over_ground() {
    let walker = Walker::new(-2.0);
    let ground = analysed(&walker);
    let belt = analysed(&walker.on_a_treadmill());
    assert_eq!(belt.course.surface, Surface::Treadmill);
    let speed = walker.stride_length() / STRIDE_S;
    assert!((belt.course.belt_m_s / speed - 1.0).abs() < 0.08, "{}", belt.course.belt_m_s);
    for parameter in [Parameter::StrideTime, Parameter::Stance, Parameter::StepLength] {
        for side in Side::BOTH {
            let ratio = mean(&belt, parameter, side) / mean(&ground, parameter, side);
            assert!((ratio - 1.0).abs() < 0.03, "{parameter:?} {side:?}: {ratio}");
        }
    }
}

#[test]
fn nothing_depends_on_where_in_the_room_the_person_walks_to() {
    let (one, other) = (analysed(&Walker::new(0.0)), analysed(&Walker::new(2.5)));
    assert_eq!(one.events.len(), other.events.len());
    for (a, b) in one.events.iter().zip(&other.events) {
        assert_eq!((a.side, a.kind), (b.side, b.kind));
        assert!((a.time_s - b.time_s).abs() < 0.002);
    }
    for (key, track) in &one.angles {
        let furthest = track.iter().zip(&other.angles[key]).map(|(a, b)| (a - b).abs());
        let furthest = furthest.fold(0.0, f64::max);
        assert!(furthest < 0.02, "{key:?}: {furthest}");
    }
}

#[test]
fn angles_of_joint_centres_are_those_that_the_body_was_posed_with() {
    let walker = Walker::new(0.3);
    let gait = analysed(&walker);
    for (angle, joint, side, tolerance_deg) in [
        (Angle::KneeFlexion, "knee_flexion_r", Side::Right, 1.0),
        (Angle::HipFlexion, "hip_flexion_l", Side::Left, 2.0),
        (Angle::AnkleDorsiflexion, "ankle_dorsiflexion_r", Side::Right, 1.5),
        (Angle::ElbowFlexion, "elbow_flexion_l", Side::Left, 1.5),
    ] {
        let truth = walker.angle(joint);
        let found = &gait.angles[&(side, angle)];
        // the filter's ends and a constant of the definition aside
        let apart: Vec<f64> =
            (20..truth.len() - 20).map(|i| (found[i] - truth[i]).to_degrees()).collect();
        let offset = apart.iter().sum::<f64>() / apart.len() as f64;
        let worst = apart.iter().map(|d| (d - offset).abs()).fold(0.0, f64::max);
        assert!(worst < tolerance_deg, "{joint}: {worst}");
        assert!(offset.abs() < 6.0, "{joint}: {offset}");
    }
    assert!(!gait.angles.contains_key(&(Side::Left, Angle::HipRotation)));
    assert!(gait.unknown.iter().any(|(angle, _)| *angle == Angle::HipRotation));
}

#[test]
fn angles_of_a_fitted_body_are_its_own() {
    let walker = Walker::new(0.3);
    let (movement, _) = walker.fitted();
    let gait = analyse(&movement, &GaitOptions::default()).expect("a pelvis");
    for (angle, joint, sign) in [
        (Angle::KneeFlexion, "knee_flexion_r", 1.0),
        (Angle::HipFlexion, "hip_flexion_r", 1.0),
        (Angle::HipAdduction, "hip_abduction_r", -1.0),
        (Angle::AnkleDorsiflexion, "ankle_dorsiflexion_r", 1.0),
        (Angle::ElbowFlexion, "elbow_flexion_r", 1.0),
    ] {
        let found = &gait.angles[&(Side::Right, angle)];
        for (f, t) in found.iter().zip(walker.angle(joint)) {
            assert!((f - sign * t).abs() < 0.5_f64.to_radians(), "{joint}: {f} {t}");
        }
    }
    assert!(gait.unknown.iter().any(|(angle, _)| *angle == Angle::KneeRotation));
}

#[test]
fn a_fitted_body_stands_evenly_in_time_with_gaps_where_nobody_was_seen() {
    let mut walker = Walker::new(0.0);
    walker.motions.truncate(20);
    let (movement, body) = walker.fitted_without(7..9);
    assert_eq!((movement.frames, body.motions.len()), (20, 20));
    let hip = body.points.iter().position(|p| p.name == "RHip");
    let hip = &body.points[hip.expect("a hip")].track;
    for (i, (motion, place)) in body.motions.iter().zip(hip).enumerate() {
        let is_seen = !(7..9).contains(&i);
        assert_eq!(motion.is_some(), is_seen);
        assert_eq!(place.x.is_finite(), is_seen);
    }
}

#[test]
fn both_methods_find_every_event() {
    let gait = analysed(&Walker::new(0.0));
    assert_eq!(gait.agreement.len(), 2);
    for agreement in &gait.agreement {
        let all = gait.events.iter().filter(|e| e.kind == agreement.kind).count();
        assert_eq!(agreement.n, all, "{:?}", agreement.kind);
        assert!(agreement.mean_s.abs() < 0.06 && agreement.sd_s.expect("several") < 0.01);
    }
    assert!(gait.events.iter().any(|e| e.kind == EventKind::Off));
}

#[test]
fn a_short_recording_says_what_is_missing_and_gives_angles_over_time() {
    let mut walker = Walker::new(0.0);
    walker.keep(0..30);
    let gait = analysed(&walker);
    assert!(gait.cycles.is_empty() && gait.curves.is_empty());
    assert!(gait.notes.iter().any(|n| n.contains("less than one left stride")), "{:?}", gait.notes);
    assert!(gait.angles.contains_key(&(Side::Left, Angle::KneeFlexion)));
}

#[test]
fn a_squat_has_no_steps() {
    let gait = analysed(&Walker::squat());
    assert!(gait.events.is_empty(), "{:?}", gait.events);
    assert!(gait.notes[0].starts_with("no steps"), "{:?}", gait.notes);
    let knee = &gait.angles[&(Side::Left, Angle::KneeFlexion)];
    assert!(knee.iter().copied().fold(0.0, f64::max) > 1.0);
}

#[test]
fn walking_backwards_is_said_and_not_measured() {
    for walker in [Walker::new(1.0).reversed(), Walker::new(1.0).on_a_treadmill().reversed()] {
        let gait = analysed(&walker);
        assert!(
            gait.events.is_empty() && gait.notes[0].starts_with("walks backwards"),
            "{:?}",
            gait.notes
        );
    }
}

#[test]
fn a_gap_costs_the_strides_that_it_lies_in_and_no_others() {
    let mut walker = Walker::new(0.0);
    let whole = analysed(&walker).curves.iter().map(|c| c.strides.len()).sum::<usize>();
    walker.forget(100..103);
    let bridged = analysed(&walker).curves.iter().map(|c| c.strides.len()).sum::<usize>();
    assert_eq!(whole, bridged);
    walker.forget(90..115);
    let gait = analysed(&walker);
    let left = gait.curves.iter().map(|c| c.strides.len()).sum::<usize>();
    assert!(0 < left && left < whole, "{left} of {whole}");
    for side in Side::BOTH {
        let stride_s = mean(&gait, Parameter::StrideTime, side);
        assert!((stride_s - STRIDE_S).abs() < 0.02, "{stride_s}");
    }
}

#[test]
fn a_body_without_an_ankle_or_of_the_wrong_unit_is_refused() {
    let mut walker = Walker::new(0.0);
    walker.rename("LAnkle", "somewhere");
    let refused = walker.movement();
    assert!(
        matches!(&refused, Err(MovementError::Missing { missing, .. }) if missing == "left ankle"),
        "{refused:?}"
    );
    let small = Walker::new(0.0).scaled(1e-3).movement();
    assert!(matches!(small, Err(MovementError::Size { .. })), "{small:?}");
}

#[test]
fn a_constant_added_to_every_place_changes_nothing() {
    let walker = Walker::new(0.0);
    let moved = walker.moved(Vector3::new(3.0, -2.0, 0.5));
    let (a, b) = (analysed(&walker), analysed(&moved));
    for (key, statistic) in &a.parameters {
        approx::assert_relative_eq!(statistic.mean, b.parameters[key].mean, epsilon = 1e-6);
    }
}

/// A recording of nothing.
#[test]
fn too_few_frames_are_refused() {
    let refused = Movement::from_points(100.0, 0, &["RHip".to_owned()], &[]);
    assert_eq!(refused, Err(MovementError::Short { frames: 0, fewest: 10 }));
}

#[test]
fn a_step_is_as_uncertain_as_the_way_between_the_feet_and_a_width_as_both_of_them() {
    let mut movement = Walker::new(0.0).movement().expect("a body");
    let frames = movement.frames;
    for side in Side::BOTH {
        let ankle = Landmark::Of(side, Paired::Ankle);
        let sd = vec![Vector3::repeat(0.01); frames];
        movement.sd_m.insert(ankle, sd);
    }
    let of = |movement: &Movement, parameter| {
        let gait = analyse(movement, &GaitOptions::default()).expect("a pelvis");
        let u = gait.parameters[&(parameter, Side::Left)].uncertainty;
        u.expect("known")
    };
    // nothing is known of how the two err together: the bound
    approx::assert_relative_eq!(of(&movement, Parameter::StepLength), 0.02, epsilon = 1e-9);
    approx::assert_relative_eq!(of(&movement, Parameter::StepWidth), 0.02, epsilon = 1e-9);
    let apart = vec![Vector3::new(0.003, 0.05, 0.05); frames];
    movement.apart_sd_m.insert(Paired::Ankle, apart);
    let u = of(&movement, Parameter::StepLength);
    assert!((0.003..0.0035).contains(&u), "{u}");
    approx::assert_relative_eq!(of(&movement, Parameter::StepWidth), 0.02, epsilon = 1e-9);
}

#[test]
fn who_sways_on_the_spot_keeps_one_heading() {
    let mut movement = Walker::squat().movement().expect("a body");
    let rate = movement.rate_hz;
    // to the left and back, 0.4 m/s at most
    for track in movement.tracks.values_mut() {
        for (i, place) in track.iter_mut().enumerate() {
            place.y += 0.2 * (2.0 * i as f64 / rate).sin();
        }
    }
    let gait = analyse(&movement, &GaitOptions::default()).expect("a pelvis");
    for (i, heading) in gait.course.heading.iter().enumerate() {
        assert!(heading.x > 0.99, "frame {i}: {heading}");
    }
}

fn of_pass(walker: &Walker, pass: Option<usize>) -> GaitAnalysis {
    let movement = walker.movement().expect("a body");
    analyse(&movement, &GaitOptions { pass, ..GaitOptions::default() }).expect("a pass")
}

#[test]
fn who_leaves_and_comes_back_has_two_passes_and_no_number_is_of_both() {
    const UNSEEN: usize = 80;
    let walker = Walker::new(0.3);
    let frames = walker.motions.len();
    let twice = walker.who_returns(UNSEEN, Vector3::new(-1.0, 3.0, 0.0));
    let alone = analysed(&walker);

    for (pass, first) in [(1, 0), (2, frames + UNSEEN)] {
        let gait = of_pass(&twice, Some(pass));
        assert_eq!(gait.cycles.len(), alone.cycles.len(), "pass {pass}");
        let within = first as f64..(first + frames) as f64;
        assert!(gait.events.iter().all(|event| within.contains(&event.frame)), "pass {pass}");
        for (key, statistic) in &alone.parameters {
            let found = &gait.parameters[key];
            assert_eq!(found.n, statistic.n, "{key:?}");
            approx::assert_relative_eq!(found.mean, statistic.mean, max_relative = 1e-3);
        }
        let note = gait.notes.iter().find(|note| note.contains("comes back"));
        let shown = format!("2: frames {}–{}", frames + UNSEEN, 2 * frames + UNSEEN - 1);
        assert!(note.is_some_and(|note| note.contains(&shown)), "{:?}", gait.notes);
    }
    assert_eq!(of_pass(&twice, None).parameters, of_pass(&twice, Some(1)).parameters);

    // no third pass, and one pass where somebody is hidden for a moment
    let movement = twice.movement().expect("a body");
    let third = analyse(&movement, &GaitOptions { pass: Some(3), ..GaitOptions::default() });
    assert_eq!(third, Err(GaitError::NoPass { pass: 3, passes: 2 }));
    let hidden = walker.who_returns(10, Vector3::zeros());
    assert!(!of_pass(&hidden, None).notes.iter().any(|note| note.contains("comes back")));
}

#[test]
fn a_stride_in_which_the_person_was_lost_is_refused_and_the_others_stay() {
    let walker = Walker::new(0.0);
    let (whole, gait) = (analysed(&walker), {
        let lost = walker.lost_from(200, Vector3::new(0.0, 3.0, 0.0));
        analysed(&lost)
    });
    let over = |gait: &GaitAnalysis| {
        let holds = |c: &&Cycle| c.strike < 200.0 && 200.0 < c.strike + c.period;
        gait.cycles.iter().filter(holds).count()
    };
    assert_eq!((over(&whole), over(&gait)), (2, 0));
    assert!(!gait.cycles.is_empty());
    let refused = gait.notes.iter().filter(|note| note.contains("is refused: the hips move at"));
    assert_eq!(refused.count(), 2, "{:?}", gait.notes);
    for side in Side::BOTH {
        assert!(mean(&gait, Parameter::StepWidth, side) < 0.5);
    }
}

#[test]
fn a_walk_read_at_half_or_twice_its_frame_rate_is_told() {
    let movement = Walker::new(0.0).movement().expect("a body");
    let note = |factor: f64| {
        let other = Movement { rate_hz: factor * movement.rate_hz, ..movement.clone() };
        let gait = analyse(&other, &GaitOptions::default()).expect("a pelvis");
        gait.notes.into_iter().find(|note| note.contains("frame rate"))
    };
    assert_eq!(note(1.0), None);
    assert!(note(0.5).is_some_and(|note| note.contains("seems too low")));
    assert!(note(2.0).is_some_and(|note| note.contains("seems too high")));
}

/// A person whose left knee bends by so many radians more in every percent, and who walks so much faster.
fn bending(gait: &GaitAnalysis, more: f64) -> GaitAnalysis {
    let mut own = gait.clone();
    let knee =
        |c: &&mut maquette::gait::Curve| c.angle == Angle::KneeFlexion && c.side == Side::Left;
    for curve in own.curves.iter_mut().filter(knee) {
        curve.mean.iter_mut().for_each(|v| *v += more);
    }
    for side in Side::BOTH {
        if let Some(speed) = own.parameters.get_mut(&(Parameter::Speed, side)) {
            speed.mean += more;
        }
    }
    own
}

#[test]
fn a_norm_of_people_is_their_mean_and_the_standard_deviation_between_them() {
    let gait = analysed(&Walker::new(0.3));
    let people = [-0.1, 0.0, 0.1].map(|more| bending(&gait, more));
    // one of them has two trials, and counts once
    let norm = of_people(&[vec![&people[0]], vec![&people[1], &people[1]], vec![&people[2]]]);

    // half of what the left knee differs by, as a person is the mean of both sides
    let (knee, n) = &norm.curves[&Angle::KneeFlexion];
    assert_eq!(*n, 3);
    approx::assert_relative_eq!(knee.sd[20], 0.05, epsilon = 1e-9);
    let of = |side| gait.curves.iter().find(|c| c.angle == Angle::KneeFlexion && c.side == side);
    let both: Vec<f64> = Side::BOTH.into_iter().filter_map(of).map(|c| c.mean[40]).collect();
    approx::assert_relative_eq!(knee.mean[20], 0.5 * (both[0] + both[1]), epsilon = 1e-9);
    let (speed, sd, _) = norm.parameters[&Parameter::Speed];
    approx::assert_relative_eq!(sd, 0.1, epsilon = 1e-9);
    let own = 0.5
        * (mean(&gait, Parameter::Speed, Side::Left) + mean(&gait, Parameter::Speed, Side::Right));
    approx::assert_relative_eq!(speed, own, epsilon = 1e-9);

    // two people have no norm
    assert!(of_people(&[vec![&people[0]], vec![&people[2]]]).curves.is_empty());
}
