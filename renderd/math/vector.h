#pragma once

#include <cmath>
#include <cstdint>

#include "renderd/math/host_device.h"

namespace diaphane::render {

/// Three numbers: a point, a direction or a colour. The layout is the same on host and device.
template <typename T>
struct Vector3 {
  T x, y, z;

  HOST_DEVICE constexpr T operator[](int axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }
};

using Float3 = Vector3<float>;
using Double3 = Vector3<double>;
using Int3 = Vector3<std::int32_t>;

/// A vector of 16 bytes, aligned so that one load fetches it.
struct alignas(16) Float4 {
  float x, y, z, w;
};

template <typename T>
HOST_DEVICE constexpr Vector3<T> operator+(Vector3<T> a, Vector3<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename T>
HOST_DEVICE constexpr Vector3<T> operator-(Vector3<T> a, Vector3<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
/// Returns the component-wise product.
template <typename T>
HOST_DEVICE constexpr Vector3<T> operator*(Vector3<T> a, Vector3<T> b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <typename T>
HOST_DEVICE constexpr Vector3<T> operator*(Vector3<T> a, T s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <typename T>
HOST_DEVICE constexpr Vector3<T> operator*(T s, Vector3<T> a) {
  return a * s;
}
template <typename T>
HOST_DEVICE constexpr Vector3<T>& operator+=(Vector3<T>& a, Vector3<T> b) {
  a = a + b;
  return a;
}
template <typename T>
HOST_DEVICE constexpr T dot(Vector3<T> a, Vector3<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename T>
HOST_DEVICE constexpr Vector3<T> cross(Vector3<T> a, Vector3<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
HOST_DEVICE float length(Float3 a) { return sqrtf(dot(a, a)); }
HOST_DEVICE double length(Double3 a) { return sqrt(dot(a, a)); }
/// Returns the unit vector along `a`, which must not be zero.
template <typename T>
HOST_DEVICE Vector3<T> normalize(Vector3<T> a) {
  return a * (T{1} / length(a));
}
HOST_DEVICE bool is_finite(Float3 a) {
  // A number minus itself is 0 only if it is finite. The compiler must not use -ffast-math.
  return (a.x - a.x) + (a.y - a.y) + (a.z - a.z) == 0.0f;
}
HOST_DEVICE constexpr Float3 to_float(Double3 a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}
HOST_DEVICE constexpr Double3 to_double(Float3 a) { return {a.x, a.y, a.z}; }

/// These replace std::min and std::max, which device code cannot call. If the first argument is
/// NaN, the result is the second.
template <typename T>
HOST_DEVICE constexpr T min(T a, T b) {
  return a < b ? a : b;
}
template <typename T>
HOST_DEVICE constexpr T max(T a, T b) {
  return a > b ? a : b;
}

/// Works like min(), but requires that neither number is NaN. Takes one instruction on a GPU.
HOST_DEVICE float fast_min(float a, float b) {
#if defined(__CUDA_ARCH__)
  return fminf(a, b);
#else
  return a < b ? a : b;
#endif
}
HOST_DEVICE float fast_max(float a, float b) {
#if defined(__CUDA_ARCH__)
  return fmaxf(a, b);
#else
  return a > b ? a : b;
#endif
}
/// Returns a / b with an error of a few units in the last place, for |b| from 1e-37 to 8e37. Use it
/// only where such an error is acceptable.
HOST_DEVICE float quotient_near(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fdividef(a, b);
#else
  return a / b;
#endif
}

HOST_DEVICE float max_component(Float3 a) { return max(a.x, max(a.y, a.z)); }

/// Computes two unit vectors that form a right-handed orthonormal basis with the unit vector `n`,
/// without branches (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
HOST_DEVICE void basis_around(Float3 n, Float3& s, Float3& t) {
  const float sign = n.z < 0.0f ? -1.0f : 1.0f;
  const float a = -1.0f / (sign + n.z);
  const float b = n.x * n.y * a;
  s = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
  t = {b, sign + n.y * n.y * a, -n.y};
}

}  // namespace diaphane::render
