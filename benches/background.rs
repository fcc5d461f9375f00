//! The mixture of Gaussians at 1280 × 720: pictures a second, learned and classified, on all cores and on one.
//!
//! `cargo bench --bench background`; `python3 benches/opencv_mog2.py` gives OpenCV's on the same pictures.

#![allow(missing_docs, reason = "divan's macros make items without documentation")]

use divan::counter::ItemsCount;
use maquette::image::{Mixture, MixtureOptions, Picture};

const SIZE: (usize, usize) = (1280, 720);

fn main() {
    divan::main();
}

/// A smooth scene with noise of ±4 grey levels, before which a square of another colour moves; as in the script.
fn pictures() -> Vec<Picture> {
    let mut random = 1_u32;
    (0..24)
        .map(|t: usize| {
            let values = (0..SIZE.0 * SIZE.1).map(|i| {
                let (x, y) = (i % SIZE.0, i / SIZE.0);
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let noise = (random >> 24) as i32 % 9 - 4;
                let is_person =
                    (200 + 10 * t..400 + 10 * t).contains(&x) && (150..600).contains(&y);
                let colour = if is_person {
                    [200, 120, 90]
                } else {
                    [x / 8 + 30, y / 5 + 40, (x + y) / 12 + 20]
                };
                colour.map(|value| (value as i32 + noise).clamp(0, 255) as u8)
            });
            Picture::from_values(SIZE.0, SIZE.1, values.collect())
                .expect("as many values as pixels")
        })
        .collect()
}

#[divan::bench(args = [1, 2], sample_count = 10)]
fn mixture(bencher: divan::Bencher<'_, '_>, threads: usize) {
    let pictures = pictures();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let mut mixture = Mixture::new(SIZE.0, SIZE.1, MixtureOptions::default());
    bencher.counter(ItemsCount::new(pictures.len())).bench_local(|| {
        pool.install(|| {
            for picture in &pictures {
                divan::black_box(mixture.update(picture, 0.01));
            }
        });
    });
}
