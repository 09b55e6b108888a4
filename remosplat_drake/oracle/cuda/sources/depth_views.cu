// Finds the nearest pixels of depth views, as `DepthSensor` defines them, in
// single precision. A block computes a band of rows of one view.
//
// A fragment absorbs light -log2(1 - alpha). The light that a ray has absorbed
// up to a range is a sum, which does not depend on the order of the fragments.
// So a pixel's median is nearer than a limit exactly if that sum reaches the
// median's threshold. A block lists the splats that are visible nearer than a
// limit. Its teams follow a few rays to the nearest of these splats, which
// bounds the result, and list again the splats that may be nearer than this
// bound. Then they draw tiles, one pixel per lane, with sums in registers; each
// lane stores its nearest fragments and finds its median among them. The rays
// of tiles with pixels that are not opaque yet are followed to the end. If no
// pixel is found, the limit is increased.
//
// Light is counted in integer multiples of 2^-20, so that sums are the same in
// any order, and results do not depend on the order of threads.
//
// A record contains the centre, and the radius of the visible part; the three
// rows that map W to the splat's axes in standard deviations (a disc's third
// row is its normal); the opacity, the squared Mahalanobis distance at which
// the visible part ends, and the uncertainty. Boxes are enlarged by the
// uncertainty.

#include "clusters.cuh"

#define GROUPS_AT_ONCE 32 // Groups whose clusters are listed at once.
#define LISTED 1024
#define TILE_COLUMNS (LANES < 8 ? LANES : 8)
#define TILE_ROWS (LANES / TILE_COLUMNS)
#define KEPT 12            // Fragments that a lane keeps.
#define UNIT 1048576.0f    // Light is counted in 1 / UNIT.
#define ENOUGH 1073741824u // Far more than any threshold.
#define NONE (~0ull)       // Behind all keys.

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
  u32 room;          // splats that a block may list
};

// Data that the threads of a block share.
struct Band {
  Position p;
  float R_WV[9];
  float sides_W[12]; // inward normals of the four planes around the band
  float floor;
  float bound;       // ranges beyond it are not asked for
  u32 nearest;       // key of a lower bound of all ranges
  u32 work, n_groups, n_clusters, n_seen, n_near;
  int low_y, high_y; // rows
  u64 best;          // key of the range, then the pixel
  u64 open;          // key of the nearest median that may be, then its tile
  u32 totals[LANES]; // light, of a tile that is followed
  int groups[LISTED];
  int clusters[LISTED];
};

HELPER bool has(const u32 *bits, int at) { return bits[at / 32] >> at % 32 & 1; }

HELPER void add(u32 *bits, int at) { atomicOr(&bits[at / 32], 1u << at % 32); }

// A splat projected into a view: see `footprints.project`.
struct alignas(16) Seen {
  float form[9];
  float height;    // of a disc's plane; for an ellipsoid its whitened
  float u, v;      // centre is (u, v, height)
  float opacity, cut, uncertainty;
};

// The pixels in which it may be visible.
struct alignas(16) Outline {
  int columns, rows; // first + last * 65536
  float nearest;     // bounds its ranges from below
  int at;            // in the list
};

// The splats that a block has listed.
struct Listing {
  Seen *seen;
  Outline *outlines;
  Outline *near; // those that may beat what was found, narrowed to where
  u32 *medians;  // keys of open pixels' medians
};

// Shared memory; its size depends on the band.
struct Scratch {
  u32 *dead;   // a bit a pixel: known not to be opaque
  u32 *drawn;  // a bit a tile: is to be drawn
  u32 *open;   // a bit a tile: has pixels that may not be opaque
  u32 *kept;   // by slot and thread: keys of ranges, then light
  int n_words; // of bits
};

// Pixels that a team draws at once, both ends included.
struct Tile {
  int left, right, top, bottom;
};

// A lane's pixel, and the state of its ray. It stores the nearest fragments
// behind `from`, a key: all of them, or as many as fit.
struct Ray {
  float x, y, length, inverse; // of the length
  int pixel;
  bool asks;  // whether it is opaque, or for its median
  u32 total;  // absorbed as far as it is known
  u32 light;  // absorbed nearer than the limit
  u32 before; // absorbed up to `from`
  u32 from;
  int n_kept;
};

HELPER float coordinate(int pixel, const Rules &rules) {
  return (pixel + 0.5f) * 2.0f / rules.resolution - 1.0f;
}

HELPER Ray ray_of(int column, int row, const Rules &rules) {
  Ray ray;
  ray.x = coordinate(column, rules), ray.y = coordinate(row, rules);
  ray.length = sqrtf(ray.x * ray.x + ray.y * ray.y + 1.0f);
  ray.inverse = 1.0f / ray.length;
  ray.pixel = row * rules.resolution + column;
  ray.asks = true;
  ray.total = ray.light = ray.before = ray.from = 0;
  ray.n_kept = 0;
  return ray;
}

