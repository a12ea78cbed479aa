"""The text of the fast gravity's loops: nodes refitted upwards, then targets downwards with their lists of sources.

A pair of nodes is parted, taken by expansions or taken particle by particle by rules that are the same from both sides,
and either side's sums are written by itself: no sum is shared, so results have the same bits for any number of threads,
and forces are opposite to rounding. Each target looks through its candidates a vector at a time and hands on to its
children those that are no larger than itself.
"""

UPWARD = """
@njit(**PART)
def fit_leaf(node, first, last, order, position, mass, reach, inverse_h, weight, origin, scale, mass_scale,
             x, y, z, m, reach2, ih, where_is, about, raw):
    total = sx = sy = sz = squares = 0.0
    furthest_reach = 0.0
    for k in range(first, last):
        i = order[k]
        x[k] = (position[i, 0] - origin[0]) * scale
        y[k] = (position[i, 1] - origin[1]) * scale
        z[k] = (position[i, 2] - origin[2]) * scale
        mass_k = mass[i] * mass_scale
        reach_k = reach * scale / inverse_h[i]
        m[k], reach2[k], ih[k] = real(mass_k), real(reach_k * reach_k), real(inverse_h[i] / scale)
        mass_k = np.float64(m[k])
        total += mass_k
        sx += mass_k * x[k]
        sy += mass_k * y[k]
        sz += mass_k * z[k]
        squares += weight[i]
        furthest_reach = reach_k if reach_k > furthest_reach else furthest_reach
    if not total > 0.0:
        total, sx, sy, sz = 0.0, x[first], y[first], z[first]
    else:
        sx, sy, sz = sx / total, sy / total, sz / total
    radius2 = second = 0.0
    for k in range(first, last):
        dx, dy, dz = x[k] - sx, y[k] - sy, z[k] - sz
        r2 = dx * dx + dy * dy + dz * dz
        second += m[k] * r2
        radius2 = r2 if r2 > radius2 else radius2
    particle_moments(first, last, x, y, z, m, sx, sy, sz, raw[node])
    where_is[4 * node], where_is[4 * node + 1], where_is[4 * node + 2] = sx, sy, sz
    finish(node, last - first, total, np.sqrt(radius2), second, squares, furthest_reach, where_is, about)


@njit(**PART)
def finish(node, count, total, radius, second, squares, furthest_reach, where_is, about):
    # about: radius, radius for the error, mass, 1/|a| (rms), furthest reach, scale of moments, second moment, sum 1/a^2
    spread = np.sqrt(second / total) if total > 0.0 else radius
    about[8 * node] = real(radius)
    about[8 * node + 1] = real(spread)
    about[8 * node + 2] = real(total)
    about[8 * node + 3] = real(np.sqrt(squares / count))
    about[8 * node + 4] = real(furthest_reach)
    about[8 * node + 5] = real(max(radius, 0.5 * furthest_reach))
    about[8 * node + 6] = real(second)
    where_is[4 * node + 3] = squares


@njit(**PART)
def fit_node(node, left, count, where_is, about, raw):
    # From two children: their moments about the common centre, and the smaller of two bounds of the radius.
    right = left + 1
    one, other = np.float64(about[8 * left + 2]), np.float64(about[8 * right + 2])
    total = one + other
    share = one / total if total > 0.0 else 0.5
    for a in range(3):
        where_is[4 * node + a] = share * where_is[4 * left + a] + (1.0 - share) * where_is[4 * right + a]
    radius = second = furthest_reach = 0.0
    row = raw[node]
    row[:] = 0.0
    for child in (left, right):
        dx = where_is[4 * node] - where_is[4 * child]
        dy = where_is[4 * node + 1] - where_is[4 * child + 1]
        dz = where_is[4 * node + 2] - where_is[4 * child + 2]
        add_moments(dx, dy, dz, raw[child], row)
        apart2 = dx * dx + dy * dy + dz * dz
        radius = max(radius, np.sqrt(apart2) + np.float64(about[8 * child]))
        second += np.float64(about[8 * child + 6]) + np.float64(about[8 * child + 2]) * apart2
        furthest_reach = max(furthest_reach, np.float64(about[8 * child + 4]))
    squares = where_is[4 * left + 3] + where_is[4 * right + 3]
    finish(node, count, total, radius * RADIUS_SLACK, second, squares, furthest_reach, where_is, about)


@njit(**PART)
def fit_any(node, first, last, child, order, position, mass, reach, inverse_h, weight, origin, scale, mass_scale,
            x, y, z, m, reach2, ih, where_is, about, raw, moments):
    if child[node] == 0:
        fit_leaf(node, first[node], last[node], order, position, mass, reach, inverse_h, weight, origin, scale,
                 mass_scale, x, y, z, m, reach2, ih, where_is, about, raw)
    else:
        fit_node(node, np.int64(child[node]), last[node] - first[node], where_is, about, raw)
    store_moments(node, np.float64(about[8 * node + 5]), raw[node], moments)


@njit(cache=True, nogil=True, error_model="numpy")
def upward(counter, first, last, child, task, begin, order, position, mass, reach, inverse_h, weight, origin, scale,
           mass_scale, x, y, z, m, reach2, ih, where_is, about, raw, moments):
    while True:
        t = take(counter)
        if t >= len(task):
            break
        for n in range(begin[t + 1] - begin[t] + 1):
            node = begin[t + 1] - 1 - n if n < begin[t + 1] - begin[t] else task[t]
            fit_any(node, first, last, child, order, position, mass, reach, inverse_h, weight, origin, scale,
                    mass_scale, x, y, z, m, reach2, ih, where_is, about, raw, moments)


@njit(cache=True, nogil=True, error_model="numpy")
def upward_top(first, last, child, begin, where_is, about, raw, moments):
    tasks = set_of_tasks = 0
    for node in range(begin[0] - 1, -1, -1):
        left = np.int64(child[node])
        if left > 0 and left < begin[0]:
            fit_node(node, left, last[node] - first[node], where_is, about, raw)
            store_moments(node, np.float64(about[8 * node + 5]), raw[node], moments)
"""

