"""Exposures of a panorama, merged into one linear image (Madsen et al. 2003, figure 4).

| step                                                         | file            |
|--------------------------------------------------------------|-----------------|
| checks of the arguments; codes or linear samples             | `pictures.py`   |
| times by hand or from EXIF                                   | `times.py`      |
| clip level of each picture                                   | `clip_level.py`      |
| codes of two pictures at the same radiance                   | `comparison.py` |
| response: named curves, or estimated                         | `response.py`   |
| response and times that agree with the pictures              | `checks.py`     |
| motion between the pictures                                  | `alignment.py`  |
| weighted mean, contradictions                                | `merge.py`      |
| the steps in order                                           | `series.py`     |
"""

from envlights.environment.exposures.series import MergeResult, merge_exposures

__all__ = ["MergeResult", "merge_exposures"]


def __dir__() -> list[str]:
    return sorted(__all__)