HELPER float root(float value) { return sqrtf(fmaxf(value, 0.0f)); }

// Returns the light that a splat absorbs on a ray nearer than a limit, 0 where
// it is not visible, and its range. Sums and products are fused by hand, so
// that results are equal to the last bit wherever the function is inlined.
HELPER u32 absorbed(const Seen &s, const Rules &rules, const Ray &ray,
                    float limit, float &range) {
  const float *f = s.form;
  float a = fmaf(f[0], ray.x, fmaf(f[1], ray.y, f[2]));
  float b = fmaf(f[3], ray.x, fmaf(f[4], ray.y, f[5]));
  float c = fmaf(f[6], ray.x, fmaf(f[7], ray.y, f[8]));
  float z, weight, inverse;
  if (rules.is_surfel) {
    inverse = reciprocal(c);
    z = s.height * inverse;
  } else {
    inverse = reciprocal(fmaf(a, a, fmaf(b, b, c * c)));
    z = fmaf(a, s.u, fmaf(b, s.v, c * s.height)) * inverse;
  }
  range = fmaf(z, ray.length, -s.uncertainty);
  // Most splats are too far.
  if (!(range < limit) || !(z >= rules.near)) return 0;
  if (!(fmaf(-s.uncertainty, ray.inverse, z) <= rules.far)) return 0;
  if (rules.is_surfel) {
    float u = a * inverse, v = b * inverse;
    weight = fmaf(u, u, v * v);
  } else {
    float da = fmaf(z, a, -s.u), db = fmaf(z, b, -s.v);
    float dc = fmaf(z, c, -s.height);
    weight = fmaf(da, da, fmaf(db, db, dc * dc));
  }
  if (!(weight <= s.cut)) return 0;
  // exp(-weight / 2)
  float falloff = power_of_2(-0.72134752f * weight);
  float light = -UNIT * logarithm_2(fmaf(-s.opacity, falloff, 1.0f));
  // It is infinite if no light passes.
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

// Reads the record of a splat; returns false if it is below the floor or does
// not exist.
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

// Returns whether a ball may be visible between four planes.
HELPER bool is_between(const float *sides_W, float3 d, float radius) {
  for (int k = 0; k < 4; ++k) {
    const float *n = sides_W + 3 * k;
    if (n[0] * d.x + n[1] * d.y + n[2] * d.z < -radius) return false;
  }
  return true;
}

// Returns a lower bound on the ranges of a splat.
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

// Returns which of the pixels 0 to last have their centres between low and
// high.
HELPER int span(float low, float high, int resolution, int first, int last) {
  float half = 0.5f * resolution;
  // If a bound is NaN, it is unknown: the result is the whole image.
  if (!(low >= -1.0f)) low = -1.0f;
  if (!(high <= 1.0f)) high = 1.0f;
  int begin = (int)ceilf((low + 1.0f) * half - 0.55f);
  int end = (int)floorf((high + 1.0f) * half - 0.45f);
  begin = begin > first ? begin : first;
  end = end < last ? end : last;
  return begin > end ? -1 : begin + end * 65536;
}

// Narrows an interval of x / z to that of a cone around n, given the sine of
// its angle.
HELPER void within_cone(float n, float n_z, float sine, float &low,
                        float &high) {
  float q = n_z * n_z - sine * sine;
  if (!(n_z > sine && q > 1e-4f)) return; // It reaches beside the camera.
  float middle = n * n_z / q;
  float half = sine * root(n * n + q) / q * 1.001f + 1e-4f;
  low = fmaxf(low, middle - half), high = fminf(high, middle + half);
}

// Narrows an outline to the part in which a splat may be nearer than a limit;
// returns false if there is none.
HELPER bool narrow(const Seen &s, const Rules &rules, float limit,
                   Outline &o) {
  if (!(o.nearest < limit)) return false;
  // A plane is nearer than the limit only around its nearest point.
  float cosine = fabsf(s.height) / fmaxf(limit + s.uncertainty, 1e-6f);
  if (!rules.is_surfel || !(cosine < 0.999f)) return true;
  float side = s.height < 0.0f ? -1.0f : 1.0f;
  float sine = sqrtf(1.0f - cosine * cosine);
  float low_x = -1.0f, high_x = 1.0f, low_y = -1.0f, high_y = 1.0f;
  const float *n = s.form + 6;
  within_cone(side * n[0], side * n[2], sine, low_x, high_x);
  within_cone(side * n[1], side * n[2], sine, low_y, high_y);
  o.columns = span(low_x, high_x, rules.resolution, o.columns & 65535,
                   o.columns >> 16);
  o.rows = span(low_y, high_y, rules.resolution, o.rows & 65535, o.rows >> 16);
  return o.columns >= 0 && o.rows >= 0;
}

// Projects a splat; returns false if it is nearer than a limit in no pixel of
// the band.
HELPER bool project(const Record &r, const Band &band, const Rules &rules,
                    float limit, Seen &s, Outline &outline) {
  outline.nearest = nearest_range(r, rules.is_surfel);
  if (!(outline.nearest < limit)) return false;
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
    // Cancellation reduces the precision of the half width.
    half_x *= 1.001f, half_y *= 1.001f;
    low_x = x - half_x, high_x = x + half_x;
    low_y = y - half_y, high_y = y + half_y;
  } else {
    // If it extends behind the camera: the box around the part before it.
    float size_x = sqrtf(E_xx), size_y = sqrtf(E_yy);
    low_x = d[0] - size_x, high_x = d[0] + size_x;
    low_y = d[1] - size_y, high_y = d[1] + size_y;
    low_x /= low_x > 0.0f ? far_end : rules.near;
    high_x /= high_x < 0.0f ? far_end : rules.near;
    low_y /= low_y > 0.0f ? far_end : rules.near;
    high_y /= high_y < 0.0f ? far_end : rules.near;
  }
  outline.columns =
      span(low_x, high_x, rules.resolution, 0, rules.resolution - 1);
  outline.rows =
      span(low_y, high_y, rules.resolution, band.low_y, band.high_y);
  if (outline.columns < 0 || outline.rows < 0) return false;
  s.height = w[2], s.u = w[0], s.v = w[1];
  if (rules.is_surfel) {
    for (int j = 0; j < 3; ++j) {
      s.form[j] = w[2] * s.form[j] - w[0] * s.form[6 + j];
      s.form[3 + j] = w[2] * s.form[3 + j] - w[1] * s.form[6 + j];
    }
  }
  s.opacity = r.opacity, s.cut = r.cut, s.uncertainty = r.uncertainty;
  return narrow(s, rules, limit, outline);
}

