//! What is seen of one body: by all cameras at once, or by one whose place or clock is an unknown.

use rayon::prelude::*;

use super::camera_prior::CameraPrior;
use super::detail::Detail;
use super::evidence::{Evidence, Terms};
use super::hull;
use super::sequence::Sequence;
use crate::body::Posed;
use crate::likelihood::{PlacedResidual, Source};
use crate::silhouette::FrameObservations;

/// Terms of −log p(Zᵢ | mᵢ, s) that one place and one moment of the body explain.
pub struct Look<'f> {
    /// The camera, if its place or its clock is an unknown: its position in the rig.
    pub camera: Option<usize>,
    /// What kind of data it shows: each errs in its own way.
    pub kind: Kind,
    /// What it shows.
    pub terms: Terms<'f>,
}

/// A kind of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Outlines.
    Outlines,
    /// Points of the surface.
    Points,
    /// Detections of joints.
    Keypoints,
}

impl Kind {
    /// The kind of what comes from a source.
    pub(super) fn of(source: Source) -> Self {
        match source {
            Source::View(_) => Self::Outlines,
            Source::Cloud => Self::Points,
            Source::Keypoint { .. } => Self::Keypoints,
        }
    }
}

/// What every frame of a sequence shows.
pub struct SequenceTerms<'f> {
    /// A part of it, to approach an optimum.
    pub thinned: Vec<Vec<Look<'f>>>,
    /// All of it, to measure.
    pub all: Vec<Vec<Look<'f>>>,
    /// What of the cameras is unknown.
    pub camera_prior: CameraPrior,
}

impl<'f> Look<'f> {
    /// By cameras that are trusted.
    fn of_all(kind: Kind, terms: Terms<'f>) -> Self {
        Self { camera: None, kind, terms }
    }
}

/// What every frame shows that tells what it shows.
pub(super) struct ClearLooks<'f> {
    pub(super) looks: Vec<Vec<Look<'f>>>,
    pub(super) residuals: Vec<Vec<PlacedResidual>>,
}

impl<'f> ClearLooks<'f> {
    /// Of looks, frame by frame; `bodies` are as each sees them.
    pub(super) fn new(looks: &[Vec<&'f Look<'_>>], bodies: &[Posed<'_>]) -> Self {
        let all: Vec<&'f Look<'_>> = looks.iter().flatten().copied().collect();
        let clear = all.par_iter().zip(bodies).map(|(look, body)| look.clear(body));
        let mut clear = clear.collect::<Vec<_>>().into_iter();
        let frame = |looks: &Vec<&Look<'_>>| {
            let (looks, residuals): (_, Vec<_>) = clear.by_ref().take(looks.len()).unzip();
            (looks, residuals.concat())
        };
        let (looks, residuals) = looks.iter().map(frame).unzip();
        Self { looks, residuals }
    }
}

impl Look<'_> {
    /// The same of the data that tell what they show at a pose, and their residuals.
    fn clear(&self, body: &Posed<'_>) -> (Look<'_>, Vec<PlacedResidual>) {
        let (mut terms, mut residuals): (Terms<'_>, Vec<_>) = (Vec::new(), Vec::new());
        for term in &self.terms {
            let clear = term.clear(body);
            terms.push(clear.term.unwrap_or_else(|| Box::new(&**term)));
            residuals.extend(clear.residuals.into_iter().map(|r| self.named(r)));
        }
        (Look { camera: self.camera, kind: self.kind, terms }, residuals)
    }

    /// A residual with the name of its source: a look of one camera counts its views from 0.
    fn named(&self, residual: PlacedResidual) -> PlacedResidual {
        let source = match (self.camera, residual.source) {
            (Some(camera), Source::View(_)) => Source::View(camera),
            (Some(camera), Source::Keypoint { keypoint, .. }) => {
                Source::Keypoint { camera, keypoint }
            }
            (_, own) => own,
        };
        PlacedResidual { source, ..residual }
    }

    fn shows_any(&self) -> bool {
        !self.terms.is_empty()
    }
}

impl Evidence<'_> {
    /// The terms of every frame of a sequence: of all cameras together, or camera by camera where something of them is unknown.
    pub fn sequence_terms<'f>(
        &self,
        sequence: Sequence<'f>,
        camera_prior: CameraPrior,
    ) -> SequenceTerms<'f> {
        let looks = |detail: Detail| {
            let frames = sequence.frames.par_iter();
            let looks = |frame| match camera_prior.is_trusting() {
                true => self.looks_of_all(frame, detail),
                false => self.looks(frame, detail),
            };
            frames.map(looks).collect()
        };
        SequenceTerms { thinned: looks(Detail::Thinned), all: looks(Detail::Fine), camera_prior }
    }

    /// What a frame shows before cameras that are trusted: one look for each kind.
    pub fn looks_of_all<'f>(&self, frame: &'f FrameObservations, detail: Detail) -> Vec<Look<'f>> {
        let subject = hull::subject(self.rig, frame);
        let looks = [
            Look::of_all(Kind::Outlines, self.terms_of_views(&frame.views, subject, detail)),
            Look::of_all(Kind::Points, self.terms_of_points(frame, detail)),
            Look::of_all(Kind::Keypoints, self.terms_of_detections(&frame.detections, subject)),
        ];
        looks.into_iter().filter(Look::shows_any).collect()
    }

    /// One look at the outlines and one at the detections of each camera, and one at the points.
    pub(crate) fn looks<'f>(&self, frame: &'f FrameObservations, detail: Detail) -> Vec<Look<'f>> {
        let subject = hull::subject(self.rig, frame);
        let views = frame.views.iter().zip(self.view_terms(frame, detail));
        let views =
            views.map(|((id, _), terms)| Look { camera: Some(id.0), kind: Kind::Outlines, terms });
        let detected = frame.detections.iter().map(|seen| Look {
            camera: Some(seen.0.0),
            kind: Kind::Keypoints,
            terms: self.terms_of_detections(std::slice::from_ref(seen), subject),
        });
        let points = Look::of_all(Kind::Points, self.terms_of_points(frame, detail));
        views.chain(detected).chain([points]).filter(Look::shows_any).collect()
    }

    /// The terms of each view of a frame.
    pub(crate) fn view_terms<'f>(
        &self,
        frame: &'f FrameObservations,
        detail: Detail,
    ) -> Vec<Terms<'f>> {
        let subject = hull::subject(self.rig, frame);
        let views = frame.views.chunks(1);
        views.map(|view| self.terms_of_views(view, subject, detail)).collect()
    }
}

impl std::fmt::Debug for Look<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Look(camera {:?}, {} terms)", self.camera, self.terms.len())
    }
}

impl std::fmt::Debug for SequenceTerms<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SequenceTerms({} frames)", self.all.len())
    }
}
