//! Whether the spectrum of what lines leave is that of noise, octave by octave: a slow motion is a small share of the power, and all of
//! that of the lowest bins.

/// Excess over the noise from which a band is looked at: 2.5 % in amplitude, half of what an error may exceed the noise by.
pub(crate) const LEAST: f64 = 0.05;
/// The same in standard deviations.
const SIGNIFICANT: f64 = 5.0;
/// Bins of the lowest band: fewer have the tails of single bins.
const LOWEST: usize = 3;
/// Share of an excess that may remain for it to be explained, and deviations of the noise besides.
const LEFT: f64 = 0.05;
const CHANCE: f64 = 2.0;
/// … and from which no prior makes it explained.
const HOPELESS: f64 = 5.0;

/// Power of an octave over that of the noise, less one, and its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    /// Its first bin, and the first one beyond it.
    pub(crate) bins: [usize; 2],
    pub(crate) excess: f64,
    std: f64,
}

impl Band {
    /// Whether there is more than noise.
    pub(crate) fn is_conspicuous(&self) -> bool {
        self.excess > LEAST.max(SIGNIFICANT * self.std)
    }
}

/// Whether noise, or nearly nothing, is left of what was conspicuous.
pub(crate) fn is_explained(before: &[Band], after: &[Band]) -> bool {
    is_within(before, after, (1.0, CHANCE))
}

/// Whether that may be so of forces under a prior, from what they leave without one: of the noise itself only a share is left then.
pub(crate) fn may_be_explained(before: &[Band], after: &[Band], share: f64) -> bool {
    is_within(before, after, (share, HOPELESS))
}

fn is_within(before: &[Band], after: &[Band], (share, chance): (f64, f64)) -> bool {
    // Bands weigh as their bins do: by the square of one over their deviation.
    let count = |band: &Band| band.std.powi(-2);
    let asked = || before.iter().zip(after).filter(|(before, _)| before.is_conspicuous());
    let bound: f64 = asked().map(|(before, _)| count(before) * before.excess).sum();
    let free: f64 = asked().map(|(_, after)| count(after) * ((1.0 + after.excess) / share - 1.0)).sum();
    let scatter = (asked().map(|(before, _)| count(before)).sum::<f64>() / share).sqrt();
    free < LEFT * bound + chance * scatter
}

/// Excess of each octave, over all sensors, from their periodograms `|R_k|²/n` of the bins `0..=n/2`; the last one is left out.
pub(crate) fn excesses(periodograms: &[&[f64]], noise_std: &[f64]) -> Vec<Band> {
    let last = periodograms.iter().map(|power| power.len().saturating_sub(1)).min().unwrap_or(0);
    let edges = std::iter::successors(Some(1), |&edge| Some((2 * edge).max(edge + LOWEST)));
    let edges: Vec<usize> = edges.take_while(|edge| *edge < last).collect();
    edges
        .iter()
        .enumerate()
        .map(|(i, &first)| {
            let bins = first..edges.get(i + 1).copied().unwrap_or(last);
            let count = (bins.len() * periodograms.len()) as f64;
            let ratio = |(power, noise): (&&[f64], &f64)| {
                power[bins.clone()].iter().sum::<f64>() / (noise * noise).max(f64::MIN_POSITIVE)
            };
            let sum: f64 = periodograms.iter().zip(noise_std).map(ratio).sum();
            let bins = [bins.start, bins.end];
            Band { bins, excess: sum / count - 1.0, std: count.sqrt().recip() }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise alone is inconspicuous whatever its size; a motion in the lowest bins is seen though it is a hundredth of the power, and
    /// explained by what takes it away.
    #[test]
    fn a_slow_motion_is_seen() {
        use rand::SeedableRng;
        use rand_distr::Distribution;
        let mut random = rand_pcg::Pcg64::seed_from_u64(2);
        let exponential = rand_distr::Exp::new(1.0).unwrap();
        let noise: Vec<Vec<f64>> =
            (0..4).map(|_| (0..1025).map(|_| 0.09 * exponential.sample(&mut random)).collect()).collect();
        let bands =
            |powers: &[Vec<f64>]| excesses(&powers.iter().map(Vec::as_slice).collect::<Vec<_>>(), &[0.3; 4]);
        assert!(bands(&noise).iter().all(|band| !band.is_conspicuous()));
        let mut moving = noise.clone();
        moving.iter_mut().for_each(|power| power[2] += 0.09 * 10.0);
        let found = bands(&moving);
        assert!(found[0].is_conspicuous() && found[1..].iter().all(|band| !band.is_conspicuous()));
        assert!(is_explained(&found, &bands(&noise)) && !is_explained(&found, &found));
        // One free force of four sensors takes a quarter of the noise with what it explains; of a motion that it does not make, too.
        let fitted = |powers: &[Vec<f64>]| {
            let left = powers.iter().map(|power| power.iter().map(|p| 0.75 * p).collect());
            bands(&left.collect::<Vec<_>>())
        };
        assert!(may_be_explained(&found, &fitted(&noise), 0.75));
        assert!(!may_be_explained(&found, &fitted(&moving), 0.75));
    }
}
