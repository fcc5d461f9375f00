//! Of two motions of each frame the most probable sequence.

use std::collections::BTreeMap;

use crate::inference::frame::FrameFit;
use crate::inference::propagate::Tracking;
use crate::inference::step::StepPrior;

/// Two motions in some frames, one in the others.
pub(super) struct Choices<'a> {
    pub(super) tracking: &'a Tracking<'a>,
    /// The winner's.
    pub(super) own: Vec<&'a FrameFit>,
    /// The others'.
    pub(super) others: BTreeMap<usize, FrameFit>,
}

impl Choices<'_> {
    /// The motions of a frame: the winner's, and the others'.
    fn of(&self, i: usize) -> impl Iterator<Item = &FrameFit> {
        [self.own[i]].into_iter().chain(self.others.get(&i))
    }

    /// −log p of the step between the motions of two frames.
    fn step(&self, (from, before): (usize, &FrameFit), (to, after): (usize, &FrameFit)) -> f64 {
        let Tracking { evidence, sequence, .. } = *self.tracking;
        let interval_s = sequence.frames_between(from, to) / sequence.fps;
        StepPrior::new(evidence.model, interval_s).cost(&before.motion, &after.motion)
    }

    /// The most probable sequence of the motions in frames that show something (Viterbi); the winner's in others.
    pub(super) fn most_probable(&self) -> Vec<FrameFit> {
        // the least cost of the way to each motion, and by which one before it
        let shown = (0..self.own.len()).filter(|i| self.own[*i].observations > 0.0);
        let mut ways: Vec<(usize, Vec<(f64, usize)>)> = Vec::new();
        for i in shown {
            let way_to = |fit: &FrameFit| {
                let Some((last, costs)) = ways.last() else {
                    return (fit.alone(), 0);
                };
                let from = self.of(*last).zip(costs).enumerate();
                let ways = from.map(|(c, (before, (cost, _)))| {
                    (cost + self.step((*last, before), (i, fit)) + fit.alone(), c)
                });
                ways.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
            };
            let to: Vec<(f64, usize)> = self.of(i).map(way_to).collect();
            ways.push((i, to));
        }

        // back along the least
        let mut frames: Vec<FrameFit> = self.own.iter().map(|fit| (*fit).clone()).collect();
        let least = |costs: &[(f64, usize)]| {
            (0..costs.len()).min_by(|a, b| costs[*a].0.total_cmp(&costs[*b].0)).unwrap_or(0)
        };
        let mut choice = ways.last().map_or(0, |(_, costs)| least(costs));
        for (i, costs) in ways.iter().rev() {
            frames[*i] = self.of(*i).nth(choice).unwrap_or(self.own[*i]).clone();
            choice = costs[choice].1;
        }
        frames
    }

    /// The frames with what their steps away from the keyframe cost; those that show nothing keep the last motion that was seen.
    pub(super) fn with_steps(
        &self,
        mut frames: Vec<FrameFit>,
        keyframe: usize,
    ) -> Vec<Option<FrameFit>> {
        frames[keyframe].step = 0.0;
        let ahead = keyframe + 1..frames.len();
        for side in [ahead.collect::<Vec<usize>>(), (0..keyframe).rev().collect()] {
            let mut last = keyframe;
            for i in side {
                if frames[i].observations > 0.0 {
                    frames[i].step = self.step((last, &frames[last]), (i, &frames[i]));
                    last = i;
                } else {
                    let pose_prior = &self.tracking.evidence.pose_prior;
                    frames[i] = FrameFit::held(pose_prior, frames[last].motion.clone());
                }
            }
        }
        frames.into_iter().map(Some).collect()
    }
}
