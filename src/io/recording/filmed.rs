//! A recording of photographs as a folder, with its truth.
//!
//! | file                            | content                                                          |
//! |---------------------------------|------------------------------------------------------------------|
//! | `sequence.toml`                 | manifest; it names neither masks nor pictures of the empty room   |
//! | `calibration.toml`              | cameras, as Pose2Sim writes them                                 |
//! | `images/<camera>/%06d.jpg`      | photographs                                                      |
//! | `truth/masks/<camera>/%06d.png` | where the person is, 0 and 255                                   |
//! | `truth.trc`, `truth.json`       | as in [`super::synthetic`]                                       |

use std::fs;
use std::path::Path;

use rayon::prelude::*;

use super::synthetic::{SyntheticError, failed, write_at_once, write_texts};
use crate::io::folder::jpeg;
use crate::io::folder::png::{self, Effort};
use crate::silhouette::FrameIndex;
use crate::synth::{Film, Studio};

/// Quality of a camera that is not set to save space.
const JPEG_QUALITY: u8 = 95;

/// Writes a recording into a folder that is empty or does not exist.
///
/// Everything is written beside it first and moved there at the end, so a failure leaves nothing.
///
/// # Errors
/// [`SyntheticError`] names the file and why.
pub fn write(filmed: &Film, folder: &Path) -> Result<(), SyntheticError> {
    write_at_once(folder, |whole| {
        for (id, camera) in filmed.synthetic.rig.iter() {
            let images = whole.join("images").join(&camera.name);
            let masks = whole.join("truth").join("masks").join(&camera.name);
            for path in [&images, &masks] {
                fs::create_dir_all(path).map_err(failed(path))?;
            }
            if let Some(studio) = filmed.studio(id) {
                let frames = (0..filmed.synthetic.frames()).into_par_iter();
                frames.try_for_each(|frame| write_shot(&studio, frame, &images, &masks))?;
            }
        }
        write_texts(&filmed.synthetic, whole, &manifest(filmed))
    })
}

fn write_shot(
    studio: &Studio<'_>,
    frame: usize,
    images: &Path,
    masks: &Path,
) -> Result<(), SyntheticError> {
    let Some(shot) = studio.shot(FrameIndex(frame)) else {
        return Ok(());
    };

    let image = images.join(format!("{frame:06}.jpg"));
    let mask = masks.join(format!("{frame:06}.png"));
    for (path, bytes) in [
        (&image, jpeg::encode(&shot.picture, JPEG_QUALITY)),
        (&mask, png::encode_mask(&shot.mask, Effort::Small)),
    ] {
        let written = bytes.and_then(|bytes| fs::write(path, bytes));
        written.map_err(failed(path))?;
    }
    Ok(())
}

fn manifest(filmed: &Film) -> String {
    let synthetic = &filmed.synthetic;
    let mut text = format!(
        "# Synthetic: model {}, seed {}. The truth is in truth.trc, truth.json and truth/masks.\n\
         fps = {:?}\ncalibration = \"calibration.toml\"\nunit = \"m\"\nup = \"z\"\nbody = \"human-metaballs\"\n",
        synthetic.model.name.escape_debug(),
        synthetic.seed,
        synthetic.fps
    );
    for name in synthetic.rig.names() {
        text.push_str(&format!(
            "\n[[camera]]\nname = {name:?}\nimages = \"images/{name}/%06d.jpg\"\n"
        ));
    }
    text
}
