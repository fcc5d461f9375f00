//! Masks and what is learned of them take turns.

use rayon::prelude::*;

use super::cut::{KeyMasks, Segmenter};
use super::subject;
use super::train::Training;
use super::view::{Key, SegmentedView};
use crate::image::{Mixture, Picture};
use crate::silhouette::{ShrunkSize, Support};

impl Training {
    /// What the key frames teach: each camera's background and the person's colours, and where the person is.
    pub fn learn(self) -> Segmenter {
        // 1. the background as it is most of the time
        let mixtures: Vec<Mixture> = self.cameras.par_iter().map(|c| c.finished()).collect();
        let shrunk: Vec<ShrunkSize> = self.cameras.iter().map(|c| c.shrunk).collect();
        let views = shrunk.iter().zip(&mixtures).zip(&self.cameras);
        let mut segmenter = Segmenter {
            views: views
                .map(|((s, mixture), c)| {
                    SegmentedView::new(mixture, (s.width, s.height), c.hue_noise)
                })
                .collect(),
            support: None,
            shrunk,
            figures: self.figures.clone(),
            options: self.options,
        };
        for round in 0..self.options.rounds {
            // 2. masks of the key frames, by what is known so far
            let found: Vec<KeyMasks> =
                self.keys.par_iter().map(|(frame, p)| segmenter.key_masks(*frame, p)).collect();
            // 3. where the person is
            if round == 0 && self.rig.cameras.len() > 1 {
                let masks = found.iter().map(|key| key.masks.as_slice());
                let by_masks = || subject::volume(&self.rig, &segmenter.shrunk, masks);
                let volume = segmenter.figures.volume().or_else(by_masks);
                segmenter.support = volume.map(|volume| {
                    Support::new(&self.rig, &segmenter.shrunk, &volume, self.options.support)
                });
            }
            // 4. colours of the person, and what the background is without the person
            let options = self.options;
            segmenter.views.par_iter_mut().enumerate().for_each(|(c, view)| {
                // pictures of the empty scene are believed
                let choice = Some(&mixtures[c]).filter(|_| !self.cameras[c].is_given());
                view.learn(choice, &self.keys_of(c, &found), &options);
            });
        }
        segmenter
    }

    /// The key frames of a camera: pictures, masks, and what the other cameras say.
    fn keys_of<'a>(&'a self, camera: usize, found: &'a [KeyMasks]) -> Vec<Key<'a>> {
        let key = |((_, pictures), found): (&'a (_, Vec<Option<Picture>>), &'a KeyMasks)| {
            Some(Key {
                picture: pictures.get(camera)?.as_ref()?,
                mask: found.masks.get(camera)?.as_ref()?,
                support: found.support.get(camera).and_then(Option::as_ref),
                told: found.told.get(camera).and_then(Option::as_ref),
            })
        };
        self.keys.iter().zip(found).filter_map(key).collect()
    }
}
