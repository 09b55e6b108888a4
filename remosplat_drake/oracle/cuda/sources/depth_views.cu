// The nearest pixels of depth views, exact along every ray: the definition of
// `DepthSensor`, in single precision, one block a band of rows of one view.
//
// How: a fragment absorbs light -log2(1 - alpha), and what a ray has absorbed
// up to a range is a sum, which does not depend on any order. So a band is
// drawn with the splats nearer than a limit, and a pixel's median is nearer
// than that limit exactly where its sum reaches the median's threshold. While
// there is no such pixel, the limit grows. Where there is one, the least range
// at which any pixel's sum reaches it is found by bisection among the fragments
// that were drawn. Pixels that are not opaque by then have their rays followed
// to the end.
//
// Light is counted in whole 2^-20, so that sums are the same in any order and
// an answer never depends on which thread came first.
//
// A record is the centre and the radius of all that is seen; the three rows
// that map W to the splat's axes in standard deviations (a disc's third is its
// normal); the opacity, the largest squared Mahalanobis distance that is seen
// and the uncertainty. Boxes are wider by it.

#include "clusters.cuh"

#define GROUPS_AT_ONCE 32 // Groups whose clusters are listed at once.
#define LISTED 1024
#define SMALL 9           // Pixels that a lane draws on its own,
#define LARGE 256         // and from which on rows have spans.
#define ROW_LANES (LANES < 4 ? LANES : 4)
#define UNIT 1048576.0f   // Light is counted in 1 / UNIT.
#define ENOUGH 1073741824u // Far more than any threshold.

struct Rules {
  int resolution;
  int band_rows;
  int bands;
  int is_surfel;
  int nearest_only;
  u32 median_light; // absorbed where the median lies
  u32 opaque_light; // absorbed by pixels that count
  u32 most_light;   // of one fragment
  float near, far;
  float uncertainty; // the largest
  u32 room;          // fragments that a block may list
};

struct Fragment {
  u32 key; // of its range
  u32 light;
  int at; // its pixel in the band
};

// What a block shares.
struct Band {
  Position p;
  float R_WV[9];
  float sides_W[12]; // inward normals of the four planes around the band
  float floor;
  float bound;         // ranges beyond it are not asked for
  u32 nearest;         // key of a lower bound of all ranges
  u32 work, n_groups, n_clusters, n_fragments, n_counting, n_open, is_reached;
  int low_y, high_y;   // rows
  u64 best;            // key of the range, then the pixel
  int groups[LISTED];
  int clusters[LISTED]; // or pixels
};

// What a block knows of its pixels. Sums of light are kept for each, the rest
// is a bit for each.
struct Pixels {
  u32 *light;    // absorbed by fragments nearer than a limit
  u32 *total;    // absorbed as far as it is known
  u32 *counting; // the median is nearer than the limit, and the ray opaque
  u32 *open;     // the same, but perhaps it is not opaque
  u32 *dead;     // it is not
};

HELPER bool has(const u32 *bits, int at) { return bits[at / 32] >> at % 32 & 1; }

HELPER void add(u32 *bits, int at) { atomicOr(&bits[at / 32], 1u << at % 32); }

// A splat as a view sees it: see `footprints.project`.
struct Seen {
  float form[9];
  float height;    // of a disc's plane; for an ellipsoid its whitened
  float u, v;      // centre is (u, v, height)
  float opacity, cut, uncertainty;
  int columns, rows; // first + last * 65536
};

HELPER float coordinate(int pixel, const Rules &rules) {
  return (pixel + 0.5f) * 2.0f / rules.resolution - 1.0f;
}

HELPER float root(float value) { return sqrtf(fmaxf(value, 0.0f)); }

// Depth and squared Mahalanobis distance of a splat on the ray (x, y, 1).
HELPER void fragment_at(const Seen &s, int is_surfel, float x, float y,
                        float &z, float &weight) {
  float a = s.form[0] * x + s.form[1] * y + s.form[2];
  float b = s.form[3] * x + s.form[4] * y + s.form[5];
  float c = s.form[6] * x + s.form[7] * y + s.form[8];
  if (is_surfel) {
    float inverse = 1.0f / c;
    z = s.height * inverse;
    float u = a * inverse, v = b * inverse;
    weight = u * u + v * v;
  } else {
    z = (a * s.u + b * s.v + c * s.height) / (a * a + b * b + c * c);
    float da = z * a - s.u, db = z * b - s.v, dc = z * c - s.height;
    weight = da * da + db * db + dc * dc;
  }
}

