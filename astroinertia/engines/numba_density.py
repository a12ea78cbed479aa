"""The text of the density pass: smoothing lengths, densities and their gradient factors, solved leaf by leaf.

With S(h) = sum_j m_j w(r/h), the condition rho = m (eta/h)^3 reads S(h) = m eta^3. S never falls as h grows, so its root
is unique. Newton steps are taken in log S against log h, in which S is nearly straight, and kept within the bracket that
the signs of earlier steps have proved; a step that leaves it is replaced by bisection.
Omega = -sum m q w'/(3 S) and zeta = sum m (phi + q phi')/(3 rho h) follow from Price & Monaghan (2007, MNRAS 374,
1347, equations 7 and 15) with rho ~ h^-3.
"""

WITHOUT_SOFTENING = """
@njit(forceinline=True)
def softening_moment(distance, weight, vectors, inverse_h):
    return real(0)
"""

SOFTENING = """
@njit(fastmath=LOOP_FLAGS, error_model="numpy", nogil=True)
def softening_moment(distance, weight, vectors, inverse_h):
    total = real(0)
    for k in range(vectors):
        q = distance[k] * inverse_h
        total += weight[k] * ({phi}(q) + q * {dphi}(q))
    return total
"""

DENSITY = """
@njit(fastmath=LOOP_FLAGS, error_model="numpy", nogil=True)
def moments(distance, weight, vectors, inverse_h):
    total = real(0)
    slope = real(0)
    for k in range(vectors):
        q = distance[k] * inverse_h
        total += weight[k] * {w}(q)
        slope -= weight[k] * (q * {dw}(q))
    return np.float64(total), np.float64(slope)


@njit(error_model="numpy", nogil=True)
def load_sources(found, count, origin, buffer, position, mass):
    if count + 1 > buffer.shape[1]:
        buffer = np.empty((7, 2 * count), real)
    x0, y0, z0 = 0.0, 0.0, 0.0
    if RELATIVE:
        x0, y0, z0 = position[origin, 0], position[origin, 1], position[origin, 2]
    to_x, to_y, to_z, to_mass = buffer[0], buffer[1], buffer[2], buffer[3]
    for k in range(count):
        j = found[k]
        to_x[k] = real(position[j, 0] - x0)
        to_y[k] = real(position[j, 1] - y0)
        to_z[k] = real(position[j, 2] - z0)
        to_mass[k] = real(mass[j])
    return buffer


@njit(fastmath=LOOP_FLAGS, error_model="numpy", nogil=True)
def squared_distances(x, y, z, s, count, square):
    x_i, y_i, z_i = x[s], y[s], z[s]
    for k in range(count):
        dx, dy, dz = x_i - x[k], y_i - y[k], z_i - z[k]
        square[k] = dx * dx + dy * dy + dz * dz


@njit(error_model="numpy", nogil=True)
def select(buffer, count, s, reach, distance, weight):
    # The sources within reach of source s, closed up: distances and masses, padded to whole vectors. NaN is kept.
    square, mass = buffer[4], buffer[3]
    squared_distances(buffer[0], buffer[1], buffer[2], s, count, square)
    if count + 32 > len(distance):
        distance = np.empty(2 * count + 32, real)
        weight = np.empty(2 * count + 32, real)
    reach2 = real(reach * reach)
    n = 0
    for k in range(count):
        distance[n] = square[k]
        weight[n] = mass[k]
        n += 1 - np.int64(square[k] >= reach2)
    vectors = ((n + 15) // 16) * 16
    for k in range(n, vectors):
        distance[k] = real(0)
        weight[k] = real(0)
    for k in range(vectors):
        distance[k] = np.sqrt(distance[k])
    return vectors, distance, weight


@njit(error_model="numpy", nogil=True)
def density_worker_{tag}(
    counter, position, mass, guess, support, eta, tolerance, margin, lo, hi, nothing, no_node, node_guess, start,
    smoothing_length, density, grad_h, zeta
):
    leaves = len(start) - 1
    found = np.empty(1024, np.int64)
    buffer = np.empty((7, 1024), real)
    own_found = np.empty(1024, np.int64)
    own_buffer = np.empty((7, 1024), real)
    distance = np.empty(1024, real)
    weight = np.empty(1024, real)
    box = np.empty((2, 3))
    smallest = 1e-12 * np.sqrt((hi[1, 0] - lo[1, 0]) ** 2 + (hi[1, 1] - lo[1, 1]) ** 2 + (hi[1, 2] - lo[1, 2]) ** 2)
    while True:
        leaf = take(counter)
        if leaf >= leaves:
            break
        first, last = start[leaf], start[leaf + 1]
        box[0], box[1] = lo[leaves + leaf], hi[leaves + leaf]
        limit = margin * node_guess[leaves + leaf]
        count, found = gather(
            position, nothing, lo, hi, no_node, start, box, support * limit, found
        )
        slot = 0
        while found[slot] != first:
            slot += 1
        buffer = load_sources(found, count, first, buffer, position, mass)
        for i in range(first, last):
            h = guess[i]
            listed = margin * h
            vectors, distance, weight = select(buffer, count, slot + i - first, support * listed, distance, weight)
            low, high = 0.0, np.inf
            target = mass[i] * eta**3
            total = slope = 0.0
            new = h
            for attempt in range(200):
                if h > listed:
                    listed = 1.25 * h
                    if listed <= limit:
                        vectors, distance, weight = select(
                            buffer, count, slot + i - first, support * listed, distance, weight
                        )
                    else:
                        box[0], box[1] = position[i], position[i]
                        own_count, own_found = gather(
                            position, nothing, lo, hi, no_node, start, box, support * listed, own_found
                        )
                        own_slot = 0
                        while own_found[own_slot] != i:
                            own_slot += 1
                        own_buffer = load_sources(own_found, own_count, i, own_buffer, position, mass)
                        vectors, distance, weight = select(
                            own_buffer, own_count, own_slot, support * listed, distance, weight
                        )
                total, slope = moments(distance, weight, vectors, real(1.0 / h))
                if np.isnan(total):
                    new = h = np.nan
                    break
                if total < target:
                    low = h
                else:
                    high = h
                factor = step_factor(target / total - 1.0, total, slope)
                new = h * factor
                if abs(factor - 1.0) <= tolerance:
                    break
                if high - low <= tolerance * h or (h <= smallest and total > target):
                    new = h
                    break
                if not low < new < high:
                    new = np.sqrt(low * high) if low > 0.0 and high < np.inf else (2.0 * h if low > 0.0 else 0.5 * h)
                h = new
            smoothing_length[i] = new
            density[i] = (total + slope * (new - h) / h) / new**3
            grad_h[i] = slope / (3.0 * total)
            zeta[i] = np.float64(softening_moment(distance, weight, vectors, real(1.0 / h))) / (3.0 * density[i] * new)


@njit(error_model="numpy", nogil=True)
def step_factor(excess, total, slope):
    # The ratio of the next h to this one: (target/S)^(1/s) with s = dlog S/dlog h, to second order where that is enough.
    if slope <= 1e-3 * total:
        return 2.0 if excess > 0.0 else 0.5
    exponent = total / slope
    if abs(excess) < 0.1:
        return 1.0 + exponent * excess * (1.0 + 0.5 * (exponent - 1.0) * excess)
    return min(2.0, max(0.5, (1.0 + excess) ** exponent))


@njit(parallel=True, cache=True, error_model="numpy")
def density_pass_{tag}(
    threads, counter, position, mass, guess, support, eta, tolerance, margin, lo, hi, nothing, no_node, node_guess,
    start, smoothing_length, density, grad_h, zeta
):
    for _ in prange(threads):
        density_worker_{tag}(
            counter, position, mass, guess, support, eta, tolerance, margin, lo, hi, nothing, no_node, node_guess,
            start, smoothing_length, density, grad_h, zeta
        )
"""
