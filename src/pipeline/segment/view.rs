//! What one camera knows of the empty scene and of the person.

use super::SegmentOptions;
use super::figures::Told;
use crate::image::{
    Background, BackgroundPixel, ColourCount, Colours, Mixture, Mode, Picture, Plane, box_mean,
};

/// A mode that was there for less than this share of the time is not the empty scene.
const RARE: f32 = 0.03;
/// How sharply the odds of a background become trust.
const TRUST_SLOPE: f32 = 3.0;
/// Nothing is certain.
const LEAST_DOUBT: f32 = 1e-6;

/// What all other cameras' support of a colour counts, as a logarithm of odds.
const OTHERS: f32 = 3.0;
/// A colour shows a mode within so many standard deviations.
const MATCH: f32 = 2.5;

/// A key frame of one camera.
pub(super) struct Key<'a> {
    pub(super) picture: &'a Picture,
    pub(super) mask: &'a Plane<u8>,
    /// What the other cameras say; `None` if they say nothing.
    pub(super) support: Option<&'a Plane<f32>>,
    /// What detections say; `None` if they say nothing.
    pub(super) told: Option<&'a Told>,
}

/// The hue's σ never falls below this, grey levels: rounding, and the blur of hues by codecs.
const LEAST_HUE: f32 = 2.5;

/// What key frames tell of the person and of what is around.
struct KnownColours<'a> {
    keys: &'a [Key<'a>],
    /// 1 where the person ever was, or may always have been.
    ever: &'a Plane<f32>,
    /// Colours of the person.
    person: &'a Colours,
    /// Colours of the empty scene around the person.
    around: &'a Colours,
}

/// One camera's background and colours.
#[derive(Clone, Debug)]
pub(super) struct SegmentedView {
    pub(super) background: Background,
    /// σ of the hue over that of the brightness.
    hue_noise: f32,
    /// Colours of the person; `None` before there are masks.
    person: Option<Colours>,
    /// Colours of the empty scene around the person.
    around: Option<Colours>,
}

impl SegmentedView {
    /// The mode of largest ω/σ in each pixel, trusted.
    pub(super) fn new(mixture: &Mixture, size: (usize, usize), hue_noise: f32) -> Self {
        Self {
            background: choose(mixture, size, hue_noise, |mode, _, _| most_there(mode)),
            hue_noise,
            person: None,
            around: None,
        }
    }

    /// ln p(x | person) − ln p(x | empty) of each pixel, within ±`most_evidence`.
    pub(super) fn evidence(&self, picture: &Picture, options: &SegmentOptions) -> Plane<f32> {
        let any = -3.0 * 256_f32.ln();
        let most = options.most_evidence;
        let mut evidence = Plane::filled(picture.width(), picture.height(), 0.0);
        for y in 0..picture.height() {
            let pixels = picture.row(y).iter().zip(self.background.row(y));
            for (value, (colour, empty)) in evidence.row_mut(y).iter_mut().zip(pixels) {
                let person = self.person.as_ref().map_or(any, |p| p.log_density(*colour));
                let empty = empty.log_density(*colour, self.around.as_ref(), &options.shadow);
                *value = (person - empty).clamp(-most, most);
            }
        }
        evidence
    }

    /// Evidence with the prior that the support of so many other cameras is.
    ///
    /// Where they do not support a pixel it does not show the person. Where they do, it may: the others' lines of sight
    /// enclose more than the person. So they decide only as far as the background is not trusted.
    pub(super) fn supported(
        &self,
        own: &Plane<f32>,
        support: &Plane<f32>,
        others: usize,
        options: &SegmentOptions,
    ) -> Plane<f32> {
        let most = options.most_evidence;
        let (allowed, unknown) = (options.allowed_weight, options.unknown_weight);
        let against = options.against_weight * (0.5 * others as f32).min(1.0);

        let mut together = own.clone();
        for y in 0..own.height() {
            let pixels = support.row(y).iter().zip(self.background.row(y));
            for (sum, (support, empty)) in together.row_mut(y).iter_mut().zip(pixels) {
                let weight = match *support > 0.0 {
                    true => allowed.max(unknown * (1.0 - empty.trust)),
                    false => against,
                };
                *sum = (*sum + weight * support).clamp(-most, most);
            }
        }
        together
    }

