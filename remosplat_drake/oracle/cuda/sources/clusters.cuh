// Splats in clusters of 32 neighbours, and clusters in groups of 32.
//
// A box is 8 floats: lower corner, height of the highest centre inside, upper
// corner, and an unused one. A position is the sum of two triples of floats, so
// that differences from a nearby position keep single precision.

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

// Returns the vector from a position to a point.
HELPER float3 to_point(const Position &p, float x, float y, float z) {
  return make_float3((x - p.x) - p.dx, (y - p.y) - p.dy, (z - p.z) - p.dz);
}

// Returns the squared distance to a box. It is rounded down, so that no splat
// in the box is excluded.
HELPER float box_distance_squared(const Position &p, float4 low, float4 high) {
  float3 a = to_point(p, low.x, low.y, low.z);
  float3 b = to_point(p, high.x, high.y, high.z);
  float x = fmaxf(fmaxf(a.x, -b.x), 0.0f);
  float y = fmaxf(fmaxf(a.y, -b.y), 0.0f);
  float z = fmaxf(fmaxf(a.z, -b.z), 0.0f);
  return (x * x + y * y + z * z) * (1.0f - 1e-5f);
}
