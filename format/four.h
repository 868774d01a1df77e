// Four doubles at a time, in one AVX register: corners, edges or nodes of the hot loops of the kernels. Written out,
// because whether the compiler finds it depends on its version and level.
#pragma once

#include <immintrin.h>

#include "format/geometry.h"

namespace rro {

/// Arithmetic and comparisons are element by element.
using Four = double __attribute__((vector_size(32)));

/// Square root, for functions that compute with one double or four.
inline double root(double x) {
    return std::sqrt(x);
}
inline Four root(Four x) {
    return _mm256_sqrt_pd(x);
}

/// Bit i of the result is whether element i of a comparison holds.
inline int bits_of(decltype(Four{} < Four{}) mask) {
    return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask));
}
constexpr int kAllFour = 0xf;

inline double sum_of(Four x) {
    return (x[0] + x[1]) + (x[2] + x[3]);
}

/// Four points or directions.
struct FourVec3 {
    Four x, y, z;
};
inline Vec3 sum_of(const FourVec3& a) {
    return {sum_of(a.x), sum_of(a.y), sum_of(a.z)};
}
inline FourVec3 operator-(const FourVec3& a, const FourVec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Four dot(const FourVec3& a, const FourVec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline FourVec3 cross(const FourVec3& a, const FourVec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline FourVec3 operator*(const FourVec3& a, Four s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline FourVec3 operator+(const FourVec3& a, const FourVec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Four dot(const Vec3& a, const FourVec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace rro