// Light that a splat absorbs on a ray, 0 where it is not seen, and its range.
HELPER u32 absorbed(const Seen &s, const Rules &rules, float x, float y,
                    float limit, float &range) {
  float z, weight;
  fragment_at(s, rules.is_surfel, x, y, z, weight);
  if (!(weight <= s.cut) || !(z >= rules.near)) return 0;
  float length = sqrtf(x * x + y * y + 1.0f);
  range = z * length - s.uncertainty;
  if (!(range < limit) || !(z - s.uncertainty / length <= rules.far)) return 0;
  float alpha = s.opacity * expf(-0.5f * weight);
  float light = -log2f(1.0f - alpha) * UNIT;
  // Where nothing passes that is infinite.
  return light < (float)rules.most_light ? (u32)(light + 0.5f)
                                         : rules.most_light;
}

HELPER void to_view(const Band &band, float3 d, float &x, float &y, float &z) {
  const float *R = band.R_WV;
  x = R[0] * d.x + R[3] * d.y + R[6] * d.z;
  y = R[1] * d.x + R[4] * d.y + R[7] * d.z;
  z = R[2] * d.x + R[5] * d.y + R[8] * d.z;
}

struct Record {
  float3 offset;
  float radius;
  float rows[9];
  float opacity, cut, uncertainty;
};

// The record of a splat; false if it is below the floor or does not exist.
HELPER bool load_record(const Clusters &scene, const Band &band, int place,
                        Record &r) {
  if (place >= scene.n_splats) return false;
  const float4 *record = (const float4 *)(scene.records + 16 * (size_t)place);
  float4 a = record[0];
  if (a.z < band.floor) return false;
  float4 b = record[1], c = record[2], d = record[3];
  r.offset = to_point(band.p, a.x, a.y, a.z);
  r.radius = a.w;
  r.rows[0] = b.x, r.rows[1] = b.y, r.rows[2] = b.z;
  r.rows[3] = b.w, r.rows[4] = c.x, r.rows[5] = c.y;
  r.rows[6] = c.z, r.rows[7] = c.w, r.rows[8] = d.x;
  r.opacity = d.y, r.cut = d.z, r.uncertainty = d.w;
  return true;
}

// Whether a ball, or what reaches that far, may be seen in a band.
HELPER bool in_band(const Band &band, float3 d, float radius) {
  for (int k = 0; k < 4; ++k) {
    const float *n = band.sides_W + 3 * k;
    if (n[0] * d.x + n[1] * d.y + n[2] * d.z < -radius) return false;
  }
  return true;
}

// Bounds the ranges of a splat from below.
HELPER float nearest_range(const Record &r, int is_surfel) {
  float3 d = r.offset;
  float square = d.x * d.x + d.y * d.y + d.z * d.z, bound;
  if (is_surfel) {
    float height = r.rows[6] * d.x + r.rows[7] * d.y + r.rows[8] * d.z;
    float along = fmaxf(root(square - height * height) - r.radius, 0.0f);
    bound = sqrtf(height * height + along * along);
  } else {
    bound = sqrtf(square) - r.radius;
  }
  return bound - 1e-5f * sqrtf(square) - r.uncertainty;
}

// Which of pixels 0 to last have their centres between low and high.
HELPER int span(float low, float high, int resolution, int first, int last) {
  float half = 0.5f * resolution;
  // Not a number is not known: the whole image.
  if (!(low >= -1.0f)) low = -1.0f;
  if (!(high <= 1.0f)) high = 1.0f;
  int begin = (int)ceilf((low + 1.0f) * half - 0.55f);
  int end = (int)floorf((high + 1.0f) * half - 0.45f);
  begin = begin > first ? begin : first;
  end = end < last ? end : last;
  return begin > end ? -1 : begin + end * 65536;
}

// Narrows an interval of x / z to where a cone around n, of an angle with this
// sine, can be.
HELPER void within_cone(float n, float n_z, float sine, float &low,
                        float &high) {
  float q = n_z * n_z - sine * sine;
  if (!(n_z > sine && q > 1e-4f)) return; // It reaches beside the camera.
  float middle = n * n_z / q;
  float half = sine * root(n * n + q) / q * 1.001f + 1e-4f;
  low = fmaxf(low, middle - half), high = fminf(high, middle + half);
}

