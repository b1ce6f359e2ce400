# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Systems of linear equations with a band of coefficients: Gaussian elimination with row pivoting, in
a kernel.

Row r of n keeps columns r - band … r + 2 band, 3 band + 1 numbers side by side: twice the band
above the diagonal is what pivoting may fill. A full matrix is the one with band = n - 1. Cost: 2 n
band^2 multiplications.

Behind them stands the weight of the row, by which its entries are multiplied where rows are
compared for a pivot: a row of a force is in kg, one of a torque in kg m^2, and which is the
larger must not depend on the unit of length. With 1 / sqrt(m) of the inertia m of the row, those
of M^-1/2 A M^-1/2 are compared, whose numbers are without unit.

Source: Golub & Van Loan, Matrix Computations, section 4.3.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel


@inline
def row_size(band):
    """Count the numbers of a row, its weight among them."""
    return 3 * band + 2


@inline
def size(n, band):
    """Count the numbers of a matrix."""
    return n * row_size(band)


@inline
def entry(band, row, column):
    """Place of an entry, |row - column| <= band."""
    return row * row_size(band) + column - row + band


@inline
def weigh(band, matrix, row, inertia):
    """Set the weight of a row, from the inertia that the row has: in the units of its entries."""
    matrix[(row + 1) * row_size(band) - 1] = 1.0 / math.sqrt(inertia)


@kernel
def clear(n, band, matrix):
    """Set all entries to zero."""
    for place in range(size(n, band)):
        matrix[place] = 0.0


@inline
def add_to_row(band, matrix, row, column, v):
    """Add a vector to three successive entries of a row."""
    matrix[entry(band, row, column)] += v[0]
    matrix[entry(band, row, column + 1)] += v[1]
    matrix[entry(band, row, column + 2)] += v[2]


@inline
def add_to_column(band, matrix, row, column, v):
    """Add a vector to three successive entries of a column."""
    matrix[entry(band, row, column)] += v[0]
    matrix[entry(band, row + 1, column)] += v[1]
    matrix[entry(band, row + 2, column)] += v[2]


@inline
def subtract_from_column(band, matrix, row, column, v):
    """Subtract a vector from three successive entries of a column."""
    matrix[entry(band, row, column)] -= v[0]
    matrix[entry(band, row + 1, column)] -= v[1]
    matrix[entry(band, row + 2, column)] -= v[2]


@kernel
def solve(n, band, matrix, rhs):
    """
    Solve matrix x = rhs, whose rows were weighed; x replaces rhs, the matrix is used up.

        returns : 1, or 0 for a matrix that is singular or not finite
    """
    width = row_size(band)
    weight = width - 1
    for k in range(n):
        below = min(k + band, n - 1)
        right = min(k + 2 * band, n - 1)
        pivot, largest = k, abs(matrix[k * width + band]) * matrix[k * width + weight]
        for row in range(k + 1, below + 1):
            candidate = abs(matrix[row * width + k - row + band]) * matrix[row * width + weight]
            if candidate > largest:
                pivot, largest = row, candidate
        if not (0.0 < largest < 1e300):
            return 0
        top = k * width - k + band
        if pivot != k:
            other = pivot * width - pivot + band
            for column in range(k, right + 1):
                matrix[top + column], matrix[other + column] = (
                    matrix[other + column],
                    matrix[top + column],
                )
            rhs[k], rhs[pivot] = rhs[pivot], rhs[k]
            matrix[pivot * width + weight] = matrix[k * width + weight]
        over = 1.0 / matrix[top + k]
        for row in range(k + 1, below + 1):
            place = row * width - row + band
            factor = matrix[place + k] * over
            if factor != 0.0:
                for column in range(k + 1, right + 1):
                    matrix[place + column] -= factor * matrix[top + column]
                rhs[row] -= factor * rhs[k]
    for k in range(n - 1, -1, -1):
        top = k * width - k + band
        total = rhs[k]
        for column in range(k + 1, min(k + 2 * band, n - 1) + 1):
            total -= matrix[top + column] * rhs[column]
        rhs[k] = total / matrix[top + k]
    return 1
