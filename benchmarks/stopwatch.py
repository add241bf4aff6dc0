"""Comparable run times: pieces of work take turns, and the least of many rounds counts."""

import time


def all_seconds(work, rounds=25, patience=10.0):
    """Seconds of each piece of `work` in each round; fewer rounds beyond `patience` seconds."""
    seconds = {name: [] for name in work}
    begun = time.perf_counter()
    for done in range(rounds):
        if done >= 3 and time.perf_counter() - begun > patience:
            break
        for name, piece in work.items():
            start = time.perf_counter()
            piece()
            seconds[name].append(time.perf_counter() - start)
    return seconds


def least_seconds(work, rounds=25, patience=10.0):
    """Least seconds of each named piece of `work`."""
    return {name: min(found) for name, found in all_seconds(work, rounds, patience).items()}


def compare(title, work, base=None, rounds=25):
    """Print the least time of each piece of work, and its ratio to `base`, or to the first."""
    print(f"\n{title}")
    least = least_seconds(work, rounds)
    for name, seconds in least.items():
        ratio = seconds / least[base or next(iter(work))]
        print(f"  {name:<52}{1e3 * seconds:>9.2f} ms{ratio:>9.2f} x", flush=True)
