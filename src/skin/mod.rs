//! The skin of a metaball body as one closed surface of triangles: the third layer of PFD99 § 3.1.
//!
//! 1. **Cross-sections.** The skin F = T is sampled along cross-sections of each limb, by rays from the limb's axis. The
//!    axis is rounded at the joints, so that the cross-sections of a bent knee or elbow do not cross.
//! 2. **Patches.** The samples are the control points of a B-spline patch: one for the trunk, one for each limb.
//! 3. **Triangles.** The patches are tessellated. A limb's first row *is* the rim of the hole that it grows out of, or
//!    half of the trunk's last row and the ridge between two legs, so there is no seam.
//!
//! | file         | holds                                                                       |
//! |--------------|-----------------------------------------------------------------------------|
//! | `plan.rs`    | which tubes there are: a trunk, and limbs that grow out of it                |
//! | `flesh.rs`   | the part of the field that a tube's skin belongs to; rays in it              |
//! | `axis.rs`    | a tube's axis, and where on it cross-sections stand                          |
//! | `section.rs` | one cross-section, sampled by rays                                           |
//! | `tube.rs`    | the samples of a tube from end to end                                        |
//! | `patch.rs`   | a B-spline surface: the patch of a tube                                      |
//! | `rim.rs`     | where a limb grows out of another tube                                       |
//! | `surface.rs` | patches to triangles                                                         |
//! | `mesh.rs`    | [`Mesh`], [`check_watertight`]                                               |
//! | `skinned.rs` | [`SkinnedMesh`]: a skin, and the parts that move it                           |
//! | `ellipsoids.rs` | of a body without metaballs: a mesh for each ellipsoid                    |
//! | `girth.rs`   | [`girths`]: how far it is around each limb                                  |
//!
//! **Differs** from PFD99 § 3.1: after the tessellation each vertex is moved onto F = T ([`Finish::Field`]; the paper's own is
//! [`Finish::Spline`]), and the sum that a ray sees is that of its limb (see [`BodyModel::limbs`]).
//!
//! [`BodyModel::limbs`]: crate::body::BodyModel::limbs

mod axis;
mod ellipsoids;
mod flesh;
mod girth;
mod mesh;
mod patch;
mod plan;
mod rim;
mod section;
mod skinned;
mod surface;
mod tube;

use nalgebra::Vector3;

use crate::body::Posed;
pub use ellipsoids::{ellipsoids, skinned_ellipsoids};
use flesh::{Flesh, TubeFlesh};
pub use girth::{Girth, girths};
pub use mesh::{Mesh, MeshFault, check_watertight};
use plan::Chain;
use rim::Rim;
pub use skinned::{BONES, SkinnedMesh, bind_pose, skinned};
use surface::{Grid, Surface};

/// Where the vertices of a skin stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finish {
    /// On the B-spline patches (PFD99 § 3.1), which round off what lies between samples by some millimetres.
    Spline,
    /// On F = T: moved there from the patches along ∇F, by 2 cm at most.
    Field,
}

/// How fine the triangles are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinOptions {
    /// Vertices around the trunk: even, 16 to 1024. Limbs have as many as the rim that they grow out of.
    pub around: usize,
    /// Vertices along a metre of skin, 20 to 2000.
    pub along_per_m: f64,
    /// Where the vertices stand.
    pub finish: Finish,
}

impl Default for SkinOptions {
    /// About 12 000 vertices for a person.
    fn default() -> Self {
        Self { around: 48, along_per_m: 60.0, finish: Finish::Field }
    }
}

