//! Location and spread.

/// Mean; `None` of no values.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) =
        values.into_iter().fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// Mean, and the standard deviation (n − 1) if there are two values or more; `None` of no values.
pub fn mean_and_sd(values: &[f64]) -> Option<(f64, Option<f64>)> {
    let mean = mean(values.iter().copied())?;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let sd = (values.len() > 1).then(|| (squares / (values.len() as f64 - 1.0)).sqrt());
    Some((mean, sd))
}

/// Median of the finite values; `None` if there are none. Reorders `values`.
pub fn median(values: &mut Vec<f64>) -> Option<f64> {
    values.retain(|v| v.is_finite());
    let middle = values.len() / 2;
    let (below, upper, _) =
        (!values.is_empty()).then(|| values.select_nth_unstable_by(middle, f64::total_cmp))?;
    let upper = *upper;
    let lower = below.iter().copied().max_by(f64::total_cmp).unwrap_or(upper);
    Some(if values.len() % 2 == 1 { upper } else { 0.5 * (lower + upper) })
}

/// Median of whole numbers of which `counts[v]` equal v; 0 of no numbers.
///
/// Equal numbers count as spread evenly over half a step to either side, so the median lies between whole numbers.
pub fn median_of_counts(counts: &[usize]) -> f64 {
    let half = counts.iter().sum::<usize>() as f64 / 2.0;
    let mut below = 0.0;
    for (value, count) in counts.iter().enumerate() {
        let count = *count as f64;
        if below + count > half {
            return (value as f64 - 0.5 + (half - below) / count).max(0.0);
        }
        below += count;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_has_no_standard_deviation() {
        assert_eq!(mean_and_sd(&[2.0]), Some((2.0, None)));
        assert_eq!(mean_and_sd(&[]), None);
        approx::assert_relative_eq!(mean_and_sd(&[1.0, 3.0]).unwrap().1.unwrap(), 2_f64.sqrt());
    }

    #[test]
    fn the_median_of_counts_lies_between_the_numbers() {
        approx::assert_relative_eq!(median_of_counts(&[0, 0, 4]), 2.0);
        approx::assert_relative_eq!(median_of_counts(&[0, 3, 1]), 1.0 + 1.0 / 6.0);
        approx::assert_relative_eq!(median_of_counts(&[]), 0.0);
    }

    #[test]
    fn the_median_of_an_even_number_of_values_is_the_mean_of_the_middle_two() {
        assert_eq!(median(&mut vec![4.0, 1.0, f64::NAN, 3.0, 2.0]), Some(2.5));
        assert_eq!(median(&mut vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut vec![]), None);
    }
}
