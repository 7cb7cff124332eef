"""The Pareto front of times and costs."""

from collections.abc import Sequence

SAME_TIME = 1.05  # times within this factor count as equal: runs differ by as much


def front(points: Sequence[tuple[float, float]]) -> list[bool]:
    """Which of the points (time, cost) none beats: as fast, within noise, at less cost, or faster at no more.

    >>> front([(10, 0.0), (30, 0.0), (5, 0.1), (6, 0.2), (9.9, 0.05)])
    [True, False, True, False, False]
    """

    def beaten(time: float, cost: float) -> bool:
        return any(
            (other <= SAME_TIME * time and less < cost) or (SAME_TIME * other <= time and less <= cost)
            for other, less in points
        )

    return [not beaten(*point) for point in points]