impl SkinOptions {
    /// Vertices around the trunk, and as many along as make the triangles about as long as wide on a person.
    pub fn with_around(around: usize) -> Self {
        Self { around, along_per_m: 1.25 * around as f64, ..Self::default() }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SkinError::Around`] and [`SkinError::Along`].
    pub fn validate(&self) -> Result<(), SkinError> {
        if !(16..=1024).contains(&self.around) || !self.around.is_multiple_of(2) {
            return Err(SkinError::Around { found: self.around });
        }
        if !(20.0..=2000.0).contains(&self.along_per_m) {
            return Err(SkinError::Along { found: self.along_per_m });
        }
        Ok(())
    }
}

/// Why a body has no skin.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkinError {
    /// A number of vertices around that makes no surface.
    #[error("vertices around the trunk: expected an even number from 16 to 1024, found {found}")]
    Around {
        /// Found.
        found: usize,
    },
    /// A number of vertices along that makes no surface.
    #[error("vertices along a metre of skin: expected 20 to 2000, found {found}")]
    Along {
        /// Found.
        found: f64,
    },
    /// The body model has no metaballs.
    #[error(
        "body model {model} has no metaballs, and only they have one closed skin: add [[part.metaball]] to it, or use a model with metaballs"
    )]
    NoMetaballs {
        /// The model.
        model: String,
    },
    /// A pose that is not finite.
    #[error("part {part}: its position is not finite, so the pose cannot be used")]
    NotFinite {
        /// The part.
        part: String,
    },
    /// Parts whose flesh does not reach all along their axis.
    #[error(
        "{parts}: the sum of their metaballs does not reach 1/2 all along the axis, so there is no skin: make the metaballs larger or move them nearer to each other"
    )]
    Thin {
        /// `part` and its name, or `parts` and the names of first and last.
        parts: String,
    },
    /// A limb that finds no place on the tube that it grows out of.
    #[error(
        "part {part}: no room for it on the skin of {base}, beside another part or at its end: ask for more vertices around"
    )]
    NoRoom {
        /// First part of the limb.
        part: String,
        /// The part that it grows out of.
        base: String,
    },
}

/// The skin of a posed body.
///
/// Closed, with its triangles facing outwards: [`check_watertight`] passes, whatever the pose. Where limbs lie against each
/// other their skins may cross: each limb is sampled by itself.
///
/// # Errors
/// [`SkinError`] if the options are out of range, or the model's metaballs cannot have one closed skin.
///
/// # Source
/// PFD99 § 3.1.
pub fn skin(body: &Posed<'_>, options: &SkinOptions) -> Result<Mesh, SkinError> {
    options.validate()?;

    let model = body.model;
    let trunk =
        plan::plan(model).ok_or_else(|| SkinError::NoMetaballs { model: model.name.clone() })?;

    for (i, part) in model.parts.iter().enumerate() {
        let place = tube::origin(body, crate::body::PartId(i));
        if !place.iter().all(|x| x.is_finite()) {
            return Err(SkinError::NotFinite { part: part.name.clone() });
        }
    }

    let mut skinner = Skinner { body, options, surface: Surface::default() };
    skinner.trunk(&trunk)?;
    Ok(skinner.surface.mesh())
}

/// The tubes that are grown one after another, on one surface.
struct Skinner<'a> {
    body: &'a Posed<'a>,
    options: &'a SkinOptions,
    surface: Surface,
}

impl Skinner<'_> {
    fn trunk(&mut self, trunk: &Chain) -> Result<(), SkinError> {
        let flesh = Flesh::new(self.body, trunk);
        let tube = tube::trunk(self.body, trunk, &flesh, self.options.around)?;
        let all = TubeFlesh { own: &flesh, with_base: &flesh };
        let grid = self.surface.tessellate(&tube, None, all, self.options);
        let mut grid = grid.ok_or_else(|| tube::thin(self.body, trunk))?;

        // legs share the trunk's lower end
        if let Some(legs) = trunk.fork() {
            let rims = self.fork(&grid, legs, &flesh);
            let rims = rims.ok_or_else(|| self.no_room(legs[0]))?;
            for (leg, rim) in legs.into_iter().zip(rims) {
                self.limb(leg, &rim, &flesh)?;
            }
        }

        // the other limbs grow out of holes in its side
        let forked: Vec<_> = trunk.fork().into_iter().flatten().collect();
        let others = trunk.limbs.iter().filter(|limb| !forked.contains(limb));
        for limb in others {
            self.through_hole(limb, &mut grid, &flesh)?;
        }

        self.surface.close(&grid);
        Ok(())
    }

    /// The rims of two legs.
    fn fork(&mut self, grid: &Grid, legs: [&Chain; 2], trunk: &Flesh) -> Option<[Rim; 2]> {
        let roots = legs.map(|leg| tube::origin(self.body, leg.parts[0]));
        let middle: Vector3<f64> = (roots[0] + roots[1]) * 0.5;
        let whole =
            legs.iter().fold(trunk.clone(), |whole, leg| whole.with(&Flesh::new(self.body, leg)));
        let per_m = self.options.along_per_m;
        rim::fork(&mut self.surface, grid, &middle, trunk, &whole, per_m)
    }

    /// Cuts a hole for a limb, and grows it from there.
    fn through_hole(
        &mut self,
        limb: &Chain,
        grid: &mut Grid,
        base: &Flesh,
    ) -> Result<(), SkinError> {
        let root = tube::origin(self.body, limb.parts[0]);
        let radius = tube::root_radius(self.body, limb);
        let rim = rim::hole(&self.surface, grid, &root, radius);
        let rim = rim.ok_or_else(|| self.no_room(limb))?;
        self.limb(limb, &rim, base)
    }

    fn limb(&mut self, limb: &Chain, rim: &Rim, base: &Flesh) -> Result<(), SkinError> {
        let own = Flesh::new(self.body, limb);
        let flesh = TubeFlesh { own: &own, with_base: &own.with(base) };

        let points = self.surface.positions(&rim.vertices);
        let tube = tube::limb(self.body, limb, &points, rim.straight_on, flesh)?;
        let grid = self.surface.tessellate(&tube, Some(&rim.vertices), flesh, self.options);
        let mut grid = grid.ok_or_else(|| tube::thin(self.body, limb))?;

        for branch in &limb.limbs {
            self.through_hole(branch, &mut grid, &own)?;
        }
        self.surface.close(&grid);
        Ok(())
    }

    fn no_room(&self, limb: &Chain) -> SkinError {
        let name = |part: crate::body::PartId| self.body.model.parts[part.0].name.clone();
        SkinError::NoRoom {
            part: name(limb.parts[0]),
            base: limb.base.map(name).unwrap_or_default(),
        }
    }
}
