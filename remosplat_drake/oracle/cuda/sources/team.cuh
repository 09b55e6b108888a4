// Teams of lanes, and the operations that lanes of a team perform together.
//
// A team processes one item at a time. It is a warp on a GPU, and a single lane
// if the same sources are compiled for a CPU. Tests run these kernels without a
// GPU in this way (tests/oracle/cuda_on_host.py), so a kernel must not rely on
// a team with several lanes.

#pragma once

#ifdef __CUDACC__

#define LANES 32
#define KERNEL extern "C" __global__ void
#define CROWDED(threads, blocks) __launch_bounds__(threads, blocks)
#define HELPER static __device__ __forceinline__
#define RARELY static __device__ __noinline__
#define SHARED __shared__
#define SCRATCH(name) extern __shared__ __align__(16) unsigned int name[]

typedef unsigned int u32;
typedef unsigned long long u64;

HELPER int lane() { return threadIdx.x % LANES; }
HELPER int thread() { return threadIdx.x; }
HELPER int threads() { return blockDim.x; }
HELPER int block() { return blockIdx.x; }
HELPER int blocks() { return gridDim.x; }
HELPER void meet() { __syncthreads(); }
HELPER u32 lanes_where(bool yes) { return __ballot_sync(~0u, yes); }
HELPER float from_lane(float value, int who) {
  return __shfl_sync(~0u, value, who);
}
HELPER int from_lane(int value, int who) {
  return __shfl_sync(~0u, value, who);
}
HELPER float across(float value, int step) {
  return __shfl_xor_sync(~0u, value, step);
}
HELPER int across(int value, int step) {
  return __shfl_xor_sync(~0u, value, step);
}
HELPER u32 across(u32 value, int step) {
  return __shfl_xor_sync(~0u, value, step);
}
HELPER u64 across(u64 value, int step) {
  return __shfl_xor_sync(~0u, value, step);
}
HELPER u32 float_bits(float value) { return __float_as_uint(value); }
HELPER float bits_float(u32 bits) { return __uint_as_float(bits); }
HELPER int first_of(u32 mask) { return __ffs(mask) - 1; }
// Approximations to within one or two units in the last place, by one
// instruction.
HELPER float reciprocal(float value) {
  float result;
  asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(value));
  return result;
}
HELPER float power_of_2(float value) {
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(value));
  return result;
}
HELPER float logarithm_2(float value) {
  float result;
  asm("lg2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(value));
  return result;
}
HELPER int count_of(u32 mask) { return __popc(mask); }

#endif

#define CLUSTER 32
#define INFINITE 3.0e38f

// Returns the lanes before this one.
HELPER u32 lanes_before() { return (1u << lane()) - 1u; }

HELPER int team() { return thread() / LANES; }
HELPER int teams() { return threads() / LANES; }

template <class T> HELPER T least_of_lanes(T value) {
  for (int step = LANES / 2; step > 0; step /= 2) {
    T other = across(value, step);
    value = other < value ? other : value;
  }
  return value;
}

HELPER u32 sum_of_lanes(u32 value) {
  for (int step = LANES / 2; step > 0; step /= 2) value += across(value, step);
  return value;
}

// Converts floats to integers of the same order, for atomicMin.
HELPER u32 key_of(float value) {
  u32 bits = float_bits(value);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

HELPER float value_of(u32 key) {
  return bits_float(key & 0x80000000u ? key & 0x7fffffffu : ~key);
}

// Reads a number of the block that other threads change.
HELPER u32 latest(const u32 &value) {
  return *const_cast<const volatile u32 *>(&value);
}
HELPER u64 latest(const u64 &value) {
  return *const_cast<const volatile u64 *>(&value);
}