// Projects a splat; false if no pixel of the band can see it nearer than a
// limit.
HELPER bool project(const Record &r, const Band &band, const Rules &rules,
                    float limit, Seen &s) {
  const float *R = band.R_WV;
  float w[3], d[3];
  to_view(band, r.offset, d[0], d[1], d[2]);
  for (int i = 0; i < 3; ++i) {
    const float *row = r.rows + 3 * i;
    for (int j = 0; j < 3; ++j)
      s.form[3 * i + j] = row[0] * R[j] + row[1] * R[3 + j] + row[2] * R[6 + j];
    w[i] = row[0] * r.offset.x + row[1] * r.offset.y + row[2] * r.offset.z;
  }
  // The shape in V: E = cut sum(a_i a_i'), a_i being its axes times scales.
  float E_xx = 0.0f, E_yy = 0.0f, E_zz = 0.0f, E_xz = 0.0f, E_yz = 0.0f;
  for (int i = 0; i < (rules.is_surfel ? 2 : 3); ++i) {
    const float *m = s.form + 3 * i;
    float inverse = 1.0f / (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    float x = m[0] * inverse, y = m[1] * inverse, z = m[2] * inverse;
    E_xx += x * x, E_yy += y * y, E_zz += z * z;
    E_xz += x * z, E_yz += y * z;
  }
  E_xx *= r.cut, E_yy *= r.cut, E_zz *= r.cut, E_xz *= r.cut, E_yz *= r.cut;
  float reach = sqrtf(E_zz);
  float near_end = d[2] - reach, far_end = d[2] + reach;
  if (far_end < rules.near * 0.999f) return false;
  if (near_end - r.uncertainty > rules.far * 1.001f) return false;
  float low_x, high_x, low_y, high_y;
  if (near_end > 0.02f * far_end) {
    // The outline is the dual conic E - d d'.
    float q = 1.0f / (E_zz - d[2] * d[2]);
    float x = (E_xz - d[0] * d[2]) * q, y = (E_yz - d[1] * d[2]) * q;
    float half_x = -q * root(d[2] * (E_xx * d[2] - 2.0f * E_xz * d[0]) +
                             E_zz * d[0] * d[0] - (E_xx * E_zz - E_xz * E_xz));
    float half_y = -q * root(d[2] * (E_yy * d[2] - 2.0f * E_yz * d[1]) +
                             E_zz * d[1] * d[1] - (E_yy * E_zz - E_yz * E_yz));
    // What cancels costs digits of the half width.
    half_x *= 1.001f, half_y *= 1.001f;
    low_x = x - half_x, high_x = x + half_x;
    low_y = y - half_y, high_y = y + half_y;
  } else {
    // It reaches behind the camera: the box around what is before it.
    float size_x = sqrtf(E_xx), size_y = sqrtf(E_yy);
    low_x = d[0] - size_x, high_x = d[0] + size_x;
    low_y = d[1] - size_y, high_y = d[1] + size_y;
    low_x /= low_x > 0.0f ? far_end : rules.near;
    high_x /= high_x < 0.0f ? far_end : rules.near;
    low_y /= low_y > 0.0f ? far_end : rules.near;
    high_y /= high_y < 0.0f ? far_end : rules.near;
  }
  if (rules.is_surfel) {
    // A plane is nearer than the limit only around its nearest point.
    float cosine = fabsf(w[2]) / fmaxf(limit + r.uncertainty, 1e-6f);
    if (cosine < 0.999f) {
      float side = w[2] < 0.0f ? -1.0f : 1.0f, sine = sqrtf(1.0f - cosine * cosine);
      const float *n = s.form + 6;
      within_cone(side * n[0], side * n[2], sine, low_x, high_x);
      within_cone(side * n[1], side * n[2], sine, low_y, high_y);
    }
  }
  s.columns = span(low_x, high_x, rules.resolution, 0, rules.resolution - 1);
  s.rows = span(low_y, high_y, rules.resolution, band.low_y, band.high_y);
  if (s.columns < 0 || s.rows < 0) return false;
  s.height = w[2], s.u = w[0], s.v = w[1];
  if (rules.is_surfel) {
    for (int j = 0; j < 3; ++j) {
      s.form[j] = w[2] * s.form[j] - w[0] * s.form[6 + j];
      s.form[3 + j] = w[2] * s.form[3 + j] - w[1] * s.form[6 + j];
    }
  }
  s.opacity = r.opacity, s.cut = r.cut, s.uncertainty = r.uncertainty;
  return true;
}

HELPER Seen seen_by(const Seen &mine, int who, int is_surfel) {
  Seen s;
  for (int i = 0; i < 9; ++i) s.form[i] = from_lane(mine.form[i], who);
  s.height = from_lane(mine.height, who);
  s.u = is_surfel ? 0.0f : from_lane(mine.u, who);
  s.v = is_surfel ? 0.0f : from_lane(mine.v, who);
  s.opacity = from_lane(mine.opacity, who);
  s.cut = from_lane(mine.cut, who);
  s.uncertainty = from_lane(mine.uncertainty, who);
  s.columns = from_lane(mine.columns, who);
  s.rows = from_lane(mine.rows, who);
  return s;
}

// Whether a box may hold something of the band nearer than a limit.
HELPER bool box_matters(const Band &band, const float4 *box, float limit) {
  float4 low = box[0], high = box[1];
  if (low.w < band.floor) return false;
  float reach = fmaxf(limit, 0.0f);
  if (box_distance_squared(band.p, low, high) > reach * reach) return false;
  float3 a = to_point(band.p, low.x, low.y, low.z);
  float3 b = to_point(band.p, high.x, high.y, high.z);
  for (int k = 0; k < 4; ++k) {
    const float *n = band.sides_W + 3 * k;
    // The corner that lies farthest inwards.
    float height = (n[0] > 0.0f ? b.x : a.x) * n[0] +
                   (n[1] > 0.0f ? b.y : a.y) * n[1] +
                   (n[2] > 0.0f ? b.z : a.z) * n[2];
    float size = (b.x - a.x) + (b.y - a.y) + (b.z - a.z);
    if (height < -1e-5f * (reach + size)) return false;
  }
  return true;
}

// Calls visit(cluster), a team at a time, for all clusters that matter nearer
// than limit(), which may shrink on the way.
template <class Limit, class Visit>
HELPER void each_cluster(const Clusters &scene, Band &band, Limit limit,
                         Visit visit) {
  for (int first = 0; first < scene.n_groups; first += LISTED) {
    meet();
    if (thread() == 0) band.n_groups = 0;
    meet();
    for (int k = thread(); k < LISTED && first + k < scene.n_groups;
         k += threads()) {
      int group = first + k;
      if (box_matters(band, scene.groups + 2 * group, limit()))
        band.groups[atomicAdd(&band.n_groups, 1u)] = group;
    }
    meet();
    int n_groups = band.n_groups;
    for (int g0 = 0; g0 < n_groups; g0 += GROUPS_AT_ONCE) {
      if (thread() == 0) band.n_clusters = 0, band.work = 0;
      meet();
      for (int k = thread(); k < GROUPS_AT_ONCE * CLUSTER; k += threads()) {
        int g = g0 + k / CLUSTER;
        if (g >= n_groups) break;
        int cluster = band.groups[g] * CLUSTER + k % CLUSTER;
        if (cluster < scene.n_clusters &&
            box_matters(band, scene.clusters + 2 * cluster, limit()))
          band.clusters[atomicAdd(&band.n_clusters, 1u)] = cluster;
      }
      meet();
      int n_clusters = band.n_clusters;
      while (true) {
        int next = 0;
        if (lane() == 0) next = (int)atomicAdd(&band.work, 1u);
        next = from_lane(next, 0);
        if (next >= n_clusters) break;
        visit(band.clusters[next]);
      }
      meet();
    }
  }
  meet();
}

// Narrows the columns of a row to those where a disc can be seen.
HELPER void row_span(const Seen &s, const Rules &rules, float y, int &first,
                     int &last) {
  float a = s.form[1] * y + s.form[2], b = s.form[4] * y + s.form[5];
  float c = s.form[7] * y + s.form[8];
  float xx = s.form[0] * s.form[0] + s.form[3] * s.form[3];
  float x = s.form[0] * a + s.form[3] * b, one = a * a + b * b;
  float scale = fabsf(x) + one + s.cut * (fabsf(s.form[6] * c) + c * c);
  xx -= s.cut * s.form[6] * s.form[6];
  x -= s.cut * s.form[6] * c, one -= s.cut * c * c;
  // A conic that is nearly a line tells nothing, in single precision.
  if (fabsf(xx) <= 1e-4f * scale) return;
  // What rounding may move makes spans wider.
  float slack = 1e-5f * scale * scale;
  float square = x * x - xx * one + (xx > 0.0f ? slack : -slack);
  if (square < 0.0f) {
    if (xx > 0.0f) last = first - 1;
    return;
  }
  float half = sqrtf(square), low = (-x - half) / xx, high = (-x + half) / xx;
  if (xx < 0.0f) {
    // Two branches, of which one lies before the camera.
    float side = s.height * s.form[6];
    if (side == 0.0f) return;
    if (side > 0.0f) high = 1.0f;
    else low = -1.0f;
  }
  int columns = span(low, high, rules.resolution, first, last);
  if (columns < 0) last = first - 1;
  else first = columns & 65535, last = columns >> 16;
}

// Draws all that is nearer than a limit: calls touch(pixel, light, range) for
// every fragment in the band.
template <class Touch>
HELPER void draw_all(const Clusters &scene, Band &band, const Rules &rules,
                     float limit, Touch touch) {
  each_cluster(scene, band, [&] { return limit; }, [&](int cluster) {
    for (int k = lane(); k < CLUSTER; k += LANES) {
      Record r;
      Seen mine;
      bool seen = load_record(scene, band, cluster * CLUSTER + k, r) &&
                  nearest_range(r, rules.is_surfel) < limit &&
                  in_band(band, r.offset, r.radius * 1.0001f) &&
                  project(r, band, rules, limit, mine);
      auto draw_at = [&](const Seen &s, int column, int row) {
        float range;
        u32 light = absorbed(s, rules, coordinate(column, rules),
                             coordinate(row, rules), limit, range);
        if (light) touch(row * rules.resolution + column, light, range);
      };
      auto draw = [&](const Seen &s, int first, int step) {
        int left = s.columns & 65535, top = s.rows & 65535;
        int right = s.columns >> 16, bottom = s.rows >> 16;
        int width = right - left + 1, size = width * (bottom - top + 1);
        if (size < LARGE || !rules.is_surfel) {
          for (int at = first; at < size; at += step)
            draw_at(s, left + at % width, top + at / width);
          return;
        }
        for (int row = top + first / ROW_LANES; row <= bottom;
             row += step / ROW_LANES) {
          int begin = left, end = right;
          row_span(s, rules, coordinate(row, rules), begin, end);
          for (int at = begin + first % ROW_LANES; at <= end; at += ROW_LANES)
            draw_at(s, at, row);
        }
      };
      bool alone = seen && ((mine.columns >> 16) - (mine.columns & 65535) + 1) *
                           ((mine.rows >> 16) - (mine.rows & 65535) + 1) <= SMALL;
      if (alone) draw(mine, 0, 1);
      for (u32 mask = lanes_where(seen && !alone); mask; mask &= mask - 1)
        draw(seen_by(mine, first_of(mask), rules.is_surfel), lane(), LANES);
    }
  });
}

// Whether a ray meets a box between the planes.
HELPER bool ray_meets(const Band &band, const Rules &rules, const float ray[3],
                      const float4 *box) {
  float4 low = box[0], high = box[1];
  if (low.w < band.floor) return false;
  float3 a = to_point(band.p, low.x, low.y, low.z);
  float3 b = to_point(band.p, high.x, high.y, high.z);
  float lows[3] = {a.x, a.y, a.z}, highs[3] = {b.x, b.y, b.z};
  float enter = 0.999f * rules.near;
  float leave = 1.001f * rules.far + rules.uncertainty;
  for (int k = 0; k < 3; ++k) {
    float slack = 1e-6f + 1e-5f * fmaxf(fabsf(lows[k]), fabsf(highs[k]));
    float from = lows[k] - slack, to = highs[k] + slack;
    if (fabsf(ray[k]) < 1e-9f) {
      if (from > 0.0f || to < 0.0f) return false;
      continue;
    }
    float s = from / ray[k], t = to / ray[k];
    enter = fmaxf(enter, fminf(s, t)), leave = fminf(leave, fmaxf(s, t));
  }
  return enter <= leave;
}

// A team follows a pixel's ray: whether it absorbs enough light to count.
HELPER bool is_opaque(const Clusters &scene, const Band &band,
                      const Rules &rules, int pixel) {
  float x = coordinate(pixel % rules.resolution, rules);
  float y = coordinate(pixel / rules.resolution, rules);
  const float *R = band.R_WV;
  float ray[3];
  for (int i = 0; i < 3; ++i)
    ray[i] = R[3 * i] * x + R[3 * i + 1] * y + R[3 * i + 2];
  u32 light = 0;
  for (int g0 = 0; g0 < scene.n_groups; g0 += LANES) {
    int group = g0 + lane();
    u32 met = lanes_where(group < scene.n_groups &&
                     ray_meets(band, rules, ray, scene.groups + 2 * group));
    for (; met; met &= met - 1) {
      int first = (g0 + first_of(met)) * CLUSTER;
      for (int c0 = 0; c0 < CLUSTER; c0 += LANES) {
        int cluster = first + c0 + lane();
        u32 crossed =
            lanes_where(cluster < scene.n_clusters &&
                   ray_meets(band, rules, ray, scene.clusters + 2 * cluster));
        for (; crossed; crossed &= crossed - 1) {
          int place = (first + c0 + first_of(crossed)) * CLUSTER;
          u32 more = 0;
          for (int k = lane(); k < CLUSTER; k += LANES) {
            Record r;
            Seen s;
            float range;
            if (load_record(scene, band, place + k, r) &&
                project(r, band, rules, INFINITE, s))
              more += absorbed(s, rules, x, y, INFINITE, range);
          }
          for (int step = LANES / 2; step > 0; step /= 2)
            more += across(more, step);
          light += more;
          if (light >= rules.opaque_light) return true;
        }
      }
    }
  }
  return false;
}

// Prepares the block for an item: sphere, view, band.
HELPER void begin(const float *sphere, const float *R_WD, const float *R_DV,
                  const Rules &rules, int rows_before, Band &band) {
  band.p.x = sphere[0], band.p.y = sphere[1], band.p.z = sphere[2];
  band.p.dx = sphere[3], band.p.dy = sphere[4], band.p.dz = sphere[5];
  band.floor = sphere[7];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      band.R_WV[3 * i + j] = R_WD[3 * i] * R_DV[j] +
                             R_WD[3 * i + 1] * R_DV[3 + j] +
                             R_WD[3 * i + 2] * R_DV[6 + j];
  int last = rows_before + rules.band_rows - 1;
  last = last < rules.resolution ? last : rules.resolution - 1;
  band.low_y = rows_before, band.high_y = last;
  float top = 2.0f * rows_before / rules.resolution - 1.0f;
  float bottom = 2.0f * (last + 1) / rules.resolution - 1.0f;
  float sides[4][3] = {{1.0f, 0.0f, 1.0f}, {-1.0f, 0.0f, 1.0f},
                       {0.0f, 1.0f, -top}, {0.0f, -1.0f, bottom}};
  for (int k = 0; k < 4; ++k) {
    const float *n = sides[k];
    float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; ++i)
      band.sides_W[3 * k + i] =
          (band.R_WV[3 * i] * n[0] + band.R_WV[3 * i + 1] * n[1] +
           band.R_WV[3 * i + 2] * n[2]) / length;
  }
  band.best = ~0ull;
  band.nearest = key_of(INFINITE);
}

