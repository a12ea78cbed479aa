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
@njit(fastmath=LOOP_FLAGS, **PART)
def softening_moment(distance, weight, vectors, inverse_h):
    widest_vectors()
    total = real(0)
    for k in range(vectors):
        q = distance[k] * inverse_h
        total += weight[k] * ({phi}(q) + q * {dphi}(q))
    return total
"""

DENSITY = """
@njit(fastmath=LOOP_FLAGS, **PART)
def moments(distance, weight, vectors, inverse_h):
    widest_vectors()
    total = real(0)
    slope = real(0)
    for k in range(vectors):
        q = distance[k] * inverse_h
        total += weight[k] * {w}(q)
        slope -= weight[k] * (q * {dw}(q))
    return np.float64(total), np.float64(slope)


@njit(**PART)
def load_sources(found, count, origin, buffer, x, y, z, mass):
    widest_vectors()
    if padded(count) + LANES > buffer.shape[1]:
        buffer = np.empty((4, 2 * count + 2 * LANES), real)
    to_x, to_y, to_z, to_mass = buffer[0], buffer[1], buffer[2], buffer[3]
    x0, y0, z0 = 0.0, 0.0, 0.0
    if RELATIVE:
        x0, y0, z0 = x[origin], y[origin], z[origin]
    for k in range(count):
        to_x[k] = real(at(x, found[k]) - x0)
        to_y[k] = real(at(y, found[k]) - y0)
        to_z[k] = real(at(z, found[k]) - z0)
        to_mass[k] = real(at(mass, found[k]))
    return buffer


@njit(fastmath=LOOP_FLAGS, **PART)
def squared_distances(x, y, z, s, count, reach2, square, key):
    widest_vectors()
    x_i, y_i, z_i = x[s], y[s], z[s]
    for k in range(count):
        dx, dy, dz = x_i - x[k], y_i - y[k], z_i - z[k]
        square[k] = dx * dx + dy * dy + dz * dz
        key[k] = square[k] - reach2


@njit(fastmath=LOOP_FLAGS, **PART)
def take_roots(distance, count):
    widest_vectors()
    for k in range(count):
        distance[k] *= inverse_distance(distance[k])


@njit(**PART)
def select(buffer, count, s, reach, lists):
    # The sources within reach of source s, closed up: distances and masses, padded to whole vectors. NaN is kept.
    if count + 2 * LANES > lists.shape[1]:
        lists = np.empty((4, 2 * count + 2 * LANES), real)
    distance, weight, square, key = lists[0], lists[1], lists[2], lists[3]
    squared_distances(buffer[0], buffer[1], buffer[2], s, count, real(reach * reach), square, key)
    vectors = filled_up(key, count)
    n = compressed_values(square, key, vectors, distance, 0)
    compressed_values(buffer[3], key, vectors, weight, 0)
    for k in range(n, padded(n)):
        distance[k] = real(0)
        weight[k] = real(0)
    take_roots(distance, padded(n))
    return padded(n), lists


@njit(cache=True, nogil=True, error_model="numpy")
def density_pass_{tag}(
    counter, x, y, z, mass, guess, support, eta, tolerance, margin, lo, hi, nothing, no_node, node_guess, start,
    smoothing_length, density, grad_h, zeta
):
    leaves = len(start) - 1
    group = min(leaves, GROUP)
    key, listed, found = np.empty(1024), np.empty(1024, np.int64), np.empty(1024, np.int64)
    leaf_rows = np.empty((8, 1024))
    buffer = np.empty((4, 1024), real)
    lists = np.empty((4, 1024), real)
    own_rows = np.empty((8, 1024))
    own_buffer = np.empty((4, 1024), real)
    own_found = np.empty(1024, np.int64)
    box = np.empty((2, 3))
    smallest = 1e-12 * np.sqrt((hi[1, 0] - lo[1, 0]) ** 2 + (hi[1, 1] - lo[1, 1]) ** 2 + (hi[1, 2] - lo[1, 2]) ** 2)
    while True:
        task = take(counter)
        if task * group >= leaves:
            break
        node = leaves // group + task
        box[0], box[1] = lo[node], hi[node]
        leaf_count, leaf_rows = reachable_leaves(lo, hi, no_node, box, support * margin * node_guess[node], leaf_rows)
        for leaf in range(task * group, (task + 1) * group):
            first, last = start[leaf], start[leaf + 1]
            box[0], box[1] = lo[leaves + leaf], hi[leaves + leaf]
            limit = margin * node_guess[leaves + leaf]
            count, key, listed, found = gather(
                x, y, z, nothing, start, leaf_rows, leaf_count, box, support * limit, key, listed, found
            )
            slot = place_of(first, found[:count])
            buffer = load_sources(found, count, first, buffer, x, y, z, mass)
            for i in range(first, last):
                h = guess[i]
                covered = margin * h
                vectors, lists = select(buffer, count, slot + i - first, support * covered, lists)
                low, high = 0.0, np.inf
                target = mass[i] * eta**3
                total = slope = 0.0
                new = h
                for attempt in range(200):
                    if h > covered:
                        covered = 1.25 * h
                        if covered <= limit:
                            vectors, lists = select(buffer, count, slot + i - first, support * covered, lists)
                        else:
                            box[0, 0], box[0, 1], box[0, 2] = x[i], y[i], z[i]
                            box[1] = box[0]
                            own_leaves, own_rows = reachable_leaves(lo, hi, no_node, box, support * covered, own_rows)
                            own_count, key, listed, own_found = gather(
                                x, y, z, nothing, start, own_rows, own_leaves, box, support * covered, key, listed,
                                own_found
                            )
                            own_buffer = load_sources(own_found, own_count, i, own_buffer, x, y, z, mass)
                            own_slot = place_of(i, own_found[:own_count])
                            vectors, lists = select(own_buffer, own_count, own_slot, support * covered, lists)
                    total, slope = moments(lists[0], lists[1], vectors, real(1.0 / h))
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
                        if low > 0.0 and high < np.inf:
                            new = np.sqrt(low * high)
                        else:
                            new = 2.0 * h if low > 0.0 else 0.5 * h
                    h = new
                smoothing_length[i] = new
                density[i] = (total + slope * (new - h) / h) / new**3
                grad_h[i] = slope / (3.0 * total)
                zeta[i] = np.float64(softening_moment(lists[0], lists[1], vectors, real(1.0 / h)))
                zeta[i] /= 3.0 * density[i] * new


@njit(**PART)
def step_factor(excess, total, slope):
    # The ratio of the next h to this one: (target/S)^(1/s) with s = dlog S/dlog h, to second order where that is enough.
    if slope <= 1e-3 * total:
        return 2.0 if excess > 0.0 else 0.5
    exponent = total / slope
    if abs(excess) < 0.1:
        return 1.0 + exponent * excess * (1.0 + 0.5 * (exponent - 1.0) * excess)
    return min(2.0, max(0.5, (1.0 + excess) ** exponent))

"""
