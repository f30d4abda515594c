"""Reference digits of bodies that tumble, for `coord R: rotation;`.

    python benches/references/bodies.py                                  (needs mpmath; a minute)

The free body is in closed form: Jacobi's functions for the angular velocity, the integral of the precession for the attitude (Landau and Lifshitz,
Mechanics, section 37; Whittaker, Analytical Dynamics, section 69). All other motions are integrals of Euler's equations with a quaternion by Gragg's midpoint
rule, extrapolated to the order 28 in 40 digits, each with two step sizes; `agreement` is the difference of both. Quaternions are w, x, y, z, and take
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


def extrapolated(rate, y, end, count):
    """Gragg, Bulirsch and Stoer: 14 columns, `count` equal steps."""
    whole = mpf(end) / count
    for _ in range(count):
        row = []
        for i in range(1, 15):
            h = whole / (2 * i)
            before, now = y, [a + h * b for a, b in zip(y, rate(y))]
            for _ in range(2 * i - 1):
                before, now = now, [a + 2 * h * b for a, b in zip(before, rate(now))]
            last = [(a + b + h * c) / 2 for a, b, c in zip(before, now, rate(now))]
            following = [last]
            for k, above in enumerate(row, start=1):
                ratio = (mpf(i) / (i - k)) ** 2
                last = [x + (x - z) / (ratio - 1) for x, z in zip(last, above)]
                following.append(last)
            row = following
        y = row[-1]
    return y


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def down(q):
    """The third axis of space, in the body."""
    w, x, y, z = q
    return [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]


def body(moments, moment):
    """Euler's equations with a moment of the quaternion and what else there is, whose rates it gives, too."""

    def rate(y):
        q, omega, rest = y[:4], y[4:7], y[7:]
        applied, further = moment(q, omega, rest)
        gyration = cross(omega, [a * b for a, b in zip(moments, omega)])
        spin = product(q, [mpf(0)] + list(omega))
        turning = [(m - g) / a for m, g, a in zip(applied, gyration, moments)]
        return [x / 2 for x in spin] + turning + further

    return rate


def top(moments, centre, weight):
    """A heavy body on its point: the mass centre by the weight."""
    arm = [mpf(x) * mpf(weight) for x in centre]
    return body([mpf(x) for x in moments], lambda q, omega, rest: (cross(arm, [-x for x in down(q)]), []))


def satellite(moments, wheel, rate, torques):
    """In a field of gravity along the third axis of space, 3 rate^2 (n x J n), with a wheel on each axis: its angular momentum obeys h' = -u, and acts by -h' - w x h."""
    moments = [mpf(x) for x in moments]

    def moment(q, omega, h):
        n, u = down(q), [mpf(x) for x in torques]
        gradient = [3 * mpf(rate) ** 2 * x for x in cross(n, [a * b for a, b in zip(moments, n)])]
        return [g + t - c for g, t, c in zip(gradient, u, cross(omega, h))], [-x for x in u]

    return body(moments, moment)


def lifter(moments, mass, load, length, gravity, thrust, torques):
    """A body that lifts a load on a rod from its mass centre, by a thrust along its third axis: places and velocities of the body, the direction to the load
    and its rate follow, with the tension of the rod (Lee, Sreenath and Kumar, CDC 2013)."""
    m, w, l, g, f = map(mpf, (mass, load, length, gravity, thrust))

    def moment(q, omega, rest):
        v, n, nd = rest[3:6], rest[6:9], rest[9:12]
        w0, x, y, z = q
        push = [f * c for c in (2 * (x * z + w0 * y), 2 * (y * z - w0 * x), w0 * w0 - x * x - y * y + z * z)]
        speed, along = sum(c * c for c in nd), sum(a * b for a, b in zip(push, n))
        tension = (l * speed - along / m) / (1 / m + 1 / w)
        weight = [0, 0, -g]
        own = [(p + tension * c) / m + k for p, c, k in zip(push, n, weight)]
        other = [k - tension * c / w for c, k in zip(n, weight)]
        turn = [(b - a) / l for a, b in zip(own, other)]
        return [mpf(u) for u in torques], list(v) + own + list(nd) + turn

    return body([mpf(x) for x in moments], moment)


def scene(name, rate, q, omega, rest, end, count):
    start = [mpf(x) for x in list(q) + list(omega) + list(rest)]
    a, b = extrapolated(rate, start, end, count), extrapolated(rate, start, end, count + count // 3)
    print(name, "at", end, "agreement", nstr(max(abs(x - y) for x, y in zip(a, b)), 3))
    show("q", b[:4])
    show("omega", b[4:7])
    if rest:
        show("rest", b[7:])


if __name__ == "__main__":
    # examples/tumbling.rs
    for t in (0, 1300):
        w, q, half = free_body(1, 2, 3, 1, 0.05, t)
        print("free body at", t, "half period", nstr(half, 20))
        show("omega", w)
        show("q", q)
    # tests/bodies.rs
    degree = mp.pi / 180
    brick = [0.00189422, 0.006211019, 0.007194665]
    scene("brick", body([mpf(x) for x in brick], lambda q, w, rest: ([mpf(0)] * 3, [])), [1, 0, 0, 0], [10 * degree, 20 * degree, 30 * degree], [], 30, 150)
    scene("Lagrange's top", top([0.5, 0.5, 0.25], [0, 0, 0.5], 8), [0.5, 0.5, -0.5, 0.5], [0.25, 0.5, 16], [], 4, 90)
    scene("Kovalevskaya's top", top([1, 1, 0.5], [0.5, 0, 0], 4), [0.5, 0.5, 0.5, 0.5], [1, -2, 4], [], 10, 150)
    scene("satellite", satellite([3, 2, 1.5], 0.1, 0.5, [0.1, -0.05, 0.02]), [0.5, -0.5, 0.5, 0.5], [0.25, -0.5, 0.75], [0.2, 0.1, -0.3], 10, 60)
    scene("lifter", lifter([0.02, 0.03, 0.04], 1.5, 0.5, 0.75, 9.81, 20.0, [0.001, -0.002, 0.003]), [1, 0, 0, 0], [0.5, -0.25, 1], [0, 0, 0, 0, 0, 0, 0, 0.6, -0.8, 1, 0, 0], 3, 30)