// Draws the band with what is nearer than a limit. Fragments are kept of all
// pixels, or of those `again` whose median was found to be nearer than it.
HELPER void draw_band(const Clusters &scene, Band &band, const Rules &rules,
                      const Pixels &pixels, int n_pixels, float limit,
                      bool again, Fragment *fragments) {
  for (int at = thread(); at < n_pixels; at += threads())
    pixels.light[at] = 0, pixels.total[at] = 0;
  for (int k = thread(); !again && k < (n_pixels + 31) / 32; k += threads())
    pixels.counting[k] = 0, pixels.open[k] = 0;
  if (thread() == 0)
    band.n_fragments = 0, band.n_counting = 0, band.n_open = 0;
  int first_pixel = band.low_y * rules.resolution;
  // What lies a little behind makes most pixels opaque.
  draw_all(scene, band, rules, limit + 0.005f + 0.02f * fmaxf(limit, 0.0f),
           [&](int pixel, u32 light, float range) {
             int at = pixel - first_pixel;
             if (latest(pixels.total[at]) < ENOUGH)
               atomicAdd(&pixels.total[at], light);
             if (!(range < limit)) return;
             if (latest(pixels.light[at]) < ENOUGH)
               atomicAdd(&pixels.light[at], light);
             if (again && !has(pixels.counting, at) && !has(pixels.open, at))
               return;
             u32 place = atomicAdd(&band.n_fragments, 1u);
             if (place >= rules.room) return;
             fragments[place].key = key_of(range);
             fragments[place].light = light;
             fragments[place].at = at;
           });
  for (int at = thread(); at < n_pixels; at += threads()) {
    if (pixels.light[at] < rules.median_light || has(pixels.dead, at)) continue;
    bool counts = pixels.total[at] >= rules.opaque_light;
    add(counts ? pixels.counting : pixels.open, at);
    atomicAdd(counts ? &band.n_counting : &band.n_open, 1u);
  }
  meet();
}

