"""Comparable run times: pieces of work alternate, and the least of many rounds counts."""

import time


def processor_seconds():
    """Seconds that the processor has worked for this process and for those that it has ended."""
    try:
        import resource
    except ImportError:  # on Windows, where nobody counts those
        return time.process_time()
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def all_seconds(work, rounds=25, patience=10.0, clock=time.perf_counter, fewest=3, shortest=0.0):
    """Seconds of each piece of `work` in each round.

    After the `fewest` rounds, a piece that has had its share of `patience` is left out.
    What takes less than `shortest` is repeated until it has taken that long.
    """
    seconds = {name: [] for name in work}
    for done in range(rounds):
        for name, piece in work.items():
            if done >= fewest and sum(seconds[name]) > patience / len(work):
                continue
            start, calls, elapsed = clock(), 0, 0.0
            while calls == 0 or elapsed < shortest:
                piece()
                calls, elapsed = calls + 1, clock() - start
            seconds[name].append(elapsed / calls)
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
