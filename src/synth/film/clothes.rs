//! A dressed person: a skin that bones move, with cloth tied to it.

use rand::Rng;

use super::texture::{Colour, Texture};
use crate::body::{BodyModel, Shape};
use crate::skin::SkinError;
use crate::synth::bound_skin::BoundSkin;
use crate::synth::worn::{SKIN, ZONES, zones};

/// A person's skin, and what is worn where.
#[derive(Debug, Clone)]
pub(super) struct DressedPerson {
    pub(super) bound: BoundSkin,
    /// Share of each zone in each vertex.
    zones: Vec<[f32; ZONES]>,
    textures: [Texture; ZONES],
}

impl DressedPerson {
    /// Textures drawn for a body.
    ///
    /// # Errors
    /// [`SkinError`] if the body cannot have a skin.
    pub(super) fn random(
        model: &BodyModel,
        shape: &Shape,
        rng: &mut impl Rng,
    ) -> Result<Self, SkinError> {
        let bound = BoundSkin::new(model, shape)?;
        let zones = zones(model, &bound.skin);

        let textures = [
            Texture::printed(rng),
            Texture::printed(rng),
            Texture::plain([0.72, 0.52, 0.42], 0.15, rng),
            Texture::plain([0.22, 0.2, 0.2], 0.5, rng),
            Texture::plain([0.2, 0.14, 0.1], 0.5, rng),
        ];

        Ok(Self { bound, zones, textures })
    }

    /// The colour at a place on a triangle.
    pub(super) fn colour(
        &self,
        triangle: [u32; 3],
        mix: impl Fn([[f32; 8]; 3]) -> [f32; 8],
    ) -> Colour {
        let corner = |i: u32| {
            let place = self.bound.skin.mesh.vertices[i as usize].cast::<f32>();
            let zones = self.zones[i as usize];
            std::array::from_fn(|k| if k < 3 { place[k] } else { zones[k - 3] })
        };
        let at = mix(triangle.map(corner));
        let worn = (0..ZONES).max_by(|a, b| at[3 + a].total_cmp(&at[3 + b]));
        self.textures[worn.unwrap_or(SKIN)].at([at[0], at[1], at[2]])
    }
}
