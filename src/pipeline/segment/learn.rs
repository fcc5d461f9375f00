//! Masks and what is learned of them take turns.

use rayon::prelude::*;

use super::cut::Segmenter;
use super::subject;
use super::train::Training;
use super::view::View;
use crate::image::{Mixture, Picture, Plane};
use crate::silhouette::{Shrunk, Support};

impl Training {
    /// What the key frames teach: each camera's background and the person's colours, and where the person is.
    pub fn learn(self) -> Segmenter {
        // 1. the background as it is most of the time
        let mixtures: Vec<Mixture> = self.cameras.par_iter().map(|c| c.finished()).collect();
        let shrunk: Vec<Shrunk> = self.cameras.iter().map(|c| c.shrunk).collect();
        let views = shrunk.iter().zip(&mixtures);
        let mut segmenter = Segmenter {
            views: views
                .map(|(s, mixture)| View::new(mixture, (s.width, s.height)))
                .collect(),
            support: None,
            shrunk,
            options: self.options,
        };
        for round in 0..self.options.rounds {
            // 2. masks of the key frames, by what is known so far
            let masks: Vec<Vec<Option<Plane<u8>>>> = self
                .keys
                .par_iter()
                .map(|pictures| segmenter.key_masks(pictures))
                .collect();
            // 3. where the person is
            if round == 0 && self.rig.cameras.len() > 1 {
                let volume = subject::volume(&self.rig, &segmenter.shrunk, &masks);
                segmenter.support = volume.map(|volume| {
                    Support::new(&self.rig, &segmenter.shrunk, &volume, self.options.support)
                });
            }
            // 4. colours of the person, and what the background is without the person
            let options = self.options;
            segmenter
                .views
                .par_iter_mut()
                .enumerate()
                .for_each(|(c, view)| {
                    let keys: Vec<(&Picture, &Plane<u8>)> = self
                        .keys
                        .iter()
                        .zip(&masks)
                        .filter_map(|(pictures, masks)| {
                            Some((pictures.get(c)?.as_ref()?, masks.get(c)?.as_ref()?))
                        })
                        .collect();
                    view.learn(&mixtures[c], &keys, self.cameras[c].is_given(), &options);
                });
        }
        segmenter
    }
}