// Loads it in four parts.
HELPER Seen load_seen(const Seen *at) {
  const float4 *from = (const float4 *)at;
  float4 a = from[0], b = from[1], c = from[2], d = from[3];
  return {{a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x}, c.y, c.z, c.w,
          d.x, d.y, d.z};
}

HELPER Seen seen_by(const Seen &mine, int who) {
  Seen s;
  for (int i = 0; i < 9; ++i) s.form[i] = from_lane(mine.form[i], who);
  s.height = from_lane(mine.height, who);
  s.u = from_lane(mine.u, who), s.v = from_lane(mine.v, who);
  s.opacity = from_lane(mine.opacity, who);
  s.cut = from_lane(mine.cut, who);
  s.uncertainty = from_lane(mine.uncertainty, who);
  return s;
}

// Returns whether a box may contain a splat between four planes and nearer than
// a limit.
HELPER bool box_matters(const Band &band, const float *sides_W,
                        const float4 *box, float limit) {
  float4 low = box[0], high = box[1];
  if (low.w < band.floor) return false;
  float reach = fmaxf(limit, 0.0f);
  if (box_distance_squared(band.p, low, high) > reach * reach) return false;
  float3 a = to_point(band.p, low.x, low.y, low.z);
  float3 b = to_point(band.p, high.x, high.y, high.z);
  for (int k = 0; k < 4; ++k) {
    const float *n = sides_W + 3 * k;
    // The corner that is farthest inside.
    float height = (n[0] > 0.0f ? b.x : a.x) * n[0] +
                   (n[1] > 0.0f ? b.y : a.y) * n[1] +
                   (n[2] > 0.0f ? b.z : a.z) * n[2];
    float size = (b.x - a.x) + (b.y - a.y) + (b.z - a.z);
    if (height < -1e-5f * (reach + size)) return false;
  }
  return true;
}

// Returns the next item of work of a team.
HELPER int take(u32 &work) {
  int next = 0;
  if (lane() == 0) next = (int)atomicAdd(&work, 1u);
  return from_lane(next, 0);
}

// Calls visit(cluster), by one team each, for all clusters that may be nearer
// than limit(), which may decrease meanwhile.
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
      if (box_matters(band, band.sides_W, scene.groups + 2 * group, limit()))
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
            box_matters(band, band.sides_W, scene.clusters + 2 * cluster,
                        limit()))
          band.clusters[atomicAdd(&band.n_clusters, 1u)] = cluster;
      }
      meet();
      int n_clusters = band.n_clusters;
      for (int next; (next = take(band.work)) < n_clusters;)
        visit(band.clusters[next]);
      meet();
    }
  }
  meet();
}