// Finds the least range from `low` and below `high` at which a pixel that counts
// has absorbed the median's light; at the end `light` is what was absorbed
// nearer than that.
HELPER void bisect(Band &band, const Rules &rules, const Pixels &pixels,
                   int n_pixels, const Fragment *fragments, u32 low, u32 high) {
  for (int at = thread(); at < n_pixels; at += threads()) pixels.light[at] = 0;
  int n = band.n_fragments;
  // A thread's own fragments between `low` and `high`, as bits while there are
  // that few: each step leaves half of them.
  bool few = n <= 64 * threads();
  u64 alive = ~0ull;
  auto each_between = [&](u32 from, u32 to, auto visit) {
    if (!few) {
      for (int f = thread(); f < n; f += threads()) {
        Fragment it = fragments[f];
        if (it.key >= from && it.key < to) visit(it);
      }
      return;
    }
    for (u64 left = alive; left; left &= left - 1) {
      int k = first_of(left), f = thread() + k * threads();
      u32 key = f < n ? fragments[f].key : ~0u;
      if (key < low || key >= high) alive &= ~(1ull << k);
      else if (key >= from && key < to) visit(fragments[f]);
    }
  };
  meet();
  while (true) {
    u32 middle = low + (high - low) / 2;
    bool last = middle == low;
    if (last) middle = high;
    if (thread() == 0) band.is_reached = 0;
    meet();
    each_between(low, middle, [&](const Fragment &it) {
      u32 sum = atomicAdd(&pixels.light[it.at], it.light) + it.light;
      if (sum < rules.median_light || !has(pixels.counting, it.at)) return;
      atomicOr(&band.is_reached, 1u);
      // Of equally near pixels the first is meant.
      u32 pixel = it.at + band.low_y * rules.resolution;
      if (last) atomicMin(&band.best, (u64)it.key << 32 | pixel);
    });
    meet();
    bool reached = band.is_reached;
    if (reached || last) {
      each_between(low, middle, [&](const Fragment &it) {
        atomicAdd(&pixels.light[it.at], 0u - it.light);
      });
      high = middle;
    } else {
      low = middle;
    }
    meet();
    if (last) return;
  }
}

