// What CUDA kernels need of a device, for one thread on the CPU.
//
// A block has one thread and a team one lane, so that whatever threads do
// together is done by one after the other. Races cannot show here.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#define LANES 1
#define KERNEL extern "C" void
#define CROWDED(threads, blocks)
#define HELPER static inline
#define RARELY static
#define SHARED static
#define SCRATCH(name) static unsigned int name[1 << 22]

typedef unsigned int u32;
typedef unsigned long long u64;

struct float3 {
  float x, y, z;
};
struct float4 {
  float x, y, z, w;
};

HELPER float3 make_float3(float x, float y, float z) { return {x, y, z}; }
HELPER float4 make_float4(float x, float y, float z, float w) {
  return {x, y, z, w};
}

HELPER int lane() { return 0; }
HELPER int thread() { return 0; }
HELPER int threads() { return 1; }
HELPER int block() { return 0; }
HELPER int blocks() { return 1; }
HELPER void meet() {}
HELPER u32 lanes_where(bool yes) { return yes; }
template <class T> HELPER T from_lane(T value, int) { return value; }
template <class T> HELPER T across(T value, int) { return value; }
HELPER int first_of(u32 mask) { return __builtin_ctz(mask); }
HELPER float reciprocal(float value) { return 1.0f / value; }
HELPER float power_of_2(float value) { return exp2f(value); }
HELPER float logarithm_2(float value) { return log2f(value); }
HELPER int count_of(u32 mask) { return __builtin_popcount(mask); }

HELPER u32 float_bits(float value) {
  u32 bits;
  std::memcpy(&bits, &value, 4);
  return bits;
}
HELPER float bits_float(u32 bits) {
  float value;
  std::memcpy(&value, &bits, 4);
  return value;
}

template <class T, class U> HELPER T atomicAdd(T *at, U value) {
  T before = *at;
  *at += value;
  return before;
}
template <class T, class U> HELPER T atomicMin(T *at, U value) {
  T before = *at;
  *at = std::min(before, (T)value);
  return before;
}
template <class T, class U> HELPER T atomicMax(T *at, U value) {
  T before = *at;
  *at = std::max(before, (T)value);
  return before;
}
template <class T, class U> HELPER T atomicOr(T *at, U value) {
  T before = *at;
  *at |= value;
  return before;
}
template <class T, class U> HELPER T atomicExch(T *at, U value) {
  T before = *at;
  *at = value;
  return before;
}
