// Vectors of three, rotation matrices and quaternions of numbers or of vectors of numbers (see
// simd::ScalarOf). The order of every sum is fixed.
#pragma once

#include "core/math/simd.h"

namespace engram {
inline namespace ENGRAM_ISA {

template <class V>
struct Vec3Of {
  V at[3];

  ENGRAM_INLINE V x() const { return at[0]; }
  ENGRAM_INLINE V y() const { return at[1]; }
  ENGRAM_INLINE V z() const { return at[2]; }
  ENGRAM_INLINE V& operator[](int i) { return at[i]; }
  ENGRAM_INLINE const V& operator[](int i) const { return at[i]; }

  ENGRAM_INLINE friend Vec3Of operator+(const Vec3Of& a, const Vec3Of& b) {
    return {a.at[0] + b.at[0], a.at[1] + b.at[1], a.at[2] + b.at[2]};
  }
  ENGRAM_INLINE friend Vec3Of operator-(const Vec3Of& a, const Vec3Of& b) {
    return {a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2]};
  }
  ENGRAM_INLINE friend Vec3Of operator*(const Vec3Of& a, V s) {
    return {a.at[0] * s, a.at[1] * s, a.at[2] * s};
  }
};

// Broadcasts a vector to all lanes.
template <class V>
ENGRAM_INLINE Vec3Of<V> broadcast_vec3(const simd::ScalarOf<V>* v) {
  return {simd::broadcast<V>(v[0]), simd::broadcast<V>(v[1]), simd::broadcast<V>(v[2])};
}

template <class V>
ENGRAM_INLINE V dot(const Vec3Of<V>& a, const Vec3Of<V>& b) {
  return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2];
}
template <class V>
ENGRAM_INLINE Vec3Of<V> cross(const Vec3Of<V>& a, const Vec3Of<V>& b) {
  return {a.at[1] * b.at[2] - a.at[2] * b.at[1], a.at[2] * b.at[0] - a.at[0] * b.at[2],
          a.at[0] * b.at[1] - a.at[1] * b.at[0]};
}

// Axes of a frame are the columns.
template <class V>
struct Mat3Of {
  V at[9];  // row by row

  ENGRAM_INLINE V& operator()(int row, int column) { return at[3 * row + column]; }
  ENGRAM_INLINE const V& operator()(int row, int column) const { return at[3 * row + column]; }
  ENGRAM_INLINE Vec3Of<V> row(int i) const { return {at[3 * i], at[3 * i + 1], at[3 * i + 2]}; }
  ENGRAM_INLINE Vec3Of<V> column(int k) const { return {at[k], at[3 + k], at[6 + k]}; }
  // Vectors and matrices of V, or of numbers that are the same in all lanes.
  ENGRAM_INLINE Vec3Of<V> operator*(const auto& v) const {
    return {at[0] * v[0] + at[1] * v[1] + at[2] * v[2], at[3] * v[0] + at[4] * v[1] + at[5] * v[2],
            at[6] * v[0] + at[7] * v[1] + at[8] * v[2]};
  }
  ENGRAM_INLINE Mat3Of times(const auto* m) const {
    Mat3Of result;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        result.at[3 * i + k] =
            at[3 * i] * m[k] + at[3 * i + 1] * m[3 + k] + at[3 * i + 2] * m[6 + k];
      }
    }
    return result;
  }
  // Rotated about its own z axis.
  ENGRAM_INLINE Mat3Of rotated_z(V sine, V cosine) const {
    Mat3Of result = *this;
    for (int i = 0; i < 9; i += 3) {
      result.at[i] = at[i] * cosine + at[i + 1] * sine;
      result.at[i + 1] = at[i + 1] * cosine - at[i] * sine;
    }
    return result;
  }
};

template <class V>
struct QuatOf {
  V w, x, y, z;

  // The vector, rotated.
  ENGRAM_INLINE Vec3Of<V> operator*(const simd::ScalarOf<V>* v) const {
    const Vec3Of<V> twice = {2.0F * (y * v[2] - z * v[1]), 2.0F * (z * v[0] - x * v[2]),
                             2.0F * (x * v[1] - y * v[0])};
    return {v[0] + w * twice.x() + (y * twice.z() - z * twice.y()),
            v[1] + w * twice.y() + (z * twice.x() - x * twice.z()),
            v[2] + w * twice.z() + (x * twice.y() - y * twice.x())};
  }
  ENGRAM_INLINE QuatOf times(const simd::ScalarOf<V>* q) const {
    return {w * q[0] - x * q[1] - y * q[2] - z * q[3], w * q[1] + x * q[0] + y * q[3] - z * q[2],
            w * q[2] - x * q[3] + y * q[0] + z * q[1], w * q[3] + x * q[2] - y * q[1] + z * q[0]};
  }
  // Rotated about its own z axis, by twice the angle of this sine and cosine.
  ENGRAM_INLINE QuatOf rotated_z(V sine, V cosine) const {
    return {w * cosine - z * sine, x * cosine + y * sine, y * cosine - x * sine,
            z * cosine + w * sine};
  }
  ENGRAM_INLINE Vec3Of<V> z_axis() const {
    return {2.0F * (x * z + w * y), 2.0F * (y * z - w * x), 1.0F - 2.0F * (x * x + y * y)};
  }
};

}  // namespace ENGRAM_ISA
}  // namespace engram
