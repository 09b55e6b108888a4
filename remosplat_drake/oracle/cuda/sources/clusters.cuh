// Splats in clusters of 32 neighbours, and these in groups of 32 clusters.
//
// A box is 8 floats: lower corner, height of the highest centre in it, upper
// corner, nothing. A position is two triples of floats whose sum it is, so that
// differences to it are as exact as single precision can be.

#pragma once

#include "team.cuh"

struct Clusters {
  const float *records;   // (splats, 16), see the kernels
  const float4 *clusters; // boxes of 32 splats
  const float4 *groups;   // boxes of 32 clusters
  int n_splats;
  int n_clusters;
  int n_groups;
};

struct Position {
  float x, y, z;          // rounded
  float dx, dy, dz;       // the rest
};

// From a position to a point.
HELPER float3 to_point(const Position &p, float x, float y, float z) {
  return make_float3((x - p.x) - p.dx, (y - p.y) - p.dy, (z - p.z) - p.dz);
}

// Squared distance to a box. Rounding must not hide what is inside.
HELPER float box_distance_squared(const Position &p, float4 low, float4 high) {
  float3 a = to_point(p, low.x, low.y, low.z);
  float3 b = to_point(p, high.x, high.y, high.z);
  float x = fmaxf(fmaxf(a.x, -b.x), 0.0f);
  float y = fmaxf(fmaxf(a.y, -b.y), 0.0f);
  float z = fmaxf(fmaxf(a.z, -b.z), 0.0f);
  return (x * x + y * y + z * z) * (1.0f - 1e-5f);
}
