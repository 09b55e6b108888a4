// Finds the nearest splat of many points, like kernels/nearest_splat.py, in
// single precision, with one team per point.
//
// A record contains the centre, the axes in the order of descending semi-axes,
// the three semi-axes (the last 0 for a disc) and the uncertainty. Boxes are
// enlarged by the uncertainty.

#include "clusters.cuh"

struct Nearest {
  float distance;
  int place;
};

struct Closest {
  float distance;
  float x[3]; // in the splat's frame
};

// The p of |p(t)| = 1, see kernels/ellipsoid_distance.py.
HELPER void unit_point(float n[3], float r0, float r1, float p[3]) {
  float d0 = r0 - 1.0f, d1 = r1 - 1.0f;
  if (n[2] < 1e-30f) n[2] = 0.0f;
  float t = fmaxf(fmaxf(n[2], fmaxf(n[1] - d1, n[0] - d0)), 0.0f);
  if (t <= 0.0f) {
    // On the plane of the two longer axes, near the centre.
    p[0] = n[0] > 0.0f ? n[0] / d0 : 0.0f;
    p[1] = n[1] > 0.0f ? n[1] / d1 : 0.0f;
    float rest = 1.0f - p[0] * p[0] - p[1] * p[1];
    p[2] = sqrtf(fmaxf(rest, 0.0f));
    if (n[2] == 0.0f && rest > 0.0f) return;
    t = 1e-30f;
  }
  for (int i = 0; i < 60; ++i) {
    float i0 = 1.0f / (t + d0), i1 = 1.0f / (t + d1), i2 = 1.0f / t;
    float p0 = n[0] * i0, p1 = n[1] * i1, p2 = n[2] * i2;
    float s0 = p0 * p0, s1 = p1 * p1, s2 = p2 * p2;
    float square = s0 + s1 + s2;
    float slope = s0 * i0 + s1 * i1 + s2 * i2;
    float step = (sqrtf(square) - 1.0f) * square / slope;
    if (!(step > 0.0f)) break;
    t += step;
    // The error after a step is proportional to the square of the step.
    if (step <= 2e-4f * t) break;
  }
  p[0] = n[0] / (t + d0);
  p[1] = n[1] / (t + d1);
  p[2] = n[2] / t;
}

HELPER Closest closest_on_disc(const float y[3], const float e[3]) {
  Closest c;
  float z0 = fabsf(y[0]) / e[0], z1 = fabsf(y[1]) / e[1];
  if (z0 * z0 + z1 * z1 <= 1.0f) {
    c.distance = fabsf(y[2]);
    c.x[0] = y[0], c.x[1] = y[1], c.x[2] = 0.0f;
    return c;
  }
  float ratio = fminf(e[0] / e[1], 1e6f);
  float r = ratio * ratio;
  float n[3] = {r * z0, 0.0f, z1}, p[3];
  unit_point(n, r, 1.0f, p);
  c.x[0] = copysignf(e[0] * p[0], y[0]);
  c.x[1] = copysignf(e[1] * p[2], y[1]);
  c.x[2] = 0.0f;
  float a = y[0] - c.x[0], b = y[1] - c.x[1];
  c.distance = sqrtf(a * a + b * b + y[2] * y[2]);
  return c;
}

HELPER Closest closest_on_ellipsoid(const float y[3], const float e[3]) {
  // Single precision does not suffice for splats thinner than a millionth of
  // their length.
  float least = fmaxf(e[2], 1e-6f * e[0]);
  float z[3] = {fabsf(y[0]) / e[0], fabsf(y[1]) / fmaxf(e[1], least),
                fabsf(y[2]) / least};
  float r0 = e[0] / least, r1 = fmaxf(e[1], least) / least;
  r0 *= r0, r1 *= r1;
  bool inside = z[0] * z[0] + z[1] * z[1] + z[2] * z[2] < 1.0f;
  float n[3] = {r0 * z[0], r1 * z[1], z[2]}, p[3];
  unit_point(n, r0, r1, p);
  Closest c;
  c.x[0] = copysignf(e[0] * p[0], y[0]);
  c.x[1] = copysignf(fmaxf(e[1], least) * p[1], y[1]);
  c.x[2] = copysignf(least * p[2], y[2]);
  float a = y[0] - c.x[0], b = y[1] - c.x[1], d = y[2] - c.x[2];
  float distance = sqrtf(a * a + b * b + d * d);
  c.distance = inside ? -distance : distance;
  return c;
}