HELPER bool touches(const Outline &o, const Tile &tile) {
  return (o.columns & 65535) <= tile.right && o.columns >> 16 >= tile.left &&
         (o.rows & 65535) <= tile.bottom && o.rows >> 16 >= tile.top;
}

HELPER int tile_columns(const Rules &rules) {
  return (rules.resolution + TILE_COLUMNS - 1) / TILE_COLUMNS;
}

// Returns the next place in a list of n, for each lane that adds an element.
HELPER u32 next_place(bool adds, u32 &n) {
  u32 mask = lanes_where(adds);
  int place = 0;
  if (lane() == 0 && mask) place = (int)atomicAdd(&n, (u32)count_of(mask));
  return from_lane(place, 0) + count_of(mask & lanes_before());
}

// Lists the splats that are visible nearer than a limit. If the list is too
// short for them, only their number is correct.
HELPER void list_seen(const Clusters &scene, Band &band, const Rules &rules,
                      float limit, const Listing &list) {
  if (thread() == 0) band.n_seen = 0;
  each_cluster(scene, band, [&] { return limit; }, [&](int cluster) {
    for (int k = lane(); k < CLUSTER; k += LANES) {
      Record r;
      Seen s;
      Outline outline;
      bool seen = load_record(scene, band, cluster * CLUSTER + k, r) &&
                  is_between(band.sides_W, r.offset, r.radius * 1.0001f) &&
                  project(r, band, rules, limit, s, outline);
      u32 place = next_place(seen, band.n_seen);
      if (!seen || place >= rules.room) continue;
      outline.at = (int)place;
      list.seen[place] = s, list.outlines[place] = outline;
    }
  });
}

// Lists again the splats that may be nearer than a limit, and marks their
// tiles.
HELPER void list_near(Band &band, const Rules &rules, float limit,
                      const Listing &list, const Scratch &scratch) {
  if (thread() == 0) band.n_near = 0;
  meet();
  int n = band.n_seen;
  for (int first = 0; first < n; first += threads()) {
    int k = first + thread();
    Outline outline;
    bool is_near = k < n;
    if (is_near) {
      outline = list.outlines[k];
      is_near = narrow(list.seen[k], rules, limit, outline);
    }
    u32 place = next_place(is_near, band.n_near);
    if (!is_near) continue;
    list.near[place] = outline;
    int left = (outline.columns & 65535) / TILE_COLUMNS;
    int right = (outline.columns >> 16) / TILE_COLUMNS;
    int top = ((outline.rows & 65535) - band.low_y) / TILE_ROWS;
    int bottom = ((outline.rows >> 16) - band.low_y) / TILE_ROWS;
    for (int row = top; row <= bottom; ++row)
      for (int column = left; column <= right; ++column) {
        int tile = row * tile_columns(rules) + column;
        if (!has(scratch.drawn, tile)) add(scratch.drawn, tile);
      }
  }
  meet();
}

HELPER void sum_up(u32 &sum, u32 light) {
  if (sum < ENOUGH) sum += light;
}

// Stores a fragment; if there is no room, it replaces the farthest one.
HELPER void keep(u32 *kept, Ray &ray, u32 key, u32 light) {
  int slot = ray.n_kept;
  if (slot < KEPT) {
    ++ray.n_kept;
  } else {
    slot = 0;
    for (int k = 1; k < KEPT; ++k)
      if (kept[k * threads()] > kept[slot * threads()]) slot = k;
    if (key >= kept[slot * threads()]) return;
  }
  kept[slot * threads()] = key;
  kept[(KEPT + slot) * threads()] = light;
}

// Adds a fragment to the state of a ray.
HELPER void add_fragment(Ray &ray, float range, u32 light, u32 *kept) {
  sum_up(ray.light, light);
  u32 key = key_of(range);
  if (key > ray.from) keep(kept, ray, key, light);
  else sum_up(ray.before, light);
}

// Adds the light that a splat absorbs to the total of a ray, which is opaque if
// the total is large enough.
HELPER void look_through(const Seen &s, const Rules &rules, float limit,
                         Ray &ray) {
  float range;
  sum_up(ray.total, absorbed(s, rules, ray, limit, range));
  if (ray.total >= rules.opaque_light) ray.asks = false;
}

