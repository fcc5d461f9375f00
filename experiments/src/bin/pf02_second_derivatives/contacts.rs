//! The contact of a line of sight: searched once and held, moved by second derivatives, or searched again and again.
//!
//! PF02 searches the contact x once, "along the line of sight", and then lets it move with the state: x ← x + r dt with
//! dt = −(r·∇ ln F)/(rᵀ∇² ln F r), which is App. A.4 and A.5 in one Newton step. Without second derivatives nothing says how
//! far to go, so x stays. The residual is T − F at x, in least squares; contacts are renewed after every few steps.

use experiments::limb::{LimbFit, three_cameras};
use experiments::run::Run;
use experiments::table::Table;
use maquette::body::metaball::{Field, FieldSample};
use maquette::body::{BodyModel, Posed, State};
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::likelihood::{
    PointField, PointOptions, PointResidual, RayOptions, Residual, SilhouetteRays, SkinScale,
    Source, SurfacePoint, Term,
};
use maquette::solver::{Loss, Problem};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::{Draw, NEAR};

/// Steps between two renewals of the contacts, and renewals.
const STEPS: usize = 3;
const RENEWALS: usize = 40;
/// Farther than this a Newton step is not believed, metres.
const FARTHEST_STEP: f64 = 0.05;

/// What becomes of a contact when the body has moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Renewal {
    Held,
    Moved,
    Searched,
}

const RENEWAL: [(Renewal, &str, &str); 3] = [
    (Renewal::Held, "held", "searched once, held"),
    (Renewal::Moved, "moved", "searched once, moved by second derivatives"),
    (Renewal::Searched, "searched", "searched at every renewal"),
];

type Starts = fn(&Draw) -> &[State];
const STARTS: [(&str, &str, Starts); 2] = [
    ("far", "up to 15 cm and 40° off", |draw| &draw.starts),
    ("near", "up to 3 cm and 10° off", |draw| &draw.near_starts),
];

/// A line of sight and where it touches.
#[derive(Debug, Clone, Copy)]
struct Contact {
    origin_world: Point3<f64>,
    place_world: Point3<f64>,
}

/// Fits every start with each renewal, and keeps what share arrives.
pub(crate) fn compare(run: &mut Run, arm: &BodyModel, draws: &[Draw]) -> Table {
    let columns = ["starts", "contacts", "in the basin, %", "at the optimum, %"];
    let mut table = Table::new("contacts", &columns);
    for (which, title, starts) in STARTS {
        let ends: Vec<Vec<[f64; 3]>> =
            draws.par_iter().map(|draw| ends(arm, draw, starts(draw))).collect();
        for (k, (_, name, renewal)) in RENEWAL.iter().enumerate() {
            let [basin, exact] = NEAR.map(|near| share(&ends, k, near));
            run.number(format!("contact_{name}_{which}_in_basin_pct"), basin);
            run.number(format!("contact_{name}_{which}_at_optimum_pct"), exact);
            let figures = [basin, exact].map(|v| format!("{v:.1}"));
            let titles = [title.to_owned(), (*renewal).to_owned()];
            table.row(titles.into_iter().chain(figures));
        }
    }
    table
}

/// Of an arm's starts, the cost at which each renewal ends; the optimum is the least of all, also from the right start.
fn ends(arm: &BodyModel, draw: &Draw, starts: &[State]) -> Vec<[f64; 3]> {
    let fit = ContactFit::new(arm, draw);
    let least = fit.end(&draw.near, Renewal::Searched);
    let all = starts.iter().map(|start| RENEWAL.map(|(renewal, _, _)| fit.end(start, renewal)));
    let all: Vec<[f64; 3]> = all.collect();
    let least = all.iter().flatten().copied().fold(least, f64::min);
    all.iter().map(|costs| costs.map(|cost| cost / least)).collect()
}

fn share(ends: &[Vec<[f64; 3]>], renewal: usize, near: f64) -> f64 {
    let all = ends.iter().flatten();
    let arrived = all.clone().filter(|costs| costs[renewal] <= 1.0 + near).count();
    100.0 * arrived as f64 / all.count().max(1) as f64
}

struct ContactFit<'a> {
    arm: &'a BodyModel,
    priors: (ShapePrior, PosePrior),
    rays: SilhouetteRays,
    centres: Vec<Point3<f64>>,
}

impl<'a> ContactFit<'a> {
    fn new(arm: &'a BodyModel, draw: &Draw) -> Self {
        let options = RayOptions { residual: Residual::Field, ..RayOptions::default() };
        Self {
            arm,
            priors: (ShapePrior::new(arm), PosePrior::new(arm)),
            rays: SilhouetteRays::new(draw.views.clone(), options, SkinScale::new(arm)),
            centres: three_cameras().cameras.iter().map(|c| c.centre_world()).collect(),
        }
    }

    /// The cost, with contacts that are searched, where a fit ends.
    fn end(&self, start: &State, renewal: Renewal) -> f64 {
        let mut state = start.clone();
        let mut contacts = self.searched(&state);
        for _ in 0..RENEWALS {
            let terms = self.terms(&contacts);
            let fit = LimbFit::new(self.arm, (&self.priors.0, &self.priors.1), &terms);
            state = fit.solve(state, STEPS).state;
            match renewal {
                Renewal::Held => {}
                Renewal::Moved => self.move_along(&mut contacts, &state),
                Renewal::Searched => contacts = self.searched(&state),
            }
        }
        let terms = self.terms(&self.searched(&state));
        LimbFit::new(self.arm, (&self.priors.0, &self.priors.1), &terms).cost(&state)
    }

    fn searched(&self, state: &State) -> Vec<Contact> {
        let body = Posed::new(self.arm, &state.shape, &state.motion);
        let touches = self.rays.residuals(&body);
        let contact = |touch: &maquette::likelihood::SkinTouch| match touch.source {
            Source::View(view) => Some(Contact {
                origin_world: *self.centres.get(view)?,
                place_world: touch.place_world,
            }),
            _ => None,
        };
        touches.iter().filter_map(contact).collect()
    }

    /// One Newton step of each contact towards the largest F on its line.
    fn move_along(&self, contacts: &mut [Contact], state: &State) {
        let body = Posed::new(self.arm, &state.shape, &state.motion);
        let field = Field::from_body(&body);
        let mut sample = FieldSample::default();
        for contact in contacts {
            let way = contact.place_world - contact.origin_world;
            let Some(line) = way.try_normalize(1e-9) else { continue };
            if sample.update(&field, &contact.place_world.coords) {
                contact.place_world += line * newton_step(&field, &sample, &line);
            }
        }
    }

    fn terms(&self, contacts: &[Contact]) -> Vec<Box<dyn Term>> {
        let point = |c: &Contact| SurfacePoint::isotropic(c.place_world, 0.0);
        let options = PointOptions {
            residual: PointResidual::Field,
            correlation_m: 0.0,
            loss: Loss::Squared,
            ..PointOptions::default()
        };
        let points = contacts.iter().map(point).collect();
        vec![Box::new(PointField::new(points, options, SkinScale::new(self.arm)))]
    }
}

/// Where ln F has no summit near on the line the contact stays.
fn newton_step(field: &Field, sample: &FieldSample, line: &Vector3<f64>) -> f64 {
    let slope = line.dot(&sample.log_gradient);
    let bend = line.dot(&(sample.log_hessian(field) * line));
    if bend < 0.0 { (-slope / bend).clamp(-FARTHEST_STEP, FARTHEST_STEP) } else { 0.0 }
}