DOWNWARD = """
@njit(fastmath=TEST_FLAGS, **PART)
def sort_candidates(node, listed, count, where_is, about, child, theta, tolerance, far, part, rest):
    # Keys below 0: taken by expansions; parted; handed on to the target's children, or near where it is a leaf.
    widest_vectors()
    x_a, y_a, z_a = where_is[4 * node], where_is[4 * node + 1], where_is[4 * node + 2]
    r_a, s_a, m_a, g_a, reach_a = (
        about[8 * node], about[8 * node + 1], about[8 * node + 2], about[8 * node + 3], about[8 * node + 4]
    )
    leaf_a = child[node] == 0
    for k in range(count):
        b = listed[k]
        x, y, z = (
            real(x_a - at(where_is, 4 * b)), real(y_a - at(where_is, 4 * b + 1)), real(z_a - at(where_is, 4 * b + 2))
        )
        r_b, s_b, m_b, g_b, reach_b = (
            at(about, 8 * b), at(about, 8 * b + 1), at(about, 8 * b + 2), at(about, 8 * b + 3), at(about, 8 * b + 4)
        )
        r2 = x * x + y * y + z * z
        inverse = inverse_distance(r2)
        r = r2 * inverse
        both = r_a + r_b
        ratio = (s_a + s_b) * inverse
        error = larger_of(m_b * g_a, m_a * g_b) * (inverse * inverse) * RATIO_POWER
        reach = larger_of(reach_a, reach_b)
        accepted = (both < theta * r) & (error <= tolerance) & (r - both > reach)
        leaf_b = at(child, b) == 0
        other = leaf_a | ((not leaf_b) & ((r_b > r_a) | ((r_b == r_a) & (b < node))))
        parted = (not accepted) & (not leaf_b) & other
        far[k] = where(accepted, real(-1), real(1))
        part[k] = where(parted, real(-1), real(1))
        rest[k] = where(accepted | parted, real(1), real(-1))


@njit(fastmath=LOOP_FLAGS, **PART)
def plain_sums(targets, count, sources, field):
    # Particles that no softening reaches.
    widest_vectors()
    all_x, all_y, all_z, mass = sources[0], sources[1], sources[2], sources[3]
    for i in range(targets.shape[1] - 2 * LANES):
        if i >= np.int64(targets[5, 0]):
            break
        x_i, y_i, z_i = targets[0, i], targets[1, i], targets[2, i]
        sum_x = sum_y = sum_z = sum_phi = real(0)
        for j in range(padded(count)):
            x, y, z = all_x[j] - x_i, all_y[j] - y_i, all_z[j] - z_i
            inverse = inverse_distance(x * x + y * y + z * z)
            potential = mass[j] * inverse
            force = potential * (inverse * inverse)
            sum_phi += potential
            sum_x += force * x
            sum_y += force * y
            sum_z += force * z
        field[0, i] += sum_x
        field[1, i] += sum_y
        field[2, i] += sum_z
        field[3, i] -= sum_phi


@njit(fastmath=LOOP_FLAGS, **PART)
def softened_sums(targets, count, sources, index, field):
    # All as 1/r beyond the reach and constant within, then what softening makes different within the reach.
    widest_vectors()
    all_x, all_y, all_z, mass, reach2, all_ih = sources[0], sources[1], sources[2], sources[3], sources[4], sources[5]
    for i in range(targets.shape[1] - 2 * LANES):
        if i >= np.int64(targets[5, 0]):
            break
        x_i, y_i, z_i, reach2_i, ih_i = targets[0, i], targets[1, i], targets[2, i], targets[3, i], targets[4, i]
        sum_x = sum_y = sum_z = sum_phi = real(0)
        for j in range(padded(count)):
            x, y, z = all_x[j] - x_i, all_y[j] - y_i, all_z[j] - z_i
            inverse = inverse_distance(larger_of(larger_of(reach2_i, reach2[j]), x * x + y * y + z * z))
            potential = mass[j] * inverse
            force = potential * (inverse * inverse)
            sum_phi += potential
            sum_x += force * x
            sum_y += force * y
            sum_z += force * z
        within = near_indices(all_x, all_y, all_z, reach2, x_i, y_i, z_i, reach2_i, count, index, index)
        for k in range(within, padded(within)):
            index[k] = count
        for k in range(padded(within)):
            j = index[k]
            x, y, z = at(all_x, j) - x_i, at(all_y, j) - y_i, at(all_z, j) - z_i
            r2 = x * x + y * y + z * z
            clipped = inverse_distance(larger_of(larger_of(reach2_i, at(reach2, j)), r2))
            inverse = inverse_distance(r2)
            r = r2 * inverse
            ih_j, mass_j = at(all_ih, j), at(mass, j)
            q_i, q_j = r * ih_i, r * ih_j
            softened = real(0.5) * inverse * (kernel_dphi(q_i) * (ih_i * ih_i) + kernel_dphi(q_j) * (ih_j * ih_j))
            force = mass_j * (softened - clipped * (clipped * clipped))
            sum_phi -= mass_j * (real(0.5) * (kernel_phi(q_i) * ih_i + kernel_phi(q_j) * ih_j) + clipped)
            sum_x += force * x
            sum_y += force * y
            sum_z += force * z
        field[0, i] += sum_x
        field[1, i] += sum_y
        field[2, i] += sum_z
        field[3, i] -= sum_phi


@njit(**PART)
def copied(first, last, x_c, y_c, z_c, x, y, z, m, reach2, ih, buffer, count):
    row_x, row_y, row_z, row_m, row_r, row_h = buffer[0], buffer[1], buffer[2], buffer[3], buffer[4], buffer[5]
    for k in range(last - first):
        row_x[count + k] = real(x[first + k] - x_c)
        row_y[count + k] = real(y[first + k] - y_c)
        row_z[count + k] = real(z[first + k] - z_c)
        row_m[count + k] = m[first + k]
        row_r[count + k] = reach2[first + k]
        row_h[count + k] = ih[first + k]
    return count + last - first


@njit(**PART)
def closed(buffer, count):
    # Massless sources fill up the last vectors.
    for k in range(count, padded(count) + LANES):
        buffer[0, k] = buffer[1, k] = buffer[2, k] = real(1e6)
        buffer[3, k] = buffer[4, k] = real(0)
        buffer[5, k] = real(1)


@njit(**PART)
def leaf_sums(node, near, near_count, local, first, last, where_is, about, x, y, z, m, reach2, ih, order,
              targets, plain, soft, index, field, acceleration, potential, force_unit, potential_unit):
    x_c, y_c, z_c = where_is[4 * node], where_is[4 * node + 1], where_is[4 * node + 2]
    begin, end = first[node], last[node]
    count = end - begin
    for k in range(count):
        targets[0, k], targets[1, k], targets[2, k] = (
            real(x[begin + k] - x_c), real(y[begin + k] - y_c), real(z[begin + k] - z_c)
        )
        targets[3, k], targets[4, k] = reach2[begin + k], ih[begin + k]
    for k in range(count, padded(count)):
        targets[0, k] = targets[1, k] = targets[2, k] = real(0)
    targets[5, 0] = real(count)
    field_of_local(count, np.float64(about[8 * node + 5]), local, targets[0], targets[1], targets[2], field)
    total = 0
    for k in range(near_count):
        total += last[near[k]] - first[near[k]]
    plain, soft = with_columns(plain, total), with_columns(soft, total)
    index = with_room(index, total)
    plains = softs = 0
    for k in range(near_count):
        b = np.int64(near[k])
        dx, dy, dz = where_is[4 * b] - x_c, where_is[4 * b + 1] - y_c, where_is[4 * b + 2] - z_c
        gap = np.sqrt(dx * dx + dy * dy + dz * dz) - about[8 * node] - about[8 * b]
        if gap > larger_of(about[8 * node + 4], about[8 * b + 4]) * GAP_SLACK:
            plains = copied(first[b], last[b], x_c, y_c, z_c, x, y, z, m, reach2, ih, plain, plains)
        else:
            softs = copied(first[b], last[b], x_c, y_c, z_c, x, y, z, m, reach2, ih, soft, softs)
    closed(plain, plains)
    closed(soft, softs)
    plain_sums(targets, plains, plain, field)
    softened_sums(targets, softs, soft, index, field)
    for k in range(count):
        i = order[begin + k]
        for a in range(3):
            acceleration[i, a] = np.float64(field[a, k]) * force_unit
        potential[i] = np.float64(field[3, k]) * potential_unit
    return plain, soft, index


@njit(**PART)
def roomier(array, filled, count):
    # Room for `count` more elements after what is kept.
    if filled + count + 2 * LANES <= len(array):
        return array
    larger = np.empty(2 * (filled + count) + 2 * LANES, array.dtype)
    larger[:filled] = array[:filled]
    return larger


@njit(**PART)
def seek(node, handed, filled, where_is, about, child, theta, tolerance, lists, keys):
    # Sorts all candidates of a node: handed on to it, and its sibling; the numbers of far and of rest.
    now, later, far, rest = lists[0], lists[1], lists[2], lists[3]
    count, fars, rests = filled, 0, 0
    for k in range(filled):
        now[k] = handed[k]
    while count > 0:
        sort_candidates(node, now, count, where_is, about, child, theta, tolerance, keys[0], keys[1], keys[2])
        fars = compressed_values(now, keys[0], count, far, fars)
        rests = compressed_values(now, keys[2], count, rest, rests)
        parted = compressed_values(now, keys[1], count, later, 0)
        for k in range(parted):
            left = child[later[k]]
            now[2 * k], now[2 * k + 1] = left, left + np.int32(1)
        count = 2 * parted
    return fars, rests


@njit(cache=True, nogil=True, error_model="numpy")
def descend(start, only_top, begin, first, last, child, levels, parent_of, seeds, seed_local, where_is, about, moments,
            x, y, z, m, reach2, ih, order, theta, tolerance, acceleration, potential, force_unit, potential_unit,
            leaf_size, saved, saved_end, saved_local, task_of):
    # From the node `start`, which was handed the candidates `seeds` and its parent's coefficients, to the leaves below.
    # With only_top, tasks are not entered: what they are handed is saved.
    width = seed_local.shape[0]
    nodes = len(first)
    handed = np.empty(len(seeds) + 1024, np.int32)
    handed[: len(seeds)] = seeds
    ends = np.zeros(levels + 2, np.int64)
    ends[0] = len(seeds)
    local = np.zeros((levels + 2, width))
    local[0] = seed_local
    lists = np.empty((4, nodes + 2 * LANES), np.int32)
    keys = np.empty((3, nodes + 2 * LANES), real)
    stack, depths = np.empty(2 * levels + 2, np.int64), np.empty(2 * levels + 2, np.int64)
    targets, field = np.empty((6, leaf_size + 3 * LANES), real), np.empty((4, leaf_size + 3 * LANES), real)
    plain, soft = np.empty((6, 2048), real), np.empty((6, 2048), real)
    index = np.empty(2048, np.int32 if RELATIVE else np.int64)
    stack[0], depths[0], height = start, 1, 1
    saved_count = 0
    while height > 0:
        height -= 1
        node, depth = stack[height], depths[height]
        parent = np.int64(parent_of[node])
        offset = 0 if depth == 1 else ends[depth - 2]
        handed = roomier(handed, ends[depth - 1], 1)
        filled = ends[depth - 1]
        if parent != node:
            sibling = 2 * np.int64(child[parent]) + 1 - node
            handed[filled] = np.int32(sibling)
            filled += 1
        if only_top and task_of[node] >= 0:
            saved = roomier(saved, saved_count, filled - offset)
            for k in range(ends[depth - 1] - offset):
                saved[saved_count + k] = handed[offset + k]
            saved_count += ends[depth - 1] - offset
            saved_end[task_of[node]] = saved_count
            saved_local[task_of[node]] = local[depth - 1]
            continue
        fars, rests = seek(
            node, handed[offset:filled], filled - offset, where_is, about, child, theta, tolerance, lists, keys
        )
        shift_local(
            where_is[4 * node] - where_is[4 * parent], where_is[4 * node + 1] - where_is[4 * parent + 1],
            where_is[4 * node + 2] - where_is[4 * parent + 2], local[depth - 1], local[depth]
        )
        for k in range(fars, padded(fars)):
            lists[2, k] = lists[2, 0]
        far_field(lists[2], fars, where_is[4 * node], where_is[4 * node + 1], where_is[4 * node + 2],
                  about[8 * node + 5], where_is, about, moments, local[depth])
        if child[node] == 0:
            lists[3, rests] = np.int32(node)
            plain, soft, index = leaf_sums(
                node, lists[3], rests + 1, local[depth], first, last, where_is, about, x, y, z, m, reach2, ih, order,
                targets, plain, soft, index, field, acceleration, potential, force_unit, potential_unit
            )
            continue
        base = ends[depth - 1]
        handed = roomier(handed, base, rests + 1)
        for k in range(rests):
            handed[base + k] = lists[3, k]
        ends[depth] = base + rests
        stack[height], depths[height] = np.int64(child[node]) + 1, depth + 1
        stack[height + 1], depths[height + 1] = np.int64(child[node]), depth + 1
        height += 2
    return saved


@njit(cache=True, nogil=True, error_model="numpy")
def descend_tasks(counter, task, begin, first, last, child, levels, parent_of, saved, saved_begin, saved_end,
                  saved_local, where_is, about, moments, x, y, z, m, reach2, ih, order, theta, tolerance, acceleration,
                  potential, force_unit, potential_unit, leaf_size, task_of):
    while True:
        t = take(counter)
        if t >= len(task):
            break
        descend(task[t], False, begin, first, last, child, levels, parent_of, saved[saved_begin[t] : saved_end[t]],
                saved_local[t], where_is, about, moments, x, y, z, m, reach2, ih, order, theta, tolerance,
                acceleration, potential, force_unit, potential_unit, leaf_size, saved, saved_end, saved_local, task_of)
"""
