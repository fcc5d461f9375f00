//! Soldiers to civilians: how much more girth varies.

/// Of body mass index, kg/m².
#[derive(Debug, Clone, Copy)]
pub(crate) struct Percentiles {
    pub(crate) fifth: f64,
    pub(crate) ninety_fifth: f64,
}

/// Men and women of 20 years and older, United States, August 2021 – August 2023 (NHANES).
///
/// # Source
/// Fryar, Gu, Afful, Carroll, Ogden 2025, *Anthropometric reference data*, Vital Health Stat 3(50), Table 10; n = 2680, 3249.
pub(crate) const CIVILIANS: [Percentiles; 2] = [
    Percentiles { fifth: 20.9, ninety_fifth: 42.1 },
    Percentiles { fifth: 19.7, ninety_fifth: 44.9 },
];

/// 95th percentile of a standard normal.
const Z: f64 = 1.644_854;

impl Percentiles {
    /// Of a sample; the order of the values does not matter.
    pub(crate) fn from_sample(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
        Self { fifth: at(0.05), ninety_fifth: at(0.95) }
    }

    /// SD of the logarithm, as if it were normal.
    fn log_sd(self) -> f64 {
        (self.ninety_fifth / self.fifth).ln() / (2.0 * Z)
    }
}

/// SD of log body mass index of civilians over that of soldiers, both sexes counted half.
pub(crate) fn widening(soldiers: [Percentiles; 2]) -> f64 {
    let spread = |sexes: [Percentiles; 2]| sexes.map(|p| p.log_sd().powi(2)).iter().sum::<f64>();
    (spread(CIVILIANS) / spread(soldiers)).sqrt()
}
