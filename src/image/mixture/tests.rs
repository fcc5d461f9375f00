use super::*;

const GREY: [u8; 3] = [100; 3];
const RED: [u8; 3] = [200, 20, 20];

fn trained(pictures: &[[u8; 3]]) -> Mixture {
    let mut mixture = Mixture::new(5, 3, MixtureOptions::default());
    for (t, colour) in pictures.iter().enumerate() {
        mixture.update(&Picture::filled(5, 3, *colour), 1.0 / (t as f32 + 1.0));
    }
    mixture
}

#[test]
fn what_stays_is_background_and_what_is_new_is_not() {
    let mut mixture = trained(&[GREY; 20]);
    let mut picture = Picture::filled(5, 3, [102, 99, 101]);
    picture.row_mut(1)[4] = RED;
    let seen = mixture.update(&picture, 0.01);
    assert_eq!((seen.row(0), seen.row(1)), (&[0; 5][..], &[0, 0, 0, 0, 1][..]));
}

#[test]
fn with_equal_weights_a_mode_is_the_mean_of_what_it_matched() {
    let mixture = trained(&[[100; 3], [104; 3], RED, [102; 3]]);
    let modes: Vec<Mode> = (0..4).map(|k| mixture.mode(k, 2, 1)).collect();
    approx::assert_relative_eq!(modes[0].weight, 0.75, epsilon = 1e-6);
    approx::assert_relative_eq!(modes[0].mean[0], 102.0, epsilon = 1e-4);
    let red = modes.iter().find(|mode| mode.mean[0] > 150.0).unwrap();
    approx::assert_relative_eq!(red.weight, 0.25, epsilon = 1e-6);
}

#[test]
fn the_weights_add_up_to_one() {
    let mixture = trained(&[GREY, RED, GREY, [0; 3], GREY]);
    let sum: f32 = (0..4).map(|k| mixture.mode(k, 0, 0).weight).sum();
    approx::assert_relative_eq!(sum, 1.0, epsilon = 1e-6);
}

#[test]
fn what_comes_often_enough_becomes_background() {
    let mut mixture = trained(&[GREY; 10]);
    let red = Picture::filled(5, 3, RED);
    let first = (0..60).position(|_| mixture.update(&red, 0.05).row(0)[0] == 0);
    // ω of the grey falls to 0.95^t; red is background when what ranks before it is below 0.7
    assert!((5..20).contains(&first.unwrap()), "{first:?}");
}

#[test]
fn a_picture_of_another_size_teaches_nothing() {
    let mut mixture = trained(&[GREY; 3]);
    mixture.update(&Picture::filled(4, 3, RED), 0.5);
    approx::assert_relative_eq!(mixture.mode(0, 0, 0).mean[1], 100.0);
}

#[test]
fn the_modes_do_not_depend_on_the_number_of_threads() {
    let mut pictures = Vec::new();
    for k in 0..6_u32 {
        let values = (0..15_u32).map(|i| [(i * 37 + k * 11) as u8, (i * k) as u8, 90]);
        pictures.push(Picture::from_values(5, 3, values.collect()).unwrap());
    }
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut mixture = Mixture::new(5, 3, MixtureOptions::default());
            for picture in &pictures {
                mixture.update(picture, 0.1);
            }
            mixture.tiles
        })
    };
    assert_eq!(run(1), run(3));
}