    /// Learns colours from key frames and their masks, and chooses the background anew from a mixture, if there is one.
    pub(super) fn learn(
        &mut self,
        mixture: Option<&Mixture>,
        keys: &[Key<'_>],
        options: &SegmentOptions,
    ) {
        // the person's colours, and where the person ever was or may always have been
        let (width, height) = (self.background.width(), self.background.height());
        let mut person = ColourCount::default();
        let mut ever = Plane::filled(width, height, 0.0_f32);
        for key in keys {
            for y in 0..height {
                let pixels = key.picture.row(y).iter().zip(key.mask.row(y));
                for (here, (colour, is_person)) in ever.row_mut(y).iter_mut().zip(pixels) {
                    if *is_person == 1 {
                        person.add(*colour);
                        *here = 1.0;
                    }
                }
            }
        }
        if person.total() < 1.0 {
            return;
        }
        add_always(keys, &mut ever);

        // with them the background, chosen anew
        let person = person.density();
        if let Some(mixture) = mixture {
            let around = self.colours_around(&ever);
            let known = KnownColours { keys, ever: &ever, person: &person, around: &around };
            self.choose_again(mixture, &known, options.background_odds);
            self.around = Some(around);
        }
        self.person = Some(person);
    }

    /// Colours of the empty scene near where the person ever was.
    fn colours_around(&self, ever: &Plane<f32>) -> Colours {
        let reach = (ever.width() + ever.height()) / 37 + 1;
        let near = box_mean(ever, reach);
        let mut around = ColourCount::default();
        for y in 0..ever.height() {
            for (x, empty) in self.background.row(y).iter().enumerate() {
                if near.row(y)[x] > 0.0 && ever.row(y)[x] < 0.5 {
                    around.add(byte_colour(&empty.mean));
                }
            }
        }
        around.density()
    }

    /// Where the person ever was: the mode that was there most and is least like the person; and how far it can be trusted.
    fn choose_again(&mut self, mixture: &Mixture, known: &KnownColours<'_>, odds: f32) {
        let KnownColours { keys, ever, person, around } = *known;

        let size = (ever.width(), ever.height());
        let near = box_mean(ever, 2 + (size.0 + size.1) / 750);
        let is_near = |x: usize, y: usize| near.row(y)[x] > 0.0;
        let unlike = |mean: &[f32; 3]| {
            let colour = byte_colour(mean);
            around.log_density(colour) - person.log_density(colour)
        };

        self.background = choose(mixture, size, self.hue_noise, |mode, x, y| {
            if !is_near(x, y) {
                most_there(mode)
            } else if mode.weight < RARE {
                f32::NEG_INFINITY
            } else {
                mode.weight.ln() + unlike(&mode.mean) - others(keys, mode, x, y)
            }
        });

        // the odds that what was chosen is the empty scene
        let mut sure = Plane::filled(size.0, size.1, 0.0_f32);
        for y in 0..size.1 {
            let pixels = sure.row_mut(y).iter_mut().zip(self.background.row(y));
            for (x, (sure, empty)) in pixels.enumerate() {
                let mode = mode_of(empty);
                *sure = odds + mode.weight.max(1e-6).ln() + unlike(&mode.mean);
                if is_near(x, y) {
                    *sure -= others(keys, &mode, x, y);
                }
            }
        }

        // and so how far it is trusted
        let sure = box_mean(&sure, 1);
        for y in 0..size.1 {
            for (x, empty) in self.background.row_mut(y).iter_mut().enumerate() {
                let trust = 1.0 / (1.0 + (-TRUST_SLOPE * sure.row(y)[x]).exp());
                empty.trust =
                    if is_near(x, y) { trust.clamp(LEAST_DOUBT, 1.0 - LEAST_DOUBT) } else { 1.0 };
            }
        }
    }
}

/// Adds where the person may have been in all key frames that tell: there the most frequent colour need not be the empty scene's.
fn add_always(keys: &[Key<'_>], ever: &mut Plane<f32>) {
    let told: Vec<&Told> = keys.iter().filter_map(|key| key.told).collect();
    if told.is_empty() {
        return;
    }
    for y in 0..ever.height() {
        for (x, here) in ever.row_mut(y).iter_mut().enumerate() {
            if told.iter().all(|told| told.is_about(x, y)) {
                *here = 1.0;
            }
        }
    }
}

/// ω/σ.
fn most_there(mode: &Mode) -> f32 {
    mode.weight / mode.variance.sqrt()
}

/// The mode that [`choose`] made this of.
fn mode_of(empty: &BackgroundPixel) -> Mode {
    Mode {
        weight: empty.trust,
        variance: (empty.along * empty.along + 2.0 * empty.across * empty.across) / 3.0,
        mean: empty.mean,
    }
}

/// How much the other cameras speak against a mode as the empty scene, within ±[`OTHERS`].
///
/// The empty scene is seen when the person is elsewhere: then the others do not support the pixel. A colour that is seen
/// when they do is the person's.
fn others(keys: &[Key<'_>], mode: &Mode, x: usize, y: usize) -> f32 {
    let gate = 3.0 * MATCH * MATCH * mode.variance;
    let (mut shown, mut supported) = (0.0, 0.0);
    for key in keys {
        let (Some(support), Some(colour)) = (key.support, key.picture.get(x, y)) else {
            continue;
        };
        let offset = [0, 1, 2].map(|i| f32::from(colour[i]) - mode.mean[i]);
        if offset.iter().map(|d| d * d).sum::<f32>() < gate {
            shown += 1.0;
            supported += support.row(y)[x];
        }
    }
    OTHERS * supported / (shown + 1.0)
}

/// The mode of largest score in each pixel, with its weight for its trust.
fn choose(
    mixture: &Mixture,
    (width, height): (usize, usize),
    hue_noise: f32,
    score: impl Fn(&Mode, usize, usize) -> f32,
) -> Background {
    let nothing = BackgroundPixel { mean: [0.0; 3], along: 1.0, across: 1.0, trust: 0.0 };
    let mut background = Plane::filled(width, height, nothing);
    for y in 0..height {
        for (x, empty) in background.row_mut(y).iter_mut().enumerate() {
            let modes = (0..mixture.modes()).map(|k| mixture.mode(k, x, y));
            let scored = modes.map(|mode| (score(&mode, x, y), mode));
            let best = scored.reduce(|best, next| if next.0 > best.0 { next } else { best });
            let Some((_, mode)) = best else { continue };
            // σ² of the mode is the mean of three directions
            let along = (3.0 * mode.variance / (1.0 + 2.0 * hue_noise * hue_noise)).sqrt();
            *empty = BackgroundPixel {
                mean: mode.mean,
                along,
                across: (hue_noise * along).max(LEAST_HUE),
                trust: mode.weight,
            };
        }
    }
    background
}

fn byte_colour(mean: &[f32; 3]) -> [u8; 3] {
    // a float becomes the nearest byte that there is
    mean.map(|value| value.round() as u8)
}