// Finds the key of a median that is nearer than the limit. The result is 0 if
// the median is behind all stored fragments; these will then be before `from`.
HELPER u32 median_key(const u32 *kept, Ray &ray, u32 median_light) {
  u32 sum = ray.before;
  while (sum < median_light) {
    u32 next = ~0u, light = 0;
    for (int k = 0; k < ray.n_kept; ++k) {
      u32 key = kept[k * threads()];
      if (key <= ray.from || key > next) continue;
      light = kept[(KEPT + k) * threads()] + (key == next ? light : 0);
      next = key;
    }
    if (next == ~0u) return 0;
    ray.from = next, sum += light;
  }
  return ray.from;
}

// Calls visit(splat), by all lanes of a team together, for all splats with
// outlines that touch a tile nearer than a limit, as long as a ray needs them.
template <class Visit>
HELPER void each_touching(const Listing &list, const Outline *outlines, int n,
                          const Tile &tile, float limit, const Ray &ray,
                          Visit visit) {
  for (int first = 0; first < n; first += LANES) {
    Outline o;
    bool touching = first + lane() < n;
    if (touching) {
      o = outlines[first + lane()];
      touching = o.nearest < limit && touches(o, tile);
    }
    u32 mask = lanes_where(touching);
    if (mask && !lanes_where(ray.asks)) return;
    for (; mask; mask &= mask - 1)
      visit(load_seen(list.seen + from_lane(o.at, first_of(mask))));
  }
}

// Returns the inward normals of the planes around pixels.
HELPER void find_sides(const float *R_WV, const Tile &tile, int resolution,
                       float *sides_W) {
  float scale = 2.0f / resolution;
  float left = scale * tile.left - 1.0f, top = scale * tile.top - 1.0f;
  float right = scale * (tile.right + 1) - 1.0f;
  float bottom = scale * (tile.bottom + 1) - 1.0f;
  float sides[4][3] = {{1.0f, 0.0f, -left}, {-1.0f, 0.0f, right},
                       {0.0f, 1.0f, -top}, {0.0f, -1.0f, bottom}};
  for (int k = 0; k < 4; ++k) {
    const float *n = sides[k];
    float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; ++i)
      sides_W[3 * k + i] = (R_WV[3 * i] * n[0] + R_WV[3 * i + 1] * n[1] +
                            R_WV[3 * i + 2] * n[2]) / length;
  }
}

// Calls visit(splat) for the splats of the scene in a tile, of every `share`-th
// cluster.
template <class Visit>
HELPER void each_in_scene(const Clusters &scene, const Band &band,
                          const Rules &rules, const Tile &tile, float limit,
                          int share, const Ray &ray, Visit visit) {
  float sides_W[12];
  find_sides(band.R_WV, tile, rules.resolution, sides_W);
  int turn = team();
  // Calls look(k), by all lanes together, for all boxes from `first` to `end`
  // that may contain needed splats.
  auto each_box = [&](const float4 *boxes, int first, int end, auto look) {
    for (int k0 = first; k0 < end; k0 += LANES) {
      int k = k0 + lane();
      bool matters =
          k < end && box_matters(band, sides_W, boxes + 2 * k, limit);
      u32 mask = lanes_where(matters);
      for (; mask && lanes_where(ray.asks); mask &= mask - 1)
        look(k0 + first_of(mask));
    }
  };
  each_box(scene.groups, 0, scene.n_groups, [&](int group) {
    int first = group * CLUSTER, end = first + CLUSTER;
    end = end < scene.n_clusters ? end : scene.n_clusters;
    each_box(scene.clusters, first, end, [&](int cluster) {
      if (turn++ % share) return;
      for (int k = lane(); k < CLUSTER; k += LANES) {
        Record r;
        Seen mine;
        Outline outline;
        bool seen = load_record(scene, band, cluster * CLUSTER + k, r) &&
                    is_between(sides_W, r.offset, r.radius * 1.0001f) &&
                    project(r, band, rules, limit, mine, outline) &&
                    touches(outline, tile);
        for (u32 mask = lanes_where(seen); mask; mask &= mask - 1)
          visit(seen_by(mine, first_of(mask)));
      }
    });
  });
}

// Returns the smaller of a limit and the least value beyond the range of the
// best pixel.
HELPER float up_to(float limit, u64 best) {
  return best == NONE ? limit : fminf(limit, value_of((u32)(best >> 32) + 1u));
}

HELPER Tile tile_of(int number, const Band &band, const Rules &rules) {
  int columns = tile_columns(rules);
  Tile tile;
  tile.left = number % columns * TILE_COLUMNS;
  tile.top = band.low_y + number / columns * TILE_ROWS;
  tile.right = tile.left + TILE_COLUMNS - 1;
  tile.bottom = tile.top + TILE_ROWS - 1;
  return tile;
}