// Follows the rays of pixels that may have a median nearer than the best, and
// may be opaque. True if one of them counts.
HELPER bool follow_open(const Clusters &scene, Band &band, const Rules &rules,
                        const Pixels &pixels, int n_pixels) {
  meet();
  for (int k = thread(); k < (n_pixels + 31) / 32; k += threads())
    pixels.counting[k] = 0;
  if (thread() == 0) band.n_counting = 0;
  for (int first = 0; first < n_pixels; first += LISTED) {
    meet();
    if (thread() == 0) band.n_open = 0, band.work = 0;
    meet();
    for (int at = first + thread(); at < first + LISTED && at < n_pixels;
         at += threads())
      if (has(pixels.open, at) && pixels.light[at] >= rules.median_light)
        band.clusters[atomicAdd(&band.n_open, 1u)] = at;
    meet();
    int n_open = band.n_open;
    while (true) {
      int next = 0;
      if (lane() == 0) next = (int)atomicAdd(&band.work, 1u);
      next = from_lane(next, 0);
      if (next >= n_open) break;
      int at = band.clusters[next];
      bool counts = is_opaque(scene, band, rules,
                              at + band.low_y * rules.resolution);
      if (lane() != 0) continue;
      add(counts ? pixels.counting : pixels.dead, at);
      if (counts) atomicAdd(&band.n_counting, 1u);
    }
  }
  meet();
  return band.n_counting > 0;
}

