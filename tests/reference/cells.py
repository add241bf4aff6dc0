"""Irradiance of a map of cells, integrated cell by cell."""

from itertools import pairwise

import numpy as np


def irradiance(radiance, normals, *, border_sampled=False, latitudes=4000):
    """Integrate every cell in closed form over phi, and by the midpoint rule over theta.

    No sum is taken from another: a cell behind the horizon adds 0. From pole to pole there are
    `latitudes`.
    """
    theta_edges = edges(len(radiance), np.pi, outer_halves=border_sampled)
    phi_edges = edges(radiance.shape[1], 2 * np.pi, outer_halves=border_sampled)
    azimuth = np.arctan2(normals[:, 0], -normals[:, 2])[:, None]
    received = np.zeros((len(normals), 3))
    for row, (top, bottom) in zip(radiance, pairwise(theta_edges), strict=True):
        steps = int(np.ceil(latitudes * (bottom - top) / np.pi))
        theta = top + (bottom - top) * (np.arange(steps) + 0.5) / steps
        # n.w = a cos(phi - azimuth) + b is positive less than half a width from the azimuth.
        a = np.hypot(normals[:, 0], normals[:, 2])[:, None] * np.sin(theta)
        b = normals[:, 1:2] * np.cos(theta)
        half = np.arccos(np.clip(-b / np.maximum(a, 1e-300), -1, 1))
        for pixel, (left, right) in zip(row, pairwise(phi_edges), strict=True):
            inside = 0.0
            for turn in (-2 * np.pi, 0, 2 * np.pi):
                start = np.clip(left - azimuth + turn, -half, half)
                end = np.clip(right - azimuth + turn, -half, half)
                inside = inside + a * (np.sin(end) - np.sin(start)) + b * (end - start)
            cell = inside @ np.sin(theta) * (bottom - top) / steps
            received += cell[:, None] * np.float64(pixel)
    return received


def edges(count, whole, *, outer_halves):
    """Angles between `count` cells; the outer ones may be halves."""
    if not outer_halves:
        return whole * np.arange(count + 1) / count
    between = (np.arange(count - 1) + 0.5) / (count - 1)
    return whole * np.concatenate([[0], between, [1]])


def vector_solid_angle(row, column, height, width):
    """Integral of the direction over a pixel, from the antiderivatives in theta and phi."""
    t0, t1 = np.pi * np.array([row, row + 1]) / height
    p0, p1 = 2 * np.pi * np.array([column, column + 1]) / width
    equatorial = (t1 - t0) / 2 - (np.sin(2 * t1) - np.sin(2 * t0)) / 4
    polar = (np.sin(t1) ** 2 - np.sin(t0) ** 2) / 2
    x, z = np.cos(p0) - np.cos(p1), np.sin(p0) - np.sin(p1)
    return np.array([x * equatorial, polar * (p1 - p0), z * equatorial])


def mean_of_row(row, column, height, width):
    """Direction of a pixel at its middle azimuth, and the mean height of its row.

    The light of a fitted pixel has it. Its integral over the azimuth too is shorter in x and z by
    the sinc of half a pixel, 6e-6 at 512 columns.
    """
    towards = vector_solid_angle(row, column, height, width)
    towards[[0, 2]] /= np.sinc(1 / width)
    return towards / np.linalg.norm(towards)
