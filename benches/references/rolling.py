"""A disk, a hoop and a coin that roll and wobble on a plane, from closed forms.

    python benches/references/rolling.py                                 (needs mpmath; a few seconds)

The digits are those of `tests/motions/constrained/disk.rs`.

With moments of inertia k m r^2 about the axle and h m r^2 across, lean phi from the vertical, heading psi, turn theta, n = psi' cos phi and
s = psi' sin phi + theta', the equations of Newton and Euler are

    (h + 1) phi'' = -h n^2 tan phi + (k + 1) n s + (g/r) sin phi,    h n' = (h n tan phi - k s) phi',    (k + 1) s' = -n phi'.

By phi instead of t, s obeys Legendre's equation in sin phi with nu (nu + 1) = -k/(h (k + 1)) (Appell; Korteweg, both 1900; Neimark and Fufaev 1972, ch. V):
s = a P(sin phi) + b P(-sin phi), n = -(k + 1) ds/dphi. The energy gives phi', and time, heading, turn and place are quadratures.
"""

from mpmath import cos, exp, findroot, legenp, lu_solve, matrix, mp, mpc, mpf, nstr, pi, quad, re, sin, sqrt, tan

mp.dps = 50
NODES = 160


def wobble(k, h, r, g, lean, n, s, other, wobbles):
    """(t, psi, theta, x, y, phi, n, s) after so many wobbles and a half, from a greatest or least `lean`, at the origin; `other`: about the lean at the end."""
    k, h, r, g, lean, n, s = map(mpf, (k, h, r, g, lean, n, s))
    nu = (sqrt(mpc(1 - 4 * k / (h * (k + 1)))) - 1) / 2
    value = lambda z: re(legenp(nu, 0, z))
    slope = lambda z: re(nu * (z * legenp(nu, 0, z) - legenp(nu - 1, 0, z)) / (z * z - 1))
    z = sin(lean)
    a, b = lu_solve(matrix([[value(z), value(-z)], [slope(z), -slope(-z)]]), matrix([s, -n / ((k + 1) * cos(lean))]))
    turning = lambda phi: a * value(sin(phi)) + b * value(-sin(phi))
    standing = lambda phi: -(k + 1) * cos(phi) * (a * slope(sin(phi)) - b * slope(-sin(phi)))
    potential = lambda phi: h * standing(phi) ** 2 + (k + 1) * turning(phi) ** 2 + 2 * g / r * cos(phi)
    energy = potential(lean)
    far = findroot(lambda phi: potential(phi) - energy, mpf(other))

    # phi = mean + half cos u. All rates by u are even and periodic, so that few values give their Fourier series.
    mean, half = (lean + far) / 2, (lean - far) / 2
    rows = []
    for j in range(NODES):
        u = (j + mpf(1) / 2) * pi / NODES
        phi = mean + half * cos(u)
        dt = abs(half) * sin(u) / sqrt((energy - potential(phi)) / (h + 1))
        heading = standing(phi) / cos(phi)
        rows.append((u, dt, dt * heading, dt * (turning(phi) - standing(phi) * tan(phi))))
    series = [[sum(row[i] * cos(m * row[0]) for row in rows) * (1 if m == 0 else 2) / NODES for m in range(NODES // 2)] for i in (1, 2, 3)]
    lost = max(abs(c[-1] / c[0]) for c in series)
    rate = lambda c, u: sum(x * cos(m * u) for m, x in enumerate(c))
    whole = lambda c, u: c[0] * u + sum(x * sin(m * u) / m for m, x in enumerate(c) if m)
    move = lambda u: r * rate(series[2], u) * exp(mpc(0, 1) * whole(series[1], u))
    first, all = quad(move, [0, pi / 2, pi]), quad(move, [0, pi / 2, pi, 3 * pi / 2, 2 * pi])
    turn = exp(mpc(0, 1) * 2 * pi * series[1][0])
    place = all * sum(turn**m for m in range(wobbles)) + turn**wobbles * first
    end = [(2 * wobbles + 1) * pi * c[0] for c in series]
    return end + [place.real, place.imag, far, standing(far), turning(far)], lost


def show(name, *arguments):
    values, lost = wobble(*arguments)
    print(f"{name} (to {nstr(lost, 1)}): [{', '.join(nstr(v, 20) for v in values)}]")


if __name__ == "__main__":
    disk, hoop = (0.5, 0.25, 0.4, 9.81), (1, 0.5, 0.4, 9.81)
    show("disk", *disk, 0.25, 3, -4, -0.694, 5)
    show("hoop", *hoop, 0.3, 2, -6, 0.023, 5)
    # A coin of 25 mm that lies almost flat.
    show("coin", 0.5, 0.25, 0.0125, 9.81, 1.2, 20, 4, 1.402, 5)
