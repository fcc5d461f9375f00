//! Several frames of a recording looked at at once.

use rayon::prelude::*;

use crate::image::Picture;
use crate::pipeline::{PictureSource, Progress, span};
use crate::silhouette::FrameIndex;

/// Looks at some frames (ascending), as many at once as there are threads, and hands what was seen to `take` in their order.
///
/// # Errors
/// Whatever `take` fails with.
pub(super) fn each_frame<T: Send, E>(
    source: &(impl PictureSource + ?Sized),
    frames: &[FrameIndex],
    (stage, progress): (&'static str, &dyn Progress),
    look: impl Fn(FrameIndex, &[Option<Picture>]) -> T + Sync,
    mut take: impl FnMut(FrameIndex, &[Option<Picture>], T) -> Result<(), E>,
) -> Result<(), E> {
    let is_asked = |frame: &FrameIndex| frames.binary_search(frame).is_ok();
    let mut pictures = source.pictures(span(frames)).filter(|(frame, _)| is_asked(frame));

    progress.begin(stage, frames.len());
    loop {
        let abreast: Vec<_> = pictures.by_ref().take(rayon::current_num_threads()).collect();
        if abreast.is_empty() {
            break;
        }

        let looks = abreast.par_iter().map(|(frame, shown)| look(*frame, shown));
        let seen: Vec<T> = looks.collect();
        for ((frame, shown), seen) in abreast.iter().zip(seen) {
            take(*frame, shown, seen)?;
            progress.step();
        }
    }
    progress.end();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{MemoryPictures, NoProgress};

    /// What is taken of some frames of a recording of nine, until frame `last`.
    fn taken(asked: &[usize], last: usize) -> (Vec<usize>, Result<(), usize>) {
        let frames = (0..9).map(|frame| (FrameIndex(frame), Vec::new())).collect();
        let source = MemoryPictures { frames, ..MemoryPictures::default() };
        let asked: Vec<FrameIndex> = asked.iter().copied().map(FrameIndex).collect();
        let mut taken = Vec::new();
        let look = |frame: FrameIndex, _: &[Option<Picture>]| 10 * frame.0;
        let done = each_frame(&source, &asked, ("test", &NoProgress), look, |frame, _, seen| {
            taken.push(seen);
            if frame.0 == last { Err(seen) } else { Ok(()) }
        });
        (taken, done)
    }

    #[test]
    fn the_frames_that_are_asked_for_are_taken_in_their_order() {
        let asked = [1, 2, 3, 5, 6, 7, 8];
        assert_eq!(taken(&asked, 9), (vec![10, 20, 30, 50, 60, 70, 80], Ok(())));
        assert_eq!(taken(&[], 9), (vec![], Ok(())));
    }

    #[test]
    fn a_frame_that_cannot_be_taken_ends_it() {
        assert_eq!(taken(&[0, 4, 5], 4), (vec![0, 40], Err(40)));
    }
}
