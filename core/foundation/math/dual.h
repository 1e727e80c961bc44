// Forward-mode automatic differentiation: a value and N partial derivatives. Gradient tests use it to get exact derivatives of
// the production templates.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace vitrine {

template <class T, size_t N> struct Dual {
  T v{};
  std::array<T, N> d{};

  Dual() = default;
  Dual(T value) : v(value) {}                                             // NOLINT: constants convert silently on purpose
  static Dual variable(T value, size_t index) {
    Dual r(value);
    r.d[index] = T(1);
    return r;
  }
  explicit operator T() const { return v; }
  explicit operator float() const requires(!std::is_same_v<T, float>) { return static_cast<float>(v); }

  // f(v) with derivative dfdv, by the chain rule.
  Dual chained(T value, T dfdv) const {
    Dual r(value);
    for (size_t i = 0; i < N; ++i) r.d[i] = dfdv * d[i];
    return r;
  }
  Dual operator-() const { return chained(-v, T(-1)); }
  friend Dual operator+(const Dual& a, const Dual& b) {
    Dual r(a.v + b.v);
    for (size_t i = 0; i < N; ++i) r.d[i] = a.d[i] + b.d[i];
    return r;
  }
  friend Dual operator-(const Dual& a, const Dual& b) { return a + (-b); }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual r(a.v * b.v);
    for (size_t i = 0; i < N; ++i) r.d[i] = a.d[i] * b.v + a.v * b.d[i];
    return r;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual r(a.v / b.v);
    for (size_t i = 0; i < N; ++i) r.d[i] = (a.d[i] - r.v * b.d[i]) / b.v;
    return r;
  }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }
  friend bool operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.v > b.v; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.v <= b.v; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.v >= b.v; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.v == b.v; }

  friend Dual sqrt(const Dual& a) { const T s = std::sqrt(a.v); return a.chained(s, T(0.5) / s); }
  friend Dual exp(const Dual& a) { const T e = std::exp(a.v); return a.chained(e, e); }
  friend Dual log(const Dual& a) { return a.chained(std::log(a.v), T(1) / a.v); }
  friend Dual sin(const Dual& a) { return a.chained(std::sin(a.v), std::cos(a.v)); }
  friend Dual cos(const Dual& a) { return a.chained(std::cos(a.v), -std::sin(a.v)); }
  friend Dual pow(const Dual& a, T p) { return a.chained(std::pow(a.v, p), p * std::pow(a.v, p - T(1))); }
  friend Dual abs(const Dual& a) { return a.v < T(0) ? -a : a; }
  friend Dual min(const Dual& a, const Dual& b) { return b.v < a.v ? b : a; }
  friend Dual max(const Dual& a, const Dual& b) { return a.v < b.v ? b : a; }
};

}  // namespace vitrine
