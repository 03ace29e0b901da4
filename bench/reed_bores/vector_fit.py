"""Common-pole rational approximation by vector fitting (Gustavsen & Semlyen 1999, in its relaxed
form of 2006), poles in the left half plane.

Every response is  at_zero + sum_k r_k s/(s - p_k):  its value at s = 0 is exact, and a pole at
infinity has no place."""

import numpy as np


def _basis(s, poles):
    """Real basis: a column for a real pole, two for a pair (given by its upper member)."""
    columns = []
    for p in poles:
        if p.imag == 0:
            columns.append(s / (s - p.real))
        else:
            one, other = s / (s - p), s / (s - np.conj(p))
            columns += [one + other, 1j * (one - other)]
    return np.stack(columns, axis=1)


def _stack(matrix):
    return np.concatenate([matrix.real, matrix.imag])


def residues(s, response, weight, at_zero, poles):
    """Least squares for the numbers r (complex for a pair's upper member, real for a real pole)."""
    basis = _basis(s, poles)
    x, *_ = np.linalg.lstsq(_stack(basis * weight[:, None]),
                            _stack((response - at_zero) * weight), rcond=None)
    found, i = [], 0
    for p in poles:
        if p.imag == 0:
            found.append(complex(x[i]))
            i += 1
        else:
            found.append(complex(x[i], x[i + 1]))
            i += 2
    return np.array(found)


def evaluate(s, at_zero, poles, found):
    total = np.full(s.shape, at_zero, complex)
    for p, r in zip(poles, found):
        if p.imag == 0:
            total += r.real * s / (s - p.real)
        else:
            total += r * s / (s - p) + np.conj(r) * s / (s - np.conj(p))
    return total


def fit(s, responses, weights, at_zero, start, rounds=40):
    """Poles, shared by all responses (rows), from starting poles (upper members of pairs)."""
    poles = list(start)
    for _ in range(rounds):
        basis = _basis(s, poles)
        order = basis.shape[1]
        reduced, right = [], []
        # Relaxed sigma = d + sum c s/(s - p), with sum of its real parts fixed.
        free = np.concatenate([np.ones((s.size, 1)), basis], axis=1)
        for response, weight, zero in zip(responses, weights, at_zero):
            w = weight[:, None]
            left = np.concatenate([basis * w, -response[:, None] * free * w], axis=1)
            # (sigma f) - zero sigma(0) has the basis as its numerator: sigma(0) = d.
            left[:, order] += zero * weight
            q, r = np.linalg.qr(_stack(left))
            reduced.append(r[order:, order:])
            right.append(np.zeros(r.shape[0] - order))
        scale = np.sqrt(sum(np.sum(np.abs(r * w)**2) for r, w in zip(responses, weights))) / s.size
        condition = scale * _stack(free).real[:s.size].sum(axis=0)
        reduced.append(condition[None])
        right.append(np.array([scale * s.size]))
        x, *_ = np.linalg.lstsq(np.concatenate(reduced), np.concatenate(right), rcond=None)
        d, c = x[0], x[1:]
        # Zeros of sigma: 1/sigma = 0 of d + sum c s/(s - p) = (d + sum c) + sum c p/(s - p).
        rows = np.zeros((order, order))
        ones, numbers = np.zeros(order), np.zeros(order)
        total, i = d, 0
        for p in poles:
            if p.imag == 0:
                rows[i, i] = p.real
                ones[i] = 1
                numbers[i] = c[i] * p.real
                total += c[i]
                i += 1
            else:
                rows[i:i + 2, i:i + 2] = [[p.real, p.imag], [-p.imag, p.real]]
                ones[i] = 2
                product = complex(c[i], c[i + 1]) * p
                numbers[i:i + 2] = [product.real, product.imag]
                total += 2 * c[i]
                i += 2
        zeros = np.linalg.eigvals(rows - np.outer(ones, numbers) / total)
        zeros = -np.abs(zeros.real) + 1j * zeros.imag
        poles = [complex(z) for z in zeros if z.imag > 1e-6 * abs(z)]
        poles += [complex(z.real) for z in zeros if abs(z.imag) <= 1e-6 * abs(z)]
        poles.sort(key=abs)
    return poles