struct Splat {
  float3 offset; // from the point to the centre, in W
  float axes[9];
  float e[3];
  float uncertainty;
  float height;
};

HELPER Splat load_splat(const Clusters &scene, const Position &p, int place) {
  const float4 *record = (const float4 *)(scene.records + 16 * (size_t)place);
  float4 a = record[0], b = record[1], c = record[2], d = record[3];
  Splat s;
  s.offset = to_point(p, a.x, a.y, a.z);
  s.height = a.z;
  s.axes[0] = a.w, s.axes[1] = b.x, s.axes[2] = b.y;
  s.axes[3] = b.z, s.axes[4] = b.w, s.axes[5] = c.x;
  s.axes[6] = c.y, s.axes[7] = c.z, s.axes[8] = c.w;
  s.e[0] = d.x, s.e[1] = d.y, s.e[2] = d.z;
  s.uncertainty = d.w;
  return s;
}

HELPER void in_splat_frame(const Splat &s, float y[3]) {
  for (int i = 0; i < 3; ++i)
    y[i] = -(s.axes[3 * i] * s.offset.x + s.axes[3 * i + 1] * s.offset.y +
             s.axes[3 * i + 2] * s.offset.z);
}

HELPER float limit_of(float distance) {
  float reach = fmaxf(distance, 0.0f);
  return reach * reach;
}

// Returns the nearer of `best` and a splat; of equally near ones, the one with
// the lower index.
HELPER Nearest nearer(const Clusters &scene, const int *order, int is_surfel,
                      const Position &p, float floor, int place,
                      Nearest best) {
  Splat s = load_splat(scene, p, place);
  if (s.height < floor) return best;
  float y[3];
  in_splat_frame(s, y);
  float a = fmaxf(fabsf(y[0]) - s.e[0], 0.0f);
  float b = fmaxf(fabsf(y[1]) - s.e[1], 0.0f);
  float c = fmaxf(fabsf(y[2]) - s.e[2], 0.0f);
  float box = (a * a + b * b + c * c) * (1.0f - 1e-5f);
  if (box > limit_of(best.distance + s.uncertainty)) return best;
  Closest found = is_surfel ? closest_on_disc(y, s.e)
                            : closest_on_ellipsoid(y, s.e);
  float distance = found.distance - s.uncertainty;
  if (distance < best.distance) {
    best.distance = distance, best.place = place;
  } else if (distance == best.distance && best.place >= 0 &&
             order[place] < order[best.place]) {
    best.place = place;
  }
  return best;
}

// Returns the best result of all lanes of a team.
HELPER Nearest agreed(const int *order, Nearest mine) {
  for (int step = LANES / 2; step > 0; step /= 2) {
    Nearest other;
    other.distance = across(mine.distance, step);
    other.place = across(mine.place, step);
    bool takes = other.distance < mine.distance;
    if (other.distance == mine.distance && other.place >= 0)
      takes = mine.place < 0 || order[other.place] < order[mine.place];
    if (takes) mine = other;
  }
  return mine;
}

HELPER Nearest search_cluster(const Clusters &scene, const int *order,
                              int is_surfel, const Position &p, float floor,
                              int cluster, Nearest best) {
  for (int k = lane(); k < CLUSTER; k += LANES) {
    int place = cluster * CLUSTER + k;
    if (place < scene.n_splats)
      best = nearer(scene, order, is_surfel, p, floor, place, best);
  }
  return agreed(order, best);
}

// Returns the least squared distance of a team's boxes, and its lane.
HELPER void nearest_box(const float4 *boxes, int first, int end,
                        const Position &p, float floor, float &least,
                        int &which) {
  least = INFINITE, which = -1;
  for (int i = first + lane(); i < end; i += LANES) {
    float4 low = boxes[2 * i], high = boxes[2 * i + 1];
    float square = low.w >= floor ? box_distance_squared(p, low, high)
                                  : INFINITE;
    if (square < least) least = square, which = i;
  }
  for (int step = LANES / 2; step > 0; step /= 2) {
    float other = across(least, step);
    int whose = across(which, step);
    if (other < least || (other == least && whose > which))
      least = other, which = whose;
  }
}

