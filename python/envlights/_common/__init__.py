"""Ground of the package: checks, results, text and files, without a step of any method."""
