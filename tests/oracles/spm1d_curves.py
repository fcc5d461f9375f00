"""Writes spm1d_curves.json: what spm1d says of groups of curves, for tests/curve_test.rs.

    pip install numpy==2.4.6 scipy==1.17.1 spm1d==0.4.55
    python tests/oracles/spm1d_curves.py > tests/oracles/spm1d_curves.json

Two-sample t with pooled variance, two-sided, alpha 0.05, Bonferroni's bound where it is lower: spm1d's own defaults but for the variance.
"""
import json
import numpy as np
import spm1d

PLACES = 101


def curves(rng, count, fwhm, spread, bump):
    """Smooth noise about a wave, with a bump at 60 % of the cycle; degrees, rounded so that the file holds what was tested."""
    noise = spm1d.rft1d.random.randn1d(count, PLACES, fwhm)
    place = np.arange(PLACES)
    wave = 20 * np.sin(2 * np.pi * place / (PLACES - 1)) + bump * np.exp(-0.5 * ((place - 60) / 8) ** 2)
    return np.round(wave + spread * noise, 3)


def case(name, seed, counts, fwhm, bump):
    np.random.seed(seed)
    before, after = (curves(np.random, n, fwhm, 2.0, b) for n, b in zip(counts, (0.0, bump)))
    t = spm1d.stats.ttest2(after, before, equal_var=True)
    found = t.inference(alpha=0.05, two_tailed=True, interp=True, circular=False)
    stretches = [dict(start=float(c.endpoints[0]), end=float(c.endpoints[1]), p=float(c.P)) for c in found.clusters]
    return dict(name=name, before=before.tolist(), after=after.tolist(), t=np.round(t.z, 9).tolist(), freedom=float(t.df[1]),
                fwhm=float(t.fwhm), threshold=float(found.zstar), stretches=stretches)


def threshold(freedom, fwhm):
    height = float(spm1d.rft1d.t.isf(0.025, freedom, PLACES, fwhm, withBonf=True))
    return dict(freedom=freedom, fwhm=fwhm, height=height)


print(json.dumps(dict(
    cases=[
        case('a bump', 3, (5, 5), 20.0, 9.0),
        case('three against six', 4, (3, 6), 12.0, -12.0),
        case('the same person', 5, (4, 4), 15.0, 0.0),
        case('rough', 6, (6, 4), 1.5, 25.0),
    ],
    thresholds=[threshold(f, w) for f in (4, 8, 20) for w in (2.0, 10.0, 25.0, 60.0)],
)))
