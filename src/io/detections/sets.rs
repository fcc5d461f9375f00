//! Which points a detector names, and in which order.

use super::Person;

/// The points of a detector, by Pose2Sim's names; those that no joint is called by are empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeypointSet {
    /// As `keypoints` in `sequence.toml` names it.
    pub name: &'static str,
    /// The points, block after block in the order of a file.
    blocks: &'static [&'static [&'static str]],
    /// How many points a file holds of it.
    pub count: usize,
}

#[rustfmt::skip]
const COCO: &[&str] = &[
    "Nose", "LEye", "REye", "LEar", "REar", "LShoulder", "RShoulder", "LElbow", "RElbow",
    "LWrist", "RWrist", "LHip", "RHip", "LKnee", "RKnee", "LAnkle", "RAnkle",
];
const FEET: &[&str] = &["LBigToe", "LSmallToe", "LHeel", "RBigToe", "RSmallToe", "RHeel"];
const HALPE: &[&str] =
    &["Head", "Neck", "Hip", "LBigToe", "RBigToe", "LSmallToe", "RSmallToe", "LHeel", "RHeel"];
#[rustfmt::skip]
const BODY_25: &[&str] = &[
    "Nose", "Neck", "RShoulder", "RElbow", "RWrist", "LShoulder", "LElbow", "LWrist", "Hip",
    "RHip", "RKnee", "RAnkle", "LHip", "LKnee", "LAnkle", "REye", "LEye", "REar", "LEar",
];
#[rustfmt::skip]
const MEDIAPIPE: &[&str] = &[
    "Nose", "", "", "", "", "", "", "LEar", "REar", "", "", "LShoulder", "RShoulder", "LElbow",
    "RElbow", "LWrist", "RWrist", "", "", "", "", "", "", "LHip", "RHip", "LKnee", "RKnee",
    "LAnkle", "RAnkle", "LHeel", "RHeel", "LBigToe", "RBigToe",
];

/// All that are known; of two with the same count the first is tried first.
const SETS: [KeypointSet; 7] = [
    KeypointSet { name: "coco17", blocks: &[COCO], count: 17 },
    KeypointSet { name: "body25", blocks: &[BODY_25, FEET], count: 25 },
    KeypointSet { name: "body25b", blocks: &[COCO, &["Neck", "Head"], FEET], count: 25 },
    KeypointSet { name: "halpe26", blocks: &[COCO, HALPE], count: 26 },
    KeypointSet { name: "mediapipe33", blocks: &[MEDIAPIPE], count: 33 },
    KeypointSet { name: "wholebody133", blocks: &[COCO, FEET], count: 133 },
    KeypointSet { name: "halpe136", blocks: &[COCO, HALPE], count: 136 },
];

impl KeypointSet {
    /// The points, in the order of a file.
    pub fn points(self) -> impl Iterator<Item = &'static str> {
        self.blocks.iter().copied().flatten().copied()
    }

    /// The names of all sets.
    pub fn names() -> impl Iterator<Item = &'static str> {
        SETS.iter().map(|set| set.name)
    }

    /// The set of a name, `halpe26` or `HALPE_26`.
    pub fn by_name(name: &str) -> Option<Self> {
        let plain: String =
            name.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
        SETS.into_iter().find(|set| set.name == plain)
    }

    /// The set of which these people are, by the number of their points.
    ///
    /// BODY_25 and BODY_25B both have 25. Nose and eyes lie together, ankles do not: point 15 is an eye of one and an ankle of the other.
    pub fn of_people(people: &[Person]) -> Option<Self> {
        let count = people.first()?.len();
        let of_count: Vec<Self> = SETS.into_iter().filter(|set| set.count == count).collect();
        match of_count.as_slice() {
            [first, second] => Some(if has_eye_at_15(people) { *first } else { *second }),
            sets => sets.first().copied(),
        }
    }
}

/// An eye is nearer to the nose than this share of the person's extent.
const EYE: f64 = 0.25;

fn has_eye_at_15(people: &[Person]) -> bool {
    let is_near = |person: &Person| {
        let seen = || person.iter().filter(|[_, _, confidence]| *confidence > 0.0);
        let extent = |axis: usize| {
            let along = || seen().map(|point| point[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let ([x, y, sure], [nose_x, nose_y, nose_sure]) = (person[15], person[0]);
        let apart = (x - nose_x).hypot(y - nose_y);
        (sure > 0.0 && nose_sure > 0.0).then(|| apart < EYE * extent(0).hypot(extent(1)))
    };
    let votes: Vec<bool> = people.iter().filter_map(is_near).collect();
    2 * votes.iter().filter(|vote| **vote).count() > votes.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(set: &KeypointSet) -> Person {
        let y = |name: &str| match name.trim_start_matches(['L', 'R']) {
            "Ankle" | "Heel" | "BigToe" | "SmallToe" => 400.0,
            "Knee" => 300.0,
            "Hip" => 200.0,
            "Shoulder" => 60.0,
            _ => 10.0,
        };
        let points = set.points().chain(std::iter::repeat("")).take(set.count);
        points.map(|name| [100.0, y(name), 0.9]).collect()
    }

    #[test]
    fn a_set_is_known_by_its_points_also_where_two_have_as_many() {
        for set in SETS {
            assert_eq!(KeypointSet::of_people(&[person(&set)]), Some(set));
            assert_eq!(KeypointSet::by_name(set.name), Some(set));
            assert!(set.points().count() <= set.count);
        }
        assert_eq!(KeypointSet::by_name("BODY_25B").unwrap().name, "body25b");
        assert_eq!(KeypointSet::of_people(&[vec![[0.0; 3]; 12]]), None);
        assert_eq!(KeypointSet::of_people(&[]), None);
    }
}