// Makes a lane's ray; returns false if its pixel is outside the band.
HELPER bool ray_in(const Tile &tile, const Band &band, const Rules &rules,
                   Ray &ray) {
  int column = tile.left + lane() % TILE_COLUMNS;
  int row = tile.top + lane() / TILE_COLUMNS;
  ray = ray_of(column, row, rules);
  return column < rules.resolution && row <= band.high_y;
}

// A team draws a tile, and finds its nearest pixel with a median that is nearer
// than a limit and than all pixels found so far. If such pixels are not opaque
// yet, the tile is marked as open. Without IS_LISTED, the tile is drawn with
// the whole scene.
template <bool IS_LISTED>
HELPER void draw_tile(const Clusters &scene, Band &band, const Rules &rules,
                      const Listing &list, const Scratch &scratch, int number,
                      float limit, float slack) {
  Tile tile = tile_of(number, band, rules);
  Ray ray;
  bool inside = ray_in(tile, band, rules, ray);
  int at = ray.pixel - band.low_y * rules.resolution;
  bool counts = inside && !has(scratch.dead, at);
  u32 *kept = scratch.kept + thread();
  float nearer;
  u32 key;
  do {
    ray.light = ray.before = 0, ray.n_kept = 0;
    // Other teams may find a nearer pixel meanwhile.
    nearer = from_lane(up_to(limit, latest(band.best)), 0);
    auto draw = [&](const Seen &s) {
      float range;
      u32 light = absorbed(s, rules, ray, nearer, range);
      if (light) add_fragment(ray, range, light, kept);
    };
    if (IS_LISTED)
      each_touching(list, list.near, band.n_near, tile, nearer, ray, draw);
    else
      each_in_scene(scene, band, rules, tile, nearer, 1, ray, draw);
    key = ~0u;
    if (counts && ray.light >= rules.median_light)
      key = median_key(kept, ray, rules.median_light);
  } while (lanes_where(key == 0));
  u64 found = (u64)key << 32 | (u32)ray.pixel;
  ray.asks = key != ~0u && found < latest(band.best);
  if (!lanes_where(ray.asks)) return;
  bool is_open = ray.asks;
  float reach = nearer + slack;
  if (IS_LISTED)
    each_touching(list, list.outlines, band.n_seen, tile, reach, ray,
                  [&](const Seen &s) { look_through(s, rules, reach, ray); });
  if (is_open && !ray.asks) atomicMin(&band.best, found);
  if (!lanes_where(ray.asks)) return;
  if (inside) list.medians[at] = ray.asks ? key : ~0u;
  u32 least = least_of_lanes(ray.asks ? key : ~0u);
  if (lane() != 0) return;
  add(scratch.open, number);
  atomicMin(&band.open, (u64)least << 32 | (u32)number);
}

// Functions that are rarely called take copies, since values whose addresses
// they take would have to be in memory, not in registers.
RARELY void draw_unlisted(Clusters scene, Band &band, Rules rules, Listing list,
                          Scratch scratch, int number, float limit) {
  draw_tile<false>(scene, band, rules, list, scratch, number, limit, 0.0f);
}

// A block follows the rays of a tile to the end, to determine whether the
// pixels that would be the nearest are opaque.
RARELY void follow_tile(Clusters scene, Band &band, Rules rules, Listing list,
                        Scratch scratch, int number) {
  Tile tile = tile_of(number, band, rules);
  Ray ray;
  bool inside = ray_in(tile, band, rules, ray);
  int at = ray.pixel - band.low_y * rules.resolution;
  u32 key = inside ? list.medians[at] : ~0u;
  u64 found = (u64)key << 32 | (u32)ray.pixel;
  bool is_open = key != ~0u && found < band.best;
  if (!lanes_where(is_open)) return;
  ray.asks = is_open;
  if (team() == 0) band.totals[lane()] = 0;
  meet();
  // No fragment is farther.
  float end = 1.75f * rules.far;
  each_in_scene(scene, band, rules, tile, end, teams(), ray,
                [&](const Seen &s) { look_through(s, rules, end, ray); });
  u32 enough = rules.opaque_light;
  atomicAdd(&band.totals[lane()], ray.total < enough ? ray.total : enough);
  meet();
  if (team() != 0 || !is_open) return;
  if (band.totals[lane()] >= enough) atomicMin(&band.best, found);
  else add(scratch.dead, at);
}