// spheres: (n, 8): position and its remainder, the distance that a result must
// undercut, the height below which splats are ignored. answer: (n, 8): distance
// minus uncertainty (INFINITE for none), vector to the closest point,
// direction, 0.
KERNEL nearest_splats(Clusters scene, const int *order, int is_surfel,
                      const float *spheres, int n, float4 *answer) {
  for (int i = block() * teams() + team(); i < n; i += blocks() * teams()) {
    const float *sphere = spheres + 8 * (size_t)i;
    Position p = {sphere[0], sphere[1], sphere[2],
                  sphere[3], sphere[4], sphere[5]};
    float floor = sphere[7];
    Nearest best = {sphere[6], -1};
    // With a good first guess, from the nearest boxes, most other boxes are
    // skipped.
    float least;
    int start;
    nearest_box(scene.groups, 0, scene.n_groups, p, floor, least, start);
    if (start >= 0 && least <= limit_of(best.distance)) {
      int first = start * CLUSTER, end = first + CLUSTER;
      end = end < scene.n_clusters ? end : scene.n_clusters;
      nearest_box(scene.clusters, first, end, p, floor, least, start);
      if (start >= 0 && least <= limit_of(best.distance))
        best = search_cluster(scene, order, is_surfel, p, floor, start, best);
      else
        start = -1;
    }
    for (int g0 = 0; g0 < scene.n_groups; g0 += LANES) {
      int group = g0 + lane();
      float near = INFINITE;
      if (group < scene.n_groups) {
        float4 low = scene.groups[2 * group], high = scene.groups[2 * group + 1];
        if (low.w >= floor) near = box_distance_squared(p, low, high);
      }
      for (u32 mask = lanes_where(near <= limit_of(best.distance)); mask;
           mask &= mask - 1) {
        int who = first_of(mask);
        if (from_lane(near, who) > limit_of(best.distance)) continue;
        for (int c0 = 0; c0 < CLUSTER; c0 += LANES) {
          int cluster = (g0 + who) * CLUSTER + c0 + lane();
          float inner = INFINITE;
          if (cluster < scene.n_clusters && cluster != start) {
            float4 low = scene.clusters[2 * cluster];
            float4 high = scene.clusters[2 * cluster + 1];
            if (low.w >= floor) inner = box_distance_squared(p, low, high);
          }
          for (u32 close = lanes_where(inner <= limit_of(best.distance)); close;
               close &= close - 1) {
            int whose = first_of(close);
            if (from_lane(inner, whose) > limit_of(best.distance)) continue;
            best = search_cluster(scene, order, is_surfel, p, floor,
                                  (g0 + who) * CLUSTER + c0 + whose, best);
          }
        }
      }
    }
    if (lane() != 0) continue;
    if (best.place < 0) {
      answer[2 * i] = make_float4(INFINITE, 0.0f, 0.0f, 0.0f);
      answer[2 * i + 1] = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
      continue;
    }
    Splat s = load_splat(scene, p, best.place);
    float y[3], u[3];
    in_splat_frame(s, y);
    Closest c = is_surfel ? closest_on_disc(y, s.e)
                          : closest_on_ellipsoid(y, s.e);
    if (is_surfel && c.distance == 0.0f) {
      u[0] = u[1] = 0.0f, u[2] = 1.0f;
    } else if (!is_surfel && fabsf(c.distance) < 1e-5f * s.e[0]) {
      // On the surface x - y vanishes, so the surface's normal is used.
      for (int k = 0; k < 3; ++k) {
        float e = fmaxf(s.e[k], 1e-6f * s.e[0]);
        u[k] = -c.x[k] / e * (s.e[2] / e);
      }
    } else {
      for (int k = 0; k < 3; ++k) u[k] = (c.x[k] - y[k]) / c.distance;
    }
    float length = sqrtf(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    float to[3], n_W[3];
    float centre[3] = {s.offset.x, s.offset.y, s.offset.z};
    for (int k = 0; k < 3; ++k) {
      to[k] = centre[k] + s.axes[k] * c.x[0] + s.axes[3 + k] * c.x[1] +
              s.axes[6 + k] * c.x[2];
      n_W[k] = (s.axes[k] * u[0] + s.axes[3 + k] * u[1] +
                s.axes[6 + k] * u[2]) / length;
    }
    float distance = c.distance - s.uncertainty;
    answer[2 * i] = make_float4(distance, to[0], to[1], to[2]);
    answer[2 * i + 1] = make_float4(n_W[0], n_W[1], n_W[2], 0.0f);
  }
}