// The nearest pixel of a band whose median is nearer than a limit.
HELPER void nearest_pixel(const Clusters &scene, Band &band, const Rules &rules,
                          const Pixels &pixels, int n_pixels, float limit,
                          const Fragment *fragments) {
  u32 low = key_of(value_of(band.nearest) - 1e-3f), high = key_of(limit);
  bool some_open = band.n_open > 0;
  if (band.n_counting > 0) {
    bisect(band, rules, pixels, n_pixels, fragments, low, high);
    high = (u32)(band.best >> 32);
  }
  if (some_open && follow_open(scene, band, rules, pixels, n_pixels))
    bisect(band, rules, pixels, n_pixels, fragments, low, high);
}

// spheres: (n, 8): position, its rest, the range that an answer must undercut,
// the height below which nothing is seen. R_WD: (n, 9). nearest: (n, 6), keys
// of range and pixel; all ones at first, and where nothing is seen. closest:
// (n,), keys of the range that all views of a sphere have found together, all
// ones at first. work: a counter, 0 at first. fragments: room for rules.room of
// them a block.
KERNEL CROWDED(256, 4) depth_views(Clusters scene, Rules rules, const float *spheres,
                   const float *R_WD, const float *R_DV, int n, u64 *nearest,
                   u32 *closest, u32 *work, Fragment *fragments) {
  SHARED Band band;
  SHARED u32 item;
  SCRATCH(scratch);
  int n_pixels = rules.band_rows * rules.resolution;
  int n_words = (n_pixels + 31) / 32;
  Pixels pixels;
  pixels.light = scratch, pixels.total = scratch + n_pixels;
  pixels.counting = scratch + 2 * n_pixels;
  pixels.open = pixels.counting + n_words, pixels.dead = pixels.open + n_words;
  fragments += (size_t)block() * rules.room;
  u32 n_items = (u32)n * 6u * (u32)rules.bands;
  while (true) {
    meet();
    if (thread() == 0) item = atomicAdd(work, 1u);
    meet();
    if (item >= n_items) return;
    // One view after the other: who asks for the nearest one only is spared
    // most of the later ones.
    int i = item % n;
    int view = item / n / rules.bands;
    int rows_before = item / n % rules.bands * rules.band_rows;
    u64 *answer = nearest + 6 * (size_t)i + view;
    if (thread() == 0) {
      begin(spheres + 8 * (size_t)i, R_WD + 9 * (size_t)i, R_DV + 9 * view,
            rules, rows_before, band);
      // Nothing beyond what other bands, or views, have found is asked for.
      float bound = spheres[8 * (size_t)i + 6];
      u32 known = *(const volatile u64 *)answer >> 32;
      if (rules.nearest_only && latest(closest[i]) < known)
        known = latest(closest[i]);
      // Of equal pixels the first is meant, whichever is met first.
      band.bound = known == ~0u ? bound : fminf(bound, value_of(known + 1u));
    }
    for (int k = thread(); k < n_words; k += threads()) pixels.dead[k] = 0;
    meet();
    float bound = band.bound;
    // How near is anything?
    each_cluster(
        scene, band,
        [&] { return fminf(bound, value_of(latest(band.nearest))); },
        [&](int cluster) {
          float near = INFINITE;
          for (int k = lane(); k < CLUSTER; k += LANES) {
            Record r;
            if (load_record(scene, band, cluster * CLUSTER + k, r) &&
                in_band(band, r.offset, r.radius * 1.0001f))
              near = fminf(near, nearest_range(r, rules.is_surfel));
          }
          for (int step = LANES / 2; step > 0; step /= 2)
            near = fminf(near, across(near, step));
          if (lane() == 0) atomicMin(&band.nearest, key_of(near));
        });
    float least = value_of(band.nearest);
    float found_none = least, found_much = INFINITE;
    float limit = fminf(bound, fmaxf(least, 0.0f) * 1.05f + 0.015f);
    while (least < bound && found_none < bound) {
      bool fits = false;
      u32 n_found = 1;
      for (int again = 0; n_found && !fits && again < 2; ++again) {
        meet();
        draw_band(scene, band, rules, pixels, n_pixels, limit, again,
                  fragments);
        n_found = band.n_counting + band.n_open;
        fits = band.n_fragments <= rules.room;
      }
      float nearer = 0.5f * (found_none + limit);
      if (n_found && !fits && nearer > found_none && nearer < limit) {
        // Fewer fragments lie a little nearer.
        found_much = limit, limit = nearer;
        meet();
        continue;
      }
      if (n_found && fits)
        nearest_pixel(scene, band, rules, pixels, n_pixels, limit, fragments);
      // Of a ray with more fragments than there is room for: no limit lies
      // between `found_none` and the range of its median.
      if (n_found && !fits &&
          (band.n_counting || follow_open(scene, band, rules, pixels, n_pixels)) &&
          thread() == 0) {
        int at = 0;
        while (!has(pixels.counting, at)) ++at;
        band.best = (u64)key_of(found_none) << 32 |
                    (u32)(at + rows_before * rules.resolution);
      }
      meet();
      if (band.best != ~0ull) break;
      found_none = limit;
      limit = limit * 1.25f + 0.015f;
      if (found_much < INFINITE) limit = 0.5f * (found_none + found_much);
      if (!(limit > found_none)) limit = found_much;
      if (limit >= found_much) found_much = INFINITE;
      limit = fminf(bound, limit);
    }
    meet();
    if (thread() == 0 && band.best != ~0ull) {
      float range = value_of((u32)(band.best >> 32));
      atomicMin(answer, band.best);
      atomicMin(&closest[i], key_of(range));
    }
  }
}