// A team follows a ray through the listed splats, to the nearest splat of its
// share. The pixel found there bounds the remaining search.
HELPER void probe(Band &band, const Rules &rules, const Listing &list,
                  u32 *kept, float limit, float slack) {
  int n = band.n_seen;
  u64 nearest = NONE;
  for (int k = thread(); k < n; k += threads()) {
    u64 key = (u64)key_of(list.outlines[k].nearest) << 32 | (u32)k;
    nearest = key < nearest ? key : nearest;
  }
  nearest = least_of_lanes(nearest);
  if (nearest == NONE) return;
  Outline first = list.outlines[(u32)nearest];
  int column = ((first.columns & 65535) + (first.columns >> 16)) / 2;
  int row = ((first.rows & 65535) + (first.rows >> 16)) / 2;
  Tile pixel = {column, column, row, row};
  // Each lane processes other splats.
  Ray ray = ray_of(column, row, rules);
  float reach = limit + slack;
  for (int k = lane(); k < n; k += LANES) {
    if (!touches(list.outlines[k], pixel)) continue;
    float range;
    u32 light = absorbed(load_seen(list.seen + k), rules, ray, reach, range);
    sum_up(ray.total, light);
    if (light && range < limit) add_fragment(ray, range, light, kept);
  }
  if (sum_of_lanes(ray.total) < rules.opaque_light ||
      sum_of_lanes(ray.light) < rules.median_light)
    return;
  u32 light = 0, key = 0;
  while (light < rules.median_light) {
    u32 next = ~0u;
    for (int k = 0; k < ray.n_kept; ++k) {
      u32 other = kept[k * threads()];
      if (other > key && other < next) next = other;
    }
    key = least_of_lanes(next);
    if (key == ~0u) return;
    // Fragments that were not stored are farther, or the pixel will be drawn
    // again, nearer.
    u32 more = 0;
    for (int k = 0; k < ray.n_kept; ++k)
      if (kept[k * threads()] == key) more += kept[(KEPT + k) * threads()];
    light += sum_of_lanes(more);
  }
  if (lane() == 0) atomicMin(&band.best, (u64)key << 32 | (u32)ray.pixel);
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
  Tile whole = {0, rules.resolution - 1, rows_before, last};
  find_sides(band.R_WV, whole, rules.resolution, band.sides_W);
  band.best = NONE;
  band.nearest = key_of(INFINITE);
}

// Draws the tiles of a band with the splats that are nearer than a limit plus a
// slack, and follows the rays of tiles that remain open.
HELPER void draw_band(const Clusters &scene, Band &band, const Rules &rules,
                      const Listing &list, const Scratch &scratch, float limit,
                      float slack, u64 *answer) {
  int n_tiles = (band.high_y - band.low_y + TILE_ROWS) / TILE_ROWS *
                tile_columns(rules);
  for (int k = thread(); k < scratch.n_words; k += threads())
    scratch.drawn[k] = scratch.open[k] = 0;
  if (thread() == 0) band.open = NONE;
  bool is_listed = band.n_seen <= rules.room;
  if (is_listed) {
    probe(band, rules, list, scratch.kept + thread(), limit, slack);
    meet();
    // Bands of a view exchange the nearest pixel found so far.
    if (thread() == 0 && rules.bands > 1)
      atomicMin(&band.best, atomicMin(answer, band.best));
    meet();
    list_near(band, rules, up_to(limit, band.best), list, scratch);
    if (!band.n_near) return;
  }
  if (thread() == 0) band.work = 0;
  meet();
  for (int tile; (tile = take(band.work)) < n_tiles;) {
    if (!is_listed)
      draw_unlisted(scene, band, rules, list, scratch, tile, limit);
    else if (has(scratch.drawn, tile))
      draw_tile<true>(scene, band, rules, list, scratch, tile, limit, slack);
  }
  meet();
  if (band.open == NONE) return;
  // The tile with the nearest open pixel comes first; most others are then
  // skipped.
  int first = (int)band.open;
  for (int k = 0; k < n_tiles; ++k) {
    int tile = (first + k) % n_tiles;
    if (!has(scratch.open, tile)) continue;
    follow_tile(scene, band, rules, list, scratch, tile);
    meet();
  }
}

