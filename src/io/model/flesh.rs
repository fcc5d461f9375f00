//! Flesh: the primitives of a part, and frames for those that turn by a share of a joint's angles.
//!
//! Skin near a joint is tied to both of its bones, and turns by less than the part that it belongs to: its frame is the
//! part's with smaller angles.

use nalgebra::Vector3;

use super::ModelFileError;
use super::build::Builder;
use super::side::Side;
use super::spec::{PartSpec, PrimitiveSpec};
use crate::body::{FrameId, ModelError, PartId, Primitive, Turn};

/// The part that flesh belongs to.
#[derive(Clone, Copy)]
struct Owner<'a> {
    spec: &'a PartSpec,
    part: PartId,
    side: Side,
}

/// The frames that one part's flesh has so far, by share.
type Frames = Vec<(f64, FrameId)>;

impl Builder<'_> {
    /// The primitives of a part; all joints are there.
    pub(super) fn flesh(
        &mut self,
        spec: &PartSpec,
        part: PartId,
        side: Side,
    ) -> Result<(), ModelFileError> {
        let owner = Owner { spec, part, side };
        let mut frames = Vec::new();
        for primitive in &spec.ellipsoids {
            let made = self.primitive(primitive, owner, &mut frames)?;
            self.model.ellipsoids.push(made);
        }
        for primitive in &spec.metaballs {
            let made = self.primitive(primitive, owner, &mut frames)?;
            self.model.metaballs.push(made);
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        spec: &PrimitiveSpec,
        owner: Owner<'_>,
        frames: &mut Frames,
    ) -> Result<Primitive, ModelFileError> {
        let Owner { part, side, .. } = owner;
        let place = format!("a primitive of part {}", owner.spec.name);
        let centre_scale = spec.centre_scale.as_ref().or(Some(&owner.spec.scale));
        let radii_scale = spec.radii_scale.as_ref().or(Some(&owner.spec.scale));

        let mut centre = self.scaled(side.place(spec.centre), centre_scale, side, &place)?;
        centre.shifts.extend(&self.carried[part.0]);
        Ok(Primitive {
            part,
            frame: self.frame_following(spec.follows, owner, frames)?,
            centre,
            home: Vector3::zeros(),
            radii: self.scaled(Vector3::from(spec.radii), radii_scale, side, &place)?,
            part_from_primitive: side.turn(spec.turn_deg),
        })
    }

    /// The frame that turns by a share of what the part's own joints turn; those that are not there yet are made.
    fn frame_following(
        &mut self,
        share: f64,
        owner: Owner<'_>,
        frames: &mut Frames,
    ) -> Result<FrameId, ModelFileError> {
        if !(0.0..=1.0).contains(&share) {
            let place = format!("follows of part {}", owner.spec.name);
            let value = share;
            return Err(self.fault(ModelError::Number { place, value }));
        }

        let mut frame = FrameId::from_joint(self.model.parts[owner.part.0].joint);
        if share.total_cmp(&1.0).is_eq() {
            return Ok(frame);
        }
        if let Some((_, made)) = frames.iter().find(|(s, _)| s.total_cmp(&share).is_eq()) {
            return Ok(*made);
        }

        // the part's own turns once more, each by the share
        let path = self.model.path(frame).take(owner.spec.joints.len());
        let own: Vec<Turn> = path.map(|(_, turn)| turn).collect();
        if let Some(first) = own.last() {
            frame = first.parent;
        }
        for turn in own.into_iter().rev() {
            let parent = frame;
            frame = FrameId(self.model.frames());
            let turn = Turn { parent, share, ..turn };
            self.model.followers.push(turn);
        }

        frames.push((share, frame));
        Ok(frame)
    }
}