// Ranges and unit directions of the nearest pixels: rows (n, 6, 4). With
// nearest_only the other views of a sphere see nothing.
KERNEL depth_rows(Rules rules, const float *R_WD, const float *R_DV, int n,
                  const u64 *nearest, float4 *rows) {
  for (int at = block() * threads() + thread(); at < 6 * n;
       at += blocks() * threads()) {
    int i = at / 6, view = at % 6;
    u64 key = nearest[at];
    for (int v = 0; rules.nearest_only && v < 6; ++v) {
      u32 other = nearest[6 * i + v] >> 32, own = key >> 32;
      if (other < own || (other == own && v < view)) key = ~0ull;
    }
    if (key == ~0ull) {
      rows[at] = make_float4(bits_float(0x7f800000u), 0.0f, 0.0f, 0.0f);
      continue;
    }
    int pixel = (int)(u32)key;
    float x = coordinate(pixel % rules.resolution, rules);
    float y = coordinate(pixel / rules.resolution, rules);
    float length = sqrtf(x * x + y * y + 1.0f);
    const float *R = R_WD + 9 * (size_t)i, *V = R_DV + 9 * view;
    float d[3], n_W[3];
    for (int k = 0; k < 3; ++k)
      d[k] = (V[3 * k] * x + V[3 * k + 1] * y + V[3 * k + 2]) / length;
    for (int k = 0; k < 3; ++k)
      n_W[k] = R[3 * k] * d[0] + R[3 * k + 1] * d[1] + R[3 * k + 2] * d[2];
    rows[at] = make_float4(value_of(key >> 32), n_W[0], n_W[1], n_W[2]);
  }
}