// Finds the nearest pixel of a band.
HELPER void search(const Clusters &scene, Band &band, const Rules &rules,
                   const Listing &list, const Scratch &scratch, u64 *answer) {
  float bound = band.bound;
  auto nearest = [&] { return fminf(bound, value_of(latest(band.nearest))); };
  // Estimates the range of the nearest splat.
  each_cluster(scene, band, nearest, [&](int cluster) {
    // A nearer pixel may have been found since then.
    const float4 *box = scene.clusters + 2 * cluster;
    if (!lanes_where(box_matters(band, band.sides_W, box, nearest()))) return;
    float near = INFINITE;
    for (int k = lane(); k < CLUSTER; k += LANES) {
      Record r;
      if (load_record(scene, band, cluster * CLUSTER + k, r) &&
          is_between(band.sides_W, r.offset, r.radius * 1.0001f))
        near = fminf(near, nearest_range(r, rules.is_surfel));
    }
    near = least_of_lanes(near);
    if (lane() == 0) atomicMin(&band.nearest, key_of(near));
  });
  float least = value_of(band.nearest);
  float below = fmaxf(least, 0.0f), most = 0.1f * below + 0.04f, step = most;
  while (least < bound) {
    float limit = fminf(below + step, bound), slack = 0.25f * step;
    list_seen(scene, band, rules, limit + slack, list);
    if (band.n_seen > rules.room) {
      // With a smaller limit, fewer splats are listed. If they are still too
      // many, none is listed.
      if (step > 0.05f * most) {
        meet();
        step *= 0.25f;
        continue;
      }
      limit = fminf(below + most, bound);
    }
    draw_band(scene, band, rules, list, scratch, limit, slack, answer);
    if (limit >= up_to(bound, band.best)) return;
    below = limit;
    float full = 0.5f * below + 0.04f;
    step = most = fminf(fmaxf(2.0f * step, 0.1f * full), full);
  }
}

// spheres: (n, 8): position and its remainder, the range that a result must
// undercut, the height below which splats are ignored. R_WD: (n, 9). nearest:
// (n, 6), keys of range and pixel; all bits set initially, and if a view
// contains no surface. closest: (n,), keys of the least range in all views of a
// sphere, all bits set initially. work: a counter, all bits set initially.
// lists: for each block, six float4 for each of rules.room splats, and a key
// for each pixel of a band.
KERNEL CROWDED(256, 4) depth_views(Clusters scene, Rules rules,
                                   const float *spheres, const float *R_WD,
                                   const float *R_DV, int n, u64 *nearest,
                                   u32 *closest, u32 *work, float4 *lists) {
  SHARED Band band;
  SHARED u32 item;
  SCRATCH(words);
  Scratch scratch;
  scratch.n_words = (rules.band_rows * rules.resolution + 31) / 32;
  scratch.dead = words;
  scratch.drawn = scratch.dead + scratch.n_words;
  scratch.open = scratch.drawn + scratch.n_words;
  scratch.kept = scratch.open + scratch.n_words;
  Listing list;
  size_t size = 6 * (size_t)rules.room + 8 * (size_t)scratch.n_words;
  list.seen = (Seen *)(lists + size * block());
  list.outlines = (Outline *)(list.seen + rules.room);
  list.near = list.outlines + rules.room;
  list.medians = (u32 *)(list.near + rules.room);
  u32 n_items = (u32)n * 6u * (u32)rules.bands;
  while (true) {
    meet();
    if (thread() == 0) item = atomicAdd(work, 1u) + 1u;
    meet();
    if (item >= n_items) return;
    // Views are computed one after the other. If only the nearest one is
    // needed, most of the later ones can be skipped.
    int i = item % n;
    int view = item / n / rules.bands;
    int rows_before = item / n % rules.bands * rules.band_rows;
    u64 *answer = nearest + 6 * (size_t)i + view;
    if (thread() == 0) {
      begin(spheres + 8 * (size_t)i, R_WD + 9 * (size_t)i, R_DV + 9 * view,
            rules, rows_before, band);
      // Pixels beyond those that other bands or views have found are not
      // needed. Of equally near pixels, the first one counts, regardless of the
      // order in which they are found.
      u64 known = latest(*answer);
      u64 other = (u64)latest(closest[i]) << 32 | 0xffffffffu;
      if (rules.nearest_only && other < known) known = other;
      band.bound = up_to(spheres[8 * (size_t)i + 6], known);
    }
    for (int k = thread(); k < scratch.n_words; k += threads())
      scratch.dead[k] = 0;
    meet();
    search(scene, band, rules, list, scratch, answer);
    meet();
    if (thread() == 0 && band.best != NONE) {
      atomicMin(answer, band.best);
      atomicMin(&closest[i], (u32)(band.best >> 32));
    }
  }
}

// Writes ranges and unit directions of the nearest pixels into rows, (n, 6, 4).
// With nearest_only, the other views of a sphere have no result.
KERNEL depth_rows(Rules rules, const float *R_WD, const float *R_DV, int n,
                  const u64 *nearest, float4 *rows) {
  for (int at = block() * threads() + thread(); at < 6 * n;
       at += blocks() * threads()) {
    int i = at / 6, view = at % 6;
    u64 key = nearest[at];
    for (int v = 0; rules.nearest_only && v < 6; ++v) {
      u32 other = nearest[6 * i + v] >> 32, own = key >> 32;
      if (other < own || (other == own && v < view)) key = NONE;
    }
    if (key == NONE) {
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
